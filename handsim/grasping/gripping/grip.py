"""The grip layer: fingers that have touched hold with a force, not with a posture.

Until a finger touches it goes where it is told. From then on it stays where it touched and presses
along the way that it was going, as far as brings its force to its share of the grip. Shares of the
fingers add up to what the thumb presses. Where things are carried, a load beyond what was to be
carried makes all press more, and so does sliding, as they do people within a tenth of a second
(Johansson and Westling 1984, Exp. Brain Res. 56:550-564). What has become tighter stays so.

What is measured are normal forces on the skin of each finger, as tactile sensors give them, how
fast the object moves in the palm, and how much of its weight the hand carries.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from handsim.hand.strength import FINGERTIP_FORCE, SATURATION
from handsim.joints import FINGERS, JOINTS, Finger
from handsim.types import Array, Mask

TOUCH = 0.3
"""Force above which a finger has touched [N]."""
LIGHT = 1.0
"""What fingers press with until the hand has closed [N]: enough to feel, too little to push."""
IDLE = 0.5
"""What fingers that the grasp does not use press with, where they touch [N]."""
SMOOTHING = 0.4
"""Share of the newest force in its running mean: a time constant of 20 ms at 100 Hz."""
SETTLING = 0.05
"""Time constant with which a force approaches its share [s]."""
BEYOND = float(np.deg2rad(30.0))
"""How far a finger goes beyond where it touched, to press [rad]."""
SEEKING, SOUGHT = 4.0, 2.0
"""How fast a finger that has met nothing closes on, and how far, in units of the squeeze [1/s]."""
SHORT = float(np.deg2rad(2.0))
"""Shorter ways than this say nothing about a direction [rad]."""
SURPRISE = 1.15
"""Load, relative to what was to be carried, from which on the grip grows in proportion: what things
weigh is felt as they are lifted (Johansson and Westling 1984)."""
SLIDES, SLIP_DOUBLES, MOST = 0.03, 0.003, 3.0
"""Speed in the palm above which things slide, and do not only give way [m/s]; how far they slide
beyond that speed while the grip grows by what it was to be [m]; and how many times as hard it
becomes at most, whatever is felt."""
FOLLOWS = 0.15
"""How long the thumb takes part after the grip has last tightened [s]."""

GRIP = (
    *(TOUCH, LIGHT, IDLE, SMOOTHING, SETTLING, BEYOND, SEEKING, SOUGHT, SHORT),
    *(SURPRISE, SLIDES, SLIP_DOUBLES, MOST, FOLLOWS),
)
"""What plans are made for, beside the task."""

_THUMB = FINGERS.index("thumb")
_PER_RADIAN = FINGERTIP_FORCE / SATURATION  # of a finger all of whose joints are off [N/rad]
_OF_FINGER = np.array(
    [-1 if joint.finger is None else FINGERS.index(joint.finger) for joint in JOINTS]
)
_FIXED = _OF_FINGER < 0
_COLUMNS = np.where(_FIXED, 0, _OF_FINGER)
_BY_FINGER = np.argsort(_OF_FINGER, kind="stable")[np.sort(_OF_FINGER) >= 0]
_STARTS = np.searchsorted(_OF_FINGER[_BY_FINGER], np.arange(len(FINGERS)))
"""The joints of fingers, finger by finger, and where each finger's begin."""


def shares_of(fingers: Sequence[Finger]) -> Array:
    """Return shares of a grip, (5,): 1 for the thumb, together 1 for what opposes it."""
    opposing = np.array([finger in fingers and finger != "thumb" for finger in FINGERS])
    shares = opposing / max(int(opposing.sum()), 1)
    shares[FINGERS.index("thumb")] = 1.0
    return shares


class _Hold:
    """What the fingers of one run press, as numbers: they are faster than arrays of five.

    Attributes
    ----------
    force : (5,) [N]
        Running means of the measured forces.
    touched : (5,)
        Whether each finger has touched.
    press : (5,) [rad]
        How far it goes beyond where it touched.
    """

    def __init__(self, shares: list[float], flexed: list[bool], grip: float) -> None:
        self.force, self.press = [0.0] * len(FINGERS), [0.0] * len(FINGERS)
        self.touched = [False] * len(FINGERS)
        self._shares, self._flexed = shares, flexed
        self._light = min(LIGHT, grip)
        self._more = grip - self._light
        self._tighter, self._since = 1.0, 1.0

    def feel(self, forces: Sequence[float]) -> bool:
        """Take in what is measured; return whether a finger has touched now."""
        newly = False
        for i, force in enumerate(forces):
            self.force[i] += SMOOTHING * (force - self.force[i])
            if force > TOUCH and not self.touched[i]:
                self.touched[i] = newly = True
        return newly

    def tighten(self, slip: float, load: float, dt: float) -> None:
        """Become tighter where the object slides, or weighs more than it was to weigh."""
        before = self._tighter
        slipped = before + dt * max(slip - SLIDES, 0.0) / SLIP_DOUBLES
        self._tighter = min(max(slipped, load / SURPRISE), MOST)
        self._since = self._since + dt if self._tighter <= before else 0.0

    def settle(self, closed: float, dt: float, acting: bool) -> None:
        """Press more where there is too little force, less where there is too much."""
        level = (self._light + min(1.5 * closed, 1.0) * self._more) * self._tighter
        idle, gain = min(IDLE, level), dt / (SETTLING * _PER_RADIAN)
        for i, (touched, share, force) in enumerate(
            zip(self.touched, self._shares, self.force, strict=True)
        ):
            if touched and not (acting and self._rests(i)):
                wanted = level * share if share > 0.0 else idle
                press = self.press[i] + gain * (wanted - force)
                self.press[i] = min(max(press, -BEYOND), BEYOND)

    def _rests(self, finger: int) -> bool:
        """Whether a finger's force is left as it is in the action.

        The thumb supports what the fingers press: two that both correct for long would push the
        object to and fro. What the action flexes presses as far as it says.
        """
        return self._flexed[finger] or (finger == _THUMB and self._since >= FOLLOWS)


@dataclass
class GripLayer:
    """Commands of n runs with forces held, reading by reading.

    Attributes
    ----------
    closing : (22,) [rad]
        How the fingers that grasp close (`squeeze_offset`).
    shares : (5,)
        Of the grip, by finger; 0 for those that the grasp does not use.
    flexed : (5,)
        Fingers that the task's action flexes: from its start on they press as far as it says.
    grip : (n,) [N]
        What thumb and fingers press on their sides, until load or sliding make it more.
    """

    closing: Array
    shares: Array
    flexed: Mask
    grip: Array
    sought: float = field(init=False, default=0.0)
    touched: Mask = field(init=False)
    at: Array = field(init=False)
    press: Array = field(init=False)

    def __post_init__(self) -> None:
        """Begin with no finger touching."""
        n = len(self.grip)
        shares, flexed = self.shares.tolist(), self.flexed.tolist()
        self._runs = [_Hold(shares, flexed, grip) for grip in self.grip.tolist()]
        self.touched = np.zeros((n, len(FINGERS)), dtype=bool)
        self.press, self.at = np.zeros((n, len(FINGERS))), np.zeros((n, len(JOINTS)))
        # What stays the same from one reading to the next is kept, since all this is done in a
        # hundredth of a second a hundred times a second.
        self._any_touched = False
        self._holds = np.zeros((n, len(JOINTS)), dtype=bool)
        self._told: Array | None = None
        self._way, self._longest = np.empty(0), np.empty(0)

    @property
    def force(self) -> Array:
        """Running means of the measured forces (n, 5) [N]."""
        return np.array([run.force for run in self._runs])

    def feel(self, forces: Sequence[Sequence[float]]) -> bool:
        """Take in measured normal forces (n, 5) [N]; return whether a finger has touched now.

        Then `touch` wants to know where.
        """
        return True in [run.feel(row) for run, row in zip(self._runs, forces, strict=True)]

    def touch(self, q: Array) -> None:
        """Keep the measured posture (n, 22) [rad] of the fingers that have touched now."""
        before, self._any_touched = self._holds, True
        self.touched = np.array([run.touched for run in self._runs])
        self._holds = self.touched[:, _COLUMNS] & ~_FIXED
        self.at = np.where(self._holds & ~before, q, self.at)
        self._told = None  # ways begin elsewhere

    def command(
        self,
        told: Array,
        slip: Sequence[float] | None,
        load: Sequence[float] | None,
        closed: float,
        dt: float,
        *,
        acting: bool,
    ) -> Array:
        """Return the targets of all joints, (n, 22) [rad]; `feel` comes first.

        Parameters
        ----------
        told : (n, 22) [rad]
            Where the driver wants the hand. The same array as before has the same values.
        slip : (n,) [m/s]
            How fast the object moves in the palm; None before the action, and where it is not
            carried.
        load : (n,)
            What the hand carries, relative to what it was to carry; None as for ``slip``.
        closed
            How far the squeeze has come, 0 to 1: the grip grows with it.
        dt : [s]
            Since the last command.
        acting
            Whether the task's action has begun.
        """
        if closed >= 1.0:  # fingers that have met nothing yet go on
            self.sought = min(self.sought + SEEKING * dt, SOUGHT)
        free = told + (closed + self.sought) * self.closing
        if not self._any_touched:
            return free
        if slip is not None and load is not None:
            for run, slides, weighs in zip(self._runs, slip, load, strict=True):
                run.tighten(slides, weighs, dt)
        for run in self._runs:
            run.settle(closed, dt, acting)
        self.press = np.array([run.press for run in self._runs])
        if told is not self._told:
            self._told, self._way = told, told + self.closing - self.at
            longest = np.maximum.reduceat(np.abs(self._way)[:, _BY_FINGER], _STARTS, axis=1)
            self._longest = np.maximum(longest, SHORT)
        scale = (self.press / self._longest).take(_COLUMNS, axis=1)
        return np.where(self._holds, self.at + scale * self._way, free)


class Ungripped:
    """What stands in place of a `GripLayer` where nothing holds: fingers go where they are told."""

    def feel(self, forces: Sequence[Sequence[float]]) -> bool:
        """Return False: no touch is of interest."""
        return False

    def touch(self, q: Array) -> None:
        """Do nothing with a posture (n, 22) [rad]."""

    def command(
        self,
        told: Array,
        slip: Sequence[float] | None,
        load: Sequence[float] | None,
        closed: float,
        dt: float,
        *,
        acting: bool,
    ) -> Array:
        """Return the targets (n, 22) [rad] as they were told."""
        return told
