"""Text and small plots drawn onto frames.

Only the pixels covered are touched, and each text is rasterised once, so that an overlay costs a
few per cent of the frame under it.
"""

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from handsim.types import Array, Frame

FORCE_COLOUR = (213, 94, 0)
PATH_COLOUR = (0, 114, 178)
"""Vermilion and blue of Okabe and Ito's palette, told apart by the colour-blind."""
DARK = (25, 28, 33)
GOOD_COLOUR, BAD_COLOUR = (0, 105, 70), (176, 38, 20)

LEAST_LETTERS = 9
"""Least height of letters that can be read [pixels]."""
ROOMY = (280, 200)
"""Least width and height of a picture with room for measurements; smaller ones have a caption."""

_Colour = tuple[int, int, int]
_EDGE = 2
"""White edge of a second view [pixels]."""


def draw_text(
    frame: Frame,
    lines: Sequence[str],
    at: tuple[float, float],
    size: int,
    colour: _Colour = DARK,
) -> None:
    """Write lines onto a frame, dark with a light edge: legible on any background.

    Parameters
    ----------
    frame : (height, width, 3)
        Changed in place.
    lines
        One under the other.
    at
        Left and top of the first line [pixels].
    size
        Height of the letters [pixels].
    colour
        Of the letters.
    """
    left, top = round(at[0]), round(at[1])
    for i, line in enumerate(lines):
        if line:
            _blend(frame, _text(line, size, colour), left, top + round(1.3 * size * i))


def text_width(line: str, size: int) -> int:
    """Return how wide a line is with its edge [pixels]."""
    return _text(line, size, DARK).shape[1]


def has_room(width: int, height: int) -> bool:
    """Return whether measurements and a second view are drawn into pictures of a size [pixels]."""
    return width >= ROOMY[0] and height >= ROOMY[1]


def fitted(line: str, size: int, width: float) -> tuple[str, int]:
    """Make a line fit into a width: by smaller letters, then by what may be left out of it.

    Letters shrink to `LEAST_LETTERS`. If that is not enough, what follows the last comma is left
    out, again and again; what is still too long ends in two points.

    Parameters
    ----------
    line
    size
        Height of letters that is wished for [pixels].
    width
        That there is [pixels].

    Returns
    -------
    str, int
        What is written, and in letters of which height.
    """
    while size > LEAST_LETTERS and text_width(line, size) > width:
        size -= 1
    while text_width(line, size) > width and ", " in line:
        line = line.rpartition(", ")[0]
    if text_width(line, size) <= width:
        return line, size
    while line and text_width(f"{line}..", size) > width:
        line = line[:-1]
    return f"{line}..", size


@functools.lru_cache(maxsize=512)
def _text(line: str, size: int, colour: _Colour) -> npt.NDArray[np.uint16]:
    """Rasterise a line as (height, width, 4): colour and opacity, 0 to 255."""
    from PIL import Image, ImageDraw, ImageFont

    font = ImageFont.load_default(size)
    edge = max(1, size // 8)
    _, _, right, bottom = font.getbbox(line, stroke_width=edge)
    patch = Image.new("RGBA", (int(right) + 2 * edge, int(bottom) + 2 * edge), (255, 255, 255, 0))
    ImageDraw.Draw(patch).text(
        (edge, edge), line, colour, font, stroke_width=edge, stroke_fill=(255, 255, 255)
    )
    return np.asarray(patch, np.uint16)


def _blend(frame: Frame, patch: npt.NDArray[np.uint16], left: int, top: int) -> None:
    """Lay a patch of colour and opacity over a frame, cut off at its edges."""
    height, width = frame.shape[:2]
    x0, y0 = max(left, 0), max(top, 0)
    x1, y1 = min(left + patch.shape[1], width), min(top + patch.shape[0], height)
    if x0 >= x1 or y0 >= y1:
        return
    over = patch[y0 - top : y1 - top, x0 - left : x1 - left]
    under = frame[y0:y1, x0:x1]
    opacity = over[..., 3:]
    under[:] = (over[..., :3] * opacity + under * (255 - opacity)) // 255


def inset_view(frame: Frame, picture: Frame, below_caption: bool = False) -> None:
    """Set a second view into a frame, with a white edge.

    Parameters
    ----------
    frame : (height, width, 3)
        Changed in place.
    picture
        Smaller.
    below_caption
        At the left below the caption, else at the lower right.
    """
    height, width = (each + 2 * _EDGE for each in picture.shape[:2])
    top, left = _inset_place(frame, (height, width), frame.shape[0] // 48, below_caption)
    frame[top : top + height, left : left + width] = 255
    inner = frame[top + _EDGE : top + height - _EDGE, left + _EDGE : left + width - _EDGE]
    inner[:] = picture


def _inset_place(
    frame: Frame, size: tuple[int, int], margin: int, below_caption: bool
) -> tuple[int, int]:
    """Return top and left of an inset of a height and width in a frame."""
    top, left = (whole - part - margin for whole, part in zip(frame.shape[:2], size, strict=True))
    if not below_caption:
        return top, left
    letters = _caption_size(frame)
    return min(round(5.2 * letters), top), letters // 2


@dataclass(frozen=True)
class Verdict:
    """How a movement ended, known from ``time`` [s] since the clip's start on."""

    time: float
    text: str
    good: bool


@dataclass(frozen=True)
class Caption:
    """Lines at the upper left: fixed ones, the time, and how it ended once that is known.

    Attributes
    ----------
    lines
        Written above the time.
    phases
        Start [s] and name of stretches of time, in order; the present one is written by the time.
    verdict
        Written below the time from when it is reached.
    scale
        Factor on the letters' size.
    """

    lines: tuple[str, ...] = ()
    phases: tuple[tuple[float, str], ...] = ()
    verdict: Verdict | None = None
    scale: float = 1.0

    def draw(self, frame: Frame, time: float) -> None:
        """Write onto a frame as of ``time`` [s]."""
        usual = round(max(_caption_size(frame), self.scale * frame.shape[0] / 26))
        names = [name for start, name in self.phases if start <= time + 1e-9]
        clock = f"{time:.2f} s" + (f"  {names[-1]}" if names else "")
        width = frame.shape[1] - usual
        left, top = 0.5 * usual, round(0.4 * usual)
        for line in (*self.lines, clock):
            written, size = fitted(line, usual, width)
            draw_text(frame, [written], (left, top), size)
            top += round(1.3 * usual)
        if self.verdict is not None and time >= self.verdict.time - 1e-9:
            colour = GOOD_COLOUR if self.verdict.good else BAD_COLOUR
            written, size = fitted(self.verdict.text, round(1.2 * usual), width)
            draw_text(frame, [written], (left, top), size, colour)


def _caption_size(frame: Frame) -> int:
    return max(11, frame.shape[0] // 26)


class SubspaceInset:
    """The path in the first two subspace coordinates, at the lower right or below the caption.

    Pictures without room (`has_room`) are left as they are.

    Parameters
    ----------
    time : (n,) [s]
        Since the clip's start.
    z : (n, n_components >= 2) [rad]
        Subspace coordinates of the movement.
    below_caption
        Whether it leaves the lower right to a second view.
    """

    def __init__(self, time: Array, z: Array, below_caption: bool = False) -> None:
        self.below_caption = below_caption
        self.time, self.z = time, np.rad2deg(z[:, :2])
        self._centre = (self.z.max(axis=0) + self.z.min(axis=0)) / 2
        half = max(float(np.ptp(self.z, axis=0).max()) / 2, 1.0)
        self._half = half * 1.45  # a margin for the texts
        self._base: Frame | None = None

    def draw(self, frame: Frame, time: float) -> None:
        """Draw onto a frame the path up to ``time`` [s] and the position at that time."""
        from PIL import Image, ImageDraw

        if not has_room(frame.shape[1], frame.shape[0]):
            return
        side = round(0.3 * min(frame.shape[:2]))
        if self._base is None or len(self._base) != side:
            self._base = self._background(side)
        image = Image.fromarray(self._base)
        pen = ImageDraw.Draw(image)
        way = self._pixels(self.z[: sample_at(self.time, time) + 1], side)
        if len(way) > 1:
            pen.line(way, fill=PATH_COLOUR, width=max(2, side // 60), joint="curve")
        radius = max(3, side // 28)
        pen.ellipse(_square(way[-1], radius), fill=PATH_COLOUR, outline=(255, 255, 255))
        margin = side // 16
        top, left = _inset_place(frame, (side, side), margin, self.below_caption)
        frame[top : top + side, left : left + side] = np.asarray(image)

    def _pixels(self, points: Array, side: int) -> list[tuple[float, float]]:
        scaled = (points - self._centre) / self._half * [1, -1]
        return [(float(x), float(y)) for x, y in (scaled + 1) / 2 * (side - 1)]

    def _length(self, degrees: float, side: int) -> int:
        return round(degrees / self._half / 2 * (side - 1))

    def _background(self, side: int) -> Frame:
        """Draw what does not change: border, scale, start (square) and destination (circle)."""
        from PIL import Image, ImageDraw

        image = Image.new("RGB", (side, side), (250, 250, 250))
        pen = ImageDraw.Draw(image)
        pen.rectangle((0, 0, side - 1, side - 1), outline=(120, 125, 132))
        radius, width = max(3, side // 28), max(1, side // 90)
        start, end = self._pixels(self.z[[0, -1]], side)
        pen.rectangle(_square(start, radius), outline=(90, 95, 102), width=width)
        pen.ellipse(_square(end, radius), outline=(90, 95, 102), width=width)
        base = np.array(image)
        size = max(9, side // 11)
        bar = _round_length(0.6 * self._half)
        base[-size // 2 - width : -size // 2, size // 2 : size // 2 + self._length(bar, side)] = 60
        draw_text(base, [f"{bar:g} deg"], (size // 2, side - 2.1 * size), size)
        draw_text(base, ["PC 2"], (size // 3, size // 4), size)
        draw_text(base, ["PC 1"], (side - 2.7 * size, side - 1.6 * size), size)
        return base


def _round_length(most: float) -> float:
    """Largest of 1, 2, 5, 10, 20, ... that is not above ``most``."""
    power = 10.0 ** np.floor(np.log10(most))
    return power * max(factor for factor in (1, 2, 5) if factor * power <= most * (1 + 1e-9))


def _square(centre: tuple[float, float], radius: float) -> tuple[float, float, float, float]:
    x, y = centre
    return x - radius, y - radius, x + radius, y + radius


def sample_at(times: Array, time: float) -> int:
    """Return the index of the last of ``times`` that is not after ``time``."""
    return max(int(np.searchsorted(times, time + 1e-9, side="right")) - 1, 0)
