"""`handsim learn`, `evaluate`, `postures`: from recordings to a controller and its movements."""

import warnings
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from handsim.cli.console import (
    Accept,
    ControllerFile,
    Folder,
    JsonFlag,
    note,
    say,
    say_json,
    say_table,
    writable,
)
from handsim.cli.waiting import fraction_done
from handsim.wording import number_of


def learn(
    output: Annotated[Path, typer.Option("-o", "--output", help="Controller file, .npz.")],
    folder: Folder = None,
    components: Annotated[int, typer.Option(help="Principal components to learn in.")] = 3,
    method: Annotated[
        Literal["direction", "pde"], typer.Option(help="How beta is learned; pde is the paper's.")
    ] = "direction",
    k: Annotated[float | None, typer.Option(help="Exponent of the navigation function.")] = None,
    free: Annotated[
        bool, typer.Option("--free", help="Learn beta without the constraint that proves it.")
    ] = False,
    field_only: Annotated[
        bool, typer.Option("--field-only", help="Follow beta's flow instead of predicted paths.")
    ] = False,
    by_progress: Annotated[
        bool | None,
        typer.Option(
            "--with-progress/--without-progress",
            help="Progress as a coordinate of the field; chosen by leaving out recordings.",
        ),
    ] = None,
    certified: Annotated[
        bool, typer.Option("--certified", help="The default now; kept for earlier scripts.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Of the random samples.")] = 0,
    accept: Accept = None,
    json: JsonFlag = False,
) -> None:
    """Learn a controller from a folder of recordings."""
    from handsim.cli.defaults import recordings_or_built_in
    from handsim.errors import InputError
    from handsim.learning.learn import learn_controller
    from handsim.recordings.plausibility import PlausibilityWarning

    writable(output, ".npz")
    if by_progress is not None and (field_only or method == "pde"):
        asked = f"--with{'' if by_progress else 'out'}-progress"
        raise InputError(f"{asked} with --field-only or --method pde; leave one out")
    if certified:
        if free or method == "pde":
            raise InputError("--certified with --free or --method pde; leave one out")
        note("--certified is the default now")
    recordings = recordings_or_built_in(folder, accept)
    with fraction_done("learning") as progress, warnings.catch_warnings():
        warnings.simplefilter("ignore", PlausibilityWarning)  # said when they were read
        learned = learn_controller(
            recordings,
            n_components=components,
            method=method,
            k=k,
            certified=False if free else None,
            guided=False if field_only else None,
            by_progress=by_progress,
            seed=seed,
            progress=progress,
            accept=accept or (),
        )
    summary = learned.as_dict()
    if json:  # said before it is written: a full disk does not take it away
        say_json(summary)
        learned.controller.save(output)
        return
    note(
        f"learned from {number_of(summary['n_recordings'], 'recording')} in "
        f"{summary['seconds']:.2f} s: "
        f"{number_of(summary['n_components'], 'component explains', 'components explain')} "
        f"{100 * summary['variance_explained']:.1f} %, cost {summary['cost_start']:.4g} to "
        f"{summary['cost_end']:.4g} in {summary['iterations']} iterations"
    )
    if summary["left_out"]:
        note(_progress_line(summary["by_progress"], **summary["left_out"]))
    learned.controller.save(output)
    note(f"wrote {output}")


def _progress_line(by_progress: bool, with_progress: float, without_progress: float) -> str:
    return (
        f"recordings left out: {with_progress:.3f} of a straight line's error with progress as "
        f"a coordinate, {without_progress:.3f} without; learned "
        f"{'with' if by_progress else 'without'} it"
    )


def certify(controller: ControllerFile = None, json: JsonFlag = False) -> None:
    """Prove that every start arrives, or show where one does not.

    Destinations are those of the recordings and of the plans beside the controller.
    Exit code 1 where there is no proof.
    """
    from handsim.cli.defaults import controller_or_built_in, planned_destinations
    from handsim.learning import certification

    learned = controller_or_built_in(controller)
    with fraction_done("certifying") as progress:
        planned = planned_destinations(learned, controller)
        result = certification.certify(learned, progress=progress, planned=planned).as_dict()
    if json:
        say_json(result)
    else:
        verdict = "certified" if result["certified"] else f"not certified: {result['reason']}"
        k_min = result["k_min"]
        say(f"{verdict}; k {result['k']:g}, least k {'none' if k_min is None else f'{k_min:.3g}'}")
        says = {True: "proven", False: "not proven", None: "none"}
        say("destinations: " + ", ".join(f"{k} {says[v]}" for k, v in result["covers"].items()))
        say(f"{result['arrivals']} of {result['starts']} starts on a grid arrive by beta alone")
        for trap in result["other_minima"]:
            place = ", ".join(f"{angle:.0f}" for angle in trap["z_deg"])
            say(f"local minimum at ({place}) deg on the way to {trap['destination']}")
    if not result["certified"]:
        raise typer.Exit(1)


def evaluate(
    controller: ControllerFile = None,
    folder: Folder = None,
    leave_one_out: Annotated[
        bool, typer.Option("--leave-one-out", help="Learn again without each recording in turn.")
    ] = False,
    object_unknown: Annotated[
        bool, typer.Option("--object-unknown", help="Do not tell the controller the object.")
    ] = False,
    accept: Accept = None,
    json: JsonFlag = False,
) -> None:
    """Score a controller against recordings."""
    from handsim.cli.defaults import controller_or_built_in, recordings_or_built_in
    from handsim.learning import scores
    from handsim.learning.learn import learn_like

    learned = controller_or_built_in(controller)
    recordings = recordings_or_built_in(folder, accept, learned)
    if leave_one_out:
        with fraction_done("leaving one out") as progress:
            again = partial(learn_like, learned)
            found = scores.leave_one_out(recordings, again, progress, not object_unknown)
    else:
        with fraction_done("evaluating") as progress:
            found = scores.evaluate(learned, recordings, not object_unknown, progress)
    result = found.as_dict()
    if json:
        say_json(result)
        return
    header = ("arrived", "path error [deg]", "straight line [deg]", "people repeat [deg]")
    say_table(("recording", *header), [_score_row(row, "name") for row in result["per_recording"]])
    say("")
    say_table(("object", *header), [_score_row(row, "object") for row in result["per_object"]])
    say("")
    say(
        f"{result['n_arrived']} of {result['n_recordings']} arrive, {result['n_proven']} proven; "
        f"mean path error "
        f"{result['path_error_deg']:.1f} deg, straight line "
        f"{result['straight_error_deg']:.1f} deg, ratio {result['ratio']:.2f}; direction off by "
        f"{result['direction_error_deg']:.0f} deg; {100 * result['variance_explained']:.1f} % of "
        "variance in the subspace"
    )
    say(
        f"over time {result['rms_over_time_deg']:.1f} deg a joint; with the recorded timing "
        f"{result['rms_path_deg']:.1f}, with the recorded path {result['rms_clipping_deg']:.1f}, "
        f"without ranges of motion {result['rms_truncation_deg']:.1f}; correlation of speeds "
        f"{_rounded(result['speed_correlation'])}"
    )


def _rounded(number: float | None) -> str:
    return "none" if number is None else f"{number:.2f}"


def _score_row(row: dict[str, Any], key: str) -> tuple[str, ...]:
    if "n_arrived" in row:
        arrived = f"{row['n_arrived']} of {row['n_recordings']}"
    else:
        arrived = "yes" if row["arrived"] else "no"
    repeat = row["repeatability_deg"]
    return (
        row[key],
        arrived,
        f"{row['path_error_deg']:.1f}",
        f"{row['straight_error_deg']:.1f}",
        "" if repeat is None else f"{repeat:.1f}",
    )


def postures(
    output: Annotated[Path, typer.Option("-o", "--output", help="Posture sequence, .csv.")],
    controller: ControllerFile = None,
    task: Annotated[
        str | None, typer.Option(help="Recorded task whose destination to take.")
    ] = None,
    goal: Annotated[
        Path | None, typer.Option(help="Posture file whose last frame is the destination.")
    ] = None,
    duration: Annotated[
        float | None, typer.Option(help="Duration in s; that of the recordings if left out.")
    ] = None,
    time_law: Annotated[
        Literal["learned", "minimum-jerk", "gradient"], typer.Option(help="Speed along the path.")
    ] = "learned",
    grasped: Annotated[
        str | None,
        typer.Option("--object", help="Object to be grasped; that of --task if left out."),
    ] = None,
) -> None:
    """Write the movement that the controller makes to a destination."""
    import numpy as np

    from handsim.cli.defaults import controller_or_built_in
    from handsim.errors import InputError
    from handsim.recordings.posture_file import read_postures, write_postures

    writable(output, ".csv")
    if (task is None) == (goal is None):
        raise InputError("give one of --task and --goal: where is the movement to end?")
    learned = controller_or_built_in(controller)
    if task is not None:
        recorded = learned.demonstration(task)
        q_start, q_goal = recorded.q_start, recorded.q_goal
        grasped = grasped or recorded.object
    else:
        assert goal is not None
        q_start, q_goal = learned.demonstrations[0].q_start, read_postures(goal)[1][-1]
    if grasped is not None:
        learned.check_object(grasped)
    movement = learned.postures(
        q_start, q_goal, grasped=grasped, time_law=time_law, duration=duration
    )
    write_postures(movement.time, movement.q, output)
    away = f"{np.rad2deg(movement.goal_distance):.1f} deg from the destination"
    ending = "" if movement.arrived else f"; it does not arrive: {movement.reason}, {away}"
    note(f"wrote {number_of(len(movement.time), 'posture')} to {output}{ending}")
