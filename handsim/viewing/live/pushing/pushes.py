"""What pushes a finger: somebody who pulls at it like a spring, or a short push on its pad."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np

from handsim.joints import FINGERS
from handsim.types import Array

STIFFNESS = 300.0
"""Force for each metre between a finger and the pointer that pulls at it [N/m]."""
MOST_FORCE = 40.0
"""Largest force of a pull [N]: some adults press more than this with a fingertip, few twice it."""
PUSH_S = 0.3
"""How long a push on a pad lasts [s]."""


class Push(Protocol):
    """A force on the hand, until a time of the simulation [s]."""

    @property
    def until(self) -> float:
        """When it ends [s]."""
        ...

    def apply(self, model: mujoco.MjModel, data: mujoco.MjData) -> float:
        """Add the force to ``qfrc_applied`` and return it [N]."""
        ...


@dataclass(frozen=True, eq=False)
class Pull:
    """A spring between a point of a body and a place in the world.

    Attributes
    ----------
    body
        Id of the body.
    point : (3,) [m]
        Where it is held, in the body's frame.
    target : (3,) [m]
        Where it is pulled to.
    until
        When it ends [s]; it usually does when it is let go.
    """

    body: int
    point: Array
    target: Array
    until: float = np.inf

    @classmethod
    def at(cls, data: mujoco.MjData, body: int, held: Array, target: Array) -> "Pull":
        """Return a pull at a point that is given in the world, (3,) [m]."""
        turn = data.xmat[body].reshape(3, 3)
        return cls(body, turn.T @ (held - data.xpos[body]), target)

    def held(self, data: mujoco.MjData) -> Array:
        """Return where the point is in the world, (3,) [m]."""
        return data.xpos[self.body] + data.xmat[self.body].reshape(3, 3) @ self.point

    def apply(self, model: mujoco.MjModel, data: mujoco.MjData) -> float:
        """Pull, with at most `MOST_FORCE`."""
        held = self.held(data)
        return _apply(model, data, self.body, held, limited(STIFFNESS * (self.target - held)))


@dataclass(frozen=True)
class PadPush:
    """A push on the pad of a finger against its outward normal: it opens the finger.

    Attributes
    ----------
    finger
        One of `FINGERS`.
    force
        Its size [N].
    until
        When it ends [s].
    """

    finger: str
    force: float
    until: float

    def apply(self, model: mujoco.MjModel, data: mujoco.MjData) -> float:
        """Push."""
        site = model.site(f"{self.finger}_pad").id
        inward = data.site_xmat[site].reshape(3, 3)[:, 2]
        body = int(model.site_bodyid[site])
        return _apply(model, data, body, data.site_xpos[site], limited(self.force * inward))


def finger_of(body: str) -> str | None:
    """Return the finger that a body of the hand belongs to; None for palm and forearm."""
    finger = body.partition("_")[0]
    return finger if finger in FINGERS else None


def limited(force: Array) -> Array:
    """Return a force (3,) [N] of at most `MOST_FORCE`, in its direction."""
    size = float(np.linalg.norm(force))
    return force if size <= MOST_FORCE else force * (MOST_FORCE / size)


def _apply(
    model: mujoco.MjModel, data: mujoco.MjData, body: int, point: Array, force: Array
) -> float:
    mujoco.mj_applyFT(model, data, force, np.zeros(3), point, body, data.qfrc_applied)
    return float(np.linalg.norm(force))
