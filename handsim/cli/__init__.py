"""The ``handsim`` command.

Standard output carries results only: tables, or one JSON object with ``--json``. Progress and
errors go to standard error. Exit codes: 0 done, 1 a check did not hold, 2 bad input, 130
interrupted.
"""

import os
import sys
from contextlib import suppress
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from handsim.cli import (
    baseline,
    driving,
    grasping,
    hand,
    learning,
    objects,
    reporting,
    seeing,
    sweeping,
)
from handsim.cli.console import help_where_alone
from handsim.cli.exporting.export_command import export
from handsim.cli.listing import hand_list, machine, object_list, task_list
from handsim.cli.recordings import importing as recordings
from handsim.cli.waiting import heard, say_no_more, what_is_kept
from handsim.disk import refused
from handsim.errors import HandsimError

app = typer.Typer(
    name="handsim",
    help="Human-like grasping learned from recordings, simulated in MuJoCo.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # its imports would take two thirds of the time of --help
)
app.add_typer(hand.app, name="hand", help="Build hand models; inspect robot hands.")
app.add_typer(objects.app, name="object", help="Look at your own things.")
app.add_typer(recordings.app, name="recordings", help="Import and inspect recordings.")
app.add_typer(baseline.app, name="baseline", help="Notice what a change did.")
for command in (
    machine.doctor,
    task_list.tasks,
    object_list.objects,
    hand_list.hands,
    learning.learn,
    learning.evaluate,
    learning.certify,
    learning.postures,
    driving.drive,
    grasping.grasp,
    sweeping.sweep,
    seeing.render,
    seeing.figures,
    export,
    reporting.report,
    reporting.view,
):
    app.command()(command)


@app.callback(invoke_without_command=True)
def _whole(
    context: typer.Context,
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Show versions and exit.", is_eager=True, callback=machine.say_version
        ),
    ] = False,
) -> None:
    """Human-like grasping learned from recordings, simulated in MuJoCo."""
    help_where_alone(context)


# typer keeps the base class of its usage errors to itself; any of them leads to it.
_UsageError: type[Exception] = next(
    kind for kind in typer.BadParameter.__mro__ if kind.__name__ == "ClickException"
)


INTERRUPTED = 130
"""Exit code after Ctrl-C."""


def main() -> NoReturn:
    """Run the command line and exit with its code."""
    heard()
    _show_any_name()
    try:
        sys.exit(_run())
    finally:
        say_no_more()
        what_is_kept()  # is forgotten, where nobody asked for it


def _run() -> int:
    """Run the command and return its exit code; what is wrong is told in one line."""
    try:
        code = app(prog_name="handsim", standalone_mode=False)
    except HandsimError as error:
        return _refuse(str(error))
    except _UsageError as error:
        return _refuse(str(getattr(error, "format_message", error.__str__)()))
    except (typer.Abort, KeyboardInterrupt):
        code = INTERRUPTED
    except BrokenPipeError:
        sys.stderr.close()  # the reader of standard output has gone; nobody is left to tell
        return 0
    except OSError as error:  # a folder without permission, a connection that is refused
        named = isinstance(error.filename, str | os.PathLike)
        said = refused(Path(error.filename), error) if named else error.strerror or error
        return _refuse(str(said))
    if code == INTERRUPTED:  # which typer makes of an interrupt itself
        _tell(f"interrupted; {what_is_kept()}")
    return code if isinstance(code, int) else 0


def _show_any_name() -> None:
    """Let names be shown that the terminal's encoding cannot, by the numbers of their letters."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _refuse(message: str) -> int:
    """Say in one line what was wrong with the input."""
    _tell(message)
    return 2


def _tell(message: str) -> None:
    say_no_more()
    with suppress(OSError):
        sys.stderr.write("handsim: " + " ".join(message.split()) + "\n")
