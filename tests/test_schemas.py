"""Files of every schema that was ever written are read: one of each is kept, none is rewritten."""

from pathlib import Path

import numpy as np
import pytest

from handsim.baseline import read_baseline
from handsim.errors import FileError, HandsimError
from handsim.files import read_archive, write_archive
from handsim.grasping.planning.plan_store import PlanStore
from handsim.grasping.rollout_file import read_rollout, write_rollout
from handsim.joints import N_JOINTS
from handsim.learning.controller import GraspController

KEPT = Path(__file__).parent / "data" / "schemas"


def kept(pattern: str):
    found = sorted(KEPT.glob(pattern))
    assert found
    return pytest.mark.parametrize("path", found, ids=lambda path: path.name)


@kept("controller-*.npz")
def test_controllers(path, tmp_path):
    controller = GraspController.load(path)
    recorded = controller.demonstration("cube-raise")
    assert controller.postures(recorded.q_start, recorded.q_goal).arrived
    controller.save(tmp_path / "c.npz")
    assert GraspController.load(tmp_path / "c.npz").digest == controller.digest
    # Schema 1 knew no metric of destinations: gamma_d is the squared distance itself.
    assert (controller.navigation.metric is None) == (path.name == "controller-1.npz")


@kept("rollout-*.npz")
def test_rollouts(path):
    rollout = read_rollout(path)
    assert rollout.task == "cube-raise"
    assert rollout.outcome.success
    assert rollout.model().nq == rollout.qpos.shape[1]


def test_rollouts_of_schema_1_tell_no_forces_beside_those_on_the_object():
    """They were made by a hand that flew, before anything was asked of how it grasps."""
    old = read_rollout(KEPT / "rollout-1.npz")
    n = len(old.time)
    assert old.conditions.base == "free"
    assert (old.conditions.bias, old.conditions.latency) == (0.0, 0.0)
    np.testing.assert_array_equal(old.press, np.zeros((n, 6, 3)))
    np.testing.assert_array_equal(old.table_force, np.zeros(n))
    assert old.contact_force.shape == (n, 6)
    assert (old.outcome.forces_n, old.outcome.need_n, old.outcome.opposed) == ({}, 0.0, 0.0)


def test_rollouts_of_schema_2_tell_how_the_hand_presses():
    new = read_rollout(KEPT / "rollout-2.npz")
    assert new.conditions.base == "arm"
    held = new.time >= new.phases[-1].start
    sums = np.linalg.norm(new.press[held].sum(axis=1), axis=1)
    assert (np.linalg.norm(new.press, axis=2) <= new.contact_force + 1e-9).all()
    assert (sums < 0.5 * new.contact_force[held].sum(axis=1)).all()  # against each other
    assert new.outcome.need_n >= 1.0
    assert new.outcome.margin == max(new.outcome.forces_n.values()) / new.outcome.need_n


def test_rollouts_written_now_come_back(tmp_path):
    for name in ("rollout-1.npz", "rollout-2.npz"):
        before = read_rollout(KEPT / name)
        write_rollout(before, tmp_path / name)
        assert read_rollout(tmp_path / name) == before
        assert read_archive(tmp_path / name, "rollout", 2)[0]["schema"] == 2


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda metadata, arrays: arrays.pop("press"), "press"),
        (lambda metadata, arrays: arrays.pop("table_force"), "table_force"),
        (lambda metadata, arrays: arrays.update(press=arrays["press"][:, :5]), "press"),
        (lambda metadata, arrays: arrays.update(table_force=arrays["press"]), "table_force"),
        (lambda metadata, arrays: arrays["press"].__setitem__(0, np.nan), "press"),
        (lambda metadata, arrays: metadata["outcome"].update(forces_n=[1.0]), "forces_n"),
        (lambda metadata, arrays: metadata["outcome"]["forces_n"].update(thumb="3"), "forces_n"),
        (lambda metadata, arrays: metadata["outcome"].update(margin=float("nan")), "margin"),
        (lambda metadata, arrays: metadata["conditions"].update(base="robot"), "robot"),
        (lambda metadata, arrays: metadata["conditions"].update(latency="late"), "latency"),
    ],
)
def test_rollouts_that_lack_forces_are_refused(tmp_path, spoil, words):
    metadata, arrays = read_archive(KEPT / "rollout-2.npz", "rollout", 2)
    arrays = {name: array.copy() for name, array in arrays.items()}
    spoil(metadata, arrays)
    del metadata["kind"], metadata["schema"]
    path = tmp_path / "r.npz"
    write_archive(path, "rollout", 2, metadata, arrays)
    with pytest.raises(HandsimError, match=words) as refused:
        read_rollout(path)
    assert "\n" not in str(refused.value)


@kept("baseline-*.npz")
def test_baselines(path):
    baseline = read_baseline(path)
    assert baseline.results.traces["grasp/cube-raise"].verdict == "held"
    assert baseline.cases.plans["cube-raise"].q_goal.shape == (N_JOINTS,)


@kept("plans-*.json")
def test_plans(path):
    assert PlanStore(path).read()["cube-raise"].palm.pos.shape == (3,)


@kept("*-*.npz")
def test_newer_schemas_are_refused_with_the_remedy(path, tmp_path):
    kind = path.name.partition("-")[0]
    metadata, arrays = read_archive(path, kind, 99)
    del metadata["kind"], metadata["schema"]
    newer = tmp_path / "newer.npz"
    write_archive(newer, kind, 99, metadata, arrays)
    read = {
        "controller": GraspController.load, "rollout": read_rollout, "baseline": read_baseline
    }[kind]  # fmt: skip
    with pytest.raises(FileError, match=r"schema 99 .* update handsim"):
        read(newer)


def test_a_flipped_bit_is_noticed(tmp_path):
    """Every member has a checksum."""
    content = (KEPT / "controller-1.npz").read_bytes()
    generator = np.random.default_rng(3)
    whole = GraspController.load(KEPT / "controller-1.npz").digest
    path = tmp_path / "c.npz"
    noticed = 0
    for _ in range(60):
        data = bytearray(content)
        data[generator.integers(len(data))] ^= 1 << int(generator.integers(8))
        path.write_bytes(data)
        try:
            # A bit that means nothing, such as of a date, may be another.
            assert GraspController.load(path).digest == whole
        except FileError:
            noticed += 1
    assert noticed > 50
