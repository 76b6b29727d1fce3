"""Run grasps and judge them by a protocol: the rule of the task, or the six-axis test.

The force-closure quality of every final grasp is measured too.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

from handsim.grasping.conditions import Conditions, Hard, trial_conditions
from handsim.grasping.judging.quality import grasp_quality
from handsim.grasping.judging.rates import wilson_interval
from handsim.grasping.judging.six_axis import SixAxisOutcome, six_axis
from handsim.grasping.planning.grasper import ControllerGrasper, Grasper
from handsim.grasping.pool import in_order, processes
from handsim.grasping.rollout.record import Rollout
from handsim.tasks.rules import Outcome, Reason
from handsim.tasks.task import Task

Protocol = Literal["lift", "six-axis"]
"""``lift``: the rule of the task; ``six-axis``: `handsim.grasping.judging.six_axis`."""


@dataclass(frozen=True)
class RunVerdict:
    """The verdicts of one run.

    Attributes
    ----------
    conditions
        Of the run.
    outcome
        By the rule of the task.
    epsilon
        Force-closure quality of the final grasp (`handsim.grasping.judging.quality`).
    six_axis, hard
        By the six-axis test, with its own contact settings and with those of MuJoCo; None where
        the protocol is another.
    certified
        Whether every start is proven to reach the destination in the subspace; None for a script.
    """

    conditions: Conditions
    outcome: Outcome
    epsilon: float
    six_axis: SixAxisOutcome | None = None
    hard: SixAxisOutcome | None = None
    certified: bool | None = None

    @property
    def success(self) -> bool:
        """Whether the run passed the protocol."""
        return (self.six_axis or self.outcome).success

    @property
    def reason(self) -> Reason | None:
        """Why the run failed, or None."""
        return (self.six_axis or self.outcome).reason

    def as_dict(self) -> dict[str, Any]:
        """Return what `handsim grasp --json` says of a run."""
        said = {
            "seed": self.conditions.seed,
            "nominal": self.conditions.nominal,
            "base": self.conditions.base,
            **asdict(self.outcome),
            "epsilon": self.epsilon,
            "certified": self.certified,
        }
        if self.six_axis is None or self.hard is None:
            return said
        return said | {
            "success": self.success,
            "reason": self.reason,
            "detail": "",
            "lift_success": self.outcome.success,
            "hard_success": self.hard.success,
            "six_axis": asdict(self.six_axis) | {"reason": self.six_axis.reason},
            "six_axis_hard": asdict(self.hard) | {"reason": self.hard.reason},
        }


@dataclass(frozen=True)
class TaskVerdict:
    """The verdicts of a task, that of the nominal run first."""

    task: Task
    runs: tuple[RunVerdict, ...]

    @property
    def nominal(self) -> RunVerdict:
        """The run in which nothing is perturbed."""
        return self.runs[0]

    @property
    def trials(self) -> tuple[RunVerdict, ...]:
        """The perturbed runs."""
        return self.runs[1:]

    @property
    def successes(self) -> int:
        """Number of perturbed runs that passed."""
        return sum(run.success for run in self.trials)

    def as_dict(self) -> dict[str, Any]:
        """Return what `handsim grasp --json` says of a task."""
        said = {
            "task": self.task.name,
            "nominal_success": self.nominal.success,
            "trials": len(self.trials),
            "successes": self.successes,
            "success_interval": wilson_interval(self.successes, len(self.trials)),
            "per_trial": [run.as_dict() for run in self.runs],
        }
        if self.nominal.hard is None:
            return said
        return said | {
            "protocol": "six-axis",
            "nominal_hard_success": self.nominal.hard.success,
            "hard_successes": sum(run.hard.success for run in self.trials if run.hard),
        }


def judge_run(
    grasp: Grasper, task: Task, conditions: Conditions, protocol: Protocol = "lift"
) -> tuple[RunVerdict, Rollout]:
    """Grasp once and judge it."""
    run = grasp(task, conditions)
    six, hard = None, None
    if protocol == "six-axis":
        six, hard = six_axis(run), six_axis(run, hard=True)
    proven = grasp.proven.get(task.name) if isinstance(grasp, ControllerGrasper) else None
    return RunVerdict(run.conditions, run.outcome, grasp_quality(run), six, hard, proven), run


def judge_runs(
    grasp: Grasper,
    tasks: Sequence[Task],
    conditions: Conditions,
    n_trials: int = 0,
    *,
    protocol: Protocol = "lift",
    hard: Hard | None = None,
    n_jobs: int = 1,
) -> Iterator[tuple[Task, RunVerdict, Rollout]]:
    """Grasp every task once as it is and ``n_trials`` times perturbed, in order.

    Parameters
    ----------
    grasp
    tasks
    conditions
        Of the nominal runs; the perturbed ones have the seeds that follow.
    n_trials
        Perturbed runs of each task.
    protocol
        What decides success.
    hard
        What the perturbed runs are perturbed in, alone; by default in all that `perturb` varies.
    n_jobs
        Processes at once. Missing plans are made before the first run, so that only this process
        writes plans.
    """
    if n_jobs > 1 and isinstance(grasp, ControllerGrasper):
        grasp.prepare(tasks, conditions, n_jobs)
    runs = [(task, each) for task in tasks for each in trial_conditions(conditions, n_trials, hard)]
    judged = in_order(processes(n_jobs), judge_run, [(grasp, *run, protocol) for run in runs])
    for (task, _), (run, rollout) in zip(runs, judged, strict=True):
        yield task, run, rollout


def summarise(results: Sequence[TaskVerdict], seconds: float) -> dict[str, Any]:
    """Return what `handsim grasp --task all --json` says."""
    objects = {r.task.object_name for r in results if r.nominal.success}
    said = {
        "tasks": [result.as_dict() for result in results],
        "tasks_passed": sum(result.nominal.success for result in results),
        "objects_passed": len(objects),
        "seconds": seconds,
    }
    if not any(result.nominal.hard for result in results):
        return said
    hard = sum(result.nominal.hard.success for result in results if result.nominal.hard)
    return said | {"protocol": "six-axis", "tasks_passed_hard": hard}
