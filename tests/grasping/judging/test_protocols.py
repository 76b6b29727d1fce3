"""What decides success, and what is said of it."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from handsim.grasping.conditions import Conditions
from handsim.grasping.judging import protocols
from handsim.grasping.judging.protocols import (
    RunVerdict,
    TaskVerdict,
    judge_run,
    judge_runs,
    summarise,
)
from handsim.grasping.judging.six_axis import SixAxisOutcome
from handsim.grasping.planning.demonstrator import demonstrate
from handsim.tasks.rules import Outcome
from handsim.tasks.table_one import task_by_name

CUBE, JAR = task_by_name("cube-raise"), task_by_name("jar-move")
HELD = Outcome(True, None, 0.12, 0.001, 2.0, 3.1, 4, 0.0005, 1.0)
DROPPED = replace(HELD, success=False, reason="slipped", detail="it moved 50 mm in the hand")
STAYED = SixAxisOutcome((0.01,) * 6, (3.0,) * 6, 0.001)
TURNED = replace(STAYED, turn_deg=(20.0,) * 6)


def pretend(task, conditions):
    """A grasper that drops the cube whenever it is perturbed."""
    held = conditions.nominal or task.name != "cube-raise"
    return SimpleNamespace(outcome=HELD if held else DROPPED, conditions=conditions)


def test_the_protocol_decides_and_the_rule_is_told_beside_it():
    run = RunVerdict(Conditions(seed=4), HELD, 0.2, TURNED, TURNED)
    assert not run.success
    said = run.as_json()
    assert (said["success"], said["reason"]) == (False, "tilted")
    assert (said["lift_success"], said["hard_success"]) == (True, False)
    assert said["six_axis"]["turn_deg"] == (20.0,) * 6
    assert said["lift_m"] == HELD.lift_m
    other = replace(run, outcome=DROPPED, six_axis=STAYED)
    assert other.success
    said = other.as_json()
    assert (said["success"], said["reason"], said["lift_success"]) == (True, None, False)


def test_the_rule_decides_where_nothing_else_is_asked_for():
    said = RunVerdict(Conditions(seed=4), DROPPED, 0.2).as_json()
    assert (said["success"], said["reason"], said["epsilon"]) == (False, "slipped", 0.2)
    assert "hard_success" not in said


def test_hard_successes_are_counted_apart():
    run = RunVerdict(Conditions(), DROPPED, 0.2, STAYED, TURNED)
    lenient = replace(run, hard=STAYED)
    result = TaskVerdict(CUBE, (run, lenient, run, replace(run, six_axis=TURNED)))
    said = result.as_json()
    assert said["nominal_success"] is True
    assert said["nominal_hard_success"] is False
    assert (said["trials"], said["successes"], said["hard_successes"]) == (3, 2, 1)
    whole = summarise([result, TaskVerdict(JAR, (lenient,))], 1.5)
    assert (whole["tasks_passed"], whole["tasks_passed_hard"], whole["objects_passed"]) == (2, 1, 2)


def test_tasks_keep_their_order_and_seeds(monkeypatch):
    monkeypatch.setattr(protocols, "grasp_quality", lambda run: 0.1)
    judged = list(judge_runs(pretend, [JAR, CUBE], Conditions(seed=7), 2))
    assert [task.name for task, _, _ in judged] == ["jar-move"] * 3 + ["cube-raise"] * 3
    assert [run.conditions.seed for _, run, _ in judged] == [7, 8, 9] * 2
    assert [run.conditions.nominal for _, run, _ in judged] == [True, False, False] * 2
    assert [run.success for _, run, _ in judged] == [True] * 4 + [False] * 2
    jar = TaskVerdict(JAR, tuple(run for _, run, _ in judged[:3]))
    assert (jar.successes, len(jar.trials), jar.nominal.epsilon) == (2, 2, 0.1)
    assert "protocol" not in summarise([jar], 1.0)


def test_the_six_pulls_are_made_as_usual_and_hard_where_they_are_asked_for(monkeypatch):
    made = []

    def pulled(run, *, hard=False):
        made.append(hard)
        return TURNED if hard else STAYED

    monkeypatch.setattr(protocols, "six_axis", pulled)
    monkeypatch.setattr(protocols, "grasp_quality", lambda run: 0.3)
    judged, rollout = judge_run(pretend, CUBE, Conditions(nominal=False), "six-axis")
    assert made == [False, True]
    assert (judged.six_axis, judged.hard) == (STAYED, TURNED)
    assert (judged.outcome, judged.epsilon) == (DROPPED, 0.3)
    assert rollout.outcome == DROPPED
    assert (judged.success, judged.reason) == (True, None)
    judged, _ = judge_run(pretend, CUBE, Conditions(nominal=False))
    assert made == [False, True]
    assert (judged.six_axis, judged.hard) == (None, None)
    assert (judged.success, judged.reason) == (False, "slipped")
    runs = [run for _, run, _ in judge_runs(pretend, [JAR], Conditions(), 1, protocol="six-axis")]
    assert [run.six_axis for run in runs] == [STAYED, STAYED]


def test_the_hard_pulls_decide_nothing():
    run = RunVerdict(Conditions(), HELD, 0.2, STAYED, TURNED)
    assert (run.success, run.reason) == (True, None)
    run = RunVerdict(Conditions(), HELD, 0.2, TURNED, STAYED)
    assert (run.success, run.reason) == (False, "tilted")
    assert run.as_json()["hard_success"] is True
    assert run.as_json()["six_axis_hard"]["reason"] is None
    assert run.as_json()["six_axis"]["reason"] == "tilted"


def test_the_nominal_run_is_none_of_the_trials():
    held, dropped = (RunVerdict(Conditions(), outcome, 0.2) for outcome in (HELD, DROPPED))
    result = TaskVerdict(CUBE, (held, dropped, held, dropped))
    said = result.as_json()
    assert said["nominal_success"] is True
    assert (said["trials"], said["successes"]) == (3, 1)
    # 1 of 3 by Wilson's score, after the formula (R. G. Newcombe 1998, method 3).
    assert said["success_interval"] == pytest.approx((0.0615, 0.7923), abs=1e-4)
    assert [each["success"] for each in said["per_trial"]] == [True, False, True, False]
    said = TaskVerdict(CUBE, (dropped, held, held)).as_json()
    assert said["nominal_success"] is False
    assert (said["trials"], said["successes"]) == (2, 2)


def test_tasks_and_objects_pass_by_their_nominal_run():
    held, dropped = (RunVerdict(Conditions(), outcome, 0.2) for outcome in (HELD, DROPPED))
    lid = task_by_name("jar-unscrew")
    results = [
        TaskVerdict(JAR, (held, dropped)),
        TaskVerdict(lid, (held,)),
        TaskVerdict(CUBE, (dropped, held)),
    ]
    whole = summarise(results, 2.5)
    assert (whole["tasks_passed"], whole["objects_passed"], whole["seconds"]) == (2, 1, 2.5)
    assert "tasks_passed_hard" not in whole


def test_hard_passes_are_those_of_nominal_runs():
    hard = RunVerdict(Conditions(), DROPPED, 0.2, TURNED, STAYED)
    soft = RunVerdict(Conditions(), DROPPED, 0.2, STAYED, TURNED)
    results = [TaskVerdict(JAR, (hard, soft)), TaskVerdict(CUBE, (soft, hard, soft))]
    whole = summarise(results, 1.0)
    assert (whole["tasks_passed"], whole["tasks_passed_hard"]) == (1, 1)
    said = [each.as_json() for each in results]
    assert [each["nominal_hard_success"] for each in said] == [True, False]
    assert [each["hard_successes"] for each in said] == [0, 1]
    assert [each["successes"] for each in said] == [1, 1]


def test_a_real_grasp_has_quality_and_a_verdict():
    run, rollout = judge_run(demonstrate, CUBE, Conditions(), "six-axis")
    assert rollout.outcome == run.outcome
    assert run.epsilon > 0.05
    assert run.success
    assert run.hard is not None
    missed, _ = judge_run(demonstrate, CUBE, Conditions(object_offset=(0.0, 0.3, 0.0)))
    assert missed.epsilon == 0.0
    assert missed.reason == "missed"
    assert missed.six_axis is None


@pytest.mark.slow
def test_processes_at_once_give_what_one_gives():
    asked = ([CUBE, JAR], Conditions(), 2)
    one = [run for _, run, _ in judge_runs(demonstrate, *asked)]
    assert [run for _, run, _ in judge_runs(demonstrate, *asked, n_jobs=2)] == one
