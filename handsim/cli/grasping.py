"""`handsim grasp`: grasps in contact physics, judged."""

from collections.abc import Callable
from itertools import count
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from handsim.cli.console import JsonFlag, check_gl, fraction_done, note, say, say_json, say_table

if TYPE_CHECKING:
    from handsim.hand.grasp_task import Task
    from handsim.simulation.conditions import Conditions
    from handsim.simulation.grasping import Grasper, TaskResult
    from handsim.simulation.rollout import Rollout

DEMONSTRATOR = "demonstrator"


def grasp(
    task: Annotated[str, typer.Option(help="Task of Table I, or all that are demonstrated.")],
    controller: Annotated[
        str | None,
        typer.Argument(help="Controller file, or demonstrator; the built-in one if left out."),
    ] = None,
    replay: Annotated[
        bool,
        typer.Option(
            "--replay/--plan", help="Take the recorded destination, or plan one in the subspace."
        ),
    ] = False,
    trials: Annotated[int, typer.Option(min=0, help="Perturbed trials beside the nominal.")] = 0,
    seed: Annotated[int, typer.Option(min=0, help="Of glove noise and perturbations.")] = 0,
    hand_length: Annotated[float | None, typer.Option(help="Hand length [m].")] = None,
    hand_breadth: Annotated[float | None, typer.Option(help="Hand breadth [m].")] = None,
    friction: Annotated[float | None, typer.Option(help="Sliding friction of the hand.")] = None,
    require_success: Annotated[
        bool, typer.Option("--require-success", help="Exit with 1 unless every task succeeds.")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder for the rollouts.")
    ] = None,
    json: JsonFlag = False,
) -> None:
    """Grasp in physics and judge the outcome by the task's rule."""
    check_gl()

    from handsim.simulation.grasping import grasp_task, summarise
    from handsim.simulation.rollout import write_rollout

    tasks = _tasks(task)
    conditions = _conditions(seed, hand_length, hand_breadth, friction)
    grasper = _grasper(controller, conditions, replay=replay)
    if output is not None:
        output.mkdir(exist_ok=True)
    started, results = perf_counter(), []
    with fraction_done("grasping") as done:
        counted = _counted(grasper, done, len(tasks) * (1 + trials))
        for each in tasks:
            result = grasp_task(counted, each, conditions, trials)
            results.append(result)
            if output is None:
                continue
            for run in (result.nominal, *result.trials):
                suffix = "" if run.conditions.nominal else f"-{run.conditions.seed}"
                write_rollout(run, output / f"{each.name}{suffix}.npz")
    if json and task != "all":
        say_json(results[0].as_json())
    elif json:
        say_json(summarise(results, perf_counter() - started))
    else:
        _show(results)
    if require_success and not all(result.nominal.outcome.success for result in results):
        raise typer.Exit(1)


def _tasks(name: str) -> "list[Task]":
    from handsim.hand.tasks import task_by_name
    from handsim.simulation.experiments import demonstrated_tasks

    return list(demonstrated_tasks()) if name == "all" else [task_by_name(name)]


def _conditions(
    seed: int, hand_length: float | None, hand_breadth: float | None, friction: float | None
) -> "Conditions":
    from handsim.hand.anthropometry import hand_geometry
    from handsim.simulation.conditions import Conditions

    default = Conditions()
    conditions = Conditions(
        seed=seed,
        hand_length=default.hand_length if hand_length is None else hand_length,
        hand_breadth=default.hand_breadth if hand_breadth is None else hand_breadth,
        friction=default.friction if friction is None else friction,
    )
    hand_geometry(conditions.hand_length, conditions.hand_breadth)  # refuses what is no hand
    return conditions


def _grasper(name: str | None, conditions: "Conditions", *, replay: bool) -> "Grasper":
    from handsim.cli.defaults import planning_grasper
    from handsim.simulation.demonstrator import demonstrate

    if name == DEMONSTRATOR:
        return demonstrate
    return planning_grasper(None if name is None else Path(name), conditions, replay=replay)


def _counted(grasp: "Grasper", done: Callable[[float], None] | None, n_runs: int) -> "Grasper":
    """Return a grasper that says after each run what fraction of ``n_runs`` is done."""
    runs = count(1)

    def grasp_and_count(task: "Task", conditions: "Conditions") -> "Rollout":
        run = grasp(task, conditions)
        if done:
            done(next(runs) / n_runs)
        return run

    return grasp_and_count


def _show(results: "list[TaskResult]") -> None:
    say_table(
        ("task", "nominal", "lift [m]", "slip [mm]", "tilt [deg]", "hold [s]", "trials"),
        [
            (
                result.task.name,
                result.nominal.outcome.reason or "held",
                f"{result.nominal.outcome.lift_m:.3f}",
                f"{1000 * result.nominal.outcome.peak_slip_m:.1f}",
                f"{result.nominal.outcome.peak_tilt_deg:.1f}",
                f"{result.nominal.outcome.hold_s:.2f}",
                f"{result.successes} of {len(result.trials)}" if result.trials else "",
            )
            for result in results
        ],
    )
    held = sum(result.nominal.outcome.success for result in results)
    say(f"{held} of {len(results)} tasks held")
    for result in results:
        if result.nominal.outcome.detail:
            note(f"{result.task.name}: {result.nominal.outcome.detail}")
