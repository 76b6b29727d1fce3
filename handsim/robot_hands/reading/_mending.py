"""Inertias that no body can have, joints without actuators or names."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from itertools import count

import mujoco
import numpy as np

SERVO_STIFFNESS = 3.0
"""Of the servos added [N m/rad], as those of the own hand's fingers (1.5 to 6)."""
SLIDE_STIFFNESS = 300.0
"""Of the servos added to slides [N/m]."""
_ARMATURE = 2e-4
"""Inertia added to joints that are given a servo [kg m2], as in the own hand."""
_RADIUS = 0.01
"""Of the ball whose inertia stands for one that is none [m]."""
_JOINT = mujoco.mjtEq.mjEQ_JOINT


def mend_inertia(spec: mujoco.MjSpec) -> list[str]:
    """Balance moments of inertia that no body has, and replace those that are not positive."""
    balanced: list[str] = []
    replaced: list[str] = []
    for body in spec.bodies:
        if not body.explicitinertial:
            continue
        moments = _moments(body)
        if not (np.isfinite(moments).all() and moments[0] > 0 and body.mass > 0):
            body.mass = body.mass if np.isfinite(body.mass) and body.mass > 0 else 1e-3
            body.inertia = np.full(3, max(0.4 * body.mass * _RADIUS**2, 1e-9))
            body.fullinertia = [np.nan, 0, 0, 0, 0, 0]
            replaced.append(body.name)
        elif moments[0] + moments[1] < moments[2] * (1 - 1e-9):
            balanced.append(body.name)
    notes: list[str] = []
    if balanced:
        notes.append(f"inertia of {_some(balanced)} broke A + B >= C, which no body does; balanced")
    if replaced:
        notes.append(f"inertia of {_some(replaced)} was not positive; that of a ball instead")
    return notes


def keep_least_masses(spec: mujoco.MjSpec, model: mujoco.MjModel) -> None:
    """Write down the masses that bodies without any got when compiled, ``boundmass`` of the file.

    A scene with the hand in it is compiled with them, but its XML has no such bound.
    """
    least = 1.001 * spec.compiler.boundmass
    for body in spec.bodies[1:]:
        compiled = model.body(body.name)
        if body.explicitinertial or not 0 < compiled.mass[0] <= least:
            continue
        body.explicitinertial = True
        body.mass, body.inertia = compiled.mass[0], compiled.inertia
        body.ipos, body.iquat = compiled.ipos, compiled.iquat


def _moments(body: mujoco.MjsBody) -> np.ndarray:
    """Return the principal moments of inertia [kg m2], the smallest first."""
    full = np.asarray(body.fullinertia)
    if not np.isfinite(full[0]):
        return np.sort(np.asarray(body.inertia))
    a, b, c, ab, ac, bc = full
    if not np.isfinite(full).all():
        return np.full(3, np.nan)
    return np.linalg.eigvalsh(np.array([[a, ab, ac], [ab, b, bc], [ac, bc, c]]))


def add_servos(spec: mujoco.MjSpec, model: mujoco.MjModel) -> list[str]:
    """Give a hand that has no actuator at all a position servo for each joint that is free."""
    if model.nu:
        return []
    led = {model.eq_obj1id[i] for i in range(model.neq) if model.eq_type[i] == _JOINT.value}
    added = 0
    for j in range(model.njnt):
        joint = spec.joint(model.joint(j).name) if model.joint(j).name else None
        slide = model.jnt_type[j] == mujoco.mjtJoint.mjJNT_SLIDE.value
        if joint is None or j in led or not (slide or _is_hinge(model, j)):
            continue
        servo = spec.add_actuator(name=joint.name, target=joint.name)
        servo.trntype = mujoco.mjtTrn.mjTRN_JOINT
        servo.set_to_position(kp=SLIDE_STIFFNESS if slide else SERVO_STIFFNESS, dampratio=1.0)
        if model.jnt_limited[j]:
            servo.ctrlrange = model.jnt_range[j]
        joint.armature = max(joint.armature, _ARMATURE)
        added += 1
    if not added:
        return []
    return [f"the file has no actuators; {added} position servos were added, named as the joints"]


def give_names(spec: mujoco.MjSpec) -> None:
    """Name bodies, joints and actuators that the file leaves without a name, by their number.

    A scene that the hand is put into finds its parts by their names.
    """
    kinds = {"body": spec.bodies, "joint": spec.joints, "actuator": spec.actuators}
    for kind, parts in kinds.items():
        taken = {part.name for part in parts}
        for i, part in enumerate(parts):
            if not part.name:
                part.name = next(n for k in count(i) if (n := f"{kind} {k}") not in taken)
                taken.add(part.name)


def _is_hinge(model: mujoco.MjModel, joint: int) -> bool:
    return model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE.value


def _some(names: list[str]) -> str:
    """Return up to three names, and how many more."""
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return ", ".join(f"'{name}'" for name in names[:3]) + more
