"""Put small faults into copies of modules, one at a time, and see whether the tests notice.

    python tests/mutants/run.py [--module NAME] [--jobs N] [--sample]

The faults are the mutants of the suites beside this file (see `suites`). A mutant is killed when
a test fails, or when the tests take far longer than without it. Exit code 1: less than 95 % of
those that a test can tell are killed, a mutant no longer fits its module, one called equivalent is
killed, or the tests fail without any mutant.
"""

import argparse
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from queue import SimpleQueue
from typing import Literal

from suites import ROOT, Mutant, Suite, suites

COPIED = ("handsim", "models", "assets", "tests", "pyproject.toml")
REQUIRED = 0.95
"""Share of the mutants that a test can tell which have to be killed."""
SLOWER, PATIENCE = 5.0, 60.0
"""A run ends after so many times what it takes without a mutant, and [s] more."""

Verdict = Literal["killed", "killed by time", "survived"]


class Copy:
    """A copy of the package in which one run after another is made."""

    _stamps = count(1_000_000_000)

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in COPIED:
            self._take(name)
        self._environment = {
            **os.environ,
            "PYTHONPATH": str(folder),
            "OMP_NUM_THREADS": "1",  # more threads would slow down the runs beside this one
            "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",  # loading them takes longer than most tests
        }
        imported = "import handsim; print(handsim.__file__)"
        told = subprocess.run(
            [sys.executable, "-c", imported],
            cwd=folder, env=self._environment, capture_output=True, text=True, check=True,
        ).stdout.strip()  # fmt: skip
        if not Path(told).is_relative_to(folder):
            raise RuntimeError(f"{told} is imported instead of the copy in {folder}")

    def _take(self, name: str) -> None:
        source, target = ROOT / name, self.folder / name
        if source.is_dir():
            shutil.rmtree(target, ignore_errors=True)
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, target)

    def run(self, suite: Suite, mutant: Mutant | None, limit: float) -> Verdict:
        """Run the tests of a suite with a mutant, or with none."""
        path = self.folder / suite.module
        source = path.read_text(encoding="utf-8")
        try:
            self._write(path, mutant.applied(source) if mutant else source)
            return self._pytest(suite.tests, limit)
        finally:
            self._write(path, source)
            self._take("assets")  # where a mutant may have left plans

    def _write(self, path: Path, text: str) -> None:
        """Write a module; no two writes share a time, by which Python knows what it compiled."""
        path.write_text(text, encoding="utf-8")
        stamp = next(self._stamps)
        os.utime(path, (stamp, stamp))

    def _pytest(self, tests: tuple[str, ...], limit: float) -> Verdict:
        options = ("-x", "-q", "-p", "no:cacheprovider", "-p", "pytest_timeout")
        command = [sys.executable, "-m", "pytest", *options, *tests]
        with (self.folder / "pytest.log").open("w+", encoding="utf-8") as log:
            child = subprocess.Popen(
                command, cwd=self.folder, env=self._environment,
                stdout=log, stderr=subprocess.STDOUT, start_new_session=True,
            )  # fmt: skip
            try:
                code = child.wait(limit)
            except subprocess.TimeoutExpired:
                return "killed by time"
            finally:
                _end(child)
        if code in (3, 4, 5):  # pytest itself is at fault, or there is no test
            raise RuntimeError(f"pytest ended with {code}:\n{self.log()}")
        return "survived" if code == 0 else "killed"

    def log(self) -> str:
        """Return the end of what the latest run said."""
        return (self.folder / "pytest.log").read_text(encoding="utf-8")[-3000:]


def _end(child: subprocess.Popen[bytes]) -> None:
    """End a run with all processes it started."""
    with suppress(ProcessLookupError):
        os.killpg(child.pid, signal.SIGKILL)
    child.wait()


@contextmanager
def copies(n: int) -> Iterator["SimpleQueue[Copy]"]:
    """Make copies for so many workers, and remove them at the end."""
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        free: SimpleQueue[Copy] = SimpleQueue()
        for i in range(n):
            place = Path(folder).resolve() / str(i)
            place.mkdir()
            free.put(Copy(place))
        yield free


def judge(suite: Suite, free: "SimpleQueue[Copy]", n_jobs: int) -> dict[str, Verdict]:
    """Return what became of each mutant of a suite.

    Raises
    ------
    RuntimeError
        If the tests fail without any mutant.
    """

    def one(mutant: Mutant | None, limit: float) -> Verdict:
        copy = free.get()
        try:
            verdict = copy.run(suite, mutant, limit)
            if mutant is None and verdict != "survived":
                raise RuntimeError(f"{suite.name}: without a mutant, {verdict}:\n{copy.log()}")
        finally:
            free.put(copy)
        return verdict

    began = time.monotonic()
    one(None, 10 * PATIENCE)
    limit = SLOWER * (time.monotonic() - began) + PATIENCE
    verdicts: dict[str, Verdict] = {}
    with ThreadPoolExecutor(n_jobs) as pool:
        waiting = {pool.submit(one, mutant, limit): mutant.name for mutant in suite.mutants}
        try:
            for done in as_completed(waiting):
                verdicts[waiting[done]] = done.result()
                place = f"{len(verdicts)}/{len(suite.mutants)}"
                print(f"{suite.name} {place} {done.result()}: {waiting[done]}", flush=True)
        finally:  # nothing waits where one went wrong
            pool.shutdown(cancel_futures=True)
    return verdicts


def report(found: list[tuple[Suite, dict[str, Verdict]]]) -> bool:
    """Print killed, survived and equivalent per module; return whether all is well."""
    n_killed = n_told = 0
    well = True
    print(f"\n{'module':40} killed survived equivalent")
    for suite, verdicts in found:
        same = [mutant for mutant in suite.mutants if mutant.equivalent]
        told = [mutant for mutant in suite.mutants if not mutant.equivalent]
        left = [mutant.name for mutant in told if verdicts[mutant.name] == "survived"]
        killed = len(told) - len(left)
        n_killed, n_told = n_killed + killed, n_told + len(told)
        print(f"{suite.module:40} {killed:6} {len(left):8} {len(same):10}")
        for name in left:
            print(f"    survived: {name}")
        for mutant in same:
            print(f"    equivalent: {mutant.name} ({mutant.equivalent})")
            if verdicts[mutant.name] != "survived":
                well = False
                print("        but a test tells it: it is not equivalent")
    share = n_killed / max(n_told, 1)
    print(f"{n_killed} of {n_told} killed: {100 * share:.1f} %, at least {100 * REQUIRED:.0f} %")
    return well and share >= REQUIRED


def main() -> int:
    """Run the suites asked for."""
    parser = argparse.ArgumentParser(description="See whether tests notice small faults.")
    parser.add_argument("--module", metavar="NAME", help="only the suite of this name")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="runs at once (2)")
    parser.add_argument("--sample", action="store_true", help="only one mutant of each")
    chosen = parser.parse_args()
    known = suites()
    asked = [suite for suite in known if chosen.module in (None, suite.name)]
    if not asked:
        parser.error(f"no suite '{chosen.module}'; give {', '.join(s.name for s in known)}")
    if chosen.jobs < 1:
        parser.error(f"{chosen.jobs} jobs; give 1 or more")
    if faults := [line for suite in asked for line in suite.faults()]:
        print(*faults, sep="\n", file=sys.stderr)
        return 1
    if chosen.sample:
        asked = [suite.sample() for suite in asked]
    try:
        with copies(chosen.jobs) as free:
            found = [(suite, judge(suite, free, chosen.jobs)) for suite in asked]
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return 1
    return 0 if report(found) else 1


if __name__ == "__main__":
    sys.exit(main())
