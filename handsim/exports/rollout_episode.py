"""Simulated grasps as episodes: what the model's coordinates are, by name."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass

import mujoco

from handsim.exports.episode import TURN, Episode, Quantity
from handsim.exports.task_sentences import sentence_of
from handsim.grasping.rollout.record import Rollout
from handsim.joints import CONTACT_PARTS, JOINT_NAMES
from handsim.result import plain
from handsim.types import Array

_FREE = mujoco.mjtJoint.mjJNT_FREE.value
_UNITS = {mujoco.mjtJoint.mjJNT_HINGE.value: "rad", mujoco.mjtJoint.mjJNT_SLIDE.value: "m"}
_XYZ = ("x", "y", "z")


@dataclass(frozen=True)
class _Axes:
    """Joints with one coordinate: names, units, and their columns in qpos and qvel."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    qpos: list[int]
    qvel: list[int]


def rollout_episode(rollout: Rollout, name: str = "") -> Episode:
    """Return a simulated grasp as an episode.

    Parameters
    ----------
    rollout
        Its model is compiled to learn what its coordinates are.
    name
        By default that of the task.

    Raises
    ------
    InputError
        If the model is none (see `Rollout.model`).
    """
    model = rollout.model()
    return Episode(
        name=name or rollout.task,
        kind="rollout",
        task=rollout.task,
        sentence=sentence_of(rollout.task),
        time=rollout.time,
        quantities=(
            *_moving(rollout, model),
            *_measured(rollout, _free(model, "forearm") is not None),
        ),
        facts={
            "driver": rollout.driver,
            "success": rollout.outcome.success,
            "outcome": plain(rollout.outcome),
            "conditions": plain(rollout.conditions.as_dict()),
            "versions": dict(rollout.versions),
        },
        phases=tuple((phase.name, phase.start) for phase in rollout.phases),
        success=rollout.outcome.success,
        hand=rollout.conditions.hand,
        rollout=rollout,
    )


def _moving(rollout: Rollout, model: mujoco.MjModel) -> list[Quantity]:
    """Return joints, commands, and where the object and a hand without an arm are."""
    hand, thing = _axes(model, of_object=False), _axes(model, of_object=True)
    velocities = tuple(f"{unit}/s" for unit in hand.units)
    found = [
        Quantity("joints", hand.names, hand.units, rollout.qpos[:, hand.qpos],
                 "joints of the hand, in the order of a data glove, then of what carries it"),
        Quantity("velocities", tuple(f"{name}_velocity" for name in hand.names), velocities,
                 rollout.qvel[:, hand.qvel], "velocities of the joints"),
        _targets(rollout, model, hand.names),
    ]  # fmt: skip
    for joint, called in (("object_joint", "object"), ("forearm", "forearm")):
        start = _free(model, joint)
        if start is not None:
            pose = rollout.qpos[:, start : start + 7]
            found += pose_quantities(called, pose[:, :3], pose[:, 3:], f"of the {called}")
    if thing.names:
        names = tuple(f"object_{name}" for name in thing.names)
        found.append(
            Quantity("object_joints", names, thing.units, rollout.qpos[:, thing.qpos],
                     "hinges of the object")
        )  # fmt: skip
    return found


def _measured(rollout: Rollout, flies: bool) -> list[Quantity]:
    """Return what was commanded of the base, read and felt; ``flies`` is without an arm."""
    base = "forearm" if flies else "palm"
    parts, n = CONTACT_PARTS, len(rollout.time)
    directions = tuple(f"{part}_press_{axis}" for part in parts for axis in _XYZ)
    glove = tuple(f"{name}_glove" for name in JOINT_NAMES)
    found = [
        *pose_quantities(f"{base}_target", rollout.mocap_pos, rollout.mocap_quat,
                         f"that is commanded of the {base}"),
        Quantity("glove", glove, ("rad",) * len(glove), rollout.reading,
                 "readings of the data glove"),
        Quantity("contact_force", tuple(f"{part}_force" for part in parts), ("N",) * len(parts),
                 rollout.contact_force, "sums of normal forces on the object"),
        Quantity("press", directions, ("N",) * len(directions), rollout.press.reshape(n, -1),
                 "the same forces as vectors", "world"),
        Quantity("penetration", ("penetration",), ("m",), rollout.penetration[:, None],
                 "deepest overlap of the hand with object or table"),
        Quantity("table_force", ("table_force",), ("N",), rollout.table_force[:, None],
                 "what hand and arm press on the table"),
    ]  # fmt: skip
    if rollout.z.shape[1]:
        names = tuple(f"z_{i}" for i in range(rollout.z.shape[1]))
        found.append(
            Quantity("z", names, ("rad",) * len(names), rollout.z,
                     "readings in the subspace of the controller")
        )  # fmt: skip
    return found


def pose_quantities(called: str, position: Array, turn: Array, what: str) -> list[Quantity]:
    """Return a pose in the world as two quantities.

    Parameters
    ----------
    called
        What the names of columns begin with.
    position : (n, 3) [m]
    turn : (n, 4)
        As quaternions (w, x, y, z).
    what
        Whose, in words.
    """
    return [
        Quantity(f"{called}_position", tuple(f"{called}_{axis}" for axis in _XYZ), ("m",) * 3,
                 position, f"position {what}", "world"),
        Quantity(f"{called}_orientation", tuple(f"{called}_{part}" for part in TURN), ("",) * 4,
                 turn, f"orientation {what} as quaternion (w, x, y, z)", "world"),
    ]  # fmt: skip


def _axes(model: mujoco.MjModel, *, of_object: bool) -> _Axes:
    """Return the hinges and slides of the object, or all others; those of a person's hand first."""
    root = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY.value, "object")
    joints = [
        joint
        for joint in range(model.njnt)
        if int(model.jnt_type[joint]) in _UNITS
        and (model.body_rootid[model.jnt_bodyid[joint]] == root) == of_object
    ]
    names = [model.joint(joint).name for joint in joints]
    order = sorted(range(len(joints)), key=lambda i: _place(names[i]))
    joints = [joints[i] for i in order]
    return _Axes(
        tuple(model.joint(joint).name for joint in joints),
        tuple(_UNITS[int(model.jnt_type[joint])] for joint in joints),
        [int(model.jnt_qposadr[joint]) for joint in joints],
        [int(model.jnt_dofadr[joint]) for joint in joints],
    )


def _place(name: str) -> int:
    """Return the place of a joint of the hand in the order of the glove; others come after."""
    return JOINT_NAMES.index(name) if name in JOINT_NAMES else len(JOINT_NAMES)


def _targets(rollout: Rollout, model: mujoco.MjModel, order: tuple[str, ...]) -> Quantity:
    """Return what is commanded of the actuators, which are position servos.

    Those of joints are in the order of the joints; those of tendons come after.
    """
    on_joint = mujoco.mjtTrn.mjTRN_JOINT.value
    units: list[str] = []
    places: list[int] = []
    for i in range(model.nu):
        joint = int(model.actuator_trnid[i, 0])
        drives = int(model.actuator_trntype[i]) == on_joint
        units.append(_UNITS.get(int(model.jnt_type[joint]), "") if drives else "")
        driven = model.joint(joint).name if drives else ""
        places.append(order.index(driven) if driven in order else len(order))
    actuators = sorted(range(model.nu), key=places.__getitem__)
    return Quantity(
        "targets",
        tuple(f"{model.actuator(i).name}_target" for i in actuators),
        tuple(units[i] for i in actuators),
        rollout.ctrl[:, actuators],
        "what is commanded of the actuators",
    )


def _free(model: mujoco.MjModel, name: str) -> int | None:
    """Return where the seven coordinates of a free joint begin in qpos; None if there is none."""
    joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT.value, name)
    found = joint >= 0 and int(model.jnt_type[joint]) == _FREE
    return int(model.jnt_qposadr[joint]) if found else None
