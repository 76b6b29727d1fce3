"""The least-squares problem of one posture, and whether its solution matches."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from handsim.joints import Finger
from handsim.retargeting.robot_hand import Fingertips
from handsim.types import Array

if TYPE_CHECKING:
    from handsim.retargeting.retarget import Retargeter

TIP_TOLERANCE = 0.25
"""How far a fingertip may be from its target, / mean length of the robot's fingers, to match."""


OPENING_TOLERANCE = 0.10
"""How far the vector from thumb to finger may be off, / that length and the vector's together."""


class PostureFit:
    """The least-squares problem of one posture."""

    def __init__(self, retargeter: "Retargeter", q: Array) -> None:
        self.robot, self.weights = retargeter.robot, retargeter.weights
        self.unit = retargeter.unit
        self.points, self.openings, self.directions, of_openings = retargeter.targets(q)
        self.of_openings = of_openings[:, None]
        self.middle = (self.robot.lower + self.robot.upper) / 2
        self.half = np.maximum((self.robot.upper - self.robot.lower) / 2, 1e-9)

    def first(self) -> Array:
        """Fit from several starts, there being no posture before; return the best."""
        lower, upper = self.robot.lower, self.robot.upper
        starts = (self.robot.reference, self.middle, 0.75 * lower + 0.25 * upper)
        fits = [self._solve(np.clip(x, lower, upper), lower, upper) for x in starts]
        return min(fits, key=lambda fit: fit[1])[0]

    def after(self, previous: Array, max_step: Array) -> Array:
        """Fit from the posture before, and no further from it than ``max_step``, (m,)."""
        lower = np.maximum(self.robot.lower, previous - max_step)
        upper = np.minimum(self.robot.upper, previous + max_step)
        return self._solve(previous, lower, upper, previous)[0]

    def errors(self, x: Array) -> tuple[Array, Array, Array]:
        """Return how far fingertips and thumb-finger vectors are off [m], and / what may be."""
        points = self.robot.forward(x).points
        tip = np.linalg.norm(points - self.points, axis=1)
        opening = np.linalg.norm(openings_of(points, self.robot.fingers) - self.openings, axis=1)
        wide = self.unit + np.linalg.norm(self.openings, axis=1)
        excess = np.maximum(tip / TIP_TOLERANCE / self.unit, opening / OPENING_TOLERANCE / wide)
        return tip, opening, excess

    def _solve(
        self, start: Array, lower: Array, upper: Array, previous: Array | None = None
    ) -> tuple[Array, float]:
        """Return the optimum within bounds, (m,), and its cost."""
        free = upper - lower > 1e-9
        x = np.clip(start, lower, upper)
        cache: dict[bytes, Fingertips] = {}

        def whole(part: Array) -> Array:
            full = x.copy()
            full[free] = part
            return full

        def forward(part: Array) -> Fingertips:
            key = part.tobytes()
            if key not in cache:
                cache.clear()
                cache[key] = self.robot.forward(whole(part))
            return cache[key]

        result = least_squares(
            lambda part: self._residual(whole(part), forward(part), previous),
            x[free],
            lambda part: self._jacobian(forward(part), previous)[:, free],  # pyright: ignore[reportArgumentType]
            bounds=(lower[free], upper[free]),
            x_scale="jac",
            xtol=1e-7,
            ftol=1e-9,
            max_nfev=100,
        )
        return whole(result.x), float(result.cost)

    def _residual(self, x: Array, tips: Fingertips, previous: Array | None) -> Array:
        weights = self.weights
        openings = openings_of(tips.points, self.robot.fingers)
        parts = [
            weights.tip / self.unit * (tips.points - self.points),
            self.of_openings / self.unit * (openings - self.openings),
            weights.direction * (tips.directions - self.directions),
            weights.middle * (x - self.middle) / self.half,
        ]
        if previous is not None:
            parts.append(weights.previous * (x - previous))
        return np.concatenate([part.ravel() for part in parts])

    def _jacobian(self, tips: Fingertips, previous: Array | None) -> Array:
        weights = self.weights
        openings = openings_of(tips.d_points, self.robot.fingers)
        size = len(self.middle)
        parts = [
            weights.tip / self.unit * tips.d_points,
            self.of_openings[:, None] / self.unit * openings,
            weights.direction * tips.d_directions,
            np.diag(weights.middle / self.half),
        ]
        if previous is not None:
            parts.append(weights.previous * np.eye(size))
        return np.vstack([part.reshape(-1, size) for part in parts])


def openings_of(points: Array, fingers: tuple[Finger, ...]) -> Array:
    """Return what of each finger is relative to the thumb, (n, ...); 0 where there is no thumb."""
    if "thumb" not in fingers:
        return np.zeros_like(points)
    return points - points[fingers.index("thumb")]


def judge_fit(
    tip: Array, opening: Array, excess: Array, fingers: tuple[Finger, ...]
) -> tuple[npt.NDArray[np.bool_], str]:
    """Return which of n postures match, (n,), and why the others do not."""
    matched = np.all(excess <= 1.0, axis=1)
    if matched.all():
        return matched, ""
    i, j = np.unravel_index(np.argmax(excess), excess.shape)
    return matched, (
        f"{np.sum(~matched)} of {len(matched)} postures do not match; worst is the {fingers[j]} in "
        f"posture {i}, {1e3 * tip[i, j]:.0f} mm from its target and {1e3 * opening[i, j]:.0f} mm "
        f"off relative to the thumb, {excess[i, j]:.1f} times the tolerance"
    )
