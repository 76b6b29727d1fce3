"""Suites of mutants: small faults for a module, and the tests that are to notice them.

Each .toml file beside this one is a suite:

    module = "handsim/grasping/judging/six_axis.py"
    tests = ["tests/grasping/judging/test_six_axis.py"]
    [[mutant]]
    name = "only three pulls"
    before = "text that occurs exactly once in the module"
    after = "the same with the fault"
    equivalent = "why no test can tell, where none can"
"""

import tomllib
from dataclasses import dataclass, replace
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]


@dataclass(frozen=True)
class Mutant:
    """A fault: ``before`` becomes ``after``; ``equivalent`` says why no test can tell, if so."""

    name: str
    before: str
    after: str
    equivalent: str = ""

    def applied(self, source: str) -> str:
        """Return the module's text with the fault."""
        found = source.count(self.before)
        if found != 1:
            raise ValueError(f"its text occurs {found} times; bring it up to date")
        return source.replace(self.before, self.after)


@dataclass(frozen=True)
class Suite:
    """The mutants of one module and the tests, files or node ids, that are to kill them."""

    name: str
    module: str
    tests: tuple[str, ...]
    mutants: tuple[Mutant, ...]

    def sample(self) -> "Suite":
        """Return the suite with only the first mutant that a test can tell."""
        return replace(self, mutants=tuple(m for m in self.mutants if not m.equivalent)[:1])

    def faults(self) -> list[str]:
        """Return what is wrong with the suite itself, a line each."""
        source = (ROOT / self.module).read_text(encoding="utf-8")
        names = [mutant.name for mutant in self.mutants]
        found = [f"'{name}': twice" for name in sorted(set(names)) if names.count(name) > 1]
        for mutant in self.mutants:
            try:
                compile(mutant.applied(source), self.module, "exec")
            except (ValueError, SyntaxError) as error:
                found.append(f"'{mutant.name}': {error}")
            if mutant.after == mutant.before:
                found.append(f"'{mutant.name}': changes nothing")
        missing = [test for test in self.tests if not (ROOT / test.split("::")[0]).exists()]
        found += [f"no tests at {test}" for test in missing]
        return [f"{self.name}.toml: {line}" for line in found]


def suites(folder: Path = HERE) -> list[Suite]:
    """Return all suites of a folder, by name."""
    found = []
    for path in sorted(folder.glob("*.toml")):
        table = tomllib.loads(path.read_text(encoding="utf-8"))
        mutants = tuple(Mutant(**entry) for entry in table["mutant"])
        found.append(Suite(path.stem, table["module"], tuple(table["tests"]), mutants))
    return found
