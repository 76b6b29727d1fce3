"""From the path of the palm to the angles of arm and wrist.

A palm pose leaves the swivel free (`handsim.arm.chain`). It is chosen along the whole movement as
the one with the least discomfort: near the swivel that people have, the wrist near the angles that
are asked for, joints within the middle of their ranges, elbow and forearm where a person who sits
at a table has them. Costs that add up over joints describe people's postures well (Cruse,
Wischmeyer, Bruewer, Brockfeld & Dress 1990, Biol. Cybern. 62:519-528).

What cannot be reached is no error: the nearest posture within the ranges is returned, with what it
misses.
"""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from handsim.arm._swivel_path import smooth_swivel
from handsim.arm.arm_geometry import ArmGeometry, Seat
from handsim.arm.arm_joints import CHAIN_LOWER, CHAIN_UPPER, N_ARM, rotation_range
from handsim.arm.chain import angles_at, matrices, mirrored, places
from handsim.arm.naturalness import Unnaturalness, range_use, unnaturalness
from handsim.arm.swivel import USUAL, SwivelLaw
from handsim.errors import InputError
from handsim.types import MEDIAN_HAND, Array, HandSize, Index

_WRIST_SPREAD = np.deg2rad([20.0, 12.0])
"""How far flexion and deviation may be from what is asked for, for a cost of 1 [rad]."""
_UNNATURAL_WEIGHT = 4.0
_SWIVELS = np.deg2rad(np.arange(-40.0, 121.0, 4.0))
"""Among which is chosen first [rad]: beyond, no elbow goes at a table."""
_LONGEST_STEP = 0.06  # between times at which the swivel is chosen, of the movement's duration


@dataclass(frozen=True)
class ArmPosture:
    """Angles of an arm along a movement, and what they miss of it.

    Attributes
    ----------
    arm : (n, 5) [rad]
        Within the ranges, in the order of `handsim.arm.arm_joints.ARM_JOINTS`.
    wrist : (n, 2) [rad]
        Flexion and deviation, within the ranges of the hand's joints.
    swivel : (n,) [rad]
    elbow : (n, 3) [m]
        In the world.
    position_error, rotation_error : (n,) [m], [rad]
        From the palm's pose to the one that the angles give.
    use : (n, 7)
        Where the joints would have to be in their ranges: beyond -1 or 1 they were held back.
    unnatural
        How far from natural the posture is that the palm would need.
    """

    arm: Array
    wrist: Array
    swivel: Array
    elbow: Array
    position_error: Array
    rotation_error: Array
    use: Array
    unnatural: Unnaturalness

    @property
    def strain(self) -> Array:
        """Sum of the terms of `unnatural` and of what is missed, in 1 cm and 10 deg, (n,).

        Up to 1 a person does it; a plan with more at any time needs an arm that no person has.
        """
        missed = self.position_error / 0.01 + self.rotation_error / np.deg2rad(10.0)
        return self.unnatural.total + missed


@dataclass(frozen=True)
class ReachingArm:
    """The arm of a person who sits at the table.

    Parameters
    ----------
    size
        Of the hand, which tells the arm's; its side is the arm's.
    seat
        Where the person sits.
    law
        The swivel without other reasons.

    Examples
    --------
    >>> import numpy as np
    >>> pos = np.tile([-0.12, -0.08, 0.12], (50, 1))
    >>> quat = np.tile([1.0, 0.0, 0.0, 0.0], (50, 1))
    >>> found = ReachingArm().posture(pos, quat)
    >>> found.arm.shape, bool(found.position_error.max() < 1e-9)
    ((50, 5), True)
    """

    size: HandSize = MEDIAN_HAND
    seat: Seat = field(default_factory=Seat)
    law: SwivelLaw = field(default_factory=lambda: SwivelLaw(USUAL))

    @property
    def geometry(self) -> ArmGeometry:
        """Lengths and masses."""
        return ArmGeometry(self.size)

    def posture(self, pos: Array, quat: Array, wrist: Array | None = None) -> ArmPosture:
        """Return the angles with which the palm follows a path.

        Parameters
        ----------
        pos, quat : (n, 3) [m], (n, 4)
            Pose of the palm in the world, w first, at equal steps of time: one movement.
        wrist : (n, 2) or (2,) [rad]
            Flexion and deviation that the hand would like. None is the straight wrist.

        Raises
        ------
        InputError
            If the shapes do not match or a number is not finite.
        """
        asked = (pos, quat, _checked(pos, quat, wrist))
        return _known(self, *(np.asarray(each, dtype=float).tobytes() for each in asked))

    def worked_out(self, pos: Array, quat: Array, wanted: Array) -> ArmPosture:
        """Return `posture` of inputs that are checked, with an angle asked for at each time."""
        where, palm = pos - self.geometry.shoulder(self.seat), matrices(_normed(quat))
        if self.size.side == "left":
            where, palm = mirrored(where, palm)
        rows = _knots(len(pos))
        cost = self._discomfort(where[rows, None], palm[rows, None], _SWIVELS, wanted[rows, None])
        swivel = smooth_swivel(cost, _SWIVELS, rows, len(pos))
        return self._followed(where, palm, swivel)

    def palm(self, arm: Array, wrist: Array) -> tuple[Array, Array]:
        """Return where the palm is in the world: positions (..., 3) [m], rotations (..., 3, 3).

        Parameters
        ----------
        arm, wrist : (..., 5), (..., 2) [rad]
        """
        geometry = self.geometry
        found = places(np.concatenate([arm, wrist], -1), geometry.upper_arm, geometry.forearm)
        pos, rotation = found.wrist, found.palm
        if self.size.side == "left":
            pos, rotation = mirrored(pos, rotation)
        return pos + geometry.shoulder(self.seat), rotation

    def _discomfort(self, where: Array, palm: Array, swivel: Array, wanted: Array) -> Array:
        """Return the cost of swivels, (n, m)."""
        geometry = self.geometry
        angles, elbow = angles_at(where, palm, swivel, geometry.upper_arm, geometry.forearm)
        use = range_use(angles)
        judged = unnaturalness(angles, elbow, where, geometry, self.seat, use)
        usual = self.law.swivel(where, geometry)
        return (
            ((swivel - usual) / self.law.spread) ** 2
            + np.sum(((angles[..., N_ARM:] - wanted) / _WRIST_SPREAD) ** 2, axis=-1)
            + np.sum(use**4, axis=-1)
            + _UNNATURAL_WEIGHT * (judged.elbow**2 + judged.trunk**2 + judged.table**2)
        )

    def _followed(self, where: Array, palm: Array, swivel: Array) -> ArmPosture:
        geometry = self.geometry
        lengths = geometry.upper_arm, geometry.forearm
        angles, elbow = angles_at(where, palm, swivel, *lengths)
        angles[:, :3] = np.unwrap(angles[:, :3], axis=0)
        angles[:, :3] -= 2 * np.pi * np.round(np.median(angles[:, :3], axis=0) / (2 * np.pi))
        use = range_use(angles)
        judged = unnaturalness(angles, elbow, where, geometry, self.seat, use)
        lower, upper = np.tile(CHAIN_LOWER, (len(where), 1)), np.tile(CHAIN_UPPER, (len(where), 1))
        least, most = rotation_range(angles[:, 0])
        lower[:, 2], upper[:, 2] = np.maximum(lower[:, 2], least), np.minimum(upper[:, 2], most)
        held = np.clip(angles, lower, upper)
        got = places(held, *lengths)
        turn = np.einsum("nij,nij->n", got.palm, palm)  # trace of the rotation between both
        flip = np.array([1.0, 1.0 if self.size.side == "right" else -1.0, 1.0])
        return ArmPosture(
            arm=held[:, :N_ARM],
            wrist=held[:, N_ARM:],
            swivel=swivel,
            elbow=flip * got.elbow + geometry.shoulder(self.seat),
            position_error=np.linalg.norm(got.wrist - where, axis=1),
            rotation_error=np.arccos(np.clip((turn - 1) / 2, -1.0, 1.0)),
            use=use,
            unnatural=judged,
        )


@lru_cache(maxsize=32)
def _known(arm: ReachingArm, pos: bytes, quat: bytes, wanted: bytes) -> ArmPosture:
    """Return the angles along a movement: trials and searches make the same again and again."""
    rows = (np.frombuffer(each).reshape(-1, n) for each, n in ((pos, 3), (quat, 4), (wanted, 2)))
    found = arm.worked_out(*rows)
    for each in (found.arm, found.wrist, found.swivel, found.elbow, found.use):
        each.flags.writeable = False
    return found


def _checked(pos: Array, quat: Array, wrist: Array | None) -> Array:
    """Return what is asked of the wrist, (n, 2)."""
    n = len(pos)
    wanted = np.zeros((n, 2)) if wrist is None else np.asarray(wrist, dtype=float)
    if wanted.shape == (2,):
        wanted = np.tile(wanted, (n, 1))
    if pos.shape != (n, 3) or quat.shape != (n, 4) or wanted.shape != (n, 2) or not n:
        raise InputError(
            f"palm positions {pos.shape}, orientations {quat.shape}, wrist angles {wanted.shape}; "
            "give (n, 3), (n, 4) and (n, 2)"
        )
    if not all(np.isfinite(each).all() for each in (pos, quat, wanted)):
        raise InputError("a palm pose or wrist angle is not finite; give finite numbers")
    if not (np.linalg.norm(quat, axis=1) > 0.0).all():
        raise InputError("a quaternion of length 0 is no orientation; give unit quaternions")
    return wanted


def _normed(quat: Array) -> Array:
    return quat / np.linalg.norm(quat, axis=-1, keepdims=True)


def _knots(n: int) -> Index:
    """Return the rows at which the swivel is chosen, the first and the last among them."""
    count = min(n, 2 + round(1 / _LONGEST_STEP))
    return np.unique(np.round(np.linspace(0, n - 1, count)).astype(np.int64))
