"""Output of commands: results on standard output, progress and notes on standard error."""

import json
import math
import os
import shutil
import sys
import textwrap
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any, cast

import typer

from handsim.cli.waiting import heard, in_time

MAX_JOBS = 256
"""Largest number of processes; each takes 200 MB."""

MAX_TRIALS = 100_000
"""Largest number of perturbed trials of a task: a day of one processor."""
SECONDS_A_RUN = 1.0
"""What a run takes on a processor [s]; 0.8 to 1 with `handsim grasp demonstrator --trials 8`."""

JsonFlag = Annotated[bool, typer.Option("--json", help="One JSON object on standard output.")]
Folder = Annotated[
    Path | None, typer.Argument(help="Folder of recordings; the built-in ones if left out.")
]
ControllerFile = Annotated[
    Path | None, typer.Argument(help="Controller file; the built-in one if left out.")
]
Accept = Annotated[
    list[str] | None,
    typer.Option(
        "--accept",
        metavar="KIND",
        help="Kind of anomaly of the recordings that is right all the same; may be repeated.",
    ),
]


def help_where_alone(context: typer.Context) -> None:
    """Show the help of a group of commands where none of them is named."""
    if context.invoked_subcommand is None:
        say(context.get_help())


def say(text: str) -> None:
    """Write a line of results."""
    with _output():
        sys.stdout.write(text + "\n")
        sys.stdout.flush()


def say_wrapped(text: str, indent: int = 0, first: str | None = None) -> None:
    """Write a paragraph of results, in lines no longer than the terminal or 100 characters.

    Parameters
    ----------
    text
    indent
        Spaces before each line.
    first
        What stands before the first line instead, ``indent`` characters long.
    """
    width = min(shutil.get_terminal_size().columns, 100)
    margin = " " * indent
    start = margin if first is None else first
    lines = textwrap.wrap(
        text,
        width,
        initial_indent=start,
        subsequent_indent=margin,
        break_long_words=False,
        break_on_hyphens=False,
    )
    say("\n".join(lines))


def note(text: str) -> None:
    """Write a line about the work to standard error; where that is closed, it is dropped."""
    with suppress(OSError):
        sys.stderr.write(text + "\n")
    heard()


def say_json(value: Any) -> None:
    """Write one JSON object; numbers that are not finite become null."""
    say(json.dumps(_finite(value), indent=2, allow_nan=False))


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        entries = cast("dict[object, object]", value).items()
        return {str(key): _finite(item) for key, item in entries}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in cast("Sequence[object]", value)]
    if hasattr(value, "item") and getattr(value, "ndim", 1) == 0:  # numpy scalars
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def say_table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table; the first column is text, the others are aligned to the right."""
    from rich.cells import cell_len  # its tables take as long to import as a small table to make

    lines = [list(header), *([str(cell) for cell in row] for row in rows)]
    widths = [max(map(cell_len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        blanks = [" " * (width - cell_len(cell)) for cell, width in zip(line, widths, strict=True)]
        first, *others = line
        cells = [first + blanks[0], *(b + cell for b, cell in zip(blanks[1:], others, strict=True))]
        say("  ".join(cells).rstrip())


@contextmanager
def _output() -> Generator[None, None, None]:
    """Turn failures to write to standard output into a `FileError`."""
    from handsim.errors import FileError

    try:
        yield
        heard()
    except BrokenPipeError:
        raise
    except OSError as error:
        with suppress(OSError):
            sys.stdout.close()  # or Python would try to write the rest when it ends
        raise FileError(
            f"standard output: cannot be written ({error.strerror}); free some space where it "
            "leads, or lead it elsewhere"
        ) from error


def check_gl(*, draws: bool = False) -> None:
    """Check MUJOCO_GL before MuJoCo is imported, which fails with some values.

    Parameters
    ----------
    draws
        Check that it can be rendered with, too.

    Raises
    ------
    UnknownNameError, MissingToolError, RenderingError
        If MuJoCo does not know the value, or it names a backend that is not installed.
    """
    if not os.environ.get("MUJOCO_GL"):
        return
    if draws:
        from handsim.viewing.opengl.backend import choose_backend

        choose_backend()
    else:
        from handsim.viewing.opengl.setting import check_import

        check_import()


def check_trials(trials: int, jobs: int) -> None:
    """Check that trials can be waited for, and say how long they would take where not.

    Raises
    ------
    InputError
        If there are more than `MAX_TRIALS`.
    """
    from handsim.errors import InputError

    if trials > MAX_TRIALS:
        seconds = SECONDS_A_RUN * trials / jobs
        raise InputError(
            f"--trials {trials}: about {in_time(seconds)} a task, at {SECONDS_A_RUN:g} s a run in "
            f"{jobs} process{'es' * (jobs > 1)}; {MAX_TRIALS} are the most, ask for fewer"
        )


def writable(path: Path, *suffixes: str) -> Path:
    """Check before the work begins that a result can be written to ``path``.

    Raises
    ------
    InputError
        If the suffix is none of ``suffixes``, or the folder does not exist.
    """
    from handsim.errors import InputError
    from handsim.files import check_target

    if suffixes and path.suffix.lower() not in suffixes:
        raise InputError(f"{path}: suffix '{path.suffix}' is not one of {', '.join(suffixes)}")
    check_target(path)
    return path


def writable_folder(folder: Path) -> None:
    """Check before the work begins that results can be written to ``folder``.

    Raises
    ------
    FileError
        As `handsim.files.check_output_folder`.
    """
    from handsim.files import check_output_folder

    check_output_folder(folder)
