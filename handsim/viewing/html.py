"""Pieces of a self-contained HTML page: text, tables, pictures and videos within the file itself.

Whatever comes from files or users is escaped here; pictures and videos become ``data:`` addresses.
"""

import base64
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

from handsim.types import Frame

_TYPES = {".svg": "image/svg+xml", ".png": "image/png", ".mp4": "video/mp4"}

_STYLE = """
:root { color-scheme: light; --ink: #1c2430; --faint: #5d6878; --line: #dde2e9; --blue: #0072b2;
  --good: #00704f; --bad: #b54700; --ground: #f5f7fa; }
* { box-sizing: border-box; }
body { margin: 0; color: var(--ink); background: #fff;
  font: 16px/1.55 system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; }
header, main, footer { margin: 0; padding: 0 clamp(1rem, 2.5vw, 3rem); }
header { padding-top: 2.5rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .3rem; }
h2 { font-size: 1.3rem; margin: 0 0 .6rem; padding-top: 1.4rem; border-top: 2px solid var(--line); }
h3 { font-size: 1rem; margin: 1.4rem 0 .4rem; }
section { margin-top: 2.2rem; min-width: 0; }
main { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(40rem, 100%), 1fr));
  column-gap: 3rem; }
section:not(:has(table)), section:has(figure) { grid-column: 1 / -1; }
p { max-width: 46rem; margin: .4rem 0 .8rem; }
.faint, figcaption { color: var(--faint); font-size: .9rem; }
nav { display: flex; flex-wrap: wrap; gap: .3rem 1.1rem; margin: 1.1rem 0 0; font-size: .95rem; }
a { color: var(--blue); text-decoration-thickness: 1px; text-underline-offset: .15em; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(8.2rem, 1fr)); gap: .6rem;
  margin: 1.5rem 0 0; padding: 0; list-style: none; }
.tiles li { background: var(--ground); border-radius: .5rem; padding: .7rem .8rem; }
.tiles b { display: block; font-size: 1.3rem; line-height: 1.3; white-space: nowrap; }
.tiles span { color: var(--faint); font-size: .85rem; line-height: 1.35; display: block; }
.scroll { overflow-x: auto; margin: .6rem 0 1rem; }
table { border-collapse: collapse; width: 100%; font-size: .9rem;
  font-variant-numeric: tabular-nums; }
th, td { padding: .28rem .9rem .28rem 0; text-align: right; border-bottom: 1px solid var(--line); }
td { white-space: nowrap; }
th { color: var(--faint); font-weight: 600; vertical-align: bottom; line-height: 1.3; }
.text { text-align: left; }
tr > :last-child { padding-right: 0; }
.good { color: var(--good); font-weight: 600; }
.bad { color: var(--bad); font-weight: 600; }
figure { margin: 1rem 0 1.4rem; }
figure img { display: block; max-width: 100%; height: auto; }
figcaption { margin-top: .4rem; max-width: 46rem; }
.films { display: grid; grid-template-columns: repeat(auto-fill, minmax(17rem, 1fr)); gap: 1.1rem; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(34rem, 100%), 1fr));
  gap: 1.6rem 2.2rem; align-items: start; }
.figures figure { margin: 0; }
.films figure { margin: 0; }
video { display: block; width: 100%; height: auto; border-radius: .4rem; background: var(--ground);
  aspect-ratio: 4 / 3; }
.still { display: none; }
pre { background: var(--ground); border-radius: .5rem; padding: .8rem 1rem; overflow-x: auto;
  font: .85rem/1.6 ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace; }
footer { padding: 2rem 1.25rem 3rem; }
@media print {
  @page { margin: 16mm; }
  body { font-size: 10.5pt; }
  nav { display: none; }
  header, main, footer { padding-left: 0; padding-right: 0; }
  main { display: block; }
  header { padding-top: 0; }
  h2, h3 { break-after: avoid; }
  figure, tr, .tiles, pre { break-inside: avoid; }
  .scroll { overflow: visible; }
  table { font-size: 8.5pt; }
  .films { grid-template-columns: repeat(3, 1fr); }
  video { display: none; }  /* browsers print them empty */
  figure .still { display: block; }
  .tiles li, pre { background: none; border: 1px solid var(--line); }
  pre { white-space: pre-wrap; }
}
"""


def page(title: str, lead: str, top: str, sections: Sequence[tuple[str, str, str]]) -> str:
    """Return the whole page.

    Parameters
    ----------
    title, lead
        Text: heading, and the line below it.
    top
        HTML between the heading and the first section.
    sections
        Anchor, heading (text) and content (HTML) of each.
    """
    links = "".join(f'<a href="#{anchor}">{escape(name)}</a>' for anchor, name, _ in sections)
    body = "".join(
        f'<section id="{anchor}"><h2>{escape(name)}</h2>{content}</section>\n'
        for anchor, name, content in sections
    )
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<link rel="icon" href="data:,">\n'  # else browsers ask a server for one
        f"<title>{escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        f'<header><h1>{escape(title)}</h1><p class="faint">{escape(lead)}</p>'
        f"{top}<nav>{links}</nav></header>\n<main>\n{body}</main>\n</body>\n</html>\n"
    )


def paragraph(text: str, kind: str = "") -> str:
    """Return a paragraph of text; ``kind`` is a class of the style sheet, such as ``faint``."""
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>"


def tiles(values: Iterable[tuple[str, str]]) -> str:
    """Return large values, each with the text that says what it is."""
    items = "".join(f"<li><b>{escape(v)}</b><span>{escape(t)}</span></li>" for v, t in values)
    return f'<ul class="tiles">{items}</ul>'


def table(header: Sequence[str], rows: Iterable[Sequence[object]], n_text: int = 1) -> str:
    """Return a table; truth values become a coloured yes or no.

    Parameters
    ----------
    header
        Titles of the columns, with units.
    rows
        Cells as they are to be read.
    n_text
        Number of columns, from the left, that hold text; the others are aligned to the right.
    """
    head = "".join(
        f'<th scope="col"{_text(i < n_text)}>{escape(title)}</th>' for i, title in enumerate(header)
    )
    body = "".join(
        f"<tr>{''.join(_cell(value, i < n_text) for i, value in enumerate(row))}</tr>"
        for row in rows
    )
    return (
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
        "</div>"
    )


def _cell(value: object, text: bool) -> str:
    if isinstance(value, bool):
        return '<td class="good">yes</td>' if value else '<td class="bad">no</td>'
    return f"<td{_text(text)}>{escape(str(value))}</td>"


def _text(text: bool) -> str:
    return ' class="text"' if text else ""


def listing(lines: Iterable[str]) -> str:
    """Return lines of code."""
    return f"<pre>{escape(chr(10).join(lines))}</pre>"


def picture(path: Path, caption: str) -> str:
    """Return a picture file, by its name's suffix, with its caption."""
    return (
        f'<figure><img src="{_data(path.read_bytes(), _TYPES[path.suffix])}" '
        f'alt="{escape(caption.partition(":")[0], quote=True)}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def film(path: Path, poster: Frame, caption: str, good: bool) -> str:
    """Return a video file with its caption; ``poster`` stands for it in print and until played."""
    import imageio.v3 as iio

    encoded = iio.imwrite("<bytes>", poster, plugin="pillow", extension=".jpg", quality=75)
    still = _data(encoded, "image/jpeg")
    return (
        f'<figure><video controls loop muted playsinline preload="metadata" poster="{still}" '
        f'src="{_data(path.read_bytes(), _TYPES[path.suffix])}"></video>'
        f'<img class="still" src="{still}" alt="">'
        f'<figcaption class="{"good" if good else "bad"}">{escape(caption)}</figcaption></figure>'
    )


def figures(items: Iterable[str]) -> str:
    """Return figures side by side where the page is wide enough for two or more."""
    return f'<div class="figures">{"".join(items)}</div>'


def films(items: Iterable[str]) -> str:
    """Return videos side by side, as many as there is room for."""
    return f'<div class="films">{"".join(items)}</div>'


def _data(content: bytes, kind: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"
