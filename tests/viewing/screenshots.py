"""Pictures of the live page, the report and the documentation, for the documentation.

``python -m tests.viewing.screenshots docs/pictures`` draws them all in headless Chromium; names
behind the folder draw those alone. The documentation is pictured as it was built last, into
out/docs. Pictures have 256 colours, so that each is small.
"""

import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from handsim.cli import main as handsim_command
from handsim.cli.reporting import _shown
from handsim.learning.learn import learn_controller
from handsim.viewing.live.page import LivePage
from handsim.viewing.live.pushing.push_controls import Grab
from handsim.viewing.live.shown import ShownController
from tests.viewing.chromium import Browser, open_browser

ROOT = Path(__file__).parents[2]
WIDE, NARROW = (1200, 800), (480, 900)
COLOURS, MOST_BYTES = 256, 200_000
PORT = 18100
SHOWN_TASKS = "tall-glass-drink,cup-side-move,cube-raise"


def run(page: LivePage, seconds: float, browser: Browser | None = None) -> None:
    """Keep a page alive; give a browser the time to draw what it shows."""
    end = last = time.monotonic()
    end += seconds
    while (now := time.monotonic()) < end:
        page.step(now - last)
        last = now
        time.sleep(0.03)
    if browser is not None:
        browser.evaluate(
            "document.querySelectorAll('.mantine-Notification-closeButton').forEach(b => b.click())"
        )


def shoot(browser: Browser, target: Path) -> None:
    """Write what a browser shows, in few colours."""
    browser.screenshot(target)
    with Image.open(target) as taken:
        few = taken.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    few.save(target, optimize=True)
    size = target.stat().st_size
    assert size < MOST_BYTES, f"{target} has {size} bytes; picture less"
    print(f"{target}: {size / 1000:.0f} kB")


def of_page(
    shown: Sequence[ShownController],
    link: str,
    act: Callable[[LivePage], None],
    target: Path,
    size: tuple[int, int] = WIDE,
) -> None:
    """Picture a live page that is opened by a link, after something was done on it."""
    page = LivePage(shown, port=PORT)
    with tempfile.TemporaryDirectory() as folder, open_browser(Path(folder), *size) as browser:
        browser.resize(*size)
        browser.visit(f"{page.address}/?{link}")
        run(page, 8.0, browser)
        act(page)
        run(page, 1.0, browser)
        time.sleep(3.0)
        shoot(browser, target)
    page.close()


def pushed(page: LivePage) -> None:
    """Push the index finger, then hold the middle finger."""
    page.pushing.asked.append("index")
    run(page, 1.2)
    puppet = page.postures.puppets[0]
    body = puppet.model.body("middle_distal").id
    held = np.array(puppet.bodies[body].position)
    page.pushing.grabs[0] = Grab(0, body, held, held + [-0.02, 0.06, 0.05], begins=True)


def nothing(_: LivePage) -> None:
    """Leave the page as its link shows it."""


def push_picture(target: Path) -> None:
    """The loop, pushed."""
    of_page([_shown(None, "built-in")], "loop=1", pushed, target)


def way_picture(target: Path) -> None:
    """The subspace with the way to a destination, and the ghost of a recording."""
    link = "share=0.6&at=way&field=φ&recording=cup-drink"
    of_page([_shown(None, "built-in")], link, nothing, target)


def table_picture(target: Path) -> None:
    """A grasp where the object was put."""
    link = "task=cup-side-move&object=-60,-60,0&time=2.60"
    of_page([_shown(None, "built-in")], link, nothing, target)


def pair_picture(target: Path) -> None:
    """Two controllers side by side."""
    built_in = _shown(None, "built-in")
    learned = learn_controller(built_in.recordings, 2, guided=False, certified=False).controller
    pair = [built_in, ShownController("2 PCs", learned, built_in.plans)]
    of_page(pair, "share=0.8&at=way", nothing, target)


def narrow_picture(target: Path) -> None:
    """The page on a narrow screen."""
    of_page([_shown(None, "built-in")], "loop=1", pushed, target, NARROW)


def report_picture(target: Path) -> None:
    """The head of a report."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "report.html"
        sys.argv[1:] = ["report", "-o", str(made), "--tasks", SHOWN_TASKS]
        try:
            handsim_command()
        except SystemExit as end:
            assert not end.code, "the report failed"
        file_picture(made, target)


def docs_picture(target: Path) -> None:
    """A page of the documentation."""
    file_picture(ROOT / "out" / "docs" / "gallery.html", target)


def file_picture(file: Path, target: Path) -> None:
    """Picture a page that lies in a file."""
    assert file.is_file(), f"{file}: no such file; run `make docs`"
    with tempfile.TemporaryDirectory() as folder, open_browser(Path(folder), *WIDE) as browser:
        browser.resize(*WIDE)
        browser.visit(file.as_uri())
        time.sleep(4.0)
        shoot(browser, target)


PICTURES: dict[str, Callable[[Path], None]] = {
    "live_way": way_picture,
    "live_push": push_picture,
    "live_table": table_picture,
    "live_pair": pair_picture,
    "live_narrow": narrow_picture,
    "report": report_picture,
    "docs": docs_picture,
}


def main() -> None:
    """Draw the pictures whose names are given, or all."""
    folder, names = Path(sys.argv[1]), sys.argv[2:] or list(PICTURES)
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        PICTURES[name](folder / f"{name}.png")


if __name__ == "__main__":
    main()
