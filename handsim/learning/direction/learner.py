"""Learn an obstacle by matching the directions of recorded motion.

With beta = beta_0 exp(k chi) the flow points along

    w = grad chi + grad(ln beta_0) / k - grad(ln gamma_d),

with gamma_d in a metric that depends on the destination (`navigation.metric`). w is -grad phi of
Eq. (2) of the paper but for a positive factor. The learner minimises, by the coefficients of chi
and the parameters of the metric,

    mean over samples of 1 - cos(angle between w and the wanted direction)
    + smoothness |second differences of the coefficients|^2 + ridge |coefficients|^2
    + metric_ridge |parameters of the metric|^2
    + descent    mean over the workspace of max(0, worst (z - z_goal) . grad chi - (2 - margin))^2

where the last is the condition under which the distance to the destination falls everywhere, for
every metric (`descent`, `navigation.certificate`); a certified fit holds it as a constraint
instead. Several times the fit so far is rolled out, the points of the roll-outs are added with
vectors that lead to the recordings (`samples`), and it is fitted again. Before all this, each
recording is averaged with those between near ends (`averaging`).

The paper matches velocities instead, Eq. (8) (`learning.pde`); here the exponent and all speeds
drop out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Self, get_args

import numpy as np

from handsim.learning.base import Estimator, check_paths
from handsim.learning.direction.averaging import averaged
from handsim.learning.direction.descent import DescentCondition, box_corners
from handsim.learning.direction.metric_model import Attraction, MetricModel
from handsim.learning.direction.samples import recorded_samples, rolled_out_samples
from handsim.learning.fit.designs import JetDesign
from handsim.learning.fit.direction_cost import direction_cost
from handsim.learning.fit.field_samples import FieldSamples
from handsim.learning.fit.history import History, Iteration
from handsim.learning.fit.lbfgs import minimise
from handsim.learning.fit.level import levelled
from handsim.learning.fit.smoothness import second_differences
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.flow import FlowPath, follow
from handsim.navigation.function import NavigationFunction, check_exponent
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.navigation.paths import path_error
from handsim.navigation.workspace import KnotRule, lay_basis
from handsim.reproducible import dot, mean, spread
from handsim.types import Array, Progress

_METRIC_REACH = 0.75  # over which destinations share their metric, as a fraction of their spread
_LEAST_REACH = np.deg2rad(1.0)
_NEW_DESTINATIONS = 1.3  # how far out the descent condition is held, relative to the recorded ones
_N_DESCENT = 3000  # points of the workspace at which the descent condition is held
_ROLLOUT_STEP = np.deg2rad(8.0)  # smaller ones tell the same, at twice the cost of learning


class DirectionLearner(Estimator):
    """Learner of navigation functions from paths, by their directions.

    Parameters
    ----------
    shape
        Coefficients per dimension; shared out by ``knot_rule`` where left out.
    degree
        Polynomial degree of the spline, 3 or more.
    k
        Exponent of the navigation function; it changes speeds and basins, not directions.
    smoothness, ridge
        Weights of the second differences and of the coefficients themselves.
    descent, margin
        Weight of the descent condition and the distance kept from its limit.
    certified
        Hold the descent condition as a constraint, for all destinations inside the closing layer
        of the workspace, so that `certificate.certify` proves convergence to any of them.
    metric_ridge
        Weight of the metric's parameters; None leaves gamma_d = |z - z_goal|^2, as in the paper.
    averaging
        Distance between the ends of recordings over which they are averaged, as a fraction of the
        spread of the destinations; 0 takes them as they are.
    n_refinements
        Rounds of roll-outs after the first fit.
    n_iterations
        Iterations of L-BFGS in the first fit; refinements, warm-started, take half.
    knot_rule
        See `workspace.knot_counts`.
    seed
        Of the corridor and of the points where the descent condition is held.

    Attributes
    ----------
    navigation_
        The navigation function learned.
    cost_start_, cost_end_
        Cost before and after the first fit (refinements change the samples, so their costs do not
        compare).
    n_iterations_, seconds_, n_coefficients_
    history_
        `History` over all rounds.
    """

    navigation_: NavigationFunction
    cost_start_: float
    cost_end_: float
    n_iterations_: int
    seconds_: float
    n_coefficients_: int
    history_: History

    def __init__(
        self,
        shape: tuple[int, ...] | None = None,
        degree: int = 3,
        k: float = 4.0,
        smoothness: float = 5e-5,
        ridge: float = 1e-5,
        descent: float = 1000.0,
        margin: float = 0.2,
        certified: bool = True,
        metric_ridge: float | None = 1e-3,
        averaging: float = 0.25,
        n_refinements: int = 4,
        n_iterations: int = 60,
        knot_rule: KnotRule = "gentle",
        seed: int = 0,
    ) -> None:
        self.shape = shape
        self.degree = degree
        self.k = k
        self.smoothness = smoothness
        self.ridge = ridge
        self.descent = descent
        self.margin = margin
        self.certified = certified
        self.metric_ridge = metric_ridge
        self.averaging = averaging
        self.n_refinements = n_refinements
        self.n_iterations = n_iterations
        self.knot_rule: KnotRule = knot_rule
        self.seed = seed

    def fit(
        self,
        paths: Sequence[Array],
        times: Sequence[Array] | None = None,
        *,
        progress: Progress | None = None,
    ) -> Self:
        """Learn from recorded paths in the subspace, each ending at its destination.

        Parameters
        ----------
        paths
            (n_i, n) [rad].
        times
            Ignored: directions do not depend on time.
        progress
            Called with the fraction done.

        Raises
        ------
        InputError
            If there are no paths, they do not move along a dimension, or a parameter is out of its
            range.
        """
        began = perf_counter()
        self._check()
        paths = check_paths(paths)
        rng = np.random.default_rng(self.seed)
        basis, width = lay_basis(paths, self.shape, self.degree, self.knot_rule)
        paths = averaged(paths, self.averaging * _spread(paths))
        problem = _Problem(self, basis, width, paths, rng)
        samples = recorded_samples(paths, rng)
        history: list[Iteration] = []
        x, cost_start, cost_end = problem.solve(
            np.zeros(problem.n_unknowns), samples, self.n_iterations, history
        )
        best = latest = problem.candidate(x)
        for i in range(self.n_refinements):
            if progress:
                progress((i + 1) / (self.n_refinements + 1))
            if self.certified:
                problem.descent.tighten(x[: basis.n_coefficients])
            samples += rolled_out_samples(latest.rollouts, paths)
            x, _, _ = problem.solve(x, samples, self.n_iterations // 2, history)
            latest = problem.candidate(x)
            best = max(best, latest, key=lambda candidate: candidate.merit)
        self.navigation_ = best.navigation
        self.cost_start_, self.cost_end_ = cost_start, cost_end
        self.n_iterations_ = len(history)
        self.n_coefficients_ = basis.n_coefficients
        self.history_ = History.of(history)
        self.seconds_ = perf_counter() - began
        if progress:
            progress(1.0)
        return self

    def _check(self) -> None:
        none_negative = ("smoothness", "ridge", "descent", "margin", "metric_ridge", "averaging")
        least = dict.fromkeys(none_negative, 0.0) | {"degree": 1, "n_refinements": 0}
        rules = get_args(KnotRule)
        self.check_parameters(least | {"n_iterations": 0, "seed": 0}, {"knot_rule": rules})
        check_exponent(self.k)


@dataclass(frozen=True)
class _Candidate:
    """A fit and where its flow leads; more arrivals are better, then less error."""

    navigation: NavigationFunction
    rollouts: list[FlowPath]
    merit: tuple[int, float]


class _Problem:
    """The cost as a function of the coefficients of chi, followed by the metric's parameters."""

    def __init__(
        self,
        learner: DirectionLearner,
        basis: TensorBasis,
        width: Array,
        paths: list[Array],
        rng: np.random.Generator,
    ) -> None:
        self.basis, self.paths, self.k = basis, paths, learner.k
        self.starts = np.array([path[0] for path in paths])
        self.goals = np.array([path[-1] for path in paths])
        self.certified = learner.certified
        self.smoothness, self.ridge = learner.smoothness, learner.ridge
        self.flat = ExponentialObstacle(TensorBSpline(basis, np.zeros(basis.shape)), width)
        self.metric_ridge = learner.metric_ridge or 0.0
        self.metric_model = None
        if learner.metric_ridge is not None and len(width) > 1:
            reach = max(_METRIC_REACH * _spread(paths), _LEAST_REACH)
            self.metric_model = MetricModel(self.goals, reach)
        self.n_unknowns = basis.n_coefficients
        self.n_unknowns += self.metric_model.n_parameters if self.metric_model else 0
        # A certified field leads to every destination inside the closing layer.
        inner = np.array([basis.lower + width, basis.upper - width])
        self.descent = DescentCondition(
            basis,
            box_corners(inner) if self.certified else _beyond(self.goals, inner),
            basis.lower + (basis.upper - basis.lower) * rng.random((_n_descent(basis), len(width))),
            2.0 - learner.margin,
            learner.descent,
        )

    def candidate(self, x: Array) -> _Candidate:
        """Roll a fit out from the recorded starts."""
        c, parameters = np.split(x, [self.basis.n_coefficients])
        if self.certified:
            c = self.descent.restored(c)
        metric = self.metric_model.metric(parameters) if self.metric_model else None
        flat = NavigationFunction(self.flat, self.k, metric)
        chi = levelled(TensorBSpline(self.basis, c), flat, self.starts, self.goals)
        navigation = replace(flat, obstacle=ExponentialObstacle(chi, self.flat.width))
        rollouts = follow(navigation.directions, self.starts, self.goals, _ROLLOUT_STEP)
        errors = [path_error(r.points, p) for r, p in zip(rollouts, self.paths, strict=True)]
        merit = (sum(r.arrived for r in rollouts), -float(mean(np.array(errors))))
        return _Candidate(navigation, rollouts, merit)

    def solve(
        self, x: Array, samples: FieldSamples, n_iterations: int, history: list[Iteration]
    ) -> tuple[Array, float, float]:
        """Minimise from ``x`` on; return the unknowns and the costs before and after."""
        design = JetDesign(self.basis, samples.points)
        closure = np.ascontiguousarray(self.flat.closure(samples.points)[1].T / self.k)
        wanted = np.ascontiguousarray(samples.vectors.T)
        attraction = Attraction(self.metric_model, samples.points, samples.goals)

        def cost(x: Array) -> tuple[float, Array]:
            c, p = x[: self.basis.n_coefficients], x[self.basis.n_coefficients :]
            pull, pulled_back = attraction(p)
            askew, slope = direction_cost(design(c)[1] + closure - pull, wanted)
            descent, descent_slope = self.descent(c)
            bend, bend_slope = second_differences(c.reshape(self.basis.shape))
            value = askew + descent
            value += self.smoothness * bend + self.ridge * dot(c, c)
            value += self.metric_ridge * dot(p, p)
            by_c = design.pulled_back(None, slope) + descent_slope
            by_c += self.smoothness * bend_slope.ravel() + 2.0 * self.ridge * c
            return value, np.append(by_c, 2.0 * self.metric_ridge * p - pulled_back(slope))

        start = cost(x)[0]
        found = minimise(cost, x, n_iterations, cost_tolerance=1e-8, gradient_tolerance=1e-9)
        history.extend(found.iterations)
        return found.x, start, found.cost


def _spread(paths: list[Array]) -> float:
    """Root of the mean squared distance of destinations from their mean [rad]."""
    return spread(np.array([path[-1] for path in paths]))


def _beyond(goals: Array, inner: Array) -> Array:
    """Move destinations away from their mean, inside the closing layer: new ones lie among them."""
    middle = mean(goals)
    return np.clip(middle + _NEW_DESTINATIONS * (goals - middle), *inner)


def _n_descent(basis: TensorBasis) -> int:
    """Points for the descent condition, fewer where each touches very many coefficients."""
    n = len(basis.shape)
    return min(_N_DESCENT, 2_000_000 // (n * (basis.degree + 1) ** n))
