"""Many findings of one cause are one line, which names what changed."""

import pytest

from handsim.baseline.causes import UNKNOWN, causes_of
from handsim.baseline.findings import Finding, Report

INPUTS = {
    "schema": "2",
    "controller/coefficients": "0123456789abcdef",
    "controller/options": "averaging 0.25, k 4, knots gentle",
    "controller/method": "direction",
    "recordings/cube-raise": "0123456789abcdef",
    "recordings/pen-write": "0123456789abcdef",
    "condition/friction": "1",
    "plan/cube-raise": "0123456789abcdef",
    "plan/pen-write": "0123456789abcdef",
}
NEW = "fedcba9876543210"


def moved(family: str, n: int = 48) -> list[Finding]:
    return [
        Finding("movement", f"{family}/{i}", f"ring_pip by {n - i} deg", n - i) for i in range(n)
    ]


def report(findings: list[Finding], after: dict[str, str], *elsewhere: str) -> Report:
    causes = causes_of(findings, INPUTS, INPUTS | after, elsewhere)
    return Report(tuple(findings), (), (), 100, None, causes)


@pytest.mark.parametrize(
    ("family", "after", "named"),
    [
        ("relearned", {"recordings/pen-write": NEW}, "recordings changed (pen-write)"),
        (
            "movement",
            {"recordings/pen-write": NEW, "controller/coefficients": NEW},
            "recordings changed (pen-write)",
        ),
        (
            "movement",
            {"controller/options": "averaging 0.25, k 6, knots gentle"},
            "option k 4 in the baseline, 6 now",
        ),
        (
            "movement",
            {"controller/method": "pde"},
            "option method direction in the baseline, pde now",
        ),
        ("movement", {"controller/coefficients": NEW}, "controller changed (coefficients)"),
        ("grasp", {"condition/friction": "0.4"}, "condition/friction 1 in the baseline, 0.4 now"),
    ],
)
def test_one_line_names_the_input_that_changed(family, after, named):
    group = next(iter(after)).partition("/")[0]
    said = report([*moved(family), Finding("input", group, "changed", 1.0)], after).as_text()
    assert said.splitlines() == [
        "49 findings in 100 answers, worst first",
        f"{named}: 49 findings, the worst movement {family}/0 ring_pip by 48 deg",
    ]


def test_plans_of_many_tasks_are_one_cause():
    found = [Finding("outcome", f"grasp/{task}", "held, dropped now", 2.0) for task in
             ("cube-raise", "pen-write")]  # fmt: skip
    after = {"plan/cube-raise": NEW, "plan/pen-write": NEW}
    (cause,) = causes_of(found, INPUTS, INPUTS | after)
    assert cause == ("plan changed", tuple(found))


def test_version_and_environment_are_named_where_no_input_changed():
    said = report(moved("movement"), {}, "handsim 0.1 in the baseline, 0.2 here").as_text()
    assert "handsim 0.1 in the baseline, 0.2 here; or the code: 48 findings" in said
    assert f"{UNKNOWN} (movement): 48 findings" in report(moved("movement"), {}).as_text()


def test_what_changed_elsewhere_does_not_explain_a_movement():
    said = report(moved("movement"), {"recordings/pen-write": NEW}).as_text()
    assert UNKNOWN in said and "recordings" not in said


def test_few_findings_and_details_have_a_line_each():
    few = report(moved("movement", 3), {"controller/coefficients": NEW})
    assert few.as_text() == few.as_text(details=True)
    assert len(few.as_text().splitlines()) == 4
    many = report(moved("movement"), {"controller/coefficients": NEW})
    assert len(many.as_text(details=True).splitlines()) == 49
    (cause,) = many.as_dict()["causes"]
    assert (cause["cause"], cause["findings"]) == ("controller changed (coefficients)", 48)
    assert cause["names"][0] == "movement/0"
