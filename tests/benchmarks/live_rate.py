"""How often the live page follows a dragged destination.

Run it by ``python -m tests.benchmarks.live_rate``.

The server's own work is measured, on this machine, with nobody looking: the path to the new
destination, the hand's bodies and what is sent. A browser draws at its own rate.
"""

import time

import numpy as np

from handsim.cli.defaults import controller_or_built_in, recordings_or_built_in
from handsim.viewing.live.page import LivePage

SECONDS = 5.0


def main() -> None:
    page = LivePage(
        controller_or_built_in(None), lambda *_: None, port=18080,
        recordings=tuple(recordings_or_built_in(None)), text="field=φ&recording=cup-drink",
    )  # fmt: skip
    page.step(0.0)
    handle, begun, took = page._panel.scene.goal, time.perf_counter(), []
    middle = np.array(handle.position)
    while time.perf_counter() - begun < SECONDS:
        before, turn = time.perf_counter(), 2 * np.pi * (time.perf_counter() - begun) / 3
        handle.position = middle + 0.03 * np.array([np.cos(turn) - 1, np.sin(turn), 0])
        page.step(0.03)
        took.append(time.perf_counter() - before)
    page.close()
    print(
        f"{len(took) / SECONDS:.0f} frames a second; "
        f"{1000 * np.median(took):.1f} ms each, slowest {1000 * max(took):.0f} ms"
    )


if __name__ == "__main__":
    main()
