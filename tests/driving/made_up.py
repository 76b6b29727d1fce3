"""Made-up demonstrations: what a controller keeps of recordings, without a controller."""

import numpy as np

from handsim.joints import N_JOINTS
from handsim.learning.demonstration import SIGNAL_PROGRESS, Demonstration

EVEN = np.linspace(0.0, 1.0, 51)


def demonstration(duration: float = 1.0, progress: np.ndarray = EVEN, **signals) -> Demonstration:
    """A movement of 0.5 rad in one component with signals over progress."""
    q = np.zeros((2, N_JOINTS))
    q[1, 4] = 0.5
    return Demonstration(
        "made-up", "task", "object", q[0], q[1], q[0, 4:5], q[1, 4:5], 0.19, 0.085, duration,
        progress=progress, signals={name: np.asarray(x, float) for name, x in signals.items()},
    )  # fmt: skip


def falling(start: float = 0.4, end: float = 0.1) -> np.ndarray:
    """A distance that falls evenly along the movement."""
    return start + (end - start) * SIGNAL_PROGRESS
