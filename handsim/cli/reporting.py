"""`handsim report` and `view`: everything about a controller on one page, and live."""

import shlex
import sys
from collections.abc import Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from handsim.cli.console import Accept, ControllerFile, Folder, check_gl, note, writable
from handsim.cli.waiting import fraction_done, progress
from handsim.errors import MissingToolError
from handsim.wording import number_of

if TYPE_CHECKING:
    from handsim.grasping.conditions import Conditions
    from handsim.grasping.plan import GraspPlan
    from handsim.grasping.rollout.record import Rollout
    from handsim.learning.controller import GraspController
    from handsim.recordings.recording import RecordingSet
    from handsim.viewing.live.shown import ShownController


BUILT_IN = "built-in"
"""What the built-in controller is called beside others."""


def report(
    output: Annotated[Path, typer.Option("-o", "--output", help="The page, .html.")],
    controller: ControllerFile = None,
    folder: Folder = None,
    tasks: Annotated[
        str, typer.Option(help="Tasks to grasp: planned, all, none, or names with commas between.")
    ] = "planned",
    accept: Accept = None,
) -> None:
    """Write one page: data, learning, proof, scores and grasps.

    Grasped are the tasks whose plans are stored beside the controller, unless others are named;
    those are planned first, which takes minutes each.
    """
    writable(output, ".html")
    check_gl(draws=True)

    from handsim.cli.defaults import (
        controller_or_built_in,
        planned_destinations,
        recordings_or_built_in,
    )
    from handsim.viewing.opengl.backend import choose_backend

    learned = controller_or_built_in(controller)
    recordings = recordings_or_built_in(folder, accept, learned)
    choose_backend()
    grasps = _grasps(controller, tasks)
    planned = planned_destinations(learned, controller)

    from handsim.viewing.report import write_report

    with fraction_done("writing") as written:
        commands = _commands(learned, folder)
        write_report(output, learned, recordings, grasps, commands, written, planned)
    size = output.stat().st_size / 2**20
    note(f"wrote {output}: {size:.1f} MB, {number_of(len(grasps), 'grasp')}")


def view(
    controllers: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[CONTROLLER|DIR]...",
            help="Controller files, or folders of recordings to learn from; several stand side by "
            "side on a page. built-in, or nothing, is the built-in controller.",
        ),
    ] = None,
    task: Annotated[str | None, typer.Option(help="Task to play in MuJoCo's viewer.")] = None,
    web: Annotated[
        bool, typer.Option("--web", help="A web page even where there is a display.")
    ] = False,
    host: Annotated[str, typer.Option(help="Address that serves the page.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Its port.")] = 8080,
    at: Annotated[
        str | None, typer.Option(help="View to begin with: the link that a page gives for it.")
    ] = None,
) -> None:
    """Move the hand, push its fingers and watch its grasps.

    MuJoCo's own viewer where there is a display; a web page where there is none, where several
    controllers are compared, and for a folder or a link; until interrupted.
    """
    check_gl()

    from handsim.cli.defaults import controller_or_built_in
    from handsim.viewing.live import window

    paths = [_named(each) for each in controllers or [Path(BUILT_IN)]]
    on_page = web or not window.has_display() or len(paths) > 1 or at is not None
    if on_page and find_spec("viser") is None:  # said before anything is computed
        raise MissingToolError("the page needs viser; run: pip install 'handsim[viewer]'")
    path = paths[0]
    if not on_page and (path is None or not path.is_dir()):
        plans = partial(_known_plan, path)
        window.show(controller_or_built_in(path), plans, task)
        return

    from handsim.viewing.live.page import LivePage, check_number, serve

    check_number(len(paths))
    shown = [_shown(each, name) for each, name in zip(paths, _names(paths), strict=True)]
    page = LivePage(shown, host, port, task, at)
    note(f"open {page.address} in a browser; end with Ctrl+C")
    serve(page)


def _named(given: Path) -> Path | None:
    """Return where a controller is; None for the built-in one, by its name."""
    return None if str(given) == BUILT_IN and not given.exists() else given


def _names(paths: "Sequence[Path | None]") -> list[str]:
    """Return a name for each controller; those of files in different folders differ as well."""
    names = [BUILT_IN if path is None else path.stem.replace(",", "_") for path in paths]
    folders = ["" if path is None else path.resolve().parent.name for path in paths]
    found: list[str] = []
    for name, folder in zip(names, folders, strict=True):
        longer = name if names.count(name) == 1 else f"{folder}/{name}"
        found.append(longer if longer not in found else f"{longer} {len(found) + 1}")
    return found


def _shown(path: Path | None, name: str) -> "ShownController":
    """Read a controller, or learn one from a folder of recordings."""
    from handsim.cli.defaults import controller_or_built_in, recordings_or_built_in
    from handsim.viewing.live.shown import ShownController

    plans = partial(_known_plan, path)
    if path is None:
        recordings = tuple(recordings_or_built_in(None))
        return ShownController(name, controller_or_built_in(None), plans, recordings)
    if not path.is_dir():
        return ShownController(name, controller_or_built_in(path), plans)
    recordings = recordings_or_built_in(path)
    return ShownController(name, _learned(recordings), plans, tuple(recordings))


def _learned(recordings: "RecordingSet") -> "GraspController":
    """Learn a controller from recordings, with the usual settings."""
    import warnings

    from handsim.learning.learn import learn_controller
    from handsim.recordings.plausibility import PlausibilityWarning

    with fraction_done("learning") as progress, warnings.catch_warnings():
        warnings.simplefilter("ignore", PlausibilityWarning)  # said when they were read
        return learn_controller(recordings, progress=progress).controller


def _known_plan(path: Path | None, task: str, conditions: "Conditions") -> "GraspPlan | None":
    """Return the stored plan of a task for this hand, else that for a hand of median size.

    None is stored for a controller that is learned from a folder of recordings here.
    """
    from handsim.cli.defaults import planning_grasper
    from handsim.grasping.conditions import Conditions
    from handsim.tasks.table_one import task_by_name

    if path is not None and path.is_dir():
        return None
    for hand in (conditions, Conditions()):
        plans = planning_grasper(path, hand).known([task_by_name(task)], hand)
        if task in plans:
            return plans[task]
    return None


def _grasps(controller: Path | None, tasks: str) -> "list[Rollout]":
    """Grasp each task once; a bar shows how far it is."""
    from handsim.cli.defaults import planning_grasper
    from handsim.grasping.conditions import Conditions
    from handsim.tasks.table_one import TASKS, task_by_name

    conditions = Conditions()
    grasper = planning_grasper(controller, conditions)
    if tasks == "planned":
        planned = grasper.known(progress(TASKS, "reading plans"), conditions)
        chosen = [task for task in TASKS if task.name in planned]
        if not chosen:
            note("no plans are stored beside the controller; `handsim grasp` makes them")
    elif tasks == "all":
        chosen = list(TASKS)
    else:
        names = [] if tasks == "none" else tasks.split(",")
        chosen = [task_by_name(name.strip()) for name in names]
    return [grasper(task, conditions) for task in progress(chosen, "grasping")]


def _progress_asked(learned: "GraspController") -> list[str]:
    """Option by which progress was made a coordinate or not, where it was not left to be chosen."""
    from handsim.learning.guide.choice import asked_of_progress

    if learned.guide is None or learned.left_out is None:
        return []
    asked = asked_of_progress(learned.guide, learned.left_out)
    return {None: [], True: ["--with-progress"], False: ["--without-progress"]}[asked]


def _commands(learned: "GraspController", folder: Path | None) -> list[str]:
    """Command lines that lead to the page, this one last."""
    data = [] if folder is None else [str(folder)]
    learn = [
        *("learn", *data, "-o", "controller.npz", "--method", learned.method),
        *("--components", str(learned.navigation.n_dimensions), "--k", f"{learned.navigation.k:g}"),
        *(["--free"] if learned.method == "direction" and not learned.certified else []),
        *(["--field-only"] if learned.method == "direction" and learned.guide is None else []),
        *_progress_asked(learned),
    ]
    steps = (
        learn,
        ["certify", "controller.npz"],
        ["evaluate", "controller.npz", *data],
        ["figures", "controller.npz", *data, "-o", "figures"],
        ["grasp", "controller.npz", "--task", "all", "-o", "grasps"],
        sys.argv[1:],
    )
    return [shlex.join(["handsim", *step]) for step in steps]
