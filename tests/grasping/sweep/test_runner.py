"""Sweeps: every run once, whatever is there already."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from handsim.errors import FileError, HandsimError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.grasper import ControllerGrasper
from handsim.grasping.planning.plan_store import PlanStore, plan_store
from handsim.grasping.pool import one_by_one, processes
from handsim.grasping.sweep import runner as module
from handsim.grasping.sweep.graspers import Planned, Source, SweepGraspers
from handsim.grasping.sweep.runner import COLUMNS, sweep, sweep_key
from handsim.grasping.sweep.spec import SweepSpec, hand_preset
from handsim.grasping.sweep.summary import rates, results_table
from handsim.grasping.sweep.table import open_table
from handsim.learning.controller import GraspController
from handsim.tasks.rules import Outcome
from handsim.tasks.table_one import task_by_name
from handsim.types import MEDIAN_HAND, HandSize

CUBE, JAR = task_by_name("cube-raise"), task_by_name("jar-move")
HELD = Outcome(True, None, 0.12, 0.001, 2.0, 3.1, 4, 0.0005)
SPEC = SweepSpec(tasks=(CUBE, JAR), controllers=("script",), seeds=(0, 1, 2))


def pretend(task, conditions):
    """A grasper that drops the cube whenever it is perturbed."""
    held = conditions.nominal or task.name != "cube-raise"
    outcome = HELD if held else replace(HELD, success=False, reason="slipped")
    return SimpleNamespace(outcome=outcome, conditions=conditions)


SOURCES = {"script": Source("1", lambda conditions: pretend)}


def run(spec, path, pool=one_by_one, sources=SOURCES):
    with open_table(path, sweep_key(spec, sources), COLUMNS, spec.n_runs) as table:
        graspers = SweepGraspers(spec, sources, table)
        graspers.plan(pool)
        sweep(spec, graspers, table, pool)
        return list(table.rows())


def test_every_run_becomes_a_row(tmp_path):
    rows = run(SPEC, tmp_path / "r.csv")
    assert [(row["task"], row["seed"]) for row in rows] == [
        (task, str(seed)) for task in ("cube-raise", "jar-move") for seed in range(3)
    ]
    assert [row["success"] for row in rows] == ["True", "False", "False"] + ["True"] * 3
    assert [row["reason"] for row in rows[:3]] == ["", "slipped", "slipped"]
    assert rows[0]["friction"] == "0.8"
    assert rows[1]["mass_scale"] != "1"


def test_only_what_is_missing_is_done(tmp_path):
    path = tmp_path / "r.csv"
    run(SPEC, path)
    whole = path.read_bytes()
    lines = whole.splitlines(keepends=True)
    path.write_bytes(b"".join([lines[0], lines[5], lines[2]]) + lines[3][:20])
    done = []

    def counted(task, conditions):
        done.append((task.name, conditions.seed))
        return pretend(task, conditions)

    run(SPEC, path, sources={"script": Source("1", lambda conditions: counted)})
    assert done == [("cube-raise", 0), ("cube-raise", 2), ("jar-move", 0), ("jar-move", 2)]
    assert path.read_bytes() == whole
    done.clear()
    run(SPEC, path, sources={"script": Source("1", lambda conditions: counted)})
    assert done == []
    assert path.read_bytes() == whole


@pytest.mark.ci
@pytest.mark.slow
def test_processes_at_once_give_what_one_gives(tmp_path):
    run(SPEC, tmp_path / "one.csv")
    run(SPEC, tmp_path / "two.csv", processes(2))
    assert (tmp_path / "two.csv").read_bytes() == (tmp_path / "one.csv").read_bytes()


def test_the_key_tells_apart_what_gives_other_rows(monkeypatch):
    keys = [sweep_key(SPEC, SOURCES)]
    assert sweep_key(replace(SPEC), dict(SOURCES)) == keys[0]
    for change in (
        {"tasks": (CUBE,)}, {"seeds": (0, 1)}, {"frictions": (0.5,)}, {"mass_scales": (1.0,)},
        {"sides": ("left",)}, {"hands": (hand_preset("man-5"),)},
    ):  # fmt: skip
        keys.append(sweep_key(replace(SPEC, **change), SOURCES))
    keys.append(sweep_key(SPEC, {"script": Source("2", lambda conditions: pretend)}))
    monkeypatch.setattr(module, "_versions", lambda: {"handsim": "0", "mujoco": "0"})
    keys.append(sweep_key(SPEC, SOURCES))
    assert len(set(keys)) == len(keys)


def test_a_worker_of_another_version_makes_no_row(monkeypatch):
    (first, *_) = SPEC.runs()
    with pytest.raises(HandsimError, match=r"'mujoco': '0'.* install the same"):
        module._row(pretend, first, {"handsim": "0", "mujoco": "0"})


def test_each_hand_is_planned_once_and_its_plans_are_kept(tmp_path, monkeypatch):
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    built_in = plan_store(data_folder("assets") / "plans", controller.digest, Conditions())
    known = built_in.read()
    planned, used = [], []

    def quickly(controller, task, conditions, hint, *, others, seed, progress):
        planned.append((task.name, conditions.hand.length, conditions.hand.side))
        assert conditions.nominal
        assert hint is None and {each.hand for each in others} == {MEDIAN_HAND}
        return known[task.name], SimpleNamespace(outcome=HELD)

    def by_plan(controller, scene, plan):
        used.append(plan)
        return pretend(CUBE, scene)

    monkeypatch.setattr("handsim.grasping.planning.grasper.plan_grasp", quickly)
    monkeypatch.setattr("handsim.grasping.sweep.graspers.run_plan", by_plan)
    monkeypatch.setattr(
        "handsim.grasping.sweep.graspers.Scene", SimpleNamespace(build=lambda task, c: c)
    )

    def grasper(conditions):
        own = plan_store(tmp_path / "plans", controller.digest, conditions)
        return ControllerGrasper(controller, "plan", own, (built_in,))

    sources = {"mine": Source(controller.digest, grasper)}
    hands = (hand_preset("woman-5"), hand_preset("man-95"))
    spec = SweepSpec((CUBE, JAR), ("mine",), hands, ("right", "left"), seeds=(0, 1, 2))
    rows = run(spec, tmp_path / "r.csv", sources=sources)
    assert len(rows) == len(used) == 24
    assert len(planned) == len(set(planned)) == 8
    assert len(list((tmp_path / "plans").iterdir())) == 4
    # What was planned is used as it is read back: the first time as at any other.
    stored = grasper(Conditions(hand=HandSize(0.165, 0.072))).store.read()
    assert used[0].q_goal.tobytes() == stored["cube-raise"].q_goal.tobytes()
    # Another sweep of the same hands has its plans already.
    planned.clear()
    lines = (tmp_path / "r.csv").read_text().splitlines(keepends=True)
    (tmp_path / "r.csv").write_text("".join(lines[:-1]))
    run(spec, tmp_path / "r.csv", sources=sources)
    assert (tmp_path / "r.csv").read_text() == "".join(lines)
    run(replace(spec, seeds=(5,)), tmp_path / "other.csv", sources=sources)
    assert planned == []


def test_rates_are_counted_by_controller_and_task(tmp_path):
    spec = replace(SPEC, controllers=("script", "other"), seeds=tuple(range(11)))
    rows = run(spec, tmp_path / "r.csv", sources=SOURCES | {"other": SOURCES["script"]})
    table = results_table(rows).splitlines()
    assert table[0] == "| task | script | other |"
    assert table[2] == "| cube-raise | held, 0/10 | held, 0/10 |"
    assert table[3] == "| jar-move | held, 10/10 | held, 10/10 |"
    assert "2 of 2, perturbed 50 % (30 to 70)" in table[4]
    found = rates(rows)["script"]["all"].as_dict()
    assert (found["nominal"], found["nominal_held"], found["trials"]) == (2, 2, 20)


def test_rates_of_several_hands_and_of_none_perturbed(tmp_path):
    hands = (hand_preset("woman-5"), hand_preset("man-95"))
    rows = run(replace(SPEC, hands=hands, seeds=(0,)), tmp_path / "r.csv")
    table = results_table(rows).splitlines()
    assert table[2] == "| cube-raise | 2/2 nominal |"
    assert table[4] == "| **all** | 4 of 4 |"
    rows = run(replace(SPEC, seeds=(4,)), tmp_path / "s.csv")
    assert results_table(rows).splitlines()[2] == "| cube-raise | 0/1 |"


def test_rows_by_another_plan_are_not_mixed_in(tmp_path, monkeypatch):
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    built_in = plan_store(data_folder("assets") / "plans", controller.digest, Conditions())
    entry = built_in.entries()["cube-raise"]
    plan = entry.plan
    store = PlanStore(tmp_path / "plans.json")
    store.add("cube-raise", entry)
    monkeypatch.setattr(
        "handsim.grasping.sweep.graspers.run_plan",
        lambda controller, scene, plan: pretend(CUBE, scene),
    )
    monkeypatch.setattr(
        "handsim.grasping.sweep.graspers.Scene", SimpleNamespace(build=lambda task, c: c)
    )
    grasper = ControllerGrasper(controller, "plan", store)
    sources = {"mine": Source(controller.digest, lambda conditions: grasper)}
    spec = SweepSpec((CUBE,), ("mine",), seeds=(0, 1, 2))
    path = tmp_path / "r.csv"
    assert len({row["plan"] for row in run(spec, path, sources=sources)}) == 1
    part = "".join(path.read_text().splitlines(keepends=True)[:-1])
    path.write_text(part)
    changed = replace(plan, squeeze=plan.squeeze * (1 + 1e-5))
    store.add("cube-raise", replace(entry, plan=changed))
    with pytest.raises(FileError, match=r"r.csv: holds rows by another plan of cube-raise"):
        run(spec, path, sources=sources)
    assert path.read_text() == part
    # A plan whose last bits another machine has made otherwise is the same.
    store.add("cube-raise", replace(entry, plan=replace(plan, squeeze=plan.squeeze * (1 + 1e-15))))
    assert store.read()["cube-raise"].squeeze != plan.squeeze
    assert len(run(spec, path, sources=sources)) == 3


def test_plans_tell_themselves_apart_by_all_that_they_say():
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    store = plan_store(data_folder("assets") / "plans", controller.digest, Conditions())
    plan = store.read()["cube-raise"]
    others = [
        replace(plan, **{name: getattr(plan, name) * (1 + 1e-5)})
        for name in ("retreat", "q_start", "q_goal", "z_goal", "squeeze", "arrive")
    ]
    others.append(replace(plan, palm=plan.palm.moved(np.array([1e-6, 0, 0]))))
    digests = {Planned(controller, each).digest for each in (plan, *others)}
    assert len(digests) == len(others) + 1
    noise = replace(plan, z_goal=plan.z_goal * (1 - 1e-14), retreat=plan.retreat + 1e-17)
    assert Planned(controller, noise).digest == Planned(controller, plan).digest


def test_a_plan_of_another_task_is_made_again(tmp_path, monkeypatch):
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    built_in = plan_store(data_folder("assets") / "plans", controller.digest, Conditions())
    entry = built_in.entries()["cube-raise"]
    store, told, used = PlanStore(tmp_path / "plans.json"), [], []
    store.add("cube-raise", replace(entry, key=replace(entry.key, task="another")))
    found = replace(entry.plan, squeeze=0.5)

    def quickly(controller, task, conditions, start, *, others, seed, progress):
        assert start.squeeze == entry.plan.squeeze
        return found, SimpleNamespace(outcome=HELD)

    def by_plan(controller, scene, plan):
        used.append(plan.squeeze)
        return pretend(CUBE, scene)

    monkeypatch.setattr("handsim.grasping.planning.grasper.plan_grasp", quickly)
    monkeypatch.setattr("handsim.grasping.sweep.graspers.run_plan", by_plan)
    monkeypatch.setattr(
        "handsim.grasping.sweep.graspers.Scene", SimpleNamespace(build=lambda task, c: c)
    )
    sources = {
        "mine": Source("1", lambda c: ControllerGrasper(controller, store=store, note=told.append))
    }
    run(SweepSpec((CUBE,), ("mine",), seeds=(0, 1)), tmp_path / "r.csv", sources=sources)
    assert told == ["plan of cube-raise is of another task: planned again"]
    assert used == [0.5, 0.5]
    assert store.entries()["cube-raise"].key == entry.key


def test_the_key_goes_by_what_tasks_and_objects_are():
    key = sweep_key(SPEC, SOURCES)
    stricter = replace(CUBE, rule=replace(CUBE.rule, slip=0.019))
    mine = replace(CUBE, own_object=replace(CUBE.object, symmetry="z"))
    same = replace(CUBE, own_object=replace(CUBE.object, source="measured again"))
    noisy = replace(CUBE, yaw_deg=CUBE.yaw_deg * (1 + 1e-15))
    assert noisy.yaw_deg != CUBE.yaw_deg
    for task, equal in ((stricter, False), (mine, False), (same, True), (noisy, True)):
        assert (sweep_key(replace(SPEC, tasks=(task, JAR)), SOURCES) == key) is equal
    (hand,) = SPEC.hands
    noisy_hand = replace(hand, length=hand.length * (1 + 1e-15))
    assert noisy_hand.length != hand.length
    assert sweep_key(replace(SPEC, hands=(noisy_hand,)), SOURCES) == key
