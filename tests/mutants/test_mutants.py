"""The mutants fit the modules as they are; a sample of them is run by `make test-all`."""

import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
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
    suite = Suite("made-up", "handsim/simulation/six_axis.py", ("tests/nowhere.py::a",), mutants)
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


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_a_mutant_of_each_module_is_killed() -> None:
    ran = subprocess.run(
        [sys.executable, HERE / "run.py", "--sample"], capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    n = len(suites())
    assert f"{n} of {n} killed" in ran.stdout
