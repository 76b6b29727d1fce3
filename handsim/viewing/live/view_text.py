"""A view of the page as text: what stands after ``?`` in its links, and back.

Nothing here knows of a page, so that all of it can be tried without a browser.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from urllib.parse import parse_qsl, urlencode

import numpy as np

from handsim.errors import InputError
from handsim.tasks.table_one import task_by_name
from handsim.types import MEDIAN_HAND, HandSize
from handsim.viewing.live.table_place import TURN_RANGE, USUAL_PLACE, X_RANGE, Y_RANGE, TablePlace

LENGTHS_MM, BREADTHS_MM = (150, 220), (65, 105)
"""Hand length and breadth that a page shows: those of adults [mm]."""
MOST_TIME = 60.0
"""Latest time of a grasp in a link [s]."""
SUBSPACE_NAMES = ("start", "goal", "share", "at", "field", "recording")
_NAMES = (*SUBSPACE_NAMES, "hand", "task", "object", "time", "loop", "camera", "shown")


@dataclass(frozen=True)
class PageView:
    """All that is needed to show the same again.

    Attributes
    ----------
    subspace
        What is shown of the subspace, by the names of `subspace_state.state_values`.
    size
        Of the hand.
    task
        The task that is chosen; None for the hand alone.
    place
        Where its object is put.
    time
        At which the grasp stands [s]; 0 before it.
    loop
        Whether the hand alone is in physics, under its controller.
    camera
        Position and the point that it looks at [m]; None for the usual place.
    shown
        Names of the controllers; none where it does not matter.
    """

    subspace: Mapping[str, str] = field(default_factory=dict[str, str])
    size: HandSize = MEDIAN_HAND
    task: str | None = None
    place: TablePlace = USUAL_PLACE
    time: float = 0.0
    loop: bool = False
    camera: tuple[float, ...] | None = None
    shown: tuple[str, ...] = ()


def view_text(view: PageView) -> str:
    """Return a view as text; what is as usual is left out."""
    values = dict(view.subspace)
    if view.size != MEDIAN_HAND:
        values["hand"] = f"{1000 * view.size.length:.0f},{1000 * view.size.breadth:.0f}"
    if view.task is not None:
        values["task"] = view.task
        if view.place != USUAL_PLACE:
            values["object"] = f"{view.place.x:g},{view.place.y:g},{view.place.turn:g}"
        if view.time > 0:
            values["time"] = f"{view.time:.2f}"
    elif view.loop:
        values["loop"] = "1"
    if view.camera is not None:
        values["camera"] = ",".join(f"{round(value, 3) + 0.0:.3f}" for value in view.camera)
    if view.shown:
        values["shown"] = ",".join(view.shown)
    return urlencode(values, safe=",")


def read_view(text: str, shown: tuple[str, ...]) -> PageView:
    """Read what `view_text` wrote, a part of it, or a whole link.

    Values of the subspace are left as they are; `read_state` reads them.

    Parameters
    ----------
    text
    shown
        Names of the controllers on this page.

    Raises
    ------
    InputError
        If a name or a value makes no sense, or the link is one of other controllers.
    UnknownNameError
        If there is no such task.
    """
    given = dict(parse_qsl(text.strip().rpartition("?")[2], keep_blank_values=True))
    unknown = sorted(set(given) - set(_NAMES))
    if unknown or (text.strip() and not given):
        what = unknown[0] if unknown else text.strip()[:60]
        raise InputError(f"'{what}' is not part of a view; copy the whole text")
    names = tuple(given["shown"].split(",")) if "shown" in given else ()
    if names and names != shown:
        raise InputError(
            f"the link shows {' and '.join(names)}, this page {' and '.join(shown)}; "
            "begin it with those controllers"
        )
    length, breadth = 1000 * MEDIAN_HAND.length, 1000 * MEDIAN_HAND.breadth
    if "hand" in given:
        length, breadth = _numbers("hand", given["hand"], (LENGTHS_MM, BREADTHS_MM))
    place = (0.0, 0.0, 0.0)
    if "object" in given:
        place = _numbers("object", given["object"], (X_RANGE, Y_RANGE, TURN_RANGE))
    time = _numbers("time", given["time"], ((0.0, MOST_TIME),))[0] if "time" in given else 0.0
    camera = _numbers("camera", given["camera"], ((-9.0, 9.0),) * 6) if "camera" in given else None
    if given.get("loop", "0") not in ("0", "1"):
        raise InputError(f"loop '{given['loop']}'; give 0 or 1")
    return PageView(
        {name: given[name] for name in SUBSPACE_NAMES if name in given},
        HandSize(length / 1000, breadth / 1000),
        task_by_name(given["task"]).name if "task" in given else None,
        TablePlace(*place),
        time,
        given.get("loop") == "1",
        camera,
        names,
    )


def _numbers(name: str, text: str, limits: tuple[tuple[float, float], ...]) -> tuple[float, ...]:
    """Return numbers with commas between, each within its limits."""
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != len(limits) or not all(
        low <= number <= high for number, (low, high) in zip(numbers, limits, strict=True)
    ):
        wanted = ", ".join(f"{low:g} to {high:g}" for low, high in limits)
        raise InputError(f"{name} '{text[:60]}'; give {wanted}")
    return numbers


def link_html(text: str) -> str:
    """Return a link to a view, relative to wherever the page was opened from."""
    return (
        f'<div style="padding:0 .8em;font-size:.9em"><a href="/?{text.replace("&", "&amp;")}">'
        "link to this view</a></div>"
    )


def close_to(first: tuple[float, ...] | None, second: tuple[float, ...] | None) -> bool:
    """Whether two places of the camera are the same to what a link says of them."""
    if first is None or second is None:
        return first is second
    return bool(np.allclose(first, second, atol=1e-3))
