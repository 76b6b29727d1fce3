"""`handsim baseline`: what a controller does, kept, and checked again."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from handsim.cli.console import JsonFlag, check_gl, help_where_alone, note, say, say_json, writable
from handsim.cli.waiting import fraction_done, progress
from handsim.wording import number_of

if TYPE_CHECKING:
    from handsim.recordings.recording import RecordingSet

app = typer.Typer()

BaselineFile = Annotated[
    Path | None, typer.Argument(help="Baseline file, .npz; the built-in one if left out.")
]
ControllerOption = Annotated[
    Path | None, typer.Option(help="Controller file; the built-in one if left out.")
]
RecordingsOption = Annotated[
    Path | None,
    typer.Option(help="Folder to learn from again; that of the built-in controller if left out."),
]


@app.command()
def record(
    baseline: Annotated[Path, typer.Argument(help="Baseline file to write, .npz.")],
    controller: ControllerOption = None,
    recordings: RecordingsOption = None,
    json: JsonFlag = False,
) -> None:
    """Keep the movements and grasps of a controller.

    Asked for are all demonstrated movements, and the tasks whose plans are stored. Where there are
    recordings, a controller learned from them again is asked as well.
    """
    check_gl()

    from handsim.baseline.check import record_baseline
    from handsim.baseline.store import write_baseline
    from handsim.cli.defaults import controller_or_built_in, planning_grasper
    from handsim.grasping.conditions import Conditions
    from handsim.tasks.table_one import PHONE_TODAY_VIEW, TASKS

    writable(baseline, ".npz")
    learned = controller_or_built_in(controller)
    tasks = progress((*TASKS, PHONE_TODAY_VIEW), "reading plans")
    plans = planning_grasper(controller, Conditions()).known(tasks, Conditions())
    source = _recordings(controller, recordings)
    with fraction_done("recording") as done:
        made = record_baseline(learned, plans, source, progress=done)
    write_baseline(made, baseline)
    if json:
        traces = made.results.traces
        say_json({"answers": {name: trace.verdict for name, trace in traces.items()}})
    note(
        f"recorded {number_of(len(made.results.traces), 'answer')}, {len(plans)} of them grasps, "
        f"to {baseline}"
    )


@app.command()
def check(
    baseline: BaselineFile = None,
    controller: ControllerOption = None,
    recordings: RecordingsOption = None,
    tolerance_deg: Annotated[
        float | None, typer.Option(help="Largest deviation of a joint in a movement, in deg.")
    ] = None,
    grasp_tolerance_deg: Annotated[
        float | None, typer.Option(help="Largest deviation of a joint in a grasp, in deg.")
    ] = None,
    friction: Annotated[float | None, typer.Option(help="Sliding friction of the hand.")] = None,
    ignore_inputs: Annotated[
        bool, typer.Option("--ignore-inputs", help="Judge by what it does; only note new inputs.")
    ] = False,
    html: Annotated[Path | None, typer.Option(help="Page with curves to write, .html.")] = None,
    details: Annotated[
        bool, typer.Option("--details", help="A line each, however many have one cause.")
    ] = False,
    update: Annotated[
        str | None, typer.Option(help="Take the new answers for right, for this reason.")
    ] = None,
    json: JsonFlag = False,
) -> None:
    """Ask again and say what moved, worst first.

    Where the baseline was made in another environment (processor, libraries, threads), that is
    said before anything else. Exit code 1 where something moved beyond its tolerance and is not
    taken for right.
    """
    check_gl()

    from handsim.baseline.check import check_baseline, updated
    from handsim.baseline.comparison import not_numbers
    from handsim.baseline.store import read_baseline, write_baseline
    from handsim.baseline.tolerances import Tolerances
    from handsim.cli.defaults import controller_or_built_in
    from handsim.files import data_folder
    from handsim.grasping.conditions import Conditions

    if html is not None:
        writable(html, ".html")
    tolerances = Tolerances.of(tolerance_deg, grasp_tolerance_deg)
    path = baseline or data_folder("assets") / "baseline.npz"
    kept = read_baseline(path)
    if update is not None:
        updated(kept, kept.results, update)  # refuses an empty reason before the work
        writable(path)
    learned = controller_or_built_in(controller)
    conditions = Conditions() if friction is None else Conditions(friction=friction)
    source = _recordings(controller, recordings) if kept.relearned else None
    with fraction_done("checking") as done:
        report, results = check_baseline(
            kept, learned, source, conditions, tolerances, ignore_inputs, done
        )
    if json:
        say_json(report.as_dict())
    else:
        say(report.as_text(details=details))
        if not details and report.as_text() != report.as_text(details=True):
            note("--details lists each finding")
    if html is not None:
        from handsim.baseline.html_page import write_page

        write_page(html, kept, results, report)
    if update is not None:
        for fault in not_numbers(results):
            note(f"handsim: {fault}; {path} stays as it was")
            raise typer.Exit(1)
        write_baseline(updated(kept, results, update), path)
        note(f"updated {path}")
    elif not report.ok:
        raise typer.Exit(1)


def _recordings(controller: Path | None, folder: Path | None) -> "RecordingSet | None":
    """Return what to learn from again: what is given, or what the built-in one was learned from."""
    from handsim.cli.defaults import controller_or_built_in, recordings_or_built_in

    if folder is None and controller is not None:
        return None
    return recordings_or_built_in(folder, learned=controller_or_built_in(controller))


@app.callback(invoke_without_command=True)
def _group(context: typer.Context) -> None:
    """Keep what a controller does, and check it again."""
    help_where_alone(context)
