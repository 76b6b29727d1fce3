"""Baselines as files: whole, of numbers, and read as they were written."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from handsim.baseline.store import SCHEMA, read_baseline, write_baseline
from handsim.errors import FileError, InputError
from handsim.files import read_archive, write_archive

TASK = "cube-raise"
KEPT = Path(__file__).parents[1] / "data" / "schemas"


@pytest.fixture(scope="module")
def small(grasps, movements):
    """A baseline of one movement and one grasp."""
    name = next(iter(movements.cases.starts))
    asked = movements.cases
    cases = replace(
        grasps.cases, starts={name: asked.starts[name]}, goals={name: asked.goals[name]}
    )
    kept = (f"movement/{name}", f"grasp/{TASK}")
    traces = {each: grasps.results.traces[each] for each in kept}
    return replace(grasps, cases=cases, results=replace(grasps.results, traces=traces))


def test_a_baseline_is_read_as_it_was_written(small, tmp_path):
    baseline = small
    path = tmp_path / "b.npz"
    write_baseline(baseline, path)
    read = read_baseline(path)
    assert read.results.inputs == baseline.results.inputs
    assert (read.environment, read.handsim) == (baseline.environment, baseline.handsim)
    assert (read.reasons, read.relearned) == (baseline.reasons, False)
    for name, one in baseline.results.traces.items():
        other = read.results.traces[name]
        np.testing.assert_array_equal(other.q, one.q)
        np.testing.assert_array_equal(other.time, one.time)
        assert (other.verdict, other.measures) == (one.verdict, one.measures)
    for kind in ("starts", "goals"):
        for name, q in getattr(baseline.cases, kind).items():
            np.testing.assert_array_equal(getattr(read.cases, kind)[name], q)
    plan, same = baseline.cases.plans[TASK], read.cases.plans[TASK]
    for name in ("retreat", "q_start", "q_goal"):
        np.testing.assert_array_equal(getattr(same, name), getattr(plan, name))
    np.testing.assert_array_equal(same.palm.quat, plan.palm.quat)
    np.testing.assert_array_equal(same.palm.pos, plan.palm.pos)
    assert (same.squeeze, same.arrive) == (plan.squeeze, plan.arrive)


def damaged(baseline, path, change) -> None:
    """Write a baseline after a change of its metadata and arrays."""
    write_baseline(baseline, path)
    metadata, arrays = read_archive(path, "baseline", SCHEMA)
    del metadata["kind"], metadata["schema"]
    change(metadata, arrays)
    write_archive(path, "baseline", SCHEMA, metadata, arrays)


def refused(path) -> None:
    kept = path.read_bytes()
    with pytest.raises(FileError, match=r"not a whole baseline .* record it again") as told:
        read_baseline(path)
    assert "\n" not in str(told.value)
    assert path.read_bytes() == kept


@pytest.mark.parametrize("name", ["starts", "goals", "q_0", "time_0"])
@pytest.mark.parametrize("shape", [(2, 3), ()])
@pytest.mark.parametrize("value", [np.nan, np.inf, 0.5])
def test_arrays_that_are_not_as_they_should_be(small, tmp_path, name, shape, value):
    path = tmp_path / "b.npz"
    damaged(small, path, lambda _, arrays: arrays.update({name: np.full(shape, value)}))
    refused(path)


@pytest.mark.parametrize("name", ["q_0", "time_0"])
def test_one_number_that_is_none(small, tmp_path, name):
    def spoil(_, arrays):
        arrays[name] = arrays[name].copy()
        arrays[name].flat[-1] = np.nan

    path = tmp_path / "b.npz"
    damaged(small, path, spoil)
    refused(path)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("palm_pos", [0.0, 0.0]), ("palm_pos", None), ("q_goal", [1.0] * 21),
        ("squeeze", float("nan")), ("squeeze", [1.0, 2.0]), ("retreat", [0.0, 0.0, 1e6]),
        ("unheard_of", 1.0), ("q_start", {"a": 1}), ("q_start", "fist"),
    ],
)  # fmt: skip
def test_plans_that_are_not_as_they_should_be(small, tmp_path, field, value):
    path = tmp_path / "b.npz"
    damaged(small, path, lambda metadata, _: metadata["plans"][0].update({field: value}))
    refused(path)


@pytest.mark.parametrize("stored", [["a plan"], [None], [[1.0]], [{}], [], None, 3])
def test_what_is_no_plan(small, tmp_path, stored):
    path = tmp_path / "b.npz"
    damaged(small, path, lambda metadata, _: metadata.update(plans=stored))
    refused(path)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), None, "much"])
def test_measures_that_are_no_numbers(small, tmp_path, value):
    path = tmp_path / "b.npz"
    damaged(small, path, lambda m, _: m["traces"][-1]["measures"].update(lift_m=value))
    refused(path)


@pytest.mark.parametrize("how", ["empty", "gone"])
def test_a_grasp_without_its_measures(small, tmp_path, how):
    def spoil(metadata, _):
        if how == "gone":
            del metadata["traces"][-1]["measures"]
        else:
            metadata["traces"][-1]["measures"] = {}

    path = tmp_path / "b.npz"
    damaged(small, path, spoil)
    refused(path)


@pytest.mark.parametrize("what", ["environment", "handsim", "inputs", "traces", "plans"])
def test_parts_that_are_missing(small, tmp_path, what):
    path = tmp_path / "b.npz"
    damaged(small, path, lambda metadata, _: metadata.pop(what))
    refused(path)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("where", ["posture", "measure", "frames"])
def test_nothing_that_is_no_number_is_written(small, tmp_path, bad, where):
    path = tmp_path / "b.npz"
    write_baseline(small, path)
    kept = path.read_bytes()
    name = f"grasp/{TASK}"
    trace = small.results.traces[name]
    broken = {
        "posture": replace(trace, q=np.where(np.arange(22) == 3, bad, trace.q)),
        "measure": replace(trace, measures=trace.measures | {"hold_s": bad}),
        "frames": replace(trace, q=trace.q[:0], time=trace.time[:0]),
    }[where]
    results = replace(small.results, traces=small.results.traces | {name: broken})
    with pytest.raises(InputError, match=rf"{name} .* nothing is written"):
        write_baseline(replace(small, results=results), path)
    assert path.read_bytes() == kept
    assert list(tmp_path.iterdir()) == [path]


def test_the_first_schema_is_read():
    old, new = (read_baseline(KEPT / f"baseline-{schema}.npz") for schema in (1, 2))
    assert old.environment.mujoco
    assert not old.environment.blas_kernel
    assert new.environment.blas_kernel
    assert old.handsim == new.handsim == "0.1.0"
    assert old.cases.plans[TASK].squeeze == pytest.approx(new.cases.plans[TASK].squeeze, abs=1)
    assert "schema" not in old.results.inputs
    assert new.results.inputs["schema"] == "2"
