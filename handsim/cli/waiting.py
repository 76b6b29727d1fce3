"""How far long work is: a bar with an estimate on a terminal, a line now and then elsewhere.

Both go to standard error. What is to be told apart from silence is the whole process: a line is due
when nothing has been said for a while, whoever said the last. What is kept where somebody does not
want to wait any longer is said at the end.
"""

import sys
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from threading import Event, Thread
from time import perf_counter
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    import rich.progress

    from handsim.types import Progress

T = TypeVar("T")

LONGEST_SILENCE = 9.0
"""Time without a word after which a line says how far the work is, where there is no bar [s]."""

NOTHING = "nothing was written, and nothing that was there is changed"
"""What is kept of most commands that are interrupted: files are written as a whole, at the end."""

_kept: list[str] = []
_last = [perf_counter()]
"""When something was last said, or a command began."""
_working: list[Event] = []
"""Work that goes on, the innermost last, which alone speaks: what began it waits for it."""
_bars: "list[rich.progress.Progress]" = []
"""Bars of work that goes on, the innermost last, which alone is drawn."""
_SOON = 0.005  # least time between two looks at the clock [s]


def heard() -> None:
    """Note that something was said just now."""
    _last[0] = perf_counter()


@contextmanager
def fraction_done(label: str) -> "Generator[Progress, None, None]":
    """Give a function that says the fraction done: by a bar, or by lines where none can be drawn.

    Work that does not know how far it is need not call it: then the time so far is shown alone.
    Processes that work for another say nothing: that one does, and has the terminal.
    """
    from multiprocessing import parent_process

    if parent_process() is not None:
        yield lambda fraction: None
        return
    # A bar puts something else in place of standard error, which is no terminal.
    shown = _bar(label) if _bars or sys.stderr.isatty() else _lines(label)
    with shown as tell:
        yield tell


def progress(items: Sequence[T], label: str) -> Iterator[T]:
    """Iterate and say how far it is."""
    if len(items) < 2:
        yield from items
        return
    with fraction_done(label) as tell:
        for number, item in enumerate(items, start=1):
            yield item
            tell(number / len(items))


def how_far(fraction: float, elapsed: float) -> str:
    """Return in words how far work is, and how long the rest will take if it goes on so.

    Parameters
    ----------
    fraction
        Done, 0 to 1; 0 where that is not known.
    elapsed
        Since it began [s].
    """
    if fraction <= 0.0:
        return f"{in_time(elapsed)} so far"
    left = elapsed * (1.0 - fraction) / fraction
    return f"{100 * fraction:.0f} %, {in_time(elapsed)} so far, about {in_time(left)} left"


def in_time(seconds: float) -> str:
    """Return a time in the unit that suits it."""
    for size, unit in ((86400.0 * 365, "years"), (86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2 * size:
            return f"{seconds / size:,.0f} {unit}"
    return f"{seconds:.0f} s"


@contextmanager
def _bar(label: str) -> "Generator[Progress, None, None]":
    from rich.console import Console
    from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn
    from rich.text import Text

    class HowFar(ProgressColumn):
        def render(self, task: Task) -> Text:
            return Text(how_far(task.completed, task.elapsed or 0.0))

    columns = (TextColumn("{task.description}"), BarColumn(bar_width=20), HowFar())
    # Results are not led into the console of the bar, unless both are on the terminal.
    shared = sys.stdout.isatty()
    bar = Progress(*columns, console=Console(stderr=True), transient=True, redirect_stdout=shared)
    task = bar.add_task(label, total=None)
    if _bars:  # two would write over each other
        _bars[-1].stop()
    _bars.append(bar)
    try:
        bar.start()
        yield lambda fraction: bar.update(task, total=1.0, completed=fraction)
    finally:
        bar.stop()
        with suppress(ValueError):
            _bars.remove(bar)
        if _bars:
            _bars[-1].start()
    heard()


@contextmanager
def _lines(label: str) -> "Generator[Progress, None, None]":
    begun, done, ended = perf_counter(), [0.0], Event()

    def tell(fraction: float) -> None:
        done[0] = fraction

    def speak() -> None:
        while not ended.wait(max(_SOON, _last[0] + LONGEST_SILENCE - perf_counter())):
            if perf_counter() >= _last[0] + LONGEST_SILENCE and _working[-1:] == [ended]:
                with suppress(OSError, ValueError):  # nobody listens; or it has been closed
                    sys.stderr.write(f"{label}: {how_far(done[0], perf_counter() - begun)}\n")
                    sys.stderr.flush()
                heard()

    _working.append(ended)
    speaker = Thread(target=speak, daemon=True)
    speaker.start()
    try:
        yield tell
    finally:
        ended.set()
        speaker.join()
        with suppress(ValueError):  # the command has ended before its work
            _working.remove(ended)


def say_no_more() -> None:
    """End what says how far work is, of a command that ends: of iterators, too, that it left alone.

    Such an iterator lives on with the error that was raised while it was gone through.
    """
    while _working:
        _working.pop().set()
    while _bars:
        _bars.pop().stop()


@contextmanager
def keeping(said: str) -> Generator[None, None, None]:
    """While the block runs, an interrupt keeps what ``said`` says.

    It stays so when the block is left by an exception, since that is when it is asked for.
    """
    _kept.append(said)
    yield
    _kept.remove(said)


def what_is_kept() -> str:
    """Return what is kept of the command that was just interrupted."""
    said = "; ".join(dict.fromkeys(_kept)) or NOTHING
    _kept.clear()
    return said
