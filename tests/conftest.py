"""What tests of several rooms need."""

import gc
import importlib.util
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest

from handsim.joints import LOWER, N_JOINTS, UPPER
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import HandSize

Frame = np.ndarray
ROOT = Path(__file__).parents[1]

BREAK_ELSEWHERE = ("test_determinism.py", "test_environments.py", "test_shipped.py")
"""What fails first on another machine; it is run first, so that nobody waits to hear of it."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.path.name not in BREAK_ELSEWHERE)


@pytest.fixture(scope="session", autouse=True)
def cache_of_the_tests(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """What commands remember of this machine lies with the tests' files, not with the user's."""
    usual = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))
        patch.setenv("MESA_SHADER_CACHE_DIR", usual)  # or each run would compile them again
        yield


@pytest.fixture(scope="session")
def read_video() -> Callable[[Path], tuple[dict[str, Any], list[Frame]]]:
    def read(path: Path) -> tuple[dict[str, Any], list[Frame]]:
        """Metadata and frames of a video, as its reader finds them."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)  # imageio-ffmpeg leaves a pipe open
            # imageio offers its ffmpeg for films alone, not for GIFs.
            by = {"plugin": "FFMPEG", "extension": ".mp4"}
            metadata, frames = iio.immeta(path, **by), list(iio.imiter(path, **by))
            gc.collect()
        return metadata, frames

    return read


@pytest.fixture(scope="session")
def script() -> Callable[[str], ModuleType]:
    def load(path: str) -> ModuleType:
        """A script of the repository, which is no part of the package, as a module."""
        file = ROOT / path
        name = "script_" + path.removesuffix(".py").replace("/", "_")
        if name not in sys.modules:
            spec = importlib.util.spec_from_file_location(name, file)
            assert spec is not None and spec.loader is not None
            sys.modules[name] = module = importlib.util.module_from_spec(spec)
            sys.path.insert(0, str(file.parent))  # as when it is run
            try:
                spec.loader.exec_module(module)
            finally:
                sys.path.remove(str(file.parent))
        return sys.modules[name]

    return load


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
        name = f"object-{i // 3}"
        made.append(
            Recording(f"{name}-{i % 3}", np.arange(len(z)) / 50, q, i + 1, "made-up", name,
                      f"{name}-grasp", HandSize(0.19, 0.085))
        )  # fmt: skip
    return RecordingSet(tuple(made))
