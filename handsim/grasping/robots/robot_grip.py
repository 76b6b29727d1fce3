"""Squeeze with a robot hand: one direction is held by force, all others by posture.

Fingers of published hands are driven by soft position servos, often of 1 N m/rad: were the force of
each controlled by itself, they would push what they hold to and fro between them. Instead the whole
hand closes along one direction of its coordinates, as far as gives the force that is wanted between
thumb and fingers. From the lift on every other direction is put back to where it was, as far as
what is carried bends it.
"""

from dataclasses import dataclass, field

import numpy as np

from handsim.grasping.gripping.grip import (
    LIGHT,
    MOST,
    SLIDES,
    SLIP_DOUBLES,
    SMOOTHING,
    SURPRISE,
)
from handsim.grasping.robots.robot_servos import RobotServos
from handsim.joints import FINGERS
from handsim.types import Array, Mask

LAGS = 1.0
"""Time constants in which forces and postures are corrected, relative to that with which the servos
follow: faster, they would swing."""
QUICKEST = 0.05
"""Least time constant of these corrections [s]."""
FASTEST = 2.0
"""How fast the hand closes at most, in units of the squeeze [1/s]."""
MOST_CLOSED = 4.0
"""How far it closes at most, in units of the squeeze."""
SWAYS = 3.0
"""How many times as fast as in a person's hand things move before they count as sliding: soft
fingers sway."""
MOST_KEPT = 0.6
"""Most that targets are moved to keep a posture [rad]."""
GRIP_SETTINGS = (LAGS, QUICKEST, FASTEST, MOST_CLOSED, SWAYS, MOST_KEPT)
"""What plans are made for, beside the task."""
_THUMB = FINGERS.index("thumb")


@dataclass
class RobotGrip:
    """Targets of a hand that squeezes, reading by reading.

    Attributes
    ----------
    closing : (m,) [rad]
        Direction in which the hand closes.
    grip : [N]
        What thumb and fingers press on their sides, until load or sliding make it more.
    servos
        Of the robot where it grasps.
    kept : (m,)
        Coordinates that keep their posture in the action; others are moved by it.
    closed : float
        How far the hand has closed, in units of the squeeze.
    """

    closing: Array
    grip: float
    servos: RobotServos
    kept: Mask
    closed: float = field(init=False, default=0.0)

    def __post_init__(self) -> None:
        """Begin open, with no force."""
        self._light, self._tighter, self._force = min(LIGHT, self.grip), 1.0, 0.0
        self._settling = max(QUICKEST, LAGS * self.servos.lag)
        self._stiffness = self.servos.force_of(self.closing)
        along = np.outer(self.closing, self.closing) / max(self.closing @ self.closing, 1e-12)
        self._aside = np.where(self.kept[:, None], np.eye(len(self.closing)) - along, 0.0)
        self._at: Array | None = None
        self._offset = np.zeros(len(self.closing))

    def feel(self, forces: list[float]) -> None:
        """Take in the normal forces of the fingers, (5,) [N]."""
        thumb = forces[_THUMB]
        between = min(thumb, sum(forces) - thumb)
        self._force += SMOOTHING * (between - self._force)

    def tighten(self, slip: float, load: float, dt: float) -> None:
        """Become tighter where the object slides [m/s], or weighs more than it was to weigh."""
        slipped = self._tighter + dt * max(slip - SWAYS * SLIDES, 0.0) / SLIP_DOUBLES
        self._tighter = min(max(slipped, load / SURPRISE), MOST)

    def targets(self, told: Array, squeeze: float, dt: float) -> Array:
        """Return the targets (m,), where a hand is told to be at (m,).

        Parameters
        ----------
        told : (m,)
        squeeze
            How far the squeeze has come, 0 to 1; until it begins the hand does as it is told.
        dt : [s]
            Since the last.
        """
        if squeeze > 0.0:
            level = self._light + min(1.5 * squeeze, 1.0) * (self.grip - self._light)
            missing = level * self._tighter - self._force
            rate = missing / (self._stiffness * self._settling)
            rate = min(max(rate, -FASTEST), FASTEST)
            self.closed = min(max(self.closed + dt * rate, -1.0), MOST_CLOSED)
        return told + self.closed * self.closing + self._offset

    def keep(self, x: Array, dt: float) -> None:
        """Put back what has given way since this was first called, coordinates x (m,) measured."""
        if self._at is None:
            self._at = x.copy()
        back = dt / self._settling * (self._aside @ (self._at - x))
        self._offset = np.clip(self._offset + back, -MOST_KEPT, MOST_KEPT)
