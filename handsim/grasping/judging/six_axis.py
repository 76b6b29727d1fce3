"""The six-axis test of a grasp: forces from six sides, after the DexGraspBench protocol.

The test begins with the state after the squeeze. Gravity and table are removed, and
the mass of the object is set to 100 g. A force of 10 m/s^2 times the mass then pulls the object for
2 s along each axis of the world in turn. The protocol has no gravity from the start; here the
object lies on the table until the test begins. Objects that are only pressed onto the table (a
mouse, a stapler) fail the test, since only the hand holds them then.

References
----------
J. Chen et al. (2024), DexGraspBench: https://github.com/JYChen18/DexGraspBench
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import MAX_SPEED
from handsim.silence import silent
from handsim.tasks.grip_rules import Reason
from handsim.types import Array

MASS = 0.1
"""Of the object [kg]."""
ACCELERATION = 10.0
"""Force on the object over its mass [m/s^2]."""
DURATION, TIMESTEP = 2.0, 0.004
"""Of each pull, and of the simulation [s]."""
FRICTION = (0.6, 0.02)
"""Tangential and torsional [m]."""
MAX_SHIFT, MAX_TURN_DEG = 0.05, 15.0
"""Limits of the displacement [m] and the turn of the object."""
MAX_OVERLAP = 0.01
"""Deepest overlap of hand and object [m], as in the published test."""
DIRECTIONS = np.concatenate([np.eye(3), -np.eye(3)])


@dataclass(frozen=True)
class SixAxisOutcome:
    """How a grasp resisted six pulls.

    Attributes
    ----------
    shift_m, turn_deg : six floats
        Largest displacement and turn of the object in each pull, +x +y +z -x -y -z; infinite where
        the simulation diverged. A pull ends when the object is lost.
    penetration_m
        Deepest overlap of hand and object in any.
    """

    shift_m: tuple[float, ...]
    turn_deg: tuple[float, ...]
    penetration_m: float

    @property
    def reason(self) -> Reason | None:
        """Why the grasp failed, or None."""
        if not all(map(math.isfinite, self.shift_m)):
            return "unstable"
        if self.penetration_m > MAX_OVERLAP:
            return "penetrated"
        if max(self.shift_m) >= MAX_SHIFT:
            return "slipped"
        return "tilted" if max(self.turn_deg) >= MAX_TURN_DEG else None

    @property
    def success(self) -> bool:
        """Whether the object stayed in all six."""
        return self.reason is None


@silent()
def six_axis(rollout: Rollout, *, hard: bool = False) -> SixAxisOutcome:
    """Pull at the object of a grasp from six sides.

    Parameters
    ----------
    rollout
        Of any task; its state after the squeeze is used.
    hard
        Use MuJoCo's own contact settings (impratio 1, no noslip iterations), with which objects
        creep.
    """
    if rollout.outcome.reason == "unstable":
        lost = (math.inf,) * len(DIRECTIONS)
        return SixAxisOutcome(lost, lost, 0.0)
    model = _protocol_model(rollout, hard)
    data = mujoco.MjData(model)
    acting = next(phase.start for phase in rollout.phases if phase.name == "action")
    start = min(int(np.searchsorted(rollout.time, acting)), len(rollout.time) - 1)
    pulls = [_pull(model, data, rollout, start, direction) for direction in DIRECTIONS]
    shift, turn, depth = (tuple(values) for values in zip(*pulls, strict=True))
    return SixAxisOutcome(shift, turn, max(depth))


def _protocol_model(rollout: Rollout, hard: bool) -> mujoco.MjModel:
    model = rollout.model()
    model.opt.gravity[:] = 0.0
    model.opt.timestep = TIMESTEP
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # keep a diverged state
    model.opt.noslip_iterations = 0 if hard else 2
    model.opt.impratio = 1.0 if hard else 10.0
    table = model.geom("table").id
    model.geom_contype[table] = model.geom_conaffinity[table] = 0
    hand = model.body_rootid[model.body("forearm").id]
    model.geom_friction[model.body_rootid[model.geom_bodyid] == hand, :2] = FRICTION
    of_object = model.body_rootid == model.body("object").id
    scale = MASS / model.body_mass[of_object].sum()
    model.body_mass[of_object] *= scale
    model.body_inertia[of_object] *= scale
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def _pull(
    model: mujoco.MjModel, data: mujoco.MjData, rollout: Rollout, start: int, direction: Array
) -> tuple[float, float, float]:
    """Return the largest displacement [m], turn [deg] and overlap [m] in one pull."""
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.ctrl[:] = rollout.qpos[start], rollout.ctrl[start]
    data.mocap_pos[:], data.mocap_quat[:] = rollout.mocap_pos[start], rollout.mocap_quat[start]
    mujoco.mj_forward(model, data)
    object_id = model.body("object").id
    pos, quat = data.xpos[object_id].copy(), data.xquat[object_id].copy()
    data.xfrc_applied[object_id, :3] = ACCELERATION * MASS * direction
    shift = turn = depth = 0.0
    for _ in range(round(DURATION / TIMESTEP)):
        mujoco.mj_step(model, data)
        if not (np.abs(data.qvel) <= MAX_SPEED).all():  # NaN too
            return math.inf, math.inf, depth
        shift = max(shift, float(np.linalg.norm(data.xpos[object_id] - pos)))
        turn = max(turn, float(2 * np.arccos(min(1.0, abs(float(data.xquat[object_id] @ quat))))))
        depth = max(depth, _overlap(model, data, object_id))
        if shift >= MAX_SHIFT:  # lost
            break
    return shift, float(np.rad2deg(turn)), depth


def _overlap(model: mujoco.MjModel, data: mujoco.MjData, object_id: int) -> float:
    """Return the deepest contact of the object [m]."""
    if data.ncon == 0:
        return 0.0
    root = model.body_rootid[model.geom_bodyid[data.contact.geom]]
    touching = (root == object_id).any(axis=1)
    return float(max(0.0, -data.contact.dist[touching].min())) if touching.any() else 0.0
