"""One movement of a hand, written by tests in the ways of many loggers.

`seen_hand`, the hand that tests of points and fits look at, is a module beside.
"""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from handsim.types import Array

sys.path.insert(0, str(Path(__file__).parent))

NAMES = (
    "ThumbRotate ThumbMPJ ThumbIPJ ThumbAb IndexMPJ IndexPIJ IndexDIJ MiddleMPJ MiddlePIJ "
    "MiddleDIJ MiddleIndexAb RingMPJ RingPIJ RingDIJ RingMiddleAb PinkieMPJ PinkiePIJ PinkieDIJ "
    "PinkieRingAb PalmArch WristPitch WristYaw"
)
CYBERGLOVE = NAMES.split()


class Movement:
    """40 frames at 100 Hz, joint j from j + 1 to 2 (j + 1) deg plus a little."""

    n = 40
    time: Array = np.arange(40) / 100
    angles: Array = np.outer(1 + np.linspace(0, 1, 40) ** 2, np.arange(22) + 1) + 0.125
    names = CYBERGLOVE

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def write(
        self,
        name: str = "a.csv",
        header: Sequence[str] | None = ("time_s", *CYBERGLOVE),
        stamp: Callable[[float], str] | None = "{:.3f}".format,
        values: Array | None = None,
        *,
        sep: str = ",",
        comma: bool = False,
        number: str = "{:.4f}",
        encoding: str = "utf-8",
        above: Sequence[str] = (),
        below: Sequence[str] = (),
        newline: str = "\n",
    ) -> Path:
        """Write the movement; ``below`` are lines under the header."""
        lines = [*above, *([sep.join(header)] if header else []), *below]
        for t, row in zip(self.time, self.angles if values is None else values, strict=True):
            cells = [number.format(value) for value in row]
            cells = [cell.replace(".", ",") for cell in cells] if comma else cells
            lines.append(sep.join([*([stamp(t)] if stamp else []), *cells]))
        path = self.folder / name
        path.write_bytes((newline.join(lines) + newline).encode(encoding))
        return path


@pytest.fixture
def movement(tmp_path: Path) -> Movement:
    return Movement(tmp_path)
