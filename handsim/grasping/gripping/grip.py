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
_JOINTS_OF = [np.flatnonzero(finger == _OF_FINGER).tolist() for finger in range(len(FINGERS))]
_BY_FINGER = np.concatenate(_JOINTS_OF).astype(np.int64)
_STARTS = np.searchsorted(_OF_FINGER[_BY_FINGER], np.arange(len(FINGERS)))
"""The joints of fingers, finger by finger, and where each finger's begin."""


Rows = Array | list[list[float]]
"""A row for each run: arrays, or numbers of one by itself, which are faster."""


def shares_of(fingers: Sequence[Finger]) -> Array:
    """Return shares of a grip, (5,): 1 for the thumb, together 1 for what opposes it."""
    opposing = np.array([finger in fingers and finger != "thumb" for finger in FINGERS])
    shares = opposing / max(int(opposing.sum()), 1)
    shares[FINGERS.index("thumb")] = 1.0
    return shares


class _Hold:
    """What the fingers of one run press, as numbers: of a few they are faster than arrays.

    Attributes
    ----------
    force : (5,) [N]
        Running means of the measured forces.
    touched : (5,)
        Whether each finger has touched.
    press : (5,) [rad]
        How far it goes beyond where it touched.
    at : (22,) [rad]
        Where that is, of the joints of fingers that have touched.
    """

    def __init__(self, shares: list[float], flexed: list[bool], grip: float) -> None:
        self.force, self.press = [0.0] * len(FINGERS), [0.0] * len(FINGERS)
        self.touched, self.at = [False] * len(FINGERS), [0.0] * len(JOINTS)
        self._holding: list[int] = []
        self._kept = 0
        self._ways: list[tuple[int, float, list[tuple[int, float, float]]]] = []
        self._shares, self._flexed = shares, flexed
        self._light = min(LIGHT, grip)
        self._more = grip - self._light
        self._tighter, self._since = 1.0, 1.0

    def feel(self, forces: Sequence[float]) -> bool:
        """Take in what is measured; return whether a finger has touched now."""
        newly, means = False, self.force
        for i, force in enumerate(forces):
            if force or means[i]:  # most fingers have felt nothing yet, and go on so
                means[i] += SMOOTHING * (force - means[i])
                if force > TOUCH and not self.touched[i]:
                    self.touched[i] = newly = True
                    self._holding.append(i)
        return newly

    def touch(self, q: Sequence[float]) -> None:
        """Keep the measured posture of the fingers that have touched now."""
        for finger in self._holding[self._kept :]:
            for joint in _JOINTS_OF[finger]:
                self.at[joint] = q[joint]
        self._kept = len(self._holding)

    def aim(self, told: Sequence[float], closing: Sequence[float]) -> None:
        """Find the ways along which fingers press: from where they touched to where they close."""
        self._ways = []
        for finger in self._holding:
            ways = [
                (joint, self.at[joint], told[joint] + closing[joint] - self.at[joint])
                for joint in _JOINTS_OF[finger]
            ]
            longest = max(abs(way) for _, _, way in ways)
            self._ways.append((finger, max(longest, SHORT), ways))

    def tighten(self, slip: float, load: float, dt: float) -> None:
        """Become tighter where the object slides, or weighs more than it was to weigh."""
        if not self._holding:
            return
        before = self._tighter
        slipped = before + dt * max(slip - SLIDES, 0.0) / SLIP_DOUBLES
        self._tighter = min(max(slipped, load / SURPRISE), MOST)
        self._since = self._since + dt if self._tighter <= before else 0.0

    def settle(self, closed: float, dt: float, acting: bool) -> None:
        """Press more where there is too little force, less where there is too much.

        In the action the thumb supports what the fingers press: two that both correct for long
        would push the object to and fro. What the action flexes presses as far as it says.
        """
        level = (self._light + min(1.5 * closed, 1.0) * self._more) * self._tighter
        idle, gain = min(IDLE, level), dt / (SETTLING * _PER_RADIAN)
        supports = acting and self._since >= FOLLOWS
        presses, means, shares, flexed = self.press, self.force, self._shares, self._flexed
        for i in self._holding:
            if (acting and flexed[i]) or (supports and i == _THUMB):
                continue
            wanted = level * shares[i] if shares[i] > 0.0 else idle
            press = presses[i] + gain * (wanted - means[i])
            presses[i] = -BEYOND if press < -BEYOND else BEYOND if press > BEYOND else press

    def targets(self, free: list[float]) -> list[float]:
        """Return the targets of all joints, of which those of free fingers are given."""
        q = free.copy()
        for finger, longest, ways in self._ways:
            scale = self.press[finger] / longest
            for joint, at, way in ways:
                q[joint] = at + scale * way
        return q


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

    def __post_init__(self) -> None:
        """Begin with no finger touching."""
        shares, flexed = self.shares.tolist(), self.flexed.tolist()
        self._runs = [_Hold(shares, flexed, grip) for grip in self.grip.tolist()]
        self._closing: list[float] = self.closing.tolist()
        self._closes = self.closing[None]  # of one run as fast as two rows, several times a row
        # What stays the same from one reading to the next is kept, since all this is done in a
        # hundredth of a second a hundred times a second.
        self._told: Array | None = None
        self._far = 0.0
        self._free: list[float] = []
        self._begin, self._way, self._longest = np.empty(0), np.empty(0), np.empty(0)

    @property
    def force(self) -> Array:
        """Running means of the measured forces (n, 5) [N]."""
        return np.array([run.force for run in self._runs])

    @property
    def touched(self) -> Mask:
        """Whether fingers have touched, (n, 5)."""
        return np.array([run.touched for run in self._runs])

    @property
    def press(self) -> Array:
        """How far fingers go beyond where they touched, (n, 5) [rad]."""
        return np.array([run.press for run in self._runs])

    @property
    def at(self) -> Array:
        """Where fingers touched, (n, 22) [rad]."""
        return np.array([run.at for run in self._runs])

    def feel(self, forces: Sequence[Sequence[float]]) -> bool:
        """Take in measured normal forces (n, 5) [N]; return whether a finger has touched now.

        Then `touch` wants to know where.
        """
        return True in [run.feel(row) for run, row in zip(self._runs, forces, strict=True)]

    def touch(self, q: Array) -> None:
        """Keep the measured posture (n, 22) [rad] of the fingers that have touched now."""
        for run, row in zip(self._runs, q.tolist(), strict=True):
            run.touch(row)
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
    ) -> Rows:
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
        far = closed + self.sought
        if slip is not None and load is not None:
            for run, slides, weighs in zip(self._runs, slip, load, strict=True):
                run.tighten(slides, weighs, dt)
        for run in self._runs:
            run.settle(closed, dt, acting)
        anew = told is not self._told
        if anew or far != self._far:
            self._told, self._far, free = told, far, told + far * self._closes
            if len(self._runs) > 1:
                self._aim(told, free)
            else:
                self._free = free[0].tolist()
        if len(self._runs) > 1:
            scale = self.press / self._longest
            return self._begin + scale.take(_COLUMNS, axis=1) * self._way
        (run,) = self._runs  # one by itself is faster as numbers
        if anew:
            run.aim(told[0].tolist(), self._closing)
        return [run.targets(self._free)]

    def _aim(self, told: Array, free: Array) -> None:
        """Find where joints of several runs press from, and their ways; free ones have none."""
        at, holds = self.at, self.touched[:, _COLUMNS] & ~_FIXED
        self._way = np.where(holds, told + self.closing - at, 0.0)
        along = np.abs(self._way).take(_BY_FINGER, axis=1)
        self._longest = np.maximum(np.maximum.reduceat(along, _STARTS, axis=1), SHORT)
        self._begin = np.where(holds, at, free)


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
    ) -> Rows:
        """Return the targets (n, 22) [rad] as they were told."""
        return told if len(told) > 1 else told.tolist()
