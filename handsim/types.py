"""Types that all rooms share."""

from collections.abc import Callable
from typing import Literal

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Frame = npt.NDArray[np.uint8]
"""A picture, (height, width, 3), top row first."""

Side = Literal["right", "left"]
SIDES: tuple[Side, ...] = ("right", "left")

Progress = Callable[[float], None]
"""Called with the fraction done, 0 to 1."""
