"""How often the live page follows a dragged destination, and how often it runs a pushed loop.

Run it by ``python -m tests.benchmarks.live_rate``.

The server's own work is measured, on this machine, with nobody looking: the path to the new
destination, the hand's bodies and what is sent. A browser draws at its own rate.
"""

import time
from collections.abc import Callable
from functools import partial

import numpy as np

from handsim.cli.defaults import controller_or_built_in, recordings_or_built_in
from handsim.viewing.live.page import LivePage
from handsim.viewing.live.shown import ShownController

SECONDS = 5.0


def main() -> None:
    controller, recordings = controller_or_built_in(None), tuple(recordings_or_built_in(None))
    for n in (1, 2):
        shown = [ShownController(str(i), controller, lambda *_: None, recordings) for i in range(n)]
        page = LivePage(shown, port=18080, text="field=φ&recording=cup-drink")
        page.step(0.0)
        middle = np.array(page.panel.scene.goal.position)
        said(f"{n} shown, destination dragged", page, partial(drag, page, middle))
        page.pushing.running.value = True
        said(f"{n} shown, loop pushed", page, partial(push, page))
        said(f"{n} shown, loop's destination dragged", page, partial(drag, page, middle))
        page.close()


def drag(page: LivePage, middle: np.ndarray, seconds: float) -> None:
    """Put the destination's handle where it is then on its circle."""
    turn = 2 * np.pi * seconds / 3
    away = 0.03 * np.array([np.cos(turn) - 1, np.sin(turn), 0])
    page.panel.scene.goal.position = middle + away


def push(page: LivePage, _: float) -> None:
    """Push a finger once the push before is over."""
    if not page.pushing._pushes:
        page.pushing.asked.append("index")


def said(what: str, page: LivePage, move: Callable[[float], None]) -> None:
    """Measure how long a frame takes while something is moved, and print it."""
    begun, took = time.perf_counter(), []
    while time.perf_counter() - begun < SECONDS:
        before = time.perf_counter()
        move(before - begun)
        page.step(1 / 30)
        took.append(time.perf_counter() - before)
    print(
        f"{what}: {len(took) / SECONDS:.0f} frames a second; "
        f"{1000 * np.median(took):.1f} ms each, slowest {1000 * max(took):.0f} ms"
    )


if __name__ == "__main__":
    main()
