"""The size of a hand, and where on it its points are, fitted over frames of a whole recording.

Size and places are the same in all frames; angles and pose are each frame's own. One step of damped
least squares changes all of them: the unknowns of each frame are eliminated first, which leaves a
small system of the shared ones (Schur complement, as in bundle adjustment: B. Triggs and others
(2000), "Bundle adjustment, a modern synthesis").
"""

from dataclasses import dataclass

import numpy as np

from handsim.hand.anthropometry import HAND_BREADTH_RANGE, HAND_LENGTH_RANGE
from handsim.recordings.fitting.hand_points import HandPoints, PalmPostures, are_seen
from handsim.recordings.fitting.posture_fit import (
    fit_postures,
    frame_costs,
    linearised,
    moved,
    predicted,
    step_equations,
    weak_prior,
)
from handsim.types import MEDIAN_HAND, Array, HandSize

LENGTH_SD = 0.12
"""Standard deviation of the logarithm of hand length over people, children among them."""
BREADTH_SD = 0.05
"""The same of breadth over length; ANSUR II has 0.045 over men and women."""
N_INDEPENDENT = 10
"""Frames that tell of size and places as if they were all: what the model cannot follow repeats
itself from frame to frame, and would else overrule what is known of hands beforehand."""
MAX_STEPS = 25
ENOUGH = 1e-5
_SIZE_STEP = 1e-5
# A little inside of what can be built, so that a smaller hand can be for the derivatives.
_LENGTHS = (HAND_LENGTH_RANGE[0] * (1 + 2 * _SIZE_STEP), HAND_LENGTH_RANGE[1])
_BREADTHS = (HAND_BREADTH_RANGE[0] * (1 + 2 * _SIZE_STEP), HAND_BREADTH_RANGE[1])


@dataclass(frozen=True)
class _Shared:
    """The shared unknowns: logarithms of length and breadth, and offsets of the points."""

    points: HandPoints
    fixed_size: bool
    size_counts: float

    def moved(self, step: Array) -> "_Shared":
        """Return them after a step, (2 + 3 m,); sizes keep to what can be built."""
        hand = self.points.hand
        if not self.fixed_size:
            hand = HandSize(
                float(np.clip(hand.length * np.exp(step[0]), *_LENGTHS)),
                float(np.clip(hand.breadth * np.exp(step[1]), *_BREADTHS)),
            )
        offset = self.points.offset + step[2:].reshape(-1, 3)
        return _Shared(
            HandPoints(self.points.points, hand, offset), self.fixed_size, self.size_counts
        )

    def prior(self) -> tuple[Array, Array, float]:
        """Return matrix, slope downwards and cost of what is known beforehand."""
        size = self.points.hand
        length = np.log(size.length / MEDIAN_HAND.length)
        breadth = np.log(size.breadth / MEDIAN_HAND.breadth) - length
        length_sd, breadth_sd = (sd / np.sqrt(self.size_counts) for sd in (LENGTH_SD, BREADTH_SD))
        of_length = np.array([1.0, 0.0]) / length_sd
        of_breadth = np.array([-1.0, 1.0]) / breadth_sd
        matrix = np.diag(np.concatenate([[0.0, 0.0], 1 / self._spread**2]))
        matrix[:2, :2] = np.outer(of_length, of_length) + np.outer(of_breadth, of_breadth)
        offset = self.points.offset.ravel() / self._spread
        slope = np.concatenate(
            [
                -of_length * length / length_sd - of_breadth * breadth / breadth_sd,
                -offset / self._spread,
            ]
        )
        cost = (length / length_sd) ** 2 + (breadth / breadth_sd) ** 2 + float(offset @ offset)
        return matrix, slope, cost

    @property
    def _spread(self) -> Array:
        return np.maximum(self.points.spread.ravel(), 1e-7)


def fit_size(
    points: HandPoints,
    seen: Array,
    start: PalmPostures,
    *,
    fixed_size: bool = False,
    size_counts: float = 1.0,
) -> tuple[HandPoints, PalmPostures]:
    """Fit size, places of points and postures to some frames of a recording.

    Parameters
    ----------
    points
        With the size and places to begin with.
    seen : (n, m, 3) [m], NaN where a point is not seen
    start
        n postures.
    fixed_size
        Whether the size is known, so that only places are fitted.
    size_counts
        How many times what is known of sizes of hands counts: more where the places of points are
        not known, and longer hands fit nearly as well as shorter ones.
    """
    prior, share = weak_prior(), len(seen) / N_INDEPENDENT
    shared, postures = _Shared(points, fixed_size, size_counts), fit_postures(points, seen, start)
    damping = 1e-3

    def whole_cost(shared: _Shared, postures: PalmPostures) -> float:
        own = frame_costs(shared.points, seen, postures, prior).sum()
        return float(own + share * shared.prior()[2])

    cost = whole_cost(shared, postures)
    for _ in range(MAX_STEPS):
        steps, common = _steps(shared, seen, postures, damping, share)
        tried, tried_postures = shared.moved(common), moved(postures, steps)
        tried_cost = whole_cost(tried, tried_postures)
        if tried_cost < cost:
            done = cost - tried_cost < ENOUGH * cost
            shared, postures, cost = tried, tried_postures, tried_cost
            damping = max(damping / 5, 1e-9)
            if done:
                break
        else:
            damping *= 8
            if damping > 1e6:
                break
    return shared.points, fit_postures(shared.points, seen, postures)


def _steps(
    shared: _Shared, seen: Array, postures: PalmPostures, damping: float, share: float
) -> tuple[Array, Array]:
    """Return the steps of the frames' unknowns (n, 26) and of the shared ones (2 + 3 m,)."""
    prior = weak_prior()
    off, own_slope = linearised(shared.points, seen, postures)
    slope = _shared_slope(shared, seen, postures)
    own, down = step_equations(off, own_slope, postures, prior, np.full(len(seen), damping))
    coupling = own_slope.swapaxes(1, 2) @ slope
    coupling[np.einsum("nii->ni", own) == 1.0] = 0.0  # angles that stand at an end
    known, known_slope, _ = shared.prior()
    common = np.einsum("nij,nik->jk", slope, slope, optimize=True) + share * known
    common[np.diag_indices(len(common))] *= 1 + damping
    common_down = np.einsum("nij,ni->j", slope, off) + share * known_slope
    solved = np.linalg.solve(own, np.concatenate([coupling, down[..., None]], axis=2))
    common -= np.einsum("nij,nik->jk", coupling, solved[..., :-1], optimize=True)
    common_down -= np.einsum("nij,ni->j", coupling, solved[..., -1])
    step = np.linalg.solve(common, common_down)
    return solved[..., -1] - solved[..., :-1] @ step, step


def _shared_slope(shared: _Shared, seen: Array, postures: PalmPostures) -> Array:
    """Return derivatives of where points are by the shared unknowns, (n, 3 m, 2 + 3 m)."""
    points = shared.points
    n, m = seen.shape[:2]
    in_palm = PalmPostures(postures.q, np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 3)))
    slope = np.zeros((n, m, 3, 2 + 3 * m))
    if not shared.fixed_size:
        for i in range(2):
            two = [_resized(points, i, factor) for factor in (1.0, 1.0 - _SIZE_STEP)]
            change = predicted(two[0], in_palm) - predicted(two[1], in_palm)
            slope[..., i] = change / _SIZE_STEP
    rotation = points.kinematics.frames(postures.q).rotation
    for i, body in enumerate(points.on_hand.body):
        slope[:, i, :, 2 + 3 * i : 5 + 3 * i] = rotation[:, body]
    there = are_seen(seen) / points.noise
    slope *= there[..., None, None]
    return slope.reshape(n, 3 * m, -1)


def _resized(points: HandPoints, which: int, factor: float) -> HandPoints:
    """Return the points on a hand of another length (0) or breadth (1)."""
    sizes = [points.hand.length, points.hand.breadth]
    sizes[which] *= factor
    return HandPoints(points.points, HandSize(sizes[0], sizes[1]), points.offset)
