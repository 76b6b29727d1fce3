"""A baseline notices what it is there for, and names it."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.baseline.check import check_baseline, record_baseline, updated
from handsim.baseline.comparison import Tolerances, compare
from handsim.baseline.inputs import scene_inputs
from handsim.baseline.outputs import Outputs, Questions, Trace
from handsim.baseline.page import write_page
from handsim.baseline.store import read_baseline, write_baseline
from handsim.errors import FileError, InputError
from handsim.files import data_folder, read_archive, write_archive
from handsim.hand.tasks import task_by_name
from handsim.joints import JOINT_INDEX, JOINT_NAMES, N_JOINTS
from handsim.learning.bspline import TensorBSpline
from handsim.learning.controller import GraspController
from handsim.motion.recording import read_recordings
from handsim.simulation.closed_loop import Stage
from handsim.simulation.conditions import Conditions
from handsim.simulation.plan_store import PlanStore
from handsim.testing import assert_as_baseline

TASK = "cube-raise"


@pytest.fixture(scope="module")
def controller():
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="module")
def recordings():
    return read_recordings(data_folder("assets") / "experiments")


@pytest.fixture(scope="module")
def plans():
    for path in sorted((data_folder("assets") / "plans").glob("*.json")):
        stored = PlanStore(path).read()
        if TASK in stored:
            return {TASK: stored[TASK]}
    raise AssertionError(f"no plan of {TASK} is stored")


@pytest.fixture(scope="module")
def baseline(controller, recordings, plans):
    return record_baseline(controller, plans, recordings)


@pytest.fixture(scope="module")
def movements(controller):
    return record_baseline(controller)


@pytest.fixture(scope="module")
def grasps(controller, plans):
    return replace(record_baseline(controller, plans), questions=Questions({}, {}, plans))


def findings(report, kind):
    return [finding for finding in report.findings if finding.kind == kind]


def test_the_same_again_is_the_same_to_the_bit(baseline, controller, recordings):
    exactly = Tolerances(0.0, 0.0, dict.fromkeys(Tolerances().measures, 0.0))
    report, _ = check_baseline(baseline, controller, recordings, tolerances=exactly)
    assert report.ok
    assert not report.notes
    assert max(change.deviation_deg for change in report.changes) == 0.0
    assert {change.name.split("/")[0] for change in report.changes} == {
        "movement", "relearned", "grasp"
    }  # fmt: skip


def bent(controller, factor, index=...):
    """The controller with coefficients of its spline multiplied by a factor."""
    obstacle = controller.navigation.obstacle
    coefficients = obstacle.chi.coefficients.copy()
    coefficients[index] *= factor
    changed = replace(obstacle, chi=TensorBSpline(obstacle.chi.basis, coefficients))
    return replace(controller, navigation=replace(controller.navigation, obstacle=changed))


def test_one_coefficient_by_one_percent(movements, controller):
    coefficients = controller.navigation.obstacle.chi.coefficients
    largest = np.unravel_index(np.abs(coefficients).argmax(), coefficients.shape)
    report, _ = check_baseline(movements, bent(controller, 1.01, largest))
    assert not report.ok
    (told,) = findings(report, "input")
    assert (told.name, told.text) == ("controller", "changed (coefficients)")


def test_the_sign_of_a_joint_swapped(movements, controller):
    joint = JOINT_INDEX["index_mcp"]
    sign = np.ones(N_JOINTS)
    sign[joint] = -1

    class Swapped:
        """The subspace of a hand whose index finger bends the other way."""

        def __getattr__(self, name):
            return getattr(controller.subspace, name)

        def inverse_transform(self, z):
            return controller.subspace.inverse_transform(z) * sign

    report, _ = check_baseline(movements, replace(controller, subspace=Swapped()))
    worst = findings(report, "movement")
    assert len(worst) == len(movements.questions.starts)
    assert all(finding.text.startswith("index_mcp by ") for finding in worst)
    sizes = [float(finding.text.split()[2]) for finding in worst]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] > 10


def test_friction_changed_by_thirty_percent(grasps, controller):
    rough = replace(Conditions(), friction=1.3 * Conditions().friction)
    report, _ = check_baseline(grasps, controller, conditions=rough)
    told = {finding.name: finding.text for finding in findings(report, "input")}
    assert set(told) == {"scene friction", "condition/friction"}
    assert TASK in told["scene friction"]
    assert told["condition/friction"] == "0.8 in the baseline, 1.04 now"


def test_a_recording_dropped(baseline, controller, recordings):
    report, _ = check_baseline(baseline, controller, recordings.without(0))
    assert f"is gone ({recordings[0].name})" in {f.text for f in findings(report, "input")}
    moved = {finding.name.split("/")[0] for finding in findings(report, "movement")}
    assert moved == {"relearned"}


def test_a_grasp_that_fails_comes_first(grasps, controller):
    wet = replace(Conditions(), friction=0.05)
    report, _ = check_baseline(grasps, controller, conditions=wet)
    first = report.findings[0]
    assert (first.kind, first.name) == ("outcome", f"grasp/{TASK}")
    assert first.text.startswith("held in the baseline, ")
    lines = report.as_text().splitlines()
    assert first.text in lines[1]
    assert report.as_json()["findings"][0]["name"] == first.name


def test_a_destination_refused_is_an_outcome(movements, controller):
    name = next(iter(movements.questions.goals))
    goals = movements.questions.goals | {name: np.full(N_JOINTS, 3.0)}
    questions = Questions(movements.questions.starts, goals, {})
    report, _ = check_baseline(replace(movements, questions=questions), controller)
    assert report.findings[0].kind == "outcome"
    assert "refused" in report.findings[0].text


def test_scenes_of_other_masses_are_named(plans):
    light, heavy = (
        scene_inputs(Stage.build(task_by_name(TASK), replace(Conditions(), mass_scale=scale)))
        for scale in (1.0, 1.2)
    )
    differing = {name for name in light if light[name] != heavy[name]}
    assert differing == {f"scene masses/{TASK}", "condition/mass_scale"}


def trace(*angles: float) -> Trace:
    q = np.zeros((len(angles), N_JOINTS))
    q[:, 3] = np.deg2rad(angles)
    return Trace(np.arange(len(angles)) / 10, q, "arrived")


def test_deviation_joint_and_time_by_hand():
    before, after = trace(0, 10, 20), trace(0, 10, 20, 26)
    report = compare(Outputs({"movement/a": before}, {}), Outputs({"movement/a": after}, {}))
    (change,) = report.changes
    assert change.joint == JOINT_NAMES[3]
    assert change.deviation_deg == pytest.approx(6.0)
    assert change.time_s == pytest.approx(0.3)
    # Each over its own length the paths of 20 and 26 deg are 6 s deg apart at s, from 0 to 1.
    assert change.path_deg == pytest.approx(6 / 3**0.5, rel=0.01)


def test_of_a_grasp_that_fails_only_the_outcome_counts():
    held, failed = (replace(trace(0, 10), verdict=verdict) for verdict in ("held", "slipped"))
    for before, found in ((held, 1), (failed, 0)):
        moved = replace(before, q=before.q + 1)
        assert (
            len(compare(Outputs({"grasp/a": before}, {}), Outputs({"grasp/a": moved}, {})).findings)
            == found
        )


def test_what_is_not_made_any_more_is_named():
    report = compare(Outputs({"movement/a": trace(0, 1)}, {"x/y": "1"}), Outputs({}, {}))
    assert [(f.kind, f.name) for f in report.findings] == [
        ("missing", "movement/a"),
        ("input", "x"),
    ]
    assert compare(
        Outputs({}, {"x/y": "1"}), Outputs({}, {"x/y": "2"}), ignore_inputs=True
    ).notes == ("x changed (y)",)


def test_versions_are_noted_and_not_counted():
    report = compare(Outputs({}, {}), Outputs({}, {}), versions=({"mujoco": "3"}, {"mujoco": "4"}))
    assert report.ok
    assert report.notes == ("mujoco 3 in the baseline, 4 here",)


def test_a_baseline_is_read_as_it_was_written(baseline, tmp_path):
    path = tmp_path / "b.npz"
    write_baseline(baseline, path)
    read = read_baseline(path)
    assert read.outputs.inputs == baseline.outputs.inputs
    assert (read.versions, read.reasons) == (baseline.versions, baseline.reasons)
    for name, one in baseline.outputs.traces.items():
        other = read.outputs.traces[name]
        np.testing.assert_array_equal(other.q, one.q)
        assert (other.verdict, other.measures) == (one.verdict, one.measures)
    plan, same = baseline.questions.plans[TASK], read.questions.plans[TASK]
    np.testing.assert_array_equal(same.palm.quat, plan.palm.quat)
    assert (same.squeeze, same.arrive) == (plan.squeeze, plan.arrive)


@pytest.mark.parametrize("name", ["starts", "plans", "q_0", "time_0"])
def test_damaged_baselines_are_refused(movements, tmp_path, name):
    path = tmp_path / "b.npz"
    write_baseline(movements, path)
    metadata, arrays = read_archive(path, "baseline", 1)
    arrays[name] = np.full((2, 3), np.nan)
    write_archive(path, "baseline", 1, metadata, arrays)
    with pytest.raises(FileError, match="record it again"):
        read_baseline(path)


def test_an_update_needs_a_reason_and_keeps_it(movements):
    with pytest.raises(InputError, match="needs a reason"):
        updated(movements, movements.outputs, "  ")
    after = updated(movements, Outputs({}, {}), "new spline")
    assert after.reasons == ("recorded", "new spline")
    assert after.outputs.traces == {}


def test_learning_is_not_skipped_silently(baseline, controller):
    with pytest.raises(InputError, match="recordings"):
        check_baseline(baseline, controller)


def test_the_page_shows_the_curves_and_nothing_from_elsewhere(movements, controller, tmp_path):
    traces = dict(movements.outputs.traces)
    name = next(iter(traces))
    traces[name] = replace(traces[name], q=traces[name].q * 0.9)
    kept = replace(movements, outputs=Outputs(traces, movements.outputs.inputs))
    report, outputs = check_baseline(kept, controller)
    write_page(tmp_path / "check.html", kept, outputs, report)
    text = (tmp_path / "check.html").read_text()
    assert name in text
    assert text.count("data:image/svg+xml") == 1
    assert "http" not in text.replace("http://www.w3.org", "")


def test_from_the_suite_of_a_user(movements, controller, tmp_path):
    path = tmp_path / "b.npz"
    write_baseline(movements, path)
    assert assert_as_baseline(controller, path).ok
    other = bent(controller, 1.5)
    with pytest.raises(AssertionError) as failed:
        assert_as_baseline(other, path)
    lines = str(failed.value).splitlines()
    assert "findings in" in lines[0]
    assert any(line.startswith("movement") and "deg at" in line for line in lines)
    assert any(line.startswith("input") and "coefficients" in line for line in lines)


def test_tolerances_are_not_negative():
    with pytest.raises(InputError, match="0 or more"):
        Tolerances(movement_deg=-1.0)


SHIPPED = data_folder("assets") / "baseline.npz"


@pytest.mark.skipif(not SHIPPED.is_file(), reason="no baseline is shipped yet")
def test_the_shipped_controller_does_what_it_did(controller, recordings):
    assert_as_baseline(controller, SHIPPED, recordings=recordings)
