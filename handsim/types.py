"""Types that all rooms share."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from handsim.errors import UnknownNameError

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Frame = npt.NDArray[np.uint8]
"""A picture, (height, width, 3), top row first."""

Base = Literal["arm", "free", "mounted"]
"""What carries the hand: a person's arm, or a free base that is moved with unlimited force."""
Side = Literal["right", "left"]
SIDES: tuple[Side, ...] = ("right", "left")

Progress = Callable[[float], None]
"""Called with the fraction done, 0 to 1."""


@dataclass(frozen=True)
class HandSize:
    """Size and side of a person's hand; by default the right hand of a man of median size.

    The median is that of ANSUR II (2012), US Army. What sizes can be built is checked where a hand
    is built.

    Attributes
    ----------
    length
        Wrist crease to the tip of the middle finger [m].
    breadth
        Across the metacarpal heads of the four fingers [m].
    side
        ``right`` or ``left``.

    Raises
    ------
    UnknownNameError
        If ``side`` is neither.
    """

    length: float = 0.1933
    breadth: float = 0.0883
    side: Side = "right"

    def __post_init__(self) -> None:
        """Check the side."""
        if self.side not in SIDES:
            raise UnknownNameError("side", self.side, SIDES)


MEDIAN_HAND = HandSize()
"""The right hand of a man of median size."""
