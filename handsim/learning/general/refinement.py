"""A field to one or more destinations while it is learned: coefficients, roll-outs, refinement.

The refinement rolls the field out from the recorded starts and fits the directions at the points
met to ones that lead back to the recordings a little ahead, as the direction learner does. But it
departs from given coefficients as little as that needs: what these have between the paths stays.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.learning.fit.designs import JetDesign
from handsim.learning.fit.direction_cost import direction_cost
from handsim.learning.fit.field_samples import FieldSamples
from handsim.learning.fit.lbfgs import minimise
from handsim.learning.fit.smoothness import second_differences
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.flow import FlowPath, follow
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.navigation.paths import arc_length, at_arc_length, path_error
from handsim.reproducible import dot, dots, mean, norms, units
from handsim.types import Array

_LONG_STEP = np.deg2rad(2.0)
_N_PER_PATH = 40  # samples of each path and of each roll-out
_LAST_FRACTION = 0.97  # of the arc length: beyond, the direction to the destination is noise
_AHEAD, _LEAST_AHEAD = 0.07, 0.02  # of the path: where points of a roll-out are led, round by round
_NEARER = 0.8  # each round by this
_SHORTEST = 0.01  # of the path: nearer than this the direction ahead is noise
_DEPARTURE = 1e-6  # weight of second differences and squares of what is changed
_N_ITERATIONS = 40


@dataclass(frozen=True)
class Tried:
    """A navigation function and where it leads from the recorded starts.

    Attributes
    ----------
    navigation
    rollouts
        One for each path.
    error : [rad]
        Mean `path_error`.
    n_arrived
    origin
        A few words on how it was made.
    """

    navigation: NavigationFunction
    rollouts: tuple[FlowPath, ...]
    error: float
    n_arrived: int
    origin: str

    @property
    def merit(self) -> tuple[int, float]:
        """The greater, the better: arrivals first."""
        return self.n_arrived, -self.error


def tried(
    navigation: NavigationFunction, paths: Sequence[Array], origin: str, step: float = _LONG_STEP
) -> Tried:
    """Roll a navigation function out along paths, in steps of some length [rad]."""
    starts = np.array([path[0] for path in paths])
    goals = np.array([path[-1] for path in paths])
    rollouts = follow(navigation.directions, starts, goals, step)
    errors = [path_error(r.points, p) for r, p in zip(rollouts, paths, strict=True)]
    n_arrived = sum(rollout.arrived for rollout in rollouts)
    return Tried(navigation, tuple(rollouts), float(mean(np.array(errors))), n_arrived, origin)


def refined(begun: Tried, paths: Sequence[Array], n_rounds: int) -> list[Tried]:
    """Return what becomes of a navigation function, round by round."""
    obstacle = begun.navigation.obstacle
    assert isinstance(obstacle, ExponentialObstacle)
    basis = obstacle.chi.basis
    first = obstacle.chi.coefficients.ravel()
    samples, c, ahead = _on_paths(paths), first, _AHEAD
    latest, result = begun, list[Tried]()
    for i in range(n_rounds):
        samples += _led_back(latest.rollouts, paths, ahead)
        ahead = max(_NEARER * ahead, _LEAST_AHEAD)
        c = _turned(basis, obstacle, begun.navigation.k, samples, first, c)
        made = ExponentialObstacle(TensorBSpline(basis, c), obstacle.width)
        navigation = NavigationFunction(made, begun.navigation.k)
        latest = tried(navigation, paths, f"{begun.origin}, refined {i + 1} x")
        result.append(latest)
    return result


def _on_paths(paths: Sequence[Array]) -> FieldSamples:
    """Return the tangents of the paths."""
    fractions = np.linspace(0.0, 1.0, _N_PER_PATH)
    use = fractions <= _LAST_FRACTION
    parts: list[FieldSamples] = []
    for path in paths:
        even = at_arc_length(path, fractions)
        tangents = units(np.gradient(even, axis=0))[use]
        parts.append(FieldSamples(even[use], tangents, np.broadcast_to(path[-1], tangents.shape)))
    return FieldSamples.together(parts)


def _led_back(rollouts: Sequence[FlowPath], paths: Sequence[Array], ahead: float) -> FieldSamples:
    """Return points of roll-outs with vectors towards the paths a fraction ahead."""
    fractions = np.linspace(0.0, _LAST_FRACTION, _N_PER_PATH)
    parts: list[FieldSamples] = []
    for rollout, path in zip(rollouts, paths, strict=True):
        here = at_arc_length(rollout.points, fractions)
        away = at_arc_length(path, np.minimum(fractions + ahead, 1.0)) - here
        use = norms(away)[:, 0] > _SHORTEST * arc_length(path)[-1]
        goals = np.broadcast_to(path[-1], here[use].shape)
        parts.append(FieldSamples(here[use], units(away[use]), goals))
    return FieldSamples.together(parts)


def _turned(
    basis: TensorBasis,
    obstacle: ExponentialObstacle,
    k: float,
    samples: FieldSamples,
    first: Array,
    c: Array,
) -> Array:
    """Turn the flow at samples towards their vectors, departing little from ``first``."""
    design = JetDesign(basis, samples.points)
    away = samples.points - samples.goals
    squares = dots(away, away)[:, None]
    fixed = obstacle.closure(samples.points)[1] / k
    fixed -= 2.0 * away / np.where(squares > 0.0, squares, 1.0)
    fixed, wanted = np.ascontiguousarray(fixed.T), np.ascontiguousarray(samples.vectors.T)

    def cost(c: Array) -> tuple[float, Array]:
        askew, slope = direction_cost(design(c)[1] + fixed, wanted)
        change = c - first
        bend, by_bend = second_differences(change.reshape(basis.shape))
        value = askew + _DEPARTURE * (bend + dot(change, change))
        by_c = design.pulled_back(None, slope)
        return value, by_c + _DEPARTURE * (by_bend.ravel() + 2.0 * change)

    return minimise(cost, c, _N_ITERATIONS, cost_tolerance=1e-8, gradient_tolerance=1e-9).x
