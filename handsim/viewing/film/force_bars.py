"""What the fingers press, beside what is needed: one bar each for fingers and palm."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.tasks.grip_rules import LEAST_PRESS
from handsim.types import Array, Frame
from handsim.viewing.film.overlay import (
    DARK,
    FORCE_COLOUR,
    draw_text,
    has_room,
    sample_at,
    text_width,
)

IDLE_COLOUR = (150, 154, 160)
"""Of the bar of a part that presses less than `LEAST_PRESS`; its name is in this grey, too."""
NEED_COLOUR = (0, 114, 178)
LIMIT_COLOUR = (140, 20, 60)
"""Of the lines at need and limit, apart from the bars for the colour-blind (Okabe and Ito)."""
MOST_OF_LIMIT = 1.6
"""Where there is a limit, forces beyond this many limits are cut off: a knock on the way is not to
make the rest too small to be seen."""


MOST_OF_WIDTH = 0.46
"""Share of a frame's width that whole names may take: what is grasped is right of that."""
_MOST = 1e6  # N; files may hold anything
_MARK = "limit 18.8"
"""The least that there is room for beside the bars."""


@dataclass(frozen=True)
class ForceBars:
    """Forces as upright bars in a lower corner, with lines at what is needed and what is too much.

    Attributes
    ----------
    time : (n,) [s]
        Since the clip's start.
    force : (n, k) [N]
        Normal forces.
    labels
        k names; their first letters where there is no room for more.
    need, limit
        Heights of the two lines [N]; 0 draws none.
    scale
        Factor on the letters' size.
    at_right
        Whether they stand at the right.
    """

    time: Array
    force: Array
    labels: tuple[str, ...]
    need: float = 0.0
    limit: float = 0.0
    scale: float = 1.0
    at_right: bool = False

    @property
    def full_scale(self) -> float:
        """Force at the top of the bars' field [N]."""
        most = float(self.force.max(initial=0.0))
        if self.limit > 0:
            most = min(most, MOST_OF_LIMIT * self.limit)
        return min(max(most, self.limit, 1.5 * self.need, LEAST_PRESS), _MOST)

    def draw(self, frame: Frame, time: float) -> None:
        """Draw onto a frame as of ``time`` [s], if it has room for them (`has_room`)."""
        if not has_room(frame.shape[1], frame.shape[0]):
            return
        written = [f"{name} {value:.1f}" for name, value in self._marks()]
        field = BarField.of(frame, self.labels, self.scale, self.at_right, written)
        field.lay_ground(frame)
        draw_text(frame, ["normal force, N"], (field.left, field.title), field.size)
        now = self.force[sample_at(self.time, time)].tolist()
        heights = [self.pixels(newton, field) for newton in now]
        for i, newton in enumerate(now):
            colour = IDLE_COLOUR if newton < LEAST_PRESS else FORCE_COLOUR
            field.bar(frame, i, heights[i], colour)
        lines: list[int] = []
        for mark, (name, value) in zip(written, self._marks(), strict=True):
            colour = NEED_COLOUR if name == "need" else LIMIT_COLOUR
            lines.append(field.bottom - self.pixels(value, field))
            field.line(frame, lines[-1], colour, dashed=name == "limit")
            at = (field.right + 0.2 * field.size, lines[-1] - 0.75 * field.size)
            draw_text(frame, [mark], at, field.size, colour)
        for i, newton in enumerate(now):
            letters = IDLE_COLOUR if newton < LEAST_PRESS else DARK
            number = f"{newton:.1f}" if newton > 0 else "0"
            above = field.bottom - heights[i] - 1.3 * field.size
            for line in lines:
                if above < line < above + 1.4 * field.size:  # not struck through by it
                    above = line - 1.4 * field.size
            field.write(frame, i, number, above, letters)
            field.name(frame, i, self.labels[i], letters)

    def _marks(self) -> list[tuple[str, float]]:
        return [(n, v) for n, v in (("need", self.need), ("limit", self.limit)) if v > 0]

    def pixels(self, newton: float, field: "BarField") -> int:
        """Return how high a force stands in a field [pixels]."""
        return round(min(newton / self.full_scale, 1.0) * field.height)


@dataclass(frozen=True)
class BarField:
    """Where the bars are in a frame, all in pixels: the columns, their letters, and their height.

    ``right`` is where the last column ends; beyond it the lines' names have ``beside`` pixels.
    Whole names stand in two lines by turns, so that the columns can be narrow and the hand in view.
    """

    left: int
    right: int
    top: int
    bottom: int
    size: int
    pitch: int
    whole_names: bool
    beside: int

    @classmethod
    def of(
        cls,
        frame: Frame,
        labels: tuple[str, ...],
        scale: float = 1.0,
        at_right: bool = False,
        marks: Sequence[str] = (),
    ) -> "BarField":
        """Lay the field out in a frame of any size, with room for the names of lines beside it."""
        height, width = frame.shape[:2]
        size = max(10, round(scale * height / 39))
        pitch = round(2.1 * size)
        beside = round(0.4 * size) + max(text_width(mark, size) for mark in (_MARK, *marks))
        whole = pitch * len(labels) + beside <= MOST_OF_WIDTH * width
        pitch = pitch if whole else round(1.75 * size)
        left = round(1.3 * size)
        if at_right:
            left = max(left, width - round(beside + 0.3 * size) - pitch * len(labels))
        bottom = height - round((3.0 if whole else 1.8) * size)
        right, top = left + pitch * len(labels), bottom - round(0.165 * height)
        return cls(left, right, top, bottom, size, pitch, whole, beside)

    @property
    def height(self) -> int:
        """Of a bar at full scale."""
        return self.bottom - self.top

    @property
    def title(self) -> int:
        """Top of the title: a bar's number is between the two."""
        return self.top - round(2.7 * self.size)

    def lay_ground(self, frame: Frame) -> None:
        """Make the frame paler under the bars, and draw the line that they stand on."""
        rows = slice(max(self.title - 2, 0), frame.shape[0] - self.size // 3)
        columns = slice(max(self.left - self.size, 0), self.right + self.beside)
        frame[rows, columns] = (0.35 * frame[rows, columns] + 0.65 * 255).astype(np.uint8)
        _fill(frame, self.left, self.bottom, self.right, self.bottom + 1, (90, 95, 102))

    def bar(self, frame: Frame, i: int, height: int, colour: tuple[int, int, int]) -> None:
        """Draw the bar of a column."""
        wide = self.pitch // 2
        left = self.left + i * self.pitch + (self.pitch - wide) // 2
        _fill(frame, left, self.bottom - height, left + wide, self.bottom, colour)

    def write(
        self, frame: Frame, i: int, text: str, top: float, colour: tuple[int, int, int]
    ) -> None:
        """Write into the middle of a column."""
        aside = 0.5 * (self.pitch - text_width(text, self.size))
        draw_text(frame, [text], (self.left + i * self.pitch + aside, top), self.size, colour)

    def name(self, frame: Frame, i: int, label: str, colour: tuple[int, int, int]) -> None:
        """Write the name of a column below it."""
        if self.whole_names:
            self.write(frame, i, label, self.bottom + 1 + (i % 2) * 1.2 * self.size, colour)
        else:
            self.write(frame, i, label[:1].upper(), self.bottom + 1, colour)

    def line(self, frame: Frame, y: int, colour: tuple[int, int, int], dashed: bool) -> None:
        """Draw a line across all columns at a height in the frame."""
        dash = max(4, self.size // 2)
        step = 2 * dash if dashed else dash
        for x in range(self.left, self.right, step):
            _fill(frame, x, y - 1, min(x + dash, self.right), y + 1, colour)


def _fill(
    frame: Frame, left: int, top: int, right: int, bottom: int, colour: tuple[int, int, int]
) -> None:
    """Fill a rectangle, cut off at the frame's edges."""
    frame[max(top, 0) : max(bottom, 0), max(left, 0) : max(right, 0)] = colour
