"""The tables of grasps: rows made by hand, of all sets or of some."""

import pytest

from handsim.tasks.rules import Outcome
from tests.benchmarks.human_grasps import NOMINAL, Trial, by_task, summary


def trial(kind: str, seed: int, success: bool = True, task: str = "cube-raise") -> Trial:
    outcome = Outcome(
        success, None if success else "slipped", 0.1, 0.0, 0.0, 1.0, 3, 0.0,
        forces_n={"thumb": 6.0}, need_n=3.0, table_force_n=4.0, strain=0.5,
    )  # fmt: skip
    return Trial("someone", task, kind, seed, outcome)


def test_all_that_was_run_is_summed_up() -> None:
    nominal = [trial("nominal", seed, seed != NOMINAL[0]) for seed in NOMINAL]
    lines = summary([*nominal, trial("friction", 301), trial("friction", 302, False)]).splitlines()
    assert lines[0] == "nominal, ten seeds: 0.9 of 24 tasks, worst 0"
    assert lines[1].startswith("friction: 1 of 2, 50 % (")
    assert lines[2].startswith("thumb in the hold, lifted things: 2.0 times the need in the median")
    assert "table 4 N at most; strain of the arm 0.50 in the median" in lines[2]
    assert len(lines) == 3


@pytest.mark.parametrize(
    ("trials", "n_lines"),
    [
        ([trial("perturbed", 101)], 1),
        ([trial("nominal", 5001, success=False)], 1),
        ([trial("nominal", 5001, task="mouse-slide")], 2),
        ([], 0),
    ],
)
def test_what_was_not_run_is_not_summed_up(trials: list[Trial], n_lines: int) -> None:
    assert len(summary(trials).splitlines()) == n_lines
    assert "times the need" not in summary(trials)


def test_the_table_by_task_has_the_sets_that_were_run() -> None:
    header, _, *rows = by_task([trial("perturbed", 101), trial("perturbed", 102, False)]).split(
        "\n"
    )
    assert header == "| task | perturbed |"
    assert "| cube-raise | 1/2 |" in rows and "| pen-write | 0/0 |" in rows
