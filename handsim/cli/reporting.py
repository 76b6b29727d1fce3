"""`handsim report` and `view`: everything about a controller on one page, and live."""

import shlex
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from handsim.cli.console import Accept, ControllerFile, Folder, check_gl, note, writable
from handsim.cli.waiting import fraction_done, progress
from handsim.errors import MissingToolError

if TYPE_CHECKING:
    from handsim.grasping.conditions import Conditions
    from handsim.grasping.plan import GraspPlan
    from handsim.grasping.rollout.record import Rollout
    from handsim.learning.controller import GraspController


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
    note(f"wrote {output}: {output.stat().st_size / 2**20:.1f} MB, {len(grasps)} grasps")


def view(
    controller: ControllerFile = None,
    task: Annotated[str | None, typer.Option(help="Task to play in MuJoCo's viewer.")] = None,
    web: Annotated[
        bool, typer.Option("--web", help="A web page even where there is a display.")
    ] = False,
    host: Annotated[str, typer.Option(help="Address that serves the page.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Its port.")] = 8080,
    at: Annotated[
        str | None, typer.Option(help="View to begin with: the text that a page gives for it.")
    ] = None,
) -> None:
    """Move the hand by its principal components and watch grasps.

    MuJoCo's own viewer where there is a display, a web page where there is none, until
    interrupted.
    """
    check_gl()

    from handsim.cli.defaults import controller_or_built_in, recordings_or_built_in
    from handsim.viewing.live import window

    on_page = web or not window.has_display()
    if on_page and find_spec("viser") is None:  # said before anything is computed
        raise MissingToolError("the page needs viser; run: pip install 'handsim[viewer]'")
    learned = controller_or_built_in(controller)
    if not on_page:
        window.show(learned, lambda name, hand: _known_plan(controller, name, hand), task)
        return

    from handsim.viewing.live.page import LivePage, serve

    page = LivePage(
        learned,
        lambda name, hand: _known_plan(controller, name, hand),
        host,
        port,
        task,
        tuple(recordings_or_built_in(None)) if controller is None else (),
        at,
    )
    note(f"open {page.address} in a browser; end with Ctrl+C")
    serve(page)


def _known_plan(controller: Path | None, task: str, conditions: "Conditions") -> "GraspPlan | None":
    """Return the stored plan of a task for this hand, else that for a hand of median size."""
    from handsim.cli.defaults import planning_grasper
    from handsim.grasping.conditions import Conditions
    from handsim.tasks.table_one import task_by_name

    for hand in (conditions, Conditions()):
        plans = planning_grasper(controller, hand).known([task_by_name(task)], hand)
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
