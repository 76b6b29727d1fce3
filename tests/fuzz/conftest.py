"""Damaged input, thousands of times over.

A case passes when the command works (exit 0, or 1 for a check that does not hold), or says in one
line what is wrong and exits with 2, having written nothing. A traceback is an exception here, since
the command line runs in this process; so is a warning.
"""

import contextlib
import io
import shutil
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from hypothesis.errors import HypothesisWarning

from handsim.cli import main

SPECIAL = (
    "nan", "inf", "-inf", "1e999", "-1e308", "1e-320", "0", "-0", "-1", "", " ", "many", "1,5", '"',
    "0x10", "1_0", "९", "True", "9" * 5000, "1e5", "180.0001", "-180", "\0", "é", "🖐", "a/b", "..",
    "/etc/passwd", "x" * 300, "x" * 200_000, "=1+1", "%s", "{}", "\n",
)  # fmt: skip
"""What numbers and words are replaced with."""


class Content(bytes):
    """The content of a file, too long to be shown."""

    def __repr__(self) -> str:
        return f"{len(self)} bytes"


@dataclass
class Sandbox:
    """A folder to work in, and the command line run beside it."""

    root: Path
    inputs: Path
    outputs: Path
    cases: int
    codes: list[int] = field(default_factory=list)

    def fresh(self) -> None:
        """Empty both folders."""
        for folder in (self.inputs, self.outputs):
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)

    def files(self) -> set[Path]:
        """Everything below the root but the inputs themselves."""
        return {path for path in self.root.rglob("*") if self.inputs not in path.parents}

    def run(self, *args: object) -> int:
        """Run the command line and hold it to what it promises."""
        before, inputs = self.files(), {*self.inputs.rglob("*")}
        out, err = io.StringIO(), io.StringIO()
        kept, sys.argv = sys.argv, ["handsim", *map(str, args)]
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                main()
        except SystemExit as ended:
            code = int(ended.code or 0)
        finally:
            sys.argv = kept
        assert code in (0, 1, 2)
        assert "Traceback" not in err.getvalue()
        if code == 2 and "Usage:" not in out.getvalue():  # a command without any argument
            assert err.getvalue().startswith("handsim: ")
            assert err.getvalue().count("\n") == 1
            assert out.getvalue() == ""
            assert self.files() == before
        new = self.files() - before
        assert all(self.outputs in path.parents for path in new)
        allowed = {path for path in self.inputs.rglob("*") if ".plans" in str(path)}
        assert {*self.inputs.rglob("*")} - inputs <= allowed
        self.codes.append(code)
        return code


@pytest.fixture(
    params=[
        pytest.param(1, id="sample"),
        pytest.param(20, id="many", marks=[pytest.mark.slow, pytest.mark.timeout(3600)]),
    ]
)
def sandbox(request, tmp_path) -> Sandbox:
    return Sandbox(tmp_path, tmp_path / "in", tmp_path / "out", request.param)


def search(check: Callable[[Any], None], strategy: st.SearchStrategy, cases: int) -> None:
    """Try ``cases`` examples of a strategy; the same ones every time.

    They are not shrunk: the first that fails is left in the sandbox to be looked at.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HypothesisWarning)  # of the length of what it shows
        _try(check, strategy, cases)


def _try(check: Callable[[Any], None], strategy: st.SearchStrategy, cases: int) -> None:
    settings(
        max_examples=cases,
        derandomize=True,
        database=None,
        phases=[Phase.generate],
        report_multiple_bugs=False,
        deadline=None,
        suppress_health_check=list(HealthCheck),
    )(given(strategy)(check))()


@st.composite
def damaged_bytes(draw: st.DrawFn, original: bytes) -> Content:
    """A file with bytes flipped, cut out, doubled, put in, or cut off."""
    data = bytearray(original)
    for _ in range(draw(st.integers(1, 4))):
        kind = draw(st.sampled_from(["flip", "cut", "double", "insert", "end", "number"]))
        at = draw(st.integers(0, max(len(data) - 1, 0)))
        length = draw(st.integers(1, 64))
        if kind == "flip" and data:
            data[at] ^= 1 << draw(st.integers(0, 7))
        elif kind == "cut":
            del data[at : at + length]
        elif kind == "double":
            data[at:at] = data[at : at + length]
        elif kind == "insert":
            data[at:at] = draw(st.binary(min_size=1, max_size=16))
        elif kind == "end":
            del data[at:]
        else:
            data[at : at + 4] = draw(
                st.sampled_from([b"\xff\xff\xff\x7f", b"\0\0\0\0", b"\xff" * 4])
            )
    return Content(data)


@st.composite
def damaged_table(draw: st.DrawFn, original: str) -> Content:
    """A CSV file with cells, rows or columns changed."""
    rows = [line.split(",") for line in original.splitlines()]
    for _ in range(draw(st.integers(1, 3))):
        i = draw(st.integers(0, len(rows) - 1))
        j = draw(st.integers(0, len(rows[i]) - 1)) if rows[i] else 0
        kind = draw(st.sampled_from(["cell", "cell", "cell", "row", "column", "swap", "rows"]))
        if kind == "cell" and rows[i]:
            number = st.floats().map(repr)
            rows[i][j] = draw(st.sampled_from(SPECIAL) | number | st.text(max_size=8))
        elif kind == "row":
            rows.insert(i, list(rows[draw(st.integers(0, len(rows) - 1))]))
        elif kind == "column":
            rows = [row[:j] + row[j + 1 :] for row in rows]
        elif kind == "swap":
            k = draw(st.integers(0, len(rows) - 1))
            rows[i], rows[k] = rows[k], rows[i]
        else:
            rows = rows[: i + 1]
        rows = rows or [[""]]
    return Content(("\n".join(",".join(row) for row in rows) + "\n").encode())


@pytest.fixture
def memory_limit():
    """Leave this process 2 GB more than it has: what takes more fails, and not the machine."""
    import resource

    pages = int(Path("/proc/self/statm").read_text().split()[0])
    kept = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + 2 * 2**30, kept[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, kept)
