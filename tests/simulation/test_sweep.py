from types import SimpleNamespace

import pytest

from handsim.errors import InputError, UnknownNameError
from handsim.hand.tasks import task_by_name
from handsim.motion.recording import Recording, RecordingSet
from handsim.simulation.conditions import Conditions
from handsim.simulation.grasping import TaskResult, grasp_many, grasp_task, without_object
from handsim.simulation.sweep import as_csv, results_table, sweep
from handsim.simulation.trials import Outcome

CUBE, JAR = task_by_name("cube-raise"), task_by_name("jar-move")


def pretend(task, conditions):
    """A grasper that drops the cube whenever it is perturbed."""
    held = conditions.nominal or task.name != "cube-raise"
    outcome = Outcome(held, None if held else "slipped", 0.12, 0.001, 2.0, 3.1, 4, 0.0005)
    return SimpleNamespace(outcome=outcome, conditions=conditions)


def test_a_sweep_goes_through_all_combinations():
    rows = list(
        sweep(
            pretend,
            [CUBE, JAR],
            hands=("woman-5", "man-95"),
            sides=("right", "left"),
            frictions=(0.5, 0.8),
            seeds=range(3),
        )
    )
    assert len(rows) == len(set(rows)) == 2 * 2 * 2 * 2 * 3
    nominal = [row for row in rows if row.nominal]
    assert {row.friction for row in rows} == {0.5, 0.8}
    assert all(row.success for row in nominal)
    assert {row.success for row in rows if row.task == "cube-raise" and not row.nominal} == {False}


def test_rows_become_a_table_with_one_line_each():
    lines = as_csv(sweep(pretend, [CUBE], seeds=(0, 5))).splitlines()
    assert lines[0].startswith("task,object,hand,side,friction,seed,nominal,success")
    assert len(lines) == 3
    assert lines[2].split(",")[:4] == ["cube-raise", "cube", "man-50", "right"]
    assert "slipped" in lines[2]


def test_what_cannot_be_swept_is_refused_before_anything_runs():
    with pytest.raises(InputError, match="nothing"):
        next(sweep(pretend, []))
    with pytest.raises(UnknownNameError, match="woman-50"):
        next(sweep(pretend, [CUBE], hands=("woman-51",)))


def test_the_table_of_results_gives_rates_with_intervals():
    results = [grasp_task(pretend, task, Conditions(), 10) for task in (CUBE, JAR)]
    table = results_table({"script": results, "controller": results}).splitlines()
    assert table[0] == "| task | script | controller |"
    assert table[2] == "| cube-raise | held, 0/10 | held, 0/10 |"
    assert "2 of 2, perturbed 50 % (30 to 70)" in table[4]


def test_many_tasks_keep_their_order_and_seeds():
    results = list(grasp_many(pretend, [JAR, CUBE], Conditions(seed=7), 2))
    assert [result.task.name for result in results] == ["jar-move", "cube-raise"]
    assert isinstance(results[0], TaskResult)
    assert [trial.conditions.seed for trial in results[0].trials] == [8, 9]


def test_processes_at_once_give_what_one_gives():
    one = as_csv(sweep(pretend, [CUBE, JAR], seeds=range(2)))
    assert as_csv(sweep(pretend, [CUBE, JAR], seeds=range(2), n_jobs=2)) == one


def test_an_object_is_left_out_with_all_its_recordings():
    import numpy as np

    time = np.arange(20) / 100
    q = np.linspace(0, 1, 20)[:, None] * np.ones(22)
    recordings = RecordingSet(
        tuple(
            Recording(
                name=f"r{i}",
                time=time,
                q=q,
                number=i,
                object=name,
                task="t",
                subject="s",
                hand_length=0.19,
                hand_breadth=0.09,
            )
            for i, name in enumerate(["cube", "jar", "cube"], start=1)
        )
    )
    assert [r.name for r in without_object(recordings, "cube")] == ["r2"]
    with pytest.raises(InputError, match="no recordings"):
        without_object(without_object(recordings, "cube"), "jar")
