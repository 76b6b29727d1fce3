"""What the actuators of a robot hand do to its joints: tendons that several share, and commands."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from handsim.types import Array

_JOINT, _JOINT_IN_PARENT = (
    mujoco.mjtTrn.mjTRN_JOINT.value,
    mujoco.mjtTrn.mjTRN_JOINTINPARENT.value,
)
_TENDON = mujoco.mjtTrn.mjTRN_TENDON.value
_WRAPPED_JOINT = mujoco.mjtWrap.mjWRAP_JOINT.value
_FIXED_GAIN = mujoco.mjtGain.mjGAIN_FIXED.value
_AFFINE_BIAS = mujoco.mjtBias.mjBIAS_AFFINE.value


def shared_tendons(model: mujoco.MjModel) -> Iterator[tuple[list[int], Array]]:
    """Yield joints that one actuator moves together by a fixed tendon, and how far each goes.

    A fixed tendon sets a sum of joint angles, sum_i c_i q_i. How it is shared out is decided by
    what holds the joints back: a force F in the tendon moves joint i by c_i F over its stiffness,
    or, where not all are springs, at a speed of c_i F over its damping; without either, by c_i F.
    Joints that have an actuator of their own besides are not coupled by the tendon.

    Yields
    ------
    joints
        Two or more.
    ways : (n,)
        How far each goes from its reference, relative to one another.
    """
    own = {
        int(model.actuator_trnid[i, 0])
        for i in range(model.nu)
        if model.actuator_trntype[i] in (_JOINT, _JOINT_IN_PARENT)
    }
    for i in range(model.nu):
        if model.actuator_trntype[i] != _TENDON:
            continue
        joints, coefficients = _fixed_tendon(model, int(model.actuator_trnid[i, 0]))
        if len(joints) > 1 and not own & set(joints):
            yield joints, coefficients / _held_back(model, joints)


def _fixed_tendon(model: mujoco.MjModel, tendon: int) -> tuple[list[int], Array]:
    """Return the joints of a fixed tendon and their coefficients; none of a spatial one."""
    first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
    wraps = slice(first, first + count)
    if not (model.wrap_type[wraps] == _WRAPPED_JOINT).all():
        return [], np.empty(0)
    return [int(j) for j in model.wrap_objid[wraps]], model.wrap_prm[wraps].copy()


def _held_back(model: mujoco.MjModel, joints: list[int]) -> Array:
    """Return what holds joints back: stiffness or else damping, if all have it, or else ones."""
    dofs = model.jnt_dofadr[joints]
    for held in (model.jnt_stiffness[joints], model.dof_damping[dofs]):
        if (held > 0).all():
            return np.asarray(held / held.min(), dtype=float)
    return np.ones(len(joints))


def driving_actuators(model: mujoco.MjModel, joints: list[int]) -> list[int]:
    """Return the actuators that move any of the joints, themselves or by a fixed tendon."""
    moved: list[int] = []
    for i in range(model.nu):
        kind, target = model.actuator_trntype[i], int(model.actuator_trnid[i, 0])
        own = [target] if kind in (_JOINT, _JOINT_IN_PARENT) else []
        if kind == _TENDON:
            own = _fixed_tendon(model, target)[0]
        if set(own) & set(joints):
            moved.append(i)
    return moved


@dataclass(frozen=True)
class Servos:
    """Position servos: their controls are linear in the joints, control = slopes q + offsets.

    Attributes
    ----------
    slopes : (a, j)
        Of a actuators and j joints; NaN for actuators that are no position servos.
    offsets : (a,)
    lower, upper : (a,)
        Ends of their ranges; infinite where there are none.
    """

    slopes: Array
    offsets: Array
    lower: Array
    upper: Array

    def commands(self, positions: Array) -> Array:
        """Return the controls that hold joint positions (..., j), (..., a), in their ranges."""
        return np.clip(positions @ self.slopes.T + self.offsets, self.lower, self.upper)


def find_servos(model: mujoco.MjModel, actuators: list[int], joints: list[int]) -> Servos:
    """Return how actuators are to be commanded.

    A position servo's force is gain * control + bias0 + bias1 * length; what makes it zero is its
    command. Its length is the joint's angle, or the sum of a fixed tendon, times its gear. Joints
    that are not among those given are in the reference posture.

    Parameters
    ----------
    model
    actuators, joints
        Ids.
    """
    slopes = np.full((len(actuators), len(joints)), np.nan)
    offsets = np.full(len(actuators), np.nan)
    limited = model.actuator_ctrllimited[actuators].astype(bool)
    for k, i in enumerate(actuators):
        gain, bias = model.actuator_gainprm[i], model.actuator_biasprm[i]
        servo = model.actuator_gaintype[i] == _FIXED_GAIN and gain[0] != 0
        if not (servo and model.actuator_biastype[i] == _AFFINE_BIAS and bias[1] != 0):
            continue
        kind, target = model.actuator_trntype[i], int(model.actuator_trnid[i, 0])
        parts = [target], np.ones(1)
        if kind == _TENDON:
            parts = _fixed_tendon(model, target)
        gear = model.actuator_gear[i, 0]
        slopes[k], offsets[k] = 0.0, -bias[0] / gain[0]
        for joint, coefficient in zip(*parts, strict=True):
            slope = -bias[1] / gain[0] * gear * coefficient
            if joint in joints:
                slopes[k, joints.index(joint)] += slope
            else:
                offsets[k] += slope * model.qpos0[model.jnt_qposadr[joint]]
    ends = model.actuator_ctrlrange[actuators]
    return Servos(
        slopes,
        offsets,
        np.where(limited, ends[:, 0], -np.inf),
        np.where(limited, ends[:, 1], np.inf),
    )
