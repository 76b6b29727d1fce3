"""The mutants fit the modules as they are; a sample of them is run by `make test-all`."""

import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from run import copies, report
from suites import HERE, Mutant, Suite, suites

AT_LEAST = 120
"""Of the mutants of all suites together: so few that a suite cannot vanish unnoticed."""


@pytest.mark.parametrize("suite", suites(), ids=lambda suite: suite.name)
def test_every_mutant_fits_its_module(suite: Suite) -> None:
    assert suite.mutants
    assert suite.faults() == []


def test_there_are_enough_mutants() -> None:
    assert sum(len(suite.mutants) for suite in suites()) >= AT_LEAST


def test_what_does_not_fit_is_named() -> None:
    mutants = (
        Mutant("stale", "no such text", ""),
        Mutant("double", "import", "import"),
        Mutant("broken", "MAX_SHIFT, MAX_TURN_DEG = 0.05, 15.0", "MAX_SHIFT ="),
        Mutant("idle", "MASS = 0.1", "MASS = 0.1"),
        Mutant("idle", "TIMESTEP = 2.0, 0.004", "TIMESTEP = 2.0, 0.002"),
    )
    suite = Suite(
        "made-up", "handsim/grasping/judging/six_axis.py", ("tests/nowhere.py::a",), mutants
    )
    named = suite.faults()
    for word in (
        "'stale': its text occurs 0 times",
        "'double': its text occurs",
        "'broken': invalid syntax",
        "'idle': twice",
        "'idle': changes nothing",
        "no tests at tests/nowhere.py",
    ):
        assert any(word in line for line in named), word
    assert all(line.startswith("made-up.toml: ") for line in named)


def test_what_the_runner_cannot_do_it_says() -> None:
    for bad, told in ((["--module", "nothing"], "no suite"), (["--jobs", "0"], "0 jobs")):
        ran = subprocess.run(
            [sys.executable, HERE / "run.py", *bad], capture_output=True, text=True, check=False
        )
        assert ran.returncode == 2 and told in ran.stderr


def test_what_the_report_lets_pass(capsys: pytest.CaptureFixture[str]) -> None:
    """95 % of those that a test can tell; none called equivalent though a test tells it."""
    mutants = [Mutant(f"number {i}", "a", "b") for i in range(20)]
    suite = Suite("made-up", "made/up.py", (), (*mutants, Mutant("same", "a", "b", "it is so")))
    killed = {mutant.name: "killed" for mutant in mutants} | {"same": "survived"}
    late = {"number 3": "killed by time"}
    for others, well in (
        ({}, True),
        (late | {"number 5": "survived"}, True),
        ({"number 5": "survived", "number 6": "survived"}, False),
        ({"same": "killed"}, False),
    ):
        assert report([(suite, killed | others)]) is well
        told = capsys.readouterr().out
        assert "equivalent: same (it is so)" in told
        assert ("survived: number 5" in told) is ("number 5" in others)
    assert report([(suite, killed)] * 2)
    assert "40 of 40 killed: 100.0 %" in capsys.readouterr().out


@pytest.mark.slow
def test_runs_are_of_the_copy_and_end_in_time() -> None:
    by_name = {suite.name: suite for suite in suites()}
    suite = by_name["conditions"].sample()
    with copies(1) as free:
        copy = free.get()
        source = (copy.folder / suite.module).read_text(encoding="utf-8")
        assert copy.run(suite, suite.mutants[0], 300) == "killed"
        assert copy.run(suite, None, 300) == "survived"
        assert copy.run(suite, None, 0.2) == "killed by time"
        assert (copy.folder / suite.module).read_text(encoding="utf-8") == source
        folder = copy.folder
    assert not folder.exists()


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_a_mutant_of_each_module_is_killed() -> None:
    ran = subprocess.run(
        [sys.executable, HERE / "run.py", "--sample"], capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    n = len(suites())
    assert f"{n} of {n} killed" in ran.stdout
