"""`handsim grasp`: grasps in contact physics, judged."""

from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from handsim.cli.console import (
    MAX_JOBS,
    JsonFlag,
    check_gl,
    check_trials,
    note,
    say_json,
    writable_folder,
)
from handsim.cli.hand import (
    base_for,
    person_beside,
    robot_as_dict,
    robot_grasper,
    robot_that_grasps,
    say_base,
)
from handsim.cli.listing.task_list import asked_tasks
from handsim.cli.listing.verdict_table import show_verdicts
from handsim.cli.objects import (
    MassOption,
    PiecesOption,
    ScaleOption,
    UpOption,
    as_dict,
    choose_grasp,
    default_jobs,
    grasp_as_dict,
    say_assumed,
)
from handsim.cli.waiting import NOTHING, fraction_done, keeping
from handsim.wording import number_of

if TYPE_CHECKING:
    from handsim.cli.defaults import PalmTransport
    from handsim.errors import FileError
    from handsim.grasping.conditions import Conditions
    from handsim.grasping.judging.protocols import RunVerdict
    from handsim.grasping.planning.grasper import ControllerGrasper, Grasper
    from handsim.grasping.planning.trials.own_object import OwnGrasp
    from handsim.grasping.rollout.record import Rollout
    from handsim.objects.mesh_import import OwnObject
    from handsim.tasks.task import Task
    from handsim.types import Base, HandSize


def grasp(
    controller: Annotated[
        str | None,
        typer.Argument(help="Controller file, or demonstrator; the built-in one if left out."),
    ] = None,
    task: Annotated[
        str | None, typer.Option(help="Task of Table I, or all that are demonstrated.")
    ] = None,
    own: Annotated[
        Path | None, typer.Option("--object", help="Mesh of your own thing, to be raised.")
    ] = None,
    up: UpOption = None,
    scale: ScaleOption = None,
    mass: MassOption = None,
    pieces: PiecesOption = None,
    hand: Annotated[
        Path | None,
        typer.Option("--hand", help="MJCF or URDF of a robot hand, which follows the controller."),
    ] = None,
    folder: Annotated[
        list[Path] | None,
        typer.Option("--folder", help="Folder of meshes of --hand; may be repeated."),
    ] = None,
    replay: Annotated[
        bool,
        typer.Option(
            "--replay/--plan", help="Take the recorded destination, or plan one in the subspace."
        ),
    ] = False,
    protocol: Annotated[
        Literal["lift", "six-axis"],
        typer.Option(help="What decides success: the task's rule, or pulls from six sides."),
    ] = "lift",
    leave_out: Annotated[
        str | None,
        typer.Option(
            metavar="OBJECT", help="Learn without this object's recordings; grasp its tasks."
        ),
    ] = None,
    recordings: Annotated[
        Path | None,
        typer.Option(help="What the controller was learned from, for --leave-out."),
    ] = None,
    trials: Annotated[int, typer.Option(min=0, help="Perturbed trials beside the nominal.")] = 0,
    seed: Annotated[int, typer.Option(min=0, help="Of glove noise and perturbations.")] = 0,
    hand_length: Annotated[float | None, typer.Option(help="Hand length in m.")] = None,
    hand_breadth: Annotated[float | None, typer.Option(help="Hand breadth in m.")] = None,
    side: Annotated[Literal["right", "left"], typer.Option(help="Side of the hand.")] = "right",
    friction: Annotated[float | None, typer.Option(help="Sliding friction of the hand.")] = None,
    base: Annotated[
        Literal["arm", "free", "mounted"] | None,
        typer.Option(
            help="What carries the hand: a person's arm; a free base of unlimited force, which is "
            "usual for robot hands; or, for these, a mount of limited force."
        ),
    ] = None,
    transport: Annotated[
        str | None,
        typer.Option(
            metavar="FOLDER",
            help="Recordings of reaches, as in which the palm comes in; or straight. If left out, "
            "as in those of a person that are shipped (people).",
        ),
    ] = None,
    hard: Annotated[
        Literal["pose", "friction", "mass", "shake", "bias", "latency"] | None,
        typer.Option(help="Perturb the trials in this alone, and hard."),
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option(
            min=1, max=MAX_JOBS, help="Processes at once; 1, for an own object up to 4 if left out."
        ),
    ] = None,
    require_success: Annotated[
        bool, typer.Option("--require-success", help="Exit with 1 unless every task succeeds.")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder for the rollouts.")
    ] = None,
    json: JsonFlag = False,
) -> None:
    """Grasp in physics and judge the outcome."""
    check_trials(trials, jobs or 1)
    given: dict[str, object] = {"--up": up, "--scale": scale, "--mass": mass, "--pieces": pieces}
    _check_what(task, own, given, leave_out, replay=replay)
    check_gl()
    learned_reach = _has_learned_reach(transport, controller, hand)
    if output is not None:
        writable_folder(output)

    from handsim.cli.defaults import PalmTransport, hand_size
    from handsim.grasping.judging.protocols import TaskVerdict, judge_runs, summarise
    from handsim.objects.mesh_import import read_object

    size = hand_size(hand_length, hand_breadth, side)
    conditions = _conditions(size, base_for(base, hand), seed, friction)
    robot = robot_that_grasps(hand, folder or (), protocol=protocol, replay=replay)
    say_base(conditions.base)
    of_person = conditions if robot is None else person_beside(robot, conditions)
    said: dict[str, Any] = {} if leave_out is None else {"left_out": leave_out}
    carried = PalmTransport.of(transport) if learned_reach else PalmTransport()
    if own is None:
        tasks = asked_tasks(task or "", leave_out)
        grasper = _grasper(controller, of_person, leave_out, recordings, carried, replay=replay)
    else:
        with fraction_done("reading"):
            thing = read_object(own, mass=mass, scale=scale, up=up, pieces=pieces)
        chosen = _chosen(thing, controller, of_person, carried, jobs)
        tasks, grasper = [chosen.task], chosen.grasper
        said = {"object": as_dict(thing), **grasp_as_dict(chosen)}
    _make(output)
    if robot is not None:
        grasper = robot_grasper(robot, grasper, controller)
        conditions = grasper.conditions_of(conditions)
        said |= robot_as_dict(robot, hand)
    started = perf_counter()
    judged = judge_runs(
        grasper, tasks, conditions, trials, protocol=protocol, hard=hard, n_jobs=jobs or 1
    )
    unwritten: list[FileError] = []
    n_runs = len(tasks) * (1 + trials)
    runs = _kept(judged, output, n_runs, unwritten)
    with keeping(_left_behind(controller, output)):
        results = [
            TaskVerdict(each, tuple(run for _, run in of_task))
            for each, of_task in groupby(runs, key=lambda pair: pair[0])
        ]
    if json:
        seconds = perf_counter() - started
        answer = summarise(results, seconds) if task == "all" else results[0].as_dict()
        say_json(answer | said | carried.said)
    else:
        show_verdicts(results)
    _note_written(output, n_runs, unwritten)
    if require_success and not all(result.nominal.success for result in results):
        raise typer.Exit(1)


def _chosen(
    thing: "OwnObject",
    controller: str | None,
    conditions: "Conditions",
    carried: "PalmTransport",
    jobs: int | None,
) -> "OwnGrasp":
    """Choose how to grasp an own object."""
    from handsim.grasping.sweep.spec import DEMONSTRATOR

    say_assumed(thing)
    planning = None if controller == DEMONSTRATOR else _planning(controller, conditions, carried)
    return choose_grasp(thing, planning, conditions, jobs or default_jobs())


def _note_written(folder: Path | None, n_runs: int, unwritten: "list[FileError]") -> None:
    """Say where the rollouts are, if any were asked for, or why they are not there."""
    if unwritten:
        raise unwritten[0]
    if folder is not None:
        note(f"wrote {number_of(n_runs, 'rollout')} to {folder}")


def _left_behind(controller: str | None, folder: Path | None) -> str:
    """Return what an interrupt keeps: rollouts of the runs that ended, and plans that were made."""
    from handsim.grasping.sweep.spec import DEMONSTRATOR

    said = [] if folder is None else [f"rollouts of the runs that ended are in {folder}"]
    if controller != DEMONSTRATOR:
        said.append("plans made until then are kept, and the same command goes on with them")
    return "; ".join(said) or NOTHING


def _make(folder: Path | None) -> None:
    """Make the folder for the rollouts, once what was asked for is known to be possible."""
    if folder is not None:
        folder.mkdir(exist_ok=True)


def _check_what(
    task: str | None,
    own: Path | None,
    given: "dict[str, object]",
    left_out: str | None,
    *,
    replay: bool,
) -> None:
    """Check that either a task or an own object is asked for, with options of its own."""
    from handsim.errors import InputError

    if (task is None) == (own is None):
        asked = "neither is given" if task is None else "both are given"
        raise InputError(
            f"--task names a task of Table I, --object a file: {asked}; give one "
            "(`handsim tasks` lists the tasks)"
        )
    if own is None:
        if extra := [name for name, value in given.items() if value is not None]:
            raise InputError(f"{extra[0]} is about an own object; give its file with --object")
        return
    if replay or left_out is not None:
        option = "--replay" if replay else "--leave-out"
        raise InputError(
            f"{option} is about recorded objects, --object is not; drop one of the two"
        )


def _has_learned_reach(name: str | None, controller: str | None, hand: Path | None) -> bool:
    """Return whether a learned transport may carry the hand; it must not be asked for elsewhere."""
    from handsim.cli.defaults import STRAIGHT
    from handsim.errors import InputError
    from handsim.grasping.sweep.spec import DEMONSTRATOR

    if controller != DEMONSTRATOR and hand is None:
        return True
    if name not in (None, STRAIGHT):
        goes = "the demonstrator's palm goes" if hand is None else "a robot's base comes in"
        raise InputError(f"{goes} straight; drop --transport")
    return False


def _planning(
    name: str | None, conditions: "Conditions", carried: "PalmTransport"
) -> "ControllerGrasper":
    from handsim.cli.defaults import planning_grasper

    return carried.by(planning_grasper(None if name is None else Path(name), conditions))


def _conditions(hand: "HandSize", base: "Base", seed: int, friction: float | None) -> "Conditions":
    from handsim.grasping.conditions import Conditions

    if friction is None:
        return Conditions(seed=seed, hand=hand, base=base)
    return Conditions(seed=seed, hand=hand, base=base, friction=friction)


def _grasper(
    name: str | None,
    conditions: "Conditions",
    left_out: str | None,
    recordings: Path | None,
    carried: "PalmTransport",
    *,
    replay: bool,
) -> "Grasper":
    from handsim.cli.defaults import grasper_without, planning_grasper
    from handsim.errors import InputError
    from handsim.grasping.planning.demonstrator import demonstrate
    from handsim.grasping.sweep.spec import DEMONSTRATOR

    if recordings is not None and left_out is None:
        raise InputError("--recordings says what to learn from without an object; add --leave-out")
    if left_out is not None and (replay or name == DEMONSTRATOR):
        asked = (
            "--replay takes a recorded destination" if replay else "the demonstrator is a script"
        )
        raise InputError(f"{asked}, so that --leave-out leaves out nothing; drop one of the two")
    if name == DEMONSTRATOR:
        return demonstrate
    path = None if name is None else Path(name)
    if left_out is not None:
        return carried.by(grasper_without(left_out, path, recordings, conditions))
    return carried.by(planning_grasper(path, conditions, replay=replay))


def _kept(
    judged: "Iterator[tuple[Task, RunVerdict, Rollout]]",
    folder: Path | None,
    n_runs: int,
    unwritten: "list[FileError]",
) -> "Iterator[tuple[Task, RunVerdict]]":
    """Write each run's rollout, if asked to, say how far it is, and pass on the judgement.

    Where one cannot be written, no further one is, and the error is put into ``unwritten``.
    """
    from handsim.errors import FileError
    from handsim.grasping.rollout_file import write_rollout

    with fraction_done("grasping") as done:
        for number, (task, run, rollout) in enumerate(judged, start=1):
            if folder is not None and not unwritten:
                suffix = "" if run.conditions.nominal else f"-{run.conditions.seed}"
                try:
                    write_rollout(rollout, folder / f"{task.name}{suffix}.npz")
                except FileError as error:
                    unwritten.append(error)
            done(number / n_runs)
            yield task, run
