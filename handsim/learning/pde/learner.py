"""The paper's learner: solve the semi-linear PDE (8) for the obstacle function.

On the recorded points u = -grad phi (Eq. 3) asks that

    grad beta = (k u / gamma_d) (gamma_d^k + beta)^(1/k + 1) + (k grad gamma_d / gamma_d) beta   (8)

with beta a B-spline (Eq. 9), beta > 0 on the recordings (Eq. 4) and beta <= 0 on the boundary of
the workspace (Eq. 5). The functional of Sec. V-B.2 is minimised over the coefficients,

    J = (w1 J_PDE + w2 J_sp + w3 J_dp + w4 J_bn) / number of points,

from beta = 0, by the paper's gradient descent or by L-BFGS.

Where the paper is corrected:

- the switch s is printed as x^3 for x <= 0, which rewards beta -> -infinity; here s(x) = |x|^3;
- J_bn, a penalty on beta > 0 at the boundary, is printed with s(beta); here s(-beta);
- the coefficients are prod(m_i) numbers, not sum(m_i);
- phi falls by at most 1 along a path, so recorded speeds cannot be met as they are: one time
  scale for all recordings makes the largest path integral of speed ``phi_max`` < 1;
- people start and end at rest, phi is not critical at a start: speeds are replaced by a profile in
  proportion to the arc length left (``speed="remaining"``), or slow samples are dropped
  (``"measured"``);
- 1 / gamma_d^k in J_PDE is singular at the destination: the end of each path is left out.

What is added to the paper, each of which can be switched off: the smoothness penalty on second
differences of the coefficients, and the ``corridor``, points beside the path at which the same PDE
is asked to lead back.

Lengths are in units of 100 deg while learning, since gamma_d^k spans many decades.
"""

from collections.abc import Callable, Sequence
from math import sqrt
from time import perf_counter
from typing import Literal, Self, get_args

import numpy as np

from handsim.errors import InputError
from handsim.learning.base import Estimator, check_paths
from handsim.learning.fit.field_samples import FieldSamples
from handsim.learning.fit.history import History, Iteration
from handsim.learning.fit.lbfgs import minimise
from handsim.learning.fit.smoothness import second_differences
from handsim.learning.pde.problem import (
    Functional,
    beside,
    boundary_points,
    measured_speeds,
    remaining_speeds,
    vanishing_on_boundary,
)
from handsim.navigation.bspline import TensorBasis, TensorBSpline
from handsim.navigation.function import NavigationFunction, check_exponent
from handsim.navigation.obstacle import SplineObstacle
from handsim.navigation.workspace import KnotRule, lay_basis
from handsim.reproducible import dot, norms, powers
from handsim.types import Array, Progress

Solver = Literal["lbfgs", "gradient"]
Speed = Literal["remaining", "measured"]

_UNIT = np.deg2rad(100.0)
# Cells between recordings and boundary: the coefficients that matter on the boundary, kept at 0,
# hardly matter on the recordings.
_REACH = 2.5
_MAX_HALVINGS = 40


class PDELearner(Estimator):
    """Learner of navigation functions by the paper's PDE.

    Parameters
    ----------
    k
        Exponent; from 3 on the PDE is badly conditioned.
    weights
        w1 to w4 of J. The paper has w4 = 0, since the boundary lies more than a knot away.
    beta_floor
        The paper's beta_0: above it beta counts as positive.
    solver
        ``lbfgs``, or ``gradient``: c <- c - lambda_J grad J with backtracking, so J never rises.
    step
        lambda_J to start from, with ``gradient``.
    n_iterations
        Of the solver.
    shape, degree, knot_rule
        Spline space, see `workspace.lay_basis`.
    phi_max
        Largest path integral of speed after the choice of the time scale.
    cut
        Fraction of arc length left out at the end of each path.
    speed
        ``remaining`` or ``measured``, see the module.
    smoothness
        Weight of second differences of the coefficients; 0 in the paper.
    corridor
        Whether points beside the paths are added; not in the paper.
    seed
        Of the corridor.

    Attributes
    ----------
    navigation_
    cost_start_, cost_end_
        J (and the smoothness penalty) at beta = 0 and at the end.
    parts_
        J_PDE, J_sp, J_dp and J_bn at the end, unweighted sums.
    n_iterations_, seconds_, n_coefficients_, history_
    coefficients_history_ : (n_iterations_, n_coefficients_)
        The right panel of the paper's Fig. 3.
    least_beta_
        Least beta on the recorded points and destinations, in units of (100 deg)^(2 k).
    boundary_beta_
        Greatest beta on the boundary of the workspace, same units.
    positive_, closed_
        Whether Eq. (4) and Eq. (5) hold.
    """

    navigation_: NavigationFunction
    cost_start_: float
    cost_end_: float
    parts_: dict[str, float]
    n_iterations_: int
    seconds_: float
    n_coefficients_: int
    history_: History
    coefficients_history_: Array
    least_beta_: float
    boundary_beta_: float
    positive_: bool
    closed_: bool

    def __init__(
        self,
        k: float = 2.0,
        weights: tuple[float, float, float, float] = (1.0, 6e5, 2.4e6, 0.0),
        beta_floor: float = 0.42,
        solver: Solver = "lbfgs",
        step: float = 1.0,
        n_iterations: int = 500,
        shape: tuple[int, ...] | None = None,
        degree: int = 3,
        knot_rule: KnotRule = "gentle",
        phi_max: float = 0.9,
        cut: float = 0.04,
        speed: Speed = "remaining",
        smoothness: float = 1e-4,
        corridor: bool = True,
        seed: int = 0,
    ) -> None:
        self.k = k
        self.weights = weights
        self.beta_floor = beta_floor
        self.solver: Solver = solver
        self.step = step
        self.n_iterations = n_iterations
        self.shape = shape
        self.degree = degree
        self.knot_rule: KnotRule = knot_rule
        self.phi_max = phi_max
        self.cut = cut
        self.speed: Speed = speed
        self.smoothness = smoothness
        self.corridor = corridor
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
            (n_i,) [s], needed for ``speed="measured"``.
        progress
            Called with the fraction done.

        Raises
        ------
        InputError
            If there are no paths, they do not move along a dimension, a parameter is out of its
            range, or times are missing.
        """
        began = perf_counter()
        self._check()
        scaled = [path / _UNIT for path in check_paths(paths)]
        basis, _ = lay_basis(scaled, self.shape, self.degree, self.knot_rule, reach=_REACH)
        experiments = asked = self._experiments(scaled, times)
        if self.corridor:
            asked = experiments + beside(experiments, np.random.default_rng(self.seed))
        goals = np.array([path[-1] for path in scaled])
        functional = Functional(basis, asked, goals, self.k, self.weights, self.beta_floor)
        inner = vanishing_on_boundary(basis)

        def cost(x: Array) -> tuple[float, Array]:
            c = np.zeros(basis.n_coefficients)
            c[inner] = x
            value, gradient = functional(c)
            bend, bend_slope = second_differences(c.reshape(basis.shape))
            slope = gradient + self.smoothness * bend_slope.ravel()
            return value + self.smoothness * bend, slope[inner]

        trace = _Trace(cost, progress, self.n_iterations)
        x = np.zeros(np.count_nonzero(inner))
        self.cost_start_ = cost(x)[0]
        solve = descend if self.solver == "gradient" else _lbfgs
        x = solve(trace, x, self.n_iterations, self.step)
        c = np.zeros(basis.n_coefficients)
        c[inner] = x
        self._conclude(functional, experiments, goals, c)
        self.cost_end_ = cost(x)[0]
        self.n_iterations_ = len(trace.log)
        self.history_ = History.of(trace.log)
        self.coefficients_history_ = np.array(trace.points).reshape(len(trace.points), len(x))
        self.seconds_ = perf_counter() - began
        return self

    def _check(self) -> None:
        least = {"beta_floor": 0.0, "step": 0.0, "phi_max": 0.0, "cut": 0.0, "smoothness": 0.0}
        words = {
            "solver": get_args(Solver),
            "speed": get_args(Speed),
            "knot_rule": get_args(KnotRule),
        }
        self.check_parameters(least | {"degree": 1, "n_iterations": 0, "seed": 0}, words)
        if len(self.weights) != 4:
            raise InputError(f"weights {self.weights!r}; give 4, of J_PDE, J_sp, J_dp and J_bn")
        check_exponent(self.k)

    def _experiments(self, paths: list[Array], times: Sequence[Array] | None) -> FieldSamples:
        if self.speed == "remaining":
            return remaining_speeds(paths, self.phi_max, self.cut)
        if times is None:
            raise InputError("no times; measured speeds need them, remaining ones do not")
        return measured_speeds(paths, times, self.phi_max, self.cut)

    def _conclude(
        self, functional: "Functional", experiments: FieldSamples, goals: Array, c: Array
    ) -> None:
        """Check Eq. (4) and (5) and turn the coefficients into a navigation function in rad."""
        basis = functional.basis
        spline = TensorBSpline(basis, c)
        on_data = spline.jets(np.vstack([experiments.points, goals]), 0)[0]
        on_boundary = spline.jets(boundary_points(basis), 0)[0]
        self.least_beta_, self.boundary_beta_ = float(on_data.min()), float(on_boundary.max())
        self.positive_ = self.least_beta_ > 0.0
        self.closed_ = self.boundary_beta_ <= 1e-12
        self.parts_ = functional.parts(c)
        self.n_coefficients_ = basis.n_coefficients
        in_rad = TensorBasis(tuple(knots * _UNIT for knots in basis.knots), basis.degree)
        beta = TensorBSpline(in_rad, c * powers(np.array(_UNIT), 2.0 * self.k))
        self.navigation_ = NavigationFunction(SplineObstacle(beta), self.k)


def descend(
    cost: Callable[[Array], tuple[float, Array]], x: Array, n_iterations: int, step: float
) -> Array:
    """Gradient descent, the paper's V-B; lambda_J is halved until J falls and then grown again."""
    value, gradient = cost(x)
    for _ in range(n_iterations):
        for _ in range(_MAX_HALVINGS):
            trial = x - step * gradient
            trial_value, trial_gradient = cost(trial)
            if trial_value < value:
                break
            step *= 0.5
        else:
            break
        x, value, gradient = trial, trial_value, trial_gradient
        step *= 2.0
        if isinstance(cost, _Trace):
            cost.accepted(x)
    return x


def _lbfgs(cost: "_Trace", x: Array, n_iterations: int, step: float) -> Array:
    return minimise(cost, x, n_iterations, 1e-12, 1e-10, cost.accepted).x


class _Trace:
    """A cost that notes each accepted point."""

    def __init__(
        self,
        cost: Callable[[Array], tuple[float, Array]],
        progress: Progress | None,
        n_iterations: int,
    ) -> None:
        self._cost, self._progress, self._n = cost, progress, n_iterations
        self._cost_here, self._norm_here = 0.0, 0.0
        self.log: list[Iteration] = []
        self.points: list[Array] = []

    def __call__(self, x: Array) -> tuple[float, Array]:
        value, gradient = self._cost(x)
        self._cost_here, self._norm_here = value, sqrt(dot(gradient, gradient))
        return value, gradient

    def accepted(self, x: Array) -> None:
        previous = self.points[-1] if self.points else np.zeros_like(x)
        change = float(norms(x - previous)[0])
        self.log.append(Iteration(self._cost_here, self._norm_here, change))
        self.points.append(x.copy())
        if self._progress:
            self._progress(len(self.points) / self._n)
