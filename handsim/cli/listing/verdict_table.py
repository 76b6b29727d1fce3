"""How grasps went, as a table."""

from typing import TYPE_CHECKING

from handsim.cli.console import note, say, say_table, say_wrapped

if TYPE_CHECKING:
    from handsim.grasping.judging.protocols import TaskVerdict


def show_verdicts(results: "list[TaskVerdict]") -> None:
    """Write a row a task, and what there is to say of them."""
    if results[0].nominal.hard is None:
        say_table(
            ("task", "nominal", "lift [m]", "slip [mm]", "tilt [deg]", "hold [s]", "thumb [N]",
             "need [N]", "table [N]", "trials"),
            [_lift_row(result) for result in results],
        )  # fmt: skip
    else:
        say_table(
            ("task", "nominal", "hard", "shift [mm]", "turn [deg]", "epsilon", "trials"),
            [_six_axis_row(result) for result in results],
        )
        say_wrapped(_HARD)
    held = sum(result.nominal.success for result in results)
    say(f"{held} of {len(results)} tasks held")
    for result in results:
        if result.nominal.six_axis is None and result.nominal.outcome.detail:
            note(f"{result.task.name}: {result.nominal.outcome.detail}")


def _lift_row(result: "TaskVerdict") -> tuple[str, ...]:
    outcome = result.nominal.outcome
    return (
        result.task.name,
        outcome.reason or "held",
        f"{outcome.lift_m:.3f}",
        f"{1000 * outcome.peak_slip_m:.1f}",
        f"{outcome.peak_tilt_deg:.1f}",
        f"{outcome.hold_s:.2f}",
        f"{outcome.forces_n.get('thumb', 0.0):.1f}",
        f"{outcome.need_n:.1f}",
        f"{outcome.table_force_n:.0f}",
        _trials(result),
    )


def _six_axis_row(result: "TaskVerdict") -> tuple[str, ...]:
    """Reason under both settings; the largest movements under the usual one."""
    run = result.nominal
    assert run.six_axis is not None and run.hard is not None
    return (
        result.task.name,
        run.reason or "held",
        run.hard.reason or "held",
        f"{1000 * max(run.six_axis.shift_m):.1f}",
        f"{max(run.six_axis.turn_deg):.1f}",
        f"{run.epsilon:.3f}",
        _trials(result),
    )


_HARD = (
    "nominal: pulled from six sides with MuJoCo's correction of slip, as in the tasks. hard: the "
    "same pulls without it, where contacts creep, so that only a firm grasp holds. shift, turn: "
    "largest movement under the usual setting; epsilon: least wrench that the contacts resist, as "
    "a share of their forces."
)


def _trials(result: "TaskVerdict") -> str:
    return f"{result.successes} of {len(result.trials)}" if result.trials else ""
