"""`handsim drive`: a recorded signal chooses the posture on the controller's path."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from handsim.cli.console import ControllerFile, JsonFlag, check_gl, note, say, say_json, writable
from handsim.cli.waiting import fraction_done
from handsim.wording import number_of

if TYPE_CHECKING:
    from handsim.driving.replay import Driven
    from handsim.driving.signal_file import SignalFile
    from handsim.driving.signal_map import SignalMap
    from handsim.learning.controller import GraspController
    from handsim.learning.demonstration import Demonstration
    from handsim.types import Array

ENOUGH = 5
"""So many recordings of an object that hold the channel are taken without those of others."""


def drive(
    output: Annotated[Path, typer.Option("-o", "--output", help="Posture sequence, .csv.")],
    signal: Annotated[
        Path, typer.Option(help="A recording with channels, or a table time_s,value; .csv.")
    ],
    controller: ControllerFile = None,
    channel: Annotated[
        str | None,
        typer.Option(help="Which signal; distance_m, then emg_envelope, if left out."),
    ] = None,
    task: Annotated[
        str | None,
        typer.Option(help="Recorded task whose destination to take; else that of the file."),
    ] = None,
    grasped: Annotated[
        str | None,
        typer.Option("--object", help="Object to be grasped; that of --task if left out."),
    ] = None,
    between: Annotated[
        tuple[float, float] | None,
        typer.Option("--range", metavar="REST GRASP", help="Values at rest and at the grasp."),
    ] = None,
    speed: Annotated[
        float, typer.Option(help="Greatest speed, relative to people's at the same pace.")
    ] = 1.15,
    smoothing: Annotated[float, typer.Option(help="Time constant of the low-pass in s.")] = 0.04,
    video: Annotated[
        Path | None, typer.Option(help="Film of it, the recorded hand beside; .mp4 or .gif.")
    ] = None,
    json: JsonFlag = False,
) -> None:
    """Replay a movement whose progress a person's signal chooses.

    Where the file holds joints, the movement goes from its first posture to its last, unless --task
    names another destination, and is scored against what was recorded.
    """
    writable(output, ".csv")
    if video is not None:
        writable(video, ".mp4", ".gif")
        check_gl(draws=True)

    from handsim.cli.defaults import controller_or_built_in
    from handsim.driving.driver import DriverRule
    from handsim.driving.replay import drive_postures
    from handsim.driving.signal_file import chosen_channel, read_signal_file
    from handsim.files import write_text
    from handsim.recordings.posture_file import postures_text

    learned = controller_or_built_in(controller)
    read = read_signal_file(signal)
    known = learned.demonstrations
    name, values = chosen_channel(read, known, channel, between is not None)
    q_start, q_goal = _ends(learned, read, task)
    thing = _object(learned, grasped, task)
    used = _signal_map(_like(known, thing, name), name, between)
    rule = DriverRule(used, smoothing, speed)
    driven = drive_postures(learned, rule, read.time, values, q_start, q_goal, read.q, thing)
    text = postures_text(driven.time, driven.q, {"progress": driven.progress, name: values})
    summary = _summary(used, driven)
    if json:
        say_json(summary)
    else:
        _say(summary)
    write_text(output, text)
    if video is not None:
        _film(driven, read, video)
    note(f"wrote {number_of(len(driven.time), 'posture')} to {output}")


def _ends(
    learned: "GraspController", read: "SignalFile", task: str | None
) -> "tuple[Array, Array]":
    """Return first and last posture."""
    from handsim.errors import InputError

    tasks = {(d.task, d.object) for d in learned.demonstrations}
    if task is None and read.q is not None:
        return read.q[0], read.q[-1]
    if task is None and len(tasks) > 1:
        raise InputError(
            f"{read.path}: holds no joints, and the controller knows {len(tasks)} tasks; say with "
            "--task where the movement is to end"
        )
    end = learned.demonstrations[0] if task is None else learned.demonstration(task)
    return (end.q_start if read.q is None else read.q[0]), end.q_goal


def _object(learned: "GraspController", grasped: str | None, task: str | None) -> str | None:
    """Return the object that is grasped: named, of the task, or the only one of the recordings."""
    if grasped is not None:
        learned.check_object(grasped)
        return grasped
    if task is not None:
        return learned.demonstration(task).object
    known = {d.object for d in learned.demonstrations}
    return known.pop() if len(known) == 1 else None


def _like(
    known: "Sequence[Demonstration]", thing: str | None, channel: str
) -> "Sequence[Demonstration]":
    """Return the demonstrations of the same object, if enough of them hold the channel."""
    same = [d for d in known if d.object == thing and channel in d.signals]
    return same if len(same) >= ENOUGH else known


def _signal_map(
    demonstrations: "Sequence[Demonstration]", channel: str, between: tuple[float, float] | None
) -> "SignalMap":
    from handsim.driving.signal_calibration import calibrate_signal
    from handsim.driving.signal_map import map_between

    if between is None:
        return calibrate_signal(demonstrations, channel)
    return map_between(demonstrations, *between, channel)


def _film(driven: "Driven", read: "SignalFile", video: Path) -> None:
    from handsim.learning.controller import PostureSequence
    from handsim.viewing.render import clip_of, render

    since = driven.time - driven.time[0]
    shown = [clip_of(PostureSequence(since, driven.q, True, ""), caption="driven")]
    if read.q is not None:
        shown.append(clip_of(PostureSequence(since, read.q, True, ""), caption="recorded"))
    with fraction_done("drawing") as progress:
        n = render(shown, video, progress=progress)
    note(f"wrote {number_of(n, 'frame')} to {video}")


def _summary(used: "SignalMap", driven: "Driven") -> dict[str, Any]:
    import numpy as np

    own, law = driven.rms_deg, driven.time_law_rms_deg
    return {
        "channel": used.channel,
        "rising": used.rising,
        "relative": used.relative,
        "explained": used.explained,
        "n_recordings": used.n_recordings,
        "n_frames": len(driven.time),
        "n_missing": driven.n_missing,
        "duration_s": float(driven.time[-1] - driven.time[0]),
        "progress_end": float(driven.progress[-1]),
        "progress_most": float(driven.progress.max()),
        "arrived": driven.arrived,
        "reason": driven.reason,
        "goal_distance_deg": float(np.rad2deg(driven.goal_distance)),
        "rms_deg": own,
        "time_law_rms_deg": law,
        "ratio": own / law if own is not None and law else None,
    }


def _say(summary: dict[str, Any]) -> None:
    way = "rises" if summary["rising"] else "falls"
    share = ", taken as a share of its start" if summary["relative"] else ""
    found = (
        "as given"
        if summary["explained"] is None
        else f"{100 * summary['explained']:.0f} % of progress explained by it in "
        f"{number_of(summary['n_recordings'], 'recording')}"
    )
    say(f"{summary['channel']} {way}{share}; {found}")
    missing = f", {summary['n_missing']} without a value" if summary["n_missing"] else ""
    say(
        f"{number_of(summary['n_frames'], 'frame')}{missing}; progress ends at "
        f"{100 * summary['progress_end']:.0f} %: {summary['reason']}, "
        f"{summary['goal_distance_deg']:.1f} deg from the destination"
    )
    if summary["rms_deg"] is not None:
        law = summary["time_law_rms_deg"]
        beside = "" if law is None else f"; the controller's time law {law:.2f} deg"
        say(f"off the recorded posture by {summary['rms_deg']:.2f} deg (rms){beside}")
