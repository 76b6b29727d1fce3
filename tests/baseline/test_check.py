"""A baseline notices what it is there for, and names it."""

from dataclasses import fields, replace

import numpy as np
import pytest

from handsim.baseline.check import check_baseline, record_baseline, updated
from handsim.baseline.environment import Environment
from handsim.baseline.html_page import write_page
from handsim.baseline.results import Cases, Results
from handsim.baseline.store import write_baseline
from handsim.baseline.tolerances import MEASURES, Tolerances
from handsim.errors import FileError, InputError
from handsim.grasping.conditions import Conditions
from handsim.joints import JOINT_INDEX, N_JOINTS
from handsim.navigation.bspline import TensorBSpline
from handsim.testing import assert_as_baseline

TASK = "cube-raise"
HERE = Environment.here()
ELSEWHERE = replace(HERE, blas_kernel="Another", processor="another")


def findings(report, kind):
    return [finding for finding in report.findings if finding.kind == kind]


def test_the_same_again_is_the_same_to_the_bit(baseline, controller, recordings):
    exactly = Tolerances(0.0, 0.0, 0.0, dict.fromkeys(MEASURES, 0.0))
    report, _ = check_baseline(baseline, controller, recordings, tolerances=exactly)
    assert report.ok
    assert not report.notes
    assert not report.differences
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


@pytest.mark.parametrize("environment", [HERE, ELSEWHERE], ids=["same", "other"])
@pytest.mark.parametrize("which", [np.argmax, np.argmin])
def test_one_coefficient_by_one_percent_is_a_change_everywhere(
    movements, controller, environment, which
):
    coefficients = controller.navigation.obstacle.chi.coefficients
    index = np.unravel_index(which(np.abs(coefficients)), coefficients.shape)
    kept = replace(movements, environment=environment)
    report, _ = check_baseline(kept, bent(controller, 1.01, index))
    (told,) = findings(report, "input")
    assert (told.name, told.text) == ("controller", "changed (coefficients)")
    assert not findings(report, "environment")
    assert bool(report.differences) == (environment is ELSEWHERE)


def test_answers_that_are_a_hundredth_of_a_degree_off_elsewhere(movements, controller):
    """Two environments that were planted: what they differ in is said before all else."""
    traces = {
        name: replace(
            trace, q=trace.q + np.deg2rad(0.01) * np.linspace(0, 1, len(trace.q))[:, None]
        )
        for name, trace in movements.results.traces.items()
    }
    kept = replace(
        movements, environment=ELSEWHERE, results=replace(movements.results, traces=traces)
    )
    report, _ = check_baseline(kept, controller)
    assert {finding.kind for finding in report.findings} == {"environment"}
    assert len(report.findings) == len(traces)
    assert all("BLAS kernel Another in the baseline" in f.text for f in report.findings)
    assert all("by 0.01 deg at" in finding.text for finding in report.findings)
    first, second = report.as_text().splitlines()[:2]
    assert first.startswith("environment: processor another in the baseline, ")
    assert second.startswith("environment: BLAS kernel Another in the baseline, ")
    unmoved, _ = check_baseline(replace(movements, environment=ELSEWHERE), controller)
    assert unmoved.ok
    assert len(unmoved.differences) == 2


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
    assert len(worst) == len(movements.cases.starts)
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


def test_an_object_that_is_turned_is_named(grasps, controller):
    turned = replace(Conditions(), object_offset=(0.0, 0.0, 0.3))
    report, _ = check_baseline(grasps, controller, conditions=turned)
    told = {finding.name: finding.text for finding in findings(report, "input")}
    assert told["condition/object_offset"] == "0, 0, 0 in the baseline, 0, 0, 0.3 now"
    assert "scene geometry" in told


@pytest.mark.ci
@pytest.mark.slow
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
    assert report.as_dict()["findings"][0]["name"] == first.name


def test_a_destination_refused_is_an_outcome(movements, controller):
    name = next(iter(movements.cases.goals))
    goals = movements.cases.goals | {name: np.full(N_JOINTS, 3.0)}
    cases = Cases(movements.cases.starts, goals, {})
    report, _ = check_baseline(replace(movements, cases=cases), controller)
    assert report.findings[0].kind == "outcome"
    assert "refused" in report.findings[0].text


def test_an_answer_that_is_no_number_is_found(movements, controller):
    class Broken:
        """A subspace that lifts the middle finger to nowhere."""

        def __getattr__(self, name):
            return getattr(controller.subspace, name)

        def inverse_transform(self, z):
            q = controller.subspace.inverse_transform(z)
            q[..., JOINT_INDEX["middle_pip"]] = np.nan
            return q

    report, results = check_baseline(movements, replace(controller, subspace=Broken()))
    told = findings(report, "number")
    assert len(told) == len(movements.cases.starts)
    assert all("first middle_pip at 0.00 s now" in finding.text for finding in told)
    with pytest.raises(InputError, match=r"is no number .* the baseline stays"):
        updated(movements, results, "it is new")


def test_another_handsim_is_noted_and_not_counted(movements, controller):
    report, _ = check_baseline(replace(movements, handsim="0.0.1"), controller)
    assert report.ok
    (note,) = report.notes
    assert note.startswith("handsim 0.0.1 in the baseline, ")


def test_an_update_needs_a_reason_and_keeps_it(movements):
    with pytest.raises(InputError, match="needs a reason"):
        updated(movements, movements.results, "  ")
    old = replace(movements, environment=ELSEWHERE, handsim="0.0.1")
    after = updated(old, Results({}, {}), "new spline")
    assert after.reasons == ("recorded", "new spline")
    assert after.results.traces == {}
    assert (after.environment, after.handsim) == (HERE, movements.handsim)


def test_learning_is_not_skipped_silently(baseline, controller):
    with pytest.raises(InputError, match="recordings"):
        check_baseline(baseline, controller)


def test_the_page_shows_the_curves_and_nothing_from_elsewhere(movements, controller, tmp_path):
    traces = dict(movements.results.traces)
    name, nan, *_ = traces
    traces[name] = replace(traces[name], q=traces[name].q * 0.9)
    traces[nan] = replace(traces[nan], q=traces[nan].q * np.nan)
    kept = replace(
        movements, results=Results(traces, movements.results.inputs), environment=ELSEWHERE
    )
    report, results = check_baseline(kept, controller)
    write_page(tmp_path / "check.html", kept, results, report)
    text = (tmp_path / "check.html").read_text()
    assert name in text
    assert text.count("data:image/svg+xml") == 1
    assert "http" not in text.replace("http://www.w3.org", "")
    said = text.index("BLAS kernel Another in the baseline")
    assert said < text.index("What moved</h2>")
    for field in fields(Environment):
        assert getattr(HERE, field.name) in text


def test_from_the_suite_of_a_user(movements, controller, tmp_path):
    path = tmp_path / "b.npz"
    write_baseline(movements, path)
    assert assert_as_baseline(controller, path).ok
    controller.save(tmp_path / "c.npz")
    assert assert_as_baseline(tmp_path / "c.npz", path).ok
    assert assert_as_baseline(str(tmp_path / "c.npz"), str(path)).ok
    with pytest.raises(FileError, match="no such file"):
        assert_as_baseline("nowhere.npz", path)
    other = replace(bent(controller, 1.5), guide=None)  # whose flow is followed
    with pytest.raises(AssertionError) as failed:
        assert_as_baseline(other, path)
    lines = str(failed.value).splitlines()
    assert "findings in" in lines[0]
    assert lines[1].startswith("option common 0.3 in the baseline, none now")
    assert "the worst movement movement/" in lines[1]
    assert "deg at" in lines[1]


def test_answers_are_of_the_recorded_questions(controller, plans):
    made = record_baseline(controller, plans)
    assert set(made.results.traces) == {
        *(f"movement/{name}" for name in made.cases.starts), f"grasp/{TASK}"
    }  # fmt: skip
    assert set(made.results.traces[f"grasp/{TASK}"].measures) == set(MEASURES)
    assert made.environment == HERE
