"""The person's hand that a robot hand follows, turned as the robot's palm is.

A rollout of a robot hand records both: the states of the robot and, as its reading, the posture of
the person. Drawn beside each other they show what the robot makes of it.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from handsim.grasping.robots.robot_scene import PREFIX
from handsim.grasping.rollout.record import Rollout
from handsim.hand.mjcf import build_hand
from handsim.joints import JOINT_NAMES
from handsim.types import Array, Frame, HandSize
from handsim.viewing.film.clip import Clip
from handsim.viewing.film.clip_player import USUAL
from handsim.viewing.film.overlay import draw_text
from handsim.viewing.stage.lighting import light_any_hand

TITLE = "the person's hand"
_HEIGHT = 1.3
"""Height of what is seen, in hand lengths: the hand, however it is turned about its knuckles."""
_FOV = 40.0
"""Vertical field of view [deg]."""


@dataclass(frozen=True)
class _Title:
    """A line at the lower left of every frame, as in contact sheets."""

    text: str

    def draw(self, frame: Frame, time: float) -> None:
        """Write it; ``time`` [s] does not count."""
        size = max(13, frame.shape[0] // 16)
        draw_text(frame, [self.text], (0.5 * size, frame.shape[0] - 1.6 * size), size)


def person_clip(rollout: Rollout, model: mujoco.MjModel) -> Clip | None:
    """Return the movement of the person's hand that a robot hand follows; None for other rollouts.

    Its palm is turned as the robot's palm, and it is seen from the same direction as the robot is.

    Parameters
    ----------
    rollout
    model
        Of the rollout.
    """
    if not any(model.joint(i).name.startswith(PREFIX) for i in range(model.njnt)):
        return None
    hand = _flying_hand(rollout.conditions.hand, model)
    data = mujoco.MjData(hand)
    columns = [hand.joint(name).qposadr[0] for name in JOINT_NAMES]
    qpos = np.tile(hand.qpos0, (len(rollout.time), 1))
    qpos[:, columns] = rollout.reading
    wanted = Rotation.from_quat(_palm_quats(rollout, model), scalar_first=True)
    for row, palm in zip(qpos, wanted, strict=True):
        data.qpos[:] = row
        data.qpos[:7] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
        mujoco.mj_kinematics(hand, data)
        turn = palm * Rotation.from_quat(data.body("palm").xquat, scalar_first=True).inv()
        row[:3] = -turn.apply(data.body("middle_proximal").xpos)
        row[3:7] = turn.as_quat(scalar_first=True)
    titles = (_Title(TITLE),)
    return Clip(hand, rollout.time - rollout.time[0], qpos, titles, titles)


def _flying_hand(size: HandSize, seen: mujoco.MjModel) -> mujoco.MjModel:
    """Compile a hand that is free in space, with the usual camera turned as that of a scene."""
    spec = build_hand(size)
    spec.body("forearm").add_freejoint(name="forearm")
    light_any_hand(spec)
    looking = Rotation.from_quat(_direction(seen), scalar_first=True)
    away = 0.5 * _HEIGHT * size.length / np.tan(np.deg2rad(_FOV / 2))
    spec.worldbody.add_camera(
        name=USUAL,
        pos=looking.apply([0.0, 0.0, away]),
        quat=looking.as_quat(scalar_first=True),
        fovy=_FOV,
    )
    return spec.compile()


def _direction(model: mujoco.MjModel) -> Array:
    """Return the orientation of a scene's usual camera, that of the world where it has none."""
    names = [model.camera(i).name for i in range(model.ncam)]
    return model.cam_quat[names.index(USUAL)] if USUAL in names else np.array([1.0, 0.0, 0.0, 0.0])


def _palm_quats(rollout: Rollout, model: mujoco.MjModel) -> Array:
    """Return the orientation of the robot's palm in the world, (n, 4)."""
    data = mujoco.MjData(model)
    palm = model.body("palm").id
    found = np.empty((len(rollout.qpos), 4))
    for row, qpos in zip(found, rollout.qpos, strict=True):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        row[:] = data.xquat[palm]
    return found
