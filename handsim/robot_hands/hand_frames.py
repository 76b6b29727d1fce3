"""Where palm and fingertips of a robot hand are, and the TOML that a user corrects them by."""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from handsim.errors import FileError, UnknownNameError
from handsim.joints import FINGERS, Finger
from handsim.types import SIDES, Side

LARGEST_OFFSET = 1.0
"""Largest distance of a frame from the body or site that it is on [m]."""
_MOST_BYTES = 1_000_000


@dataclass(frozen=True)
class AttachedFrame:
    """A frame fixed to a site or body of the model.

    Attributes
    ----------
    name
        Of a site, or else of a body.
    pos, quat
        Pose in it: (3,) [m], (4,) w, x, y, z. A palm's x points distal and z dorsal; a fingertip's
        origin is where it touches things and x points out of the finger, z to its back.
    """

    name: str
    pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
    quat: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class HandFrames:
    """Palm and fingertips of a robot hand.

    Attributes
    ----------
    palm
        Frame of the palm: x distal, z dorsal.
    fingertips
        Of each human finger that the hand has a counterpart of, where it touches things.
    knuckles
        Names of the joints at which fingers begin, where that is not the first joint of their own.
    side
        Which human hand it resembles.
    origin
        Where the frames come from, in words.
    """

    palm: AttachedFrame
    fingertips: Mapping[Finger, AttachedFrame]
    knuckles: Mapping[Finger, str] = field(default_factory=dict[Finger, str])
    side: Side = "right"
    origin: str = "given"


def frames_as_toml(frames: HandFrames) -> str:
    """Return frames as the text of a TOML file, to be corrected and read again."""
    lines = [
        "# Palm: x to the fingers, z out of the back of the hand. Fingertips: origin where they",
        "# touch things, x out of the finger, z to its back. `on` is a body or site of the hand's",
        "# file; pos is in m in its frame, quat is w, x, y, z. Fingers left out are not used.",
        f'side = "{frames.side}"',
        "",
        "[palm]",
        *_frame_lines(frames.palm),
    ]
    for finger in FINGERS:
        if finger in frames.fingertips:
            lines += ["", f"[fingertips.{finger}]", *_frame_lines(frames.fingertips[finger])]
    if frames.knuckles:
        lines += ["", "[knuckles]  # joints at which fingers begin"]
        lines += [f"{finger} = {_quoted(name)}" for finger, name in frames.knuckles.items()]
    return "\n".join(lines) + "\n"


def _frame_lines(frame: AttachedFrame) -> list[str]:
    pos = ", ".join(f"{value:.5f}" for value in frame.pos)
    quat = ", ".join(f"{value:.6f}" for value in frame.quat)
    return [f"on = {_quoted(frame.name)}", f"pos = [{pos}]", f"quat = [{quat}]"]


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in escaped) + '"'


def read_frames(path: Path | str) -> HandFrames:
    """Read the frames of a hand from a TOML file.

    Raises
    ------
    FileError
        If it is missing, no TOML, or an entry is not what it should be.
    UnknownNameError
        If it names a finger or side that there is none of.
    """
    file = Path(path)
    try:
        if file.stat().st_size > _MOST_BYTES:
            raise FileError(f"{file}: more than 1 MB; give the TOML of a hand's frames")
        table = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise FileError(f"{file}: not readable ({error.strerror}); give a TOML file") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError, ValueError) as error:
        reason = str(error).splitlines()[0][:120]
        raise FileError(f"{file}: no TOML ({reason}); correct it") from error
    known = ("side", "palm", "fingertips", "knuckles")
    for key in table:
        if key not in known:
            raise UnknownNameError(f"entry in {file}", key[:60], known)
    side = table.get("side", "right")
    if side not in SIDES:
        raise UnknownNameError(f"side in {file}", str(side)[:60], SIDES)
    if "palm" not in table or not isinstance(table.get("fingertips"), dict):
        raise FileError(f"{file}: [palm] or [fingertips.…] is missing; `hand inspect` writes both")
    tips = cast("dict[str, Any]", table["fingertips"])
    knuckles = table.get("knuckles", {})
    if not isinstance(knuckles, dict) or not all(isinstance(v, str) for v in knuckles.values()):
        raise FileError(f'{file}: [knuckles] is to hold finger = "joint"')
    for finger in (*tips, *cast("dict[str, str]", knuckles)):
        if finger not in FINGERS:
            raise UnknownNameError(f"finger in {file}", finger[:60], FINGERS)
    return HandFrames(
        _frame(table["palm"], "palm", file),
        {f: _frame(tips[f], f"fingertips.{f}", file) for f in FINGERS if f in tips},
        cast("dict[Finger, str]", knuckles),
        side,
        str(file),
    )


def _frame(value: Any, name: str, file: Path) -> AttachedFrame:
    if isinstance(value, str):
        return AttachedFrame(value)
    entry = cast("dict[str, Any]", value) if isinstance(value, dict) else {}
    if not isinstance(entry.get("on"), str) or set(entry) - {"on", "pos", "quat"}:
        raise FileError(f"{file}: [{name}] is to hold on, pos and quat; `hand inspect` writes them")
    pos = _numbers(entry.get("pos", [0.0, 0.0, 0.0]), 3, f"{name}.pos", file)
    quat = _numbers(entry.get("quat", [1.0, 0.0, 0.0, 0.0]), 4, f"{name}.quat", file)
    if max(map(abs, pos)) > LARGEST_OFFSET:
        raise FileError(f"{file}: {name}.pos is beyond {LARGEST_OFFSET:g} m; give metres")
    size = math.hypot(*quat)
    if not 0.9 < size < 1.1:
        raise FileError(f"{file}: {name}.quat has length {size:.3g}; give w, x, y, z of length 1")
    turned = (quat[0] / size, quat[1] / size, quat[2] / size, quat[3] / size)
    return AttachedFrame(entry["on"], (pos[0], pos[1], pos[2]), turned)


def _numbers(value: Any, count: int, name: str, file: Path) -> list[float]:
    numbers = cast("list[Any]", value) if isinstance(value, list) else []
    good = [
        float(x)
        for x in numbers
        if isinstance(x, int | float) and not isinstance(x, bool) and abs(x) < 1e6
    ]
    if len(numbers) != count or len(good) != count:
        raise FileError(f"{file}: {name} is to be {count} numbers")
    return good
