"""Look for links of a built site that lead nowhere: ``python dead_links.py FOLDER``.

Files that a page shows or links to have to be there, and the places on a page that are named after
``#``. Addresses elsewhere are not asked for. Exit code 1: some lead nowhere, each with its page.
"""

import sys
from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LEADING = ("href", "src", "poster")


class SitePage(HTMLParser):
    """A page: what it links to or shows, and the places on it that links may name."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.places: set[str] = set()
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect addresses and names; ``link`` elements may name pages of other tools."""
        for name, value in attrs:
            if name in LEADING and value:
                self.links.append(value)
            elif name == "id" or (name == "name" and tag == "a"):
                self.places.add(value or "")


@cache
def read_page(path: Path) -> SitePage:
    """Read a page once."""
    return SitePage(path.read_text(encoding="utf-8"))


def fault_of(page: Path, link: str) -> str:
    """Why a link of a page leads nowhere; empty where it does not, or leads elsewhere."""
    address = urlsplit(link)
    if address.scheme or address.netloc:
        return ""
    target = (page.parent / unquote(address.path)).resolve() if address.path else page
    if target.is_dir():
        target /= "index.html"
    if not target.is_file():
        return "no such file"
    place = unquote(address.fragment)
    if place and target.suffix == ".html" and place not in read_page(target).places:
        return "no such place on that page"
    return ""


def dead_links(folder: Path) -> Iterator[tuple[Path, str, str]]:
    """Return page, link and fault of each link that leads nowhere."""
    for page in sorted(folder.rglob("*.html")):
        for link in dict.fromkeys(read_page(page.resolve()).links):
            fault = fault_of(page.resolve(), link)
            if fault:
                yield page.relative_to(folder), link, fault


def main() -> int:
    """Print what leads nowhere, and how much was looked at."""
    folder = Path(sys.argv[1])
    pages = sorted(folder.rglob("*.html"))
    found = list(dead_links(folder))
    for page, link, fault in found:
        sys.stderr.write(f"{page}: {link}: {fault}\n")
    n_links = sum(len(set(read_page(page.resolve()).links)) for page in pages)
    sys.stdout.write(f"pages: {len(pages)}, links: {n_links}, dead: {len(found)}\n")
    return 1 if found or not pages else 0


if __name__ == "__main__":
    raise SystemExit(main())
