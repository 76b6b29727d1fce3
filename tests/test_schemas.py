"""Files of every schema that was ever written are read: one of each is kept, none is rewritten."""

from pathlib import Path

import numpy as np
import pytest

from handsim.baseline import read_baseline
from handsim.errors import FileError
from handsim.files import read_archive, write_archive
from handsim.grasping.planning.plan_store import PlanStore
from handsim.grasping.rollout_file import read_rollout
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
