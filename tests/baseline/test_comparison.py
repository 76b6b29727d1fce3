"""Whatever differs between two sets of answers is found, named and put in order."""

import json
from dataclasses import replace

import numpy as np
import pytest

from handsim.baseline.comparison import (
    compare,
    deviation_deg,
    not_numbers,
    trace_change,
    unusable,
)
from handsim.baseline.environment import Environment
from handsim.baseline.results import Results, Trace
from handsim.baseline.tolerances import ENVIRONMENT_LIMITS, MEASURES, Tolerances
from handsim.joints import JOINT_NAMES, N_JOINTS

HASWELL = Environment(
    processor="AMD EPYC", numpy="1.0", mujoco="4.0.0", blas_kernel="Haswell", blas_threads="2"
)
SANDYBRIDGE = replace(HASWELL, blas_kernel="Sandybridge")
OTHER = replace(SANDYBRIDGE, blas_threads="1", numpy="2.0", mujoco="3.17.0")


def trace(*angles: float, verdict: str = "arrived", **measures: float) -> Trace:
    q = np.zeros((len(angles), N_JOINTS))
    q[:, 3] = np.deg2rad(angles)
    return Trace(np.arange(len(angles)) / 10, q, verdict, measures)


def held(*angles: float, **measures: float) -> Trace:
    return trace(*angles, verdict="held", **(dict.fromkeys(MEASURES, 0.5) | measures))


def compared(before: Trace, after: Trace, name="movement/a", **options):
    """Compare one answer."""
    return compare(Results({name: before}, {}), Results({name: after}, {}), **options)


def kinds(report) -> list[str]:
    return [finding.kind for finding in report.findings]


def test_deviation_joint_and_time_by_hand():
    report = compared(trace(0, 10, 20), trace(0, 10, 20, 26))
    (change,) = report.changes
    assert change.joint == JOINT_NAMES[3]
    assert change.deviation_deg == pytest.approx(6.0)
    assert change.time_s == pytest.approx(0.3)
    # Each over its own length the paths of 20 and 26 deg are 6 s deg apart at s, from 0 to 1.
    assert change.path_deg == pytest.approx(6 / 3**0.5, rel=0.01)
    assert kinds(report) == ["shape", "movement"]
    assert report.findings[0].text == "3 frames to 0.20 s in the baseline, 4 to 0.30 s now"


def test_deviation_is_of_all_joints_at_all_times_of_both():
    before, after = trace(0, 10), trace(0, 10)
    after.time[1] = 0.05
    after.q[1, 7] = np.deg2rad(-3.0)
    time, apart = deviation_deg(before, after)
    np.testing.assert_allclose(time, [0, 0.05, 0.1])
    np.testing.assert_allclose(apart[:, 3], [0, 5, 0], atol=1e-12)
    np.testing.assert_allclose(apart[:, 7], [0, 3, 3], atol=1e-12)


def test_the_same_is_within_and_has_no_findings():
    for name, one in (("movement/a", trace(0, 5)), ("grasp/a", held(0, 5))):
        report = compared(one, one, name)
        assert report.ok
        assert report.changes[0].within
        assert report.as_text() == "1 answer as in the baseline"


@pytest.mark.parametrize(
    ("name", "limit"),
    [
        ("movement/a", "replayed_deg"),
        ("relearned/a", "relearned_deg"),
        ("grasp/a", "simulated_deg"),
    ],
)
@pytest.mark.parametrize("tolerances", [Tolerances(), Tolerances(0.5, 0.02, 0.3)])
def test_each_kind_of_answer_has_its_tolerance(name, limit, tolerances):
    start = held(0, 10) if name.startswith("grasp") else trace(0, 10)
    for factor, found in ((0.98, []), (-0.98, []), (1.02, ["movement"]), (-1.02, ["movement"])):
        q = start.q.copy()
        q[1, 3] += np.deg2rad(factor * getattr(tolerances, limit))
        report = compared(start, replace(start, q=q), name, tolerances=tolerances)
        assert kinds(report) == found
        assert report.changes[0].within == (not found)


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("scale", [1.0, 0.1])
def test_each_measure_has_its_tolerance(measure, scale):
    tolerances = Tolerances(measures={name: scale * limit for name, limit in MEASURES.items()})
    limit = scale * MEASURES[measure]
    for change, found in ((0.98, []), (-0.98, []), (1.02, ["measure"]), (-1.02, ["measure"])):
        after = held(0, 10, **{measure: 0.5 + change * limit})
        report = compared(held(0, 10), after, "grasp/a", tolerances=tolerances)
        assert kinds(report) == found
        assert all(finding.text.startswith(f"{measure} 0.5 in") for finding in report.findings)
        assert report.changes[0].within == (not found)


def test_a_measure_without_a_tolerance_may_not_move():
    before, after = held(0, 1, width_m=1.0), held(0, 1, width_m=1.0 + 1e-12)
    assert kinds(compared(before, after, "grasp/a")) == ["measure"]


BAD = [np.nan, np.inf, -np.inf]


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize("verdict", ["held", "slipped"])
@pytest.mark.parametrize("where", [(1, 0), (0, 1), (1, 1)], ids=["kept", "new", "both"])
def test_a_posture_that_is_no_number_equals_nothing(bad, verdict, where):
    traces = [replace(held(0, 10), verdict=verdict) for _ in range(2)]
    for one, spoiled in zip(traces, where, strict=True):
        if spoiled:
            one.q[1, 5] = bad
    report = compared(*traces, "grasp/a", environments=(HASWELL, SANDYBRIDGE))
    assert kinds(report) == ["number"] * sum(where)
    assert f"is no number in 1 of 2 frames, first {JOINT_NAMES[5]}" in report.findings[0].text
    assert report.findings[0].text.endswith("in the baseline" if where[0] else "now")
    assert report.n_answers == 1
    assert not report.changes


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize("verdict", ["held", "slipped"])
@pytest.mark.parametrize("where", [(1, 0), (0, 1), (1, 1)], ids=["kept", "new", "both"])
@pytest.mark.parametrize("measure", MEASURES)
def test_a_measure_that_is_no_number_equals_nothing(bad, verdict, where, measure):
    traces = [
        replace(held(0, 10, **({measure: bad} if spoiled else {})), verdict=verdict)
        for spoiled in where
    ]
    report = compared(*traces, "grasp/a", environments=(HASWELL, SANDYBRIDGE))
    assert kinds(report) == ["measure"]
    assert report.findings[0].text.startswith(measure)
    assert report.findings[0].harm == np.inf
    assert not report.changes[0].within


@pytest.mark.parametrize("verdict", ["held", "slipped"])
def test_measures_that_vanish_or_appear_are_named(verdict):
    full = replace(held(0, 10), verdict=verdict)
    measures = {name: value for name, value in full.measures.items() if name != "hold_s"}
    less = replace(full, measures=measures)
    for pair, kind in (((full, less), "missing"), ((less, full), "new")):
        report = compared(*pair, "grasp/a", environments=(HASWELL, SANDYBRIDGE))
        assert kinds(report) == [kind]
        assert report.findings[0].text.startswith("hold_s ")
        assert not report.changes[0].within


def test_answers_that_vanish_or_appear_are_named():
    one, none = Results({"movement/a": trace(0, 1)}, {}), Results({}, {})
    for pair, kind, text in (
        ((one, none), "missing", "not made any more"), ((none, one), "new", "no such answer")
    ):  # fmt: skip
        report = compare(*pair, environments=(HASWELL, SANDYBRIDGE))
        assert [(f.kind, f.name) for f in report.findings] == [(kind, "movement/a")]
        assert text in report.findings[0].text
        assert report.n_answers == 1
        assert not report.ok


EMPTY = Trace(np.zeros(0), np.zeros((0, N_JOINTS)), "arrived")
TOO_FEW_JOINTS = replace(trace(0, 1), q=np.zeros((2, N_JOINTS - 1)))
FLAT = replace(trace(0, 1), q=np.zeros(2))
TOO_FEW_TIMES = replace(trace(0, 1), time=np.zeros(1))
TIMES_OF_TIMES = replace(trace(0, 1), time=np.array([[0.0, 1.0], [0.0, 1.0]]))
BACKWARDS = replace(trace(0, 1), time=np.array([0.1, 0.0]))
STANDING = replace(trace(0, 1), time=np.array([0.1, 0.1]))
TIMELESS = replace(trace(0, 1), time=np.array([0.0, np.nan]))
ENDLESS = replace(trace(0, 1), time=np.array([0.0, np.inf]))


@pytest.mark.parametrize(
    ("odd", "says"),
    [
        (EMPTY, "has no frames"),
        (TOO_FEW_JOINTS, f"shape (2, {N_JOINTS - 1})"),
        (FLAT, "shape (2,)"),
        (TOO_FEW_TIMES, "times of shape (1,)"),
        (TIMES_OF_TIMES, "times of shape (2, 2)"),
        (BACKWARDS, "do not increase"),
        (STANDING, "do not increase"),
        (TIMELESS, "do not increase"),
        (ENDLESS, "do not increase"),
    ],
)  # fmt: skip
def test_answers_of_another_shape_are_named(odd, says):
    for pair, n in (((odd, trace(0, 1)), 1), ((trace(0, 1), odd), 1), ((odd, odd), 2)):
        report = compared(*pair, environments=(HASWELL, SANDYBRIDGE))
        assert kinds(report) == ["shape"] * n
        assert says in report.findings[0].text
    assert unusable(trace(0, 1)) == []
    assert not_numbers(Results({"movement/a": odd}, {})) == [f"movement/a {unusable(odd)[0]}"]


def test_what_is_no_number_is_listed():
    results = Results({"a": held(0, 1), "b": held(0, 1, lift_m=np.nan), "c": held(0, np.inf)}, {})
    said = not_numbers(results)
    assert said[0] == "b has lift_m nan"
    assert said[1].startswith("c is no number")
    assert len(said) == 2


def test_an_answer_that_lasts_longer_is_named():
    before, after = trace(0, 10, 10), trace(0, 10, 10, 10)
    assert kinds(compared(before, after)) == ["shape"]
    loose = Tolerances(90.0, 90.0, 90.0)
    for factor in (0.999, 1.001):
        report = compared(before, replace(before, time=before.time * factor), tolerances=loose)
        assert kinds(report) == ["shape"]
        assert not report.changes[0].within
    denser = replace(trace(0, 5, 10, 10, 10), time=np.arange(5) / 20)
    assert kinds(compared(before, denser)) == ["shape"]
    shaken = replace(before, time=before.time + 1e-9)
    assert compared(before, shaken).ok


def test_of_a_grasp_that_fails_only_the_outcome_counts():
    good, failed = (replace(held(0, 10), verdict=verdict) for verdict in ("held", "slipped"))
    for before, found in ((good, 6), (failed, 0)):
        measures = {name: value + 10 for name, value in before.measures.items()}
        moved = replace(before, q=before.q + 1, measures=measures)
        assert len(compared(before, moved, "grasp/a").findings) == found
    longer = replace(held(0, 10, 20), verdict="slipped")
    assert compared(failed, longer, "grasp/a").ok
    # A movement that does not arrive is compared all the same.
    stuck = trace(0, 10, verdict="stuck")
    assert kinds(compared(stuck, replace(stuck, q=stuck.q + 1))) == ["movement"]


def test_an_outcome_that_was_good_comes_before_others():
    verdicts = {"a": ("slipped", "dropped"), "b": ("held", "slipped"), "c": ("slipped", "held")}
    before, after = (
        Results({f"grasp/{n}": replace(held(0, 1), verdict=v[i]) for n, v in verdicts.items()}, {})
        for i in (0, 1)
    )
    report = compare(before, after)
    assert [finding.name for finding in report.findings] == ["grasp/b", "grasp/a", "grasp/c"]
    assert report.findings[0].text == "held in the baseline, slipped now"
    arrived = {"z": trace(0, 1), "a": replace(trace(0, 1), verdict="stuck")}
    other = {n: replace(t, verdict="too long") for n, t in arrived.items()}
    report = compare(Results(arrived, {}), Results(other, {}))
    assert [finding.name for finding in report.findings] == ["z", "a"]


def test_findings_are_in_order():
    before = {
        "grasp/outcome": held(0, 1), "grasp/measure": held(0, 1), "grasp/missing": held(0, 1),
        "movement/small": trace(0, 1), "movement/large": trace(0, 1), "movement/nan": trace(0, 1),
    }  # fmt: skip
    after = {
        "grasp/outcome": replace(held(0, 1), verdict="slipped"),
        "grasp/measure": held(0, 1, lift_m=0.9), "movement/small": trace(0, 2),
        "movement/large": trace(0, 5), "movement/nan": trace(0, np.nan),
        "movement/new": trace(0, 1),
    }  # fmt: skip
    report = compare(Results(before, {"x/y": "1"}), Results(after, {"x/y": "2"}))
    assert [(f.kind, f.name) for f in report.findings] == [
        ("outcome", "grasp/outcome"),
        ("missing", "grasp/missing"),
        ("new", "movement/new"),
        ("number", "movement/nan"),
        ("movement", "movement/large"),
        ("movement", "movement/small"),
        ("measure", "grasp/measure"),
        ("input", "x"),
    ]
    assert report.n_answers == 7
    assert report.as_text().startswith("8 findings in 7 answers, worst first\noutcome ")


def test_measures_are_in_order_of_their_relative_change():
    before, after = held(0, 1), held(0, 1, lift_m=0.6, hold_s=0.1, peak_tilt_deg=9.0)
    report = compared(before, after, "grasp/a")
    assert [f.text.split()[0] for f in report.findings] == ["peak_tilt_deg", "hold_s", "lift_m"]


def test_inputs_are_told_by_group():
    before = {"x/a": "1", "x/b": "1", "y/a": "1", "z/a": "1", "condition/seed": "0"}
    after = {"x/a": "2", "x/b": "2", "y/b": "1", "z/a": "1", "condition/seed": "3"}
    report = compare(Results({}, before), Results({}, after))
    assert {(f.name, f.text) for f in report.findings} == {
        ("x", "changed (a, b)"),
        ("y", "is gone (a)"),
        ("y", "is new (b)"),
        ("condition/seed", "0 in the baseline, 3 now"),
    }
    assert report.findings[0].name == "x"
    ignored = compare(Results({}, before), Results({}, after), ignore_inputs=True, notes=("n",))
    assert ignored.ok
    assert len(ignored.notes) == 5
    many = {f"x/{i}": "1" for i in range(8)}
    (told,) = compare(Results({}, many), Results({}, {})).findings
    assert told.text == "is gone (0, 1, 2, 3, 4, 5 and 2 more)"


def test_inputs_kept_in_another_way_are_not_said_to_be_the_same():
    report = compare(Results({}, {"x/y": "1"}), Results({}, {"schema": "2", "x/y": "1"}))
    (finding,) = report.findings
    assert (finding.kind, finding.name) == ("input", "inputs")
    assert "record the baseline again" in finding.text


@pytest.mark.parametrize("name", ["movement/a", "relearned/a", "grasp/a"])
def test_a_hundredth_of_a_degree_elsewhere_is_a_difference_of_environment(name):
    start = held(0, 10) if name.startswith("grasp") else trace(0, 10)
    after = replace(start, q=start.q + np.deg2rad([[0.0], [0.01]]))
    tight = Tolerances(0.001, 0.001, 0.001)
    report = compared(start, after, name, tolerances=tight, environments=(HASWELL, SANDYBRIDGE))
    (finding,) = report.findings
    assert finding.kind == "environment"
    assert finding.text.startswith(
        "a difference of environment: BLAS kernel Haswell in the baseline, Sandybridge here; "
    )
    assert "by 0.01 deg" in finding.text
    assert report.as_text().splitlines()[0] == (
        "environment: BLAS kernel Haswell in the baseline, Sandybridge here"
    )
    said = json.loads(json.dumps(report.as_dict()["environment"]))
    assert said["before"]["blas_kernel"] == "Haswell"
    assert said["now"]["blas_kernel"] == "Sandybridge"
    assert said["differences"] == ["BLAS kernel Haswell in the baseline, Sandybridge here"]
    for environments in (None, (HASWELL, HASWELL)):
        report = compared(start, after, name, tolerances=tight, environments=environments)
        assert kinds(report) == ["movement"]
        assert not report.differences
        assert report.as_dict()["environment"]["differences"] == []


def test_within_the_tolerance_another_environment_is_said_and_no_finding():
    report = compared(trace(0, 10), trace(0, 10.0005), environments=(HASWELL, OTHER))
    assert report.ok
    *lines, head = report.as_text().splitlines()
    assert head == "1 answer as in the baseline"
    assert lines == [f"environment: {difference}" for difference in report.differences]
    assert lines[0] == "environment: numpy 1.0 in the baseline, 2.0 here"
    assert len(lines) == 4


def test_measures_elsewhere_are_a_difference_of_environment_too():
    for factor, kind in ((1.5, "environment"), (2.5, "measure")):
        after = held(0, 10, lift_m=0.5 + factor * MEASURES["lift_m"])
        report = compared(held(0, 10), after, "grasp/a", environments=(HASWELL, OTHER))
        assert kinds(report) == [kind]


def test_environment_explains_little_and_nothing_where_something_else_differs():
    elsewhere = (HASWELL, SANDYBRIDGE)
    start = trace(0, 10)
    limit = ENVIRONMENT_LIMITS.replayed_deg
    assert kinds(compared(start, trace(0, 10 + 0.98 * limit), environments=elsewhere)) == [
        "environment"
    ]
    far = trace(0, 10 + 1.02 * limit)
    assert kinds(compared(start, far, environments=elsewhere)) == ["movement"]
    other_verdict = replace(trace(0, 10.01), verdict="stuck")
    assert kinds(compared(start, other_verdict, environments=elsewhere)) == ["outcome", "movement"]
    # Both a joint and a measure have to be near for either to be explained.
    after = held(0, 10.01, lift_m=0.9)
    tight = Tolerances(simulated_deg=0.001)
    found = compared(held(0, 10), after, "grasp/a", tolerances=tight, environments=elsewhere)
    assert kinds(found) == ["movement", "measure"]
    for ignore, expected in ((False, ["movement", "input"]), (True, ["movement"])):
        report = compare(
            Results({"movement/a": start}, {"x/y": "1"}),
            Results({"movement/a": trace(0, 10.01)}, {"x/y": "2"}),
            environments=elsewhere,
            ignore_inputs=ignore,
        )
        assert kinds(report) == expected


def test_environment_comes_first():
    before = {"movement/a": trace(0, 10), "movement/b": trace(0, 10)}
    after = {"movement/a": trace(0, 10.01), "movement/b": replace(trace(0, 10), verdict="stuck")}
    report = compare(Results(before, {}), Results(after, {}), environments=(HASWELL, SANDYBRIDGE))
    assert kinds(report) == ["environment", "outcome"]


def test_many_differences_of_environment_are_told_in_short():
    report = compared(trace(0, 10), trace(0, 10.01), environments=(HASWELL, OTHER))
    assert " and 2 more; " in report.findings[0].text


def test_the_time_of_the_largest_deviation():
    change = trace_change("movement/a", trace(0, 10, 0), trace(0, 14, 1), Tolerances())
    assert (change.time_s, change.deviation_deg) == (0.1, pytest.approx(4.0))
