"""Made-up movements that share the traits of real ones: curved, several objects, noisy ends."""

import numpy as np
import pytest

from handsim.joints import LOWER, N_JOINTS, UPPER
from handsim.motion.recording import Recording, RecordingSet


def curved_paths(n_objects: int = 3, n_trials: int = 3, n: int = 3, seed: int = 0) -> list:
    """Paths (80, n) [rad] from about the origin, bent to one side, one destination an object."""
    rng = np.random.default_rng(seed)
    s = np.linspace(0.0, 1.0, 80)[:, None]
    paths = []
    for _ in range(n_objects):
        goal, bend = rng.normal(size=n), rng.normal(size=n)
        goal *= 1.5 / np.linalg.norm(goal)
        bend -= (bend @ goal) * goal / (goal @ goal)
        for _ in range(n_trials):
            start, end = 0.05 * rng.normal(size=n), goal + 0.05 * rng.normal(size=n)
            paths.append(start + s * (end - start) + 0.5 * np.sin(np.pi * s) * bend)
    return paths


@pytest.fixture(scope="session")
def paths() -> list:
    return curved_paths()


@pytest.fixture(scope="session")
def recordings() -> RecordingSet:
    """The same movements lifted to 22 joints, with a little movement outside the subspace."""
    rng = np.random.default_rng(5)
    wide = np.rad2deg(UPPER - LOWER) > 80  # so that postures stay inside the ranges
    basis = np.linalg.qr(rng.normal(size=(N_JOINTS, 3)) * wide[:, None])[0].T
    humps = np.sin(np.pi * np.outer([1, 2, 3], np.linspace(0.0, 1.0, 80)))
    made = []
    for i, z in enumerate(curved_paths()):
        q = 0.5 * (LOWER + UPPER) + z @ basis + 0.01 * humps.T @ rng.normal(size=(3, N_JOINTS))
        thing = f"object-{i // 3}"
        made.append(
            Recording(f"{thing}-{i % 3}", np.arange(len(z)) / 50, q, i + 1, "made-up", thing,
                      f"{thing}-grasp", 0.19, 0.085)
        )  # fmt: skip
    return RecordingSet(tuple(made))
