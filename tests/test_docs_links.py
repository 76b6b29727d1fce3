"""Relative links between pages, and from them to files, lead somewhere; no network is asked."""

import re
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[1]
DOCS = CHECKOUT / "docs"
pytestmark = pytest.mark.skipif(not DOCS.is_dir(), reason="no docs beside the tests")

PAGES = sorted(
    path
    for path in (
        *CHECKOUT.glob("*.md"), *DOCS.glob("*.md"), *DOCS.glob("howto/*.md"),
        *CHECKOUT.glob("assets/*.md"), *CHECKOUT.glob("models/*/*.md"),
        *CHECKOUT.glob("tests/benchmarks/*.md"),
    )
)  # fmt: skip
LINK = re.compile(r"\[[^\]]*\]\(\s*<?([^)\s>]+)>?[^)]*\)")
PICTURE = re.compile(r"""<(?:img|video|a)\b[^>]*?\b(?:src|href|poster)=["']([^"']+)["']""")
FENCE = re.compile(r"^(```+|~~~+).*?^\1", re.MULTILINE | re.DOTALL)
HEADING = re.compile(r"^(#+) (.*?)\s*$", re.MULTILINE)
ELSEWHERE = re.compile(r"^[a-z][a-z0-9+.-]*:", re.IGNORECASE)


def links_of(text: str) -> list[str]:
    """What a page links to in its own project; code shows no links."""
    prose = re.sub(r"`[^`\n]*`", "", FENCE.sub("", text))
    found = LINK.findall(prose) + PICTURE.findall(prose)
    return [link for link in found if not ELSEWHERE.match(link)]


def anchors_of(text: str) -> set[str]:
    """What may stand after ``#``: headings, in small letters and with hyphens, and named places."""
    prose = FENCE.sub("", text)
    said = {
        re.sub(r"[^\w\- ]", "", title.lower().replace("`", "")).replace(" ", "-")
        for _, title in HEADING.findall(prose)
    }
    return said | set(re.findall(r"^\(([\w-]+)\)=$", prose, re.MULTILINE))


def fault_of(page: Path, link: str) -> str:
    """Why a link leads nowhere; empty where it does not."""
    name, _, anchor = link.partition("#")
    target = (page.parent / name).resolve() if name else page
    if not target.exists():
        return f"{link}: there is no {target}"
    if anchor and target.suffix == ".md" and anchor not in anchors_of(target.read_text("utf-8")):
        return f"{link}: {target.name} has no heading of that name"
    return ""


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(CHECKOUT)))
def test_links_lead_somewhere(page: Path) -> None:
    faults = [fault_of(page, link) for link in links_of(page.read_text(encoding="utf-8"))]
    assert not [fault for fault in faults if fault]


def test_links_are_found() -> None:
    index = {*links_of((DOCS / "index.md").read_text(encoding="utf-8"))}
    assert {"start.md", "howto/index.md", "../assets/pictures/grasp.gif"} <= index


def test_a_link_that_leads_nowhere_is_noticed(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# It's `here`\n[a](#its-here) [b](none.md) [c](page.md#there)\n`[d](no.md)`\n")
    faults = [fault_of(page, link) for link in links_of(page.read_text())]
    assert [bool(fault) for fault in faults] == [False, True, True]


@pytest.mark.parametrize("folder", [DOCS, DOCS / "howto"], ids=lambda path: path.name)
def test_every_page_is_in_the_list_of_its_folder(folder: Path) -> None:
    text = (folder / "index.md").read_text(encoding="utf-8")
    listed = re.findall(r"^([\w/]+)$", text.partition("{toctree}")[2], re.MULTILINE)
    there = {path.stem for path in folder.glob("*.md")} - {"index"}
    assert there == {name for name in listed if not name.endswith("/index")}
