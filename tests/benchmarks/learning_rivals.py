"""Other ways to learn reaching movements, on the same recordings and scores as ours.

Run: .venv/bin/python tests/benchmarks/learning_rivals.py
"""

import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from movement_primitives.dmp import DMP
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, WhiteKernel
from sklearn.mixture import GaussianMixture

sys.path.insert(0, str(Path(__file__).parent))
from learning_data import SUBJECTS, Subject, load, ratio, roll_out

from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.pde.learner import PDELearner
from handsim.navigation.flow import ARRIVAL, FlowPath, follow
from handsim.navigation.paths import at_arc_length, between_ends, path_error

Field = Callable[[np.ndarray, np.ndarray], np.ndarray]
N_RANDOM = 200


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)


def samples(subject: Subject) -> tuple[np.ndarray, np.ndarray]:
    """Points with destinations (N, 6) and directions of motion (N, 3)."""
    fractions = np.linspace(0, 0.97, 50)
    inputs, outputs = [], []
    for path in subject.paths:
        points = at_arc_length(path, fractions)
        inputs.append(np.hstack([points, np.tile(path[-1], (50, 1))]))
        outputs.append(unit(np.gradient(points, axis=0)))
    return np.vstack(inputs), np.vstack(outputs)


def straight(subject: Subject) -> Field:
    return lambda z, goal: unit(goal - z)


def mixture(subject: Subject) -> Field:
    """Gaussian-mixture regression of the direction of motion, 20 components."""
    inputs, outputs = samples(subject)
    model = GaussianMixture(20, reg_covar=1e-4, random_state=0).fit(np.hstack([inputs, outputs]))
    gains = [c[6:, :6] @ np.linalg.inv(c[:6, :6]) for c in model.covariances_]
    precisions = [np.linalg.inv(c[:6, :6]) for c in model.covariances_]
    log_det = [np.linalg.slogdet(c[:6, :6])[1] for c in model.covariances_]

    def field(z: np.ndarray, goal: np.ndarray) -> np.ndarray:
        x = np.hstack([z, goal])
        weights, means = [], []
        for i, mean in enumerate(model.means_):
            away = x - mean[:6]
            square = np.einsum("ni,ij,nj->n", away, precisions[i], away)
            weights.append(np.log(model.weights_[i]) - 0.5 * (square + log_det[i]))
            means.append(mean[6:] + away @ gains[i].T)
        log_weight = np.array(weights)
        weight = np.exp(log_weight - log_weight.max(axis=0))
        return unit(np.einsum("kn,kni->ni", weight, np.array(means)))

    return field


def gaussian_process(subject: Subject) -> Field:
    """Gaussian-process regression of the direction of motion, every other sample."""
    inputs, outputs = samples(subject)
    kernel = RBF(0.5 * np.ones(6), (0.05, 20)) + WhiteKernel(0.1)
    model = GaussianProcessRegressor(kernel, n_restarts_optimizer=0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # bounds reached by length scales of idle inputs
        model.fit(inputs[::2], outputs[::2])
    return lambda z, goal: unit(model.predict(np.hstack([z, goal])))


def pde(subject: Subject) -> Field:
    return PDELearner().fit(subject.paths).navigation_.directions


def direction(subject: Subject) -> Field:
    return DirectionLearner().fit(subject.paths).navigation_.directions


def certified(subject: Subject) -> Field:
    return DirectionLearner(certified=True).fit(subject.paths).navigation_.directions


FIELDS = {
    "straight line": straight,
    "Gaussian-mixture regression": mixture,
    "Gaussian-process regression": gaussian_process,
    "the paper's PDE, all trials": pde,
    "direction fit": direction,
    "direction fit, certified": certified,
}


def primitive(subject: Subject, trial: int, start: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """Path of a dynamic movement primitive learned from one trial, between other ends."""
    path, time = subject.paths[trial], subject.times[trial]
    even = np.linspace(time[0], time[-1], 200)
    samples = np.column_stack([np.interp(even, time, column) for column in path.T])
    duration = float(even[-1] - even[0])
    dmp = DMP(3, execution_time=duration, dt=duration / 199, n_weights_per_dim=30)
    dmp.imitate(even - even[0], samples)
    dmp.configure(start_y=start, goal_y=goal)
    return dmp.open_loop()[1]


def primitives(subject: Subject) -> tuple[float, int]:
    """Ratio with a primitive of each other trial of the same object, and arrivals."""
    errors, straights, arrived = [], [], 0
    for i, path in enumerate(subject.paths):
        others = [j for j, o in enumerate(subject.objects) if o == subject.objects[i] and j != i]
        made = [primitive(subject, j, path[0], path[-1]) for j in others]
        errors.append(np.mean([path_error(one, path) for one in made]))
        straights.append(path_error(path[[0, -1]], path))
        arrived += all(np.linalg.norm(one[-1] - path[-1]) < ARRIVAL for one in made)
    return float(np.sum(errors) / np.sum(straights)), arrived


def kernel_mean(paths: list[np.ndarray], start: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """Mean of the paths with their ends moved here, by how near the ends are (30 deg)."""
    ends = np.array([np.hstack([path[0], path[-1]]) for path in paths])
    squares = np.sum((ends - np.hstack([start, goal])) ** 2, axis=1)
    weights = np.exp(-0.5 * (squares - squares.min()) / np.deg2rad(30.0) ** 2)
    moved = [between_ends(path, start, goal) for path in paths]
    return np.average(moved, axis=0, weights=weights)


def flow_path(paths: list[np.ndarray], start: np.ndarray, goal: np.ndarray) -> np.ndarray:
    directions = DirectionLearner().fit(paths).navigation_.directions
    return follow(directions, start[None], goal[None])[0].points


def left_out(
    subject: Subject, predict: Callable[[list[np.ndarray], np.ndarray, np.ndarray], np.ndarray]
) -> tuple[float, int]:
    """Ratio of paths predicted from all other trials, and how many reach the destination."""
    made = [
        predict(subject.paths[:i] + subject.paths[i + 1 :], path[0], path[-1])
        for i, path in enumerate(subject.paths)
    ]
    arrived = [
        bool(np.linalg.norm(one[-1] - path[-1]) < ARRIVAL)
        for one, path in zip(made, subject.paths, strict=True)
    ]
    rollouts = [FlowPath(one, there, "") for one, there in zip(made, arrived, strict=True)]
    return ratio(rollouts, subject.paths), sum(arrived)


def from_anywhere(field: Field, subject: Subject) -> list[FlowPath]:
    rng = np.random.default_rng(0)
    points = np.vstack(subject.paths)
    starts = rng.uniform(points.min(axis=0), points.max(axis=0), (N_RANDOM, 3))
    goals = subject.goals[rng.integers(len(subject.paths), size=N_RANDOM)]
    return follow(field, starts, goals, step=np.deg2rad(2.0))


def evaluation_time(field: Field, subject: Subject) -> float:
    """Seconds for the direction at one point, best of 5."""
    z, goal = subject.starts[:1], subject.goals[:1]
    times = []
    for _ in range(5):
        began = perf_counter()
        for _ in range(50):
            field(z, goal)
        times.append((perf_counter() - began) / 50)
    return min(times)


def main() -> None:
    subjects = [load(number) for number in SUBJECTS]
    print("| method | path error over straight, subjects 1 to 4 | mean | arrive of 20 each |"
          " arrive of 200 random starts each | learning, CPU s | one direction, us |")  # fmt: skip
    print("|---|---|---|---|---|---|---|")
    for name, learn in FIELDS.items():
        ratios, arrivals, anywhere, learning, evaluating = [], [], [], [], []
        for subject in subjects:
            began = process_time()
            field = learn(subject)
            learning.append(process_time() - began)
            rollouts = roll_out(field, subject.paths)
            ratios.append(ratio(rollouts, subject.paths))
            arrivals.append(sum(r.arrived for r in rollouts))
            anywhere.append(sum(r.arrived for r in from_anywhere(field, subject)))
            evaluating.append(evaluation_time(field, subject))
        row(name, ratios, arrivals, anywhere, np.mean(learning), np.mean(evaluating))
    found = [primitives(subject) for subject in subjects]
    row("movement primitive of another trial of the same object", *zip(*found, strict=True),
        ["by time"], 0.0, float("nan"))  # fmt: skip
    for name, predict in (
        ("kernel mean of paths between near ends, left out", kernel_mean),
        ("direction fit, left out", flow_path),
    ):
        found = [left_out(subject, predict) for subject in subjects]
        row(name, *zip(*found, strict=True), [""], 0.0, float("nan"))


def row(
    name: str, ratios: list, arrivals: list, anywhere: list, learning: float, evaluating: float
) -> None:
    cells = (" ".join(f"{r:.2f}" for r in ratios), f"{np.mean(ratios):.2f}",
             " ".join(map(str, arrivals)), " ".join(map(str, anywhere)),
             f"{learning:.1f}", f"{1e6 * evaluating:.0f}")  # fmt: skip
    print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
