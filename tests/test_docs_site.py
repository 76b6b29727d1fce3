"""Tools that build the site: formulas that need no script, and links that lead nowhere."""

import importlib
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).parents[1] / "docs"
pytestmark = pytest.mark.skipif(not DOCS.is_dir(), reason="no docs beside the tests")

PAGES = sorted(path for path in DOCS.rglob("*.md") if "_ext" not in path.parts)
FENCE = re.compile(r"^(```+|~~~+).*?^\1", re.MULTILINE | re.DOTALL)
FORMULA = re.compile(r"\$\$(.+?)\$\$|\$(\S(?:[^$\n]*\S)?)\$", re.DOTALL)


@pytest.fixture
def extension(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Any]:
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(str(DOCS / "_ext"))
    return importlib.import_module


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_formulas_are_understood(extension, page: Path) -> None:
    pages = extension("mathml_pages")
    prose = re.sub(r"`[^`\n]*`", "", FENCE.sub("", page.read_text(encoding="utf-8")))
    for block, inline in FORMULA.findall(prose):
        assert "<math" in pages.mathml(block or inline, bool(block))


def test_theory_has_formulas() -> None:
    assert len(FORMULA.findall((DOCS / "theory.md").read_text(encoding="utf-8"))) > 100


def test_functions_and_bars_are_spaced(extension) -> None:
    mathml = extension("mathml_pages").mathml
    assert "<mi>ln</mi><mo>&ApplyFunction;</mo><mspace" in re.sub(
        r"\s+(?=<)", "", mathml(r"\ln x", False)
    )
    assert "<mspace" not in mathml(r"\ln(x)", False)
    assert mathml(r"\lvert x\rvert", False).count('lspace="0" rspace="0">|</mo>') == 2


def site(folder: Path, body: str) -> Path:
    (folder / "api").mkdir()
    (folder / "index.html").write_text(f"<body><h1 id='top'>Top</h1>{body}</body>")
    (folder / "api" / "page.html").write_text("<h2 id='a b'></h2><img src='../film.png'>")
    (folder / "film.png").write_bytes(b"")
    return folder


def test_links_that_lead_somewhere(extension, tmp_path: Path) -> None:
    links = (
        "<a href='#top'></a><a href='api/page.html#a%20b'></a><a href='https://example.org/no'></a>"
        "<a href='mailto:a@example.org'></a><video poster='film.png'></video><a href='#'></a>"
    )
    assert list(extension("dead_links").dead_links(site(tmp_path, links))) == []


@pytest.mark.parametrize(
    ("link", "fault"),
    [
        ("<a href='nowhere.html'></a>", "no such file"),
        ("<a href='#bottom'></a>", "no such place on that page"),
        ("<a href='api/page.html#top'></a>", "no such place on that page"),
        ("<video src='film.mp4'></video>", "no such file"),
        ("<a href='api/'></a>", "no such file"),
    ],
)
def test_links_that_lead_nowhere(
    extension, tmp_path: Path, monkeypatch, capsys, link: str, fault: str
) -> None:
    tool = extension("dead_links")
    ((page, _, found),) = tool.dead_links(site(tmp_path, link))
    assert (page.name, found) == ("index.html", fault)
    monkeypatch.setattr("sys.argv", ["dead_links.py", str(tmp_path)])
    assert tool.main() == 1
    assert "pages: 2, links: 2, dead: 1" in capsys.readouterr().out


def test_an_empty_folder_is_no_site(extension, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("sys.argv", ["dead_links.py", str(tmp_path)])
    assert extension("dead_links").main() == 1
