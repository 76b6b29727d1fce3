"""Streams of postures whose phases are known: minimum-jerk movements between still stretches."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from handsim.recordings.recording import Recording
from handsim.types import HandSize

Stream = Callable[..., Recording]
GRASP = np.deg2rad(np.linspace(20, 60, 22))


def smooth(n: int) -> np.ndarray:
    x = np.linspace(0, 1, n)
    return x**3 * (10 - 15 * x + 6 * x**2)


@pytest.fixture
def stream() -> Stream:
    """Make a recording of ``(share of the way to the grasp, seconds)`` at 100 Hz.

    A share that equals the one before is a stop.
    """

    def make(
        *legs: tuple[float, float], name: str = "a", noise_deg: float = 0.2, seed: int = 0, **more
    ) -> Recording:
        share = shares(legs)
        noise = np.deg2rad(noise_deg) * np.random.default_rng(seed).normal(size=(len(share), 22))
        channels = {key: value(share) for key, value in more.pop("channels", {}).items()}
        return Recording(
            name, np.arange(len(share)) / 100, np.outer(share, GRASP) + noise, 1, "s", "cup",
            "cup-drink", HandSize(), channels=channels, **more,
        )  # fmt: skip

    return make


def shares(legs: Sequence[tuple[float, float]]) -> np.ndarray:
    parts, at = [], legs[0][0]
    for target, seconds in legs:
        parts.append(at + (target - at) * smooth(round(100 * seconds)))
        at = target
    return np.concatenate(parts)
