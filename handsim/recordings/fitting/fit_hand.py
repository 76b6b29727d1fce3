"""From points seen on a hand to its side, size, pose and angles: the fits in their order.

1. Some frames in which most is seen tell the side (the hand is fitted as it is and mirrored), the
   size and where on the hand each point is.
2. Then every frame is fitted by itself, and those that ended unlike their neighbours once more from
   where these are.
3. A joint of which no point in a frame tells moves evenly from where it was last seen to where it
   is seen next; so does everything in frames in which the hand is lost.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter

from handsim.errors import InputError
from handsim.recordings.fitting.hand_points import HandPoint, HandPoints, PalmPostures, are_seen
from handsim.recordings.fitting.posture_fit import (
    FIRM_SD_DEG,
    N_ANGLES,
    WEAK_SD_DEG,
    Prior,
    fit_postures,
    frame_costs,
    predicted,
    prior_of,
    told_joints,
)
from handsim.recordings.fitting.size_fit import fit_size
from handsim.recordings.fitting.start import start_from_fingers, start_from_palm
from handsim.types import MEDIAN_HAND, Array, HandSize, Index, Mask, Side

BAD_FIT_M = 0.010
"""Root mean square of what is left over in a frame above which the frame is marked [m]."""
FARTHEST_M = 100.0
"""Coordinates beyond this are no measurements [m]."""
LEAST_SEEN = 5
"""Points without which a frame tells nothing: the hand is lost in it."""
N_FRAMES_OF_SIZE, N_FRAMES_OF_SIDE = 120, 24
SIZE_COUNTS = 4.0
"""How many times what is known of sizes counts where places are not known: with markers, hands a
tenth longer or shorter fit nearly as well."""
CLEAR_SIDE = 1.15
"""How many times worse the other side must fit; below that it is not guessed."""
UNLIKE_NEIGHBOURS = np.deg2rad(12.0)
"""Angle from the median of nine frames from which a frame is fitted again [rad]."""
LEAST_LEAP, FASTEST = np.deg2rad(25.0), np.deg2rad(1000.0)
"""Change between two frames [rad] and speed [rad/s] beyond both of which joints do not go: fast
tapping reaches 600 deg/s."""
SMOOTHED_FRAMES = 3
"""Standard deviation of the frames over which a leap is smoothed."""
PULL_SD = np.deg2rad(6.0)
"""How near to the smooth path angles are held there [rad]."""
ROUNDS_OF_SMOOTHING = 3
_MIRROR = np.array([1.0, -1.0, 1.0])


@dataclass(frozen=True)
class HandFit:
    """A hand fitted to points in n frames.

    Attributes
    ----------
    hand
        Size as fitted or given, and side.
    points
        Where on the right hand each point is.
    q : (n, 22) [rad], glove order, wrist 0
    rotation : (n, 3, 3)
        From the frame of the palm, `handsim.hand.anthropometry`, to that of the points; NaN where
        the hand is lost. A left hand's palm has +y away from its thumb.
    position : (n, 3) [m]
        Of the wrist centre; NaN where the hand is lost.
    residual : (n, m) [m]
        Distance of each point from where it was seen; NaN where it was not.
    other_side
        Root mean square over that of this side if the hand is taken for the other one; infinite
        where the side was given.
    """

    hand: HandSize
    points: HandPoints
    q: Array
    rotation: Array
    position: Array
    residual: Array
    other_side: float

    @property
    def frame_residual(self) -> Array:
        """Root mean square a frame, (n,) [m]; NaN where the hand is lost."""
        return root_mean_square(self.residual, axis=1)

    @property
    def lost(self) -> Mask:
        """Frames in which too little of the hand is seen, (n,)."""
        return ~np.isfinite(self.position[:, 0])

    @property
    def bad(self) -> Mask:
        """Frames in which the hand is lost or fits worse than `BAD_FIT_M`, (n,)."""
        return self.lost | (np.nan_to_num(self.frame_residual) > BAD_FIT_M)

    def in_world(self, body: str) -> tuple[Array, Array]:
        """Return rotations (n, 3, 3) and origins (n, 3) [m] of a body, where the points are."""
        kinematics = self.points.kinematics
        frames, i = kinematics.frames(self.q), kinematics.names.index(body)
        rotation, position = frames.rotation[:, i], frames.position[:, i]
        if self.hand.side == "left":
            rotation, position = _MIRROR[:, None] * rotation * _MIRROR, position * _MIRROR
        moved = (self.rotation @ position[:, :, None])[..., 0] + self.position
        return self.rotation @ rotation, moved


def root_mean_square(values: Array, axis: int | None = None) -> Array:
    """Return the root mean square of what is not NaN; NaN where all is."""
    there = np.isfinite(values)
    total = np.where(there, values, 0.0) ** 2
    count = there.sum(axis=axis)
    mean = total.sum(axis=axis) / np.maximum(count, 1)
    return np.where(count > 0, np.sqrt(mean), np.nan)


def fit_hand(
    where: str,
    points: Sequence[HandPoint],
    seen: Array,
    *,
    hand: HandSize | None = None,
    side: Side | None = None,
    palm_known: bool = True,
    step_s: float = 0.01,
) -> HandFit:
    """Fit handsim's own hand to points over time.

    Parameters
    ----------
    where
        What messages begin with, such as the name of the file.
    points
        m points and where they should be.
    seen : (n, m, 3) [m]
        NaN where a point is not seen.
    hand
        Its size, where that is known.
    side
        Its side, where that is known.
    palm_known
        Whether the places of points are known, as those of keypoints are and those of markers are
        not: then the palm is found by them, and the prior of angles is weak.
    step_s
        Time between frames [s].

    Raises
    ------
    InputError
        If the hand is seen in less than 10 frames, or its side cannot be told.
    """
    seen = np.where(np.abs(np.nan_to_num(seen, nan=np.inf)) <= FARTHEST_M, seen, np.nan)
    seen[~are_seen(seen)] = np.nan
    lost = _lost(points, seen)
    if (~lost).sum() < 10:
        raise InputError(
            f"{where}: the hand is seen in {(~lost).sum()} of {len(seen)} frames, with at least "
            f"{LEAST_SEEN} points; at least 10 are needed"
        )
    there = seen[~lost]
    task = _Task(where, tuple(points), hand, palm_known)
    side, other_side = (side, np.inf) if side is not None else task.side_of(there)
    towards = there * (_MIRROR if side == "left" else 1.0)
    learned = task.learned(towards, N_FRAMES_OF_SIZE)
    prior = prior_of(WEAK_SD_DEG if palm_known else FIRM_SD_DEG)
    postures = _fit_all(learned, towards, step_s, prior)
    return _assembled(learned, postures, side, seen, lost, other_side)


@dataclass(frozen=True)
class _Task:
    where: str
    points: tuple[HandPoint, ...]
    hand: HandSize | None
    palm_known: bool

    def learned(self, seen: Array, n_frames: int) -> HandPoints:
        """Return size and places from some frames of a right hand."""
        expected = HandPoints.expected(self.points, self.hand or MEDIAN_HAND)
        some = seen[_telling_frames(seen, n_frames)]
        start = (start_from_palm if self.palm_known else start_from_fingers)(expected, some)
        return fit_size(
            expected,
            some,
            start,
            fixed_size=self.hand is not None,
            size_counts=1.0 if self.palm_known else SIZE_COUNTS,
        )[0]

    def side_of(self, seen: Array) -> tuple[Side, float]:
        """Return the side that fits better, and how many times worse the other one does."""
        left = {side: self._error(seen * mirror) for side, mirror in _SIDES.items()}
        side: Side = "right" if left["right"] <= left["left"] else "left"
        worse = max(left.values()) / max(min(left.values()), 1e-9)
        if not worse >= CLEAR_SIDE:
            raise InputError(
                f"{self.where}: a right hand fits to {1000 * left['right']:.1f} mm and a left one "
                f"to {1000 * left['left']:.1f} mm, too near to tell; give the side (--side right "
                "or left)"
            )
        return side, worse

    def _error(self, seen: Array) -> float:
        some = seen[_telling_frames(seen, N_FRAMES_OF_SIDE)]
        learned = self.learned(seen, N_FRAMES_OF_SIDE)
        fitted = fit_postures(learned, some, start_from_palm(learned, some))
        return float(root_mean_square(some - predicted(learned, fitted)))


_SIDES: dict[Side, Array] = {"right": np.ones(3), "left": _MIRROR}


def _lost(points: Sequence[HandPoint], seen: Array) -> Mask:
    """Frames in which less than three points of the palm, or too few in all, are seen."""
    there = are_seen(seen)
    on_palm = np.array([point.finger is None for point in points])
    least = min(3, int(on_palm.sum()))
    return (there.sum(axis=1) < LEAST_SEEN) | (there[:, on_palm].sum(axis=1) < least)


def _telling_frames(seen: Array, n_frames: int) -> Index:
    """Return frames spread over the recording, of those in which most points are seen."""
    count = are_seen(seen).sum(axis=1)
    enough = np.sort(count)[::-1][min(n_frames, len(count)) - 1]
    able = np.flatnonzero(count >= enough)
    return able[np.unique(np.linspace(0, len(able) - 1, n_frames).round().astype(np.int64))]


def _fit_all(points: HandPoints, seen: Array, step_s: float, prior: Prior) -> PalmPostures:
    """Fit every frame; then those unlike their neighbours again, from where these are."""
    fitted = fit_postures(points, seen, start_from_palm(points, seen), prior)
    usual = median_filter(fitted.q, size=(9, 1), mode="nearest")
    unlike = np.flatnonzero(np.abs(fitted.q - usual).max(axis=1) > UNLIKE_NEIGHBOURS)
    if len(unlike):
        before = fitted.at(unlike)
        start = PalmPostures(usual[unlike], before.rotation, before.position)
        again = fit_postures(points, seen[unlike], start, prior)
        costs = [frame_costs(points, seen[unlike], each, prior) for each in (before, again)]
        better = costs[1] < costs[0]
        _put(fitted, unlike[better], again.at(better))
    for _ in range(ROUNDS_OF_SMOOTHING):
        _smooth_leaps(points, seen, fitted, step_s, prior)
    return fitted


def _smooth_leaps(
    points: HandPoints, seen: Array, fitted: PalmPostures, step_s: float, prior: Prior
) -> None:
    """Fit again, drawn to a smooth path, what is near a leap that no hand can make; in place.

    Where the points leave a thumb that lies beside the palm two ways to lie, the better one may
    change from frame to frame.
    """
    leap = np.abs(np.diff(fitted.q, axis=0)).max(axis=1) > max(LEAST_LEAP, FASTEST * step_s)
    if not leap.any():
        return
    reach = 2 * SMOOTHED_FRAMES
    near = np.convolve(leap, np.ones(2 * reach), mode="full")[reach - 1 : reach + len(leap)] > 0
    frames = np.flatnonzero(near)
    smooth = gaussian_filter1d(fitted.q, SMOOTHED_FRAMES, axis=0, mode="nearest")[frames]
    start = PalmPostures(smooth, fitted.rotation[frames], fitted.position[frames])
    pulled = prior.with_pull(smooth[:, :N_ANGLES], PULL_SD)
    _put(fitted, frames, fit_postures(points, seen[frames], start, pulled))


def _put(postures: PalmPostures, frames: Index, others: PalmPostures) -> None:
    for old, new in zip(postures.arrays, others.arrays, strict=True):
        old[frames] = new


def _assembled(
    points: HandPoints,
    fitted: PalmPostures,
    side: Side,
    seen: Array,
    lost: Mask,
    other_side: float,
) -> HandFit:
    """Put the frames in which the hand is lost back in, and a left hand on its own side."""
    n = len(seen)
    q, rotation = np.full((n, fitted.q.shape[1]), np.nan), np.full((n, 3, 3), np.nan)
    position, residual = np.full((n, 3), np.nan), np.full(seen.shape[:2], np.nan)
    q[~lost], rotation[~lost], position[~lost] = fitted.arrays
    mirror = _SIDES[side]
    off = seen[~lost] * mirror - predicted(points, fitted)
    residual[~lost] = np.sqrt((off**2).sum(axis=2))
    told = told_joints(points, seen)
    never = np.asarray(~told.any(axis=0), dtype=bool)  # these keep to the prior
    q[~(told | never) | lost[:, None]] = np.nan
    rotation, position = mirror[:, None] * rotation * mirror, position * mirror
    hand = HandSize(points.hand.length, points.hand.breadth, side)
    return HandFit(hand, points, _filled(q), rotation, position, residual, other_side)


def _filled(q: Array) -> Array:
    """Return angles with what is NaN on the straight line between what is not."""
    frames = np.arange(len(q))
    for column in q.T:
        known = np.isfinite(column)
        if not known.all():
            column[~known] = np.interp(frames[~known], frames[known], column[known])
    return q
