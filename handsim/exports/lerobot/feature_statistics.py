"""Statistics by which LeRobot scales what it learns from."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.types import Array, Frame

QUANTILES: dict[str, float] = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}


def statistics_of(values: npt.NDArray[Any]) -> dict[str, list[Any]]:
    """Return statistics of each element over frames.

    Parameters
    ----------
    values : (n, k)

    Returns
    -------
    ``min``, ``max``, ``mean``, ``std`` (of the population) and quantiles, k each; and ``count``.
    """
    numbers = values.astype(np.float64)
    quantiles = np.quantile(numbers, list(QUANTILES.values()), axis=0)
    return {
        "min": numbers.min(axis=0).tolist(),
        "max": numbers.max(axis=0).tolist(),
        "mean": numbers.mean(axis=0).tolist(),
        "std": numbers.std(axis=0).tolist(),
        "count": [len(numbers)],
        **{name: row.tolist() for name, row in zip(QUANTILES, quantiles, strict=True)},
    }


class PixelCounts:
    """How often each brightness occurs in each colour of the frames that went by."""

    def __init__(self) -> None:
        self.counts: npt.NDArray[np.int64] = np.zeros((3, 256), dtype=np.int64)
        self.n_frames = 0

    def counting(self, frames: Iterable[Frame]) -> Iterator[Frame]:
        """Let frames through, and count them."""
        for frame in frames:
            for colour in range(3):
                self.counts[colour] += np.bincount(frame[..., colour].ravel(), minlength=256)
            self.n_frames += 1
            yield frame

    def add(self, other: "PixelCounts") -> None:
        """Count the frames of another, too."""
        self.counts += other.counts
        self.n_frames += other.n_frames

    def statistics(self) -> dict[str, Any]:
        """Return statistics of brightness, 0 to 1, (3, 1, 1) each; ``count`` is that of frames."""
        level = np.arange(256) / 255.0
        total = self.counts.sum(axis=1)
        mean = self.counts @ level / total
        variance = self.counts @ level**2 / total - mean**2
        below = np.cumsum(self.counts, axis=1) / total[:, None]
        seen = self.counts > 0

        def shaped(values: Array) -> list[Any]:
            return values.reshape(3, 1, 1).tolist()

        return {
            "min": shaped(level[seen.argmax(axis=1)]),
            "max": shaped(level[255 - seen[:, ::-1].argmax(axis=1)]),
            "mean": shaped(mean),
            "std": shaped(np.sqrt(np.maximum(variance, 0.0))),
            "count": [self.n_frames],
            **{name: shaped(level[(below >= q).argmax(axis=1)]) for name, q in QUANTILES.items()},
        }
