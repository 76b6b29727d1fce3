"""The fixture ``as_baseline``, which pytest finds wherever handsim is installed.

    def test_the_controller_does_what_it_did(as_baseline):
        as_baseline("controller.npz", "baseline.npz", tolerance_deg=0.01)

It is `handsim.testing.assert_as_baseline`, and where something moved it keeps a page with curves in
the folder that ``--baseline-pages`` or the ini option ``baseline_pages`` names, else among the
temporary files of the test. Each test has pages of its own names, so that workers of pytest-xdist
do not write over each other's.
"""

import re
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from handsim.baseline.findings import Report


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that names the folder for pages."""
    said = "folder for the pages that as_baseline keeps where something moved"
    parser.getgroup("handsim").addoption("--baseline-pages", metavar="FOLDER", help=said)
    parser.addini("baseline_pages", said, default="")


@pytest.fixture
def as_baseline(request: pytest.FixtureRequest, tmp_path: Path) -> "Callable[..., Report]":
    """Return `handsim.testing.assert_as_baseline`, which keeps a page where something moved."""
    asked = request.config.getoption("--baseline-pages")
    ini = request.config.getini("baseline_pages")
    folder = Path(asked) if asked else request.config.rootpath / ini if ini else tmp_path
    pages: list[str] = []

    def check(controller: Any, baseline: Any, **options: Any) -> "Report":
        from handsim.testing import assert_as_baseline

        __tracebackhide__ = True
        pages.append(page_name(request.node.nodeid, len(pages)))
        options.setdefault("html", folder / pages[-1])
        return assert_as_baseline(controller, baseline, **options)

    return check


def page_name(node: str, number: int) -> str:
    """Return the name of a test's page: readable, and of no other test."""
    words = re.sub(r"[^\w.-]+", "-", node.rpartition("/")[2]).strip("-")[:80]
    return f"{words}-{sha256(node.encode()).hexdigest()[:8]}{f'-{number}' * bool(number)}.html"
