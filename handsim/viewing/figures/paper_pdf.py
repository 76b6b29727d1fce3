"""What the figures show, in words, and all of them on the pages of one file."""

import textwrap
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from handsim.files import replacing

if TYPE_CHECKING:
    from matplotlib.backends.backend_pdf import PdfPages
    from matplotlib.figure import Figure

CAPTIONS = {
    "fig1a_spheres": "Fig. 1a: Navigation function φ of four known round obstacles: landscape and "
    "level sets; it is 1 on every obstacle and 0 at the destination alone.",
    "fig1b_level_sets": "Fig. 1b: Level sets and flow of the navigation function of a refit of two "
    "components: colours, φ; white, the flow to the destination.",
    "fig3_learning": "Fig. 3: Course of learning of a refit of two components to the same "
    "recordings: a, the obstacle learned, as ln β; b, the cost; c, the norm of its gradient; d, "
    "how far the coefficients move, each over the iterations.",
    "fig4_field": "Fig. 4: Level sets and flow of the navigation function in the first three "
    "components: left, level sets of φ as shells about a destination, arrows along the flow, the "
    "recording of median length and the controller's path; right, slices through the destination.",
    "fig5_variance": "Fig. 5: Variance of all recorded postures that lies in their first principal "
    "components: blue, those kept.",
    "fig6_paths": "Fig. 6: Recordings and the controller's paths in the subspace: same starts, "
    "same destinations.",
    "fig7_components": "Fig. 7: Principal components along the movements, over normalised arc "
    "length: left, recordings and controller; right, the mean hand between those two standard "
    "deviations to either side along each component.",
    "fig9_postures": "Fig. 9: Postures along a recording and along the controller's path with the "
    "same start and destination, at equal shares of their length.",
}
"""Captions by the names of the figures' files; the text before the colon names a figure."""

_PAGE, _MARGIN = (8.27, 11.69), 0.9
"""Width and height of a page and its margin [inch]: A4."""
_LETTERS_A_LINE, _LETTERS = 96, 9.0
_RASTER = 200
"""Of what has too many faces to be drawn as lines [dots per inch]."""


def write_pages(figures: Iterable[tuple[str, "Figure"]], path: Path) -> int:
    """Write figures at their sizes into one PDF, a page each, with their captions.

    Parameters
    ----------
    figures
        Their names and themselves, one after the other.
    path
        Written as a whole or not at all.

    Returns
    -------
    int
        Number of pages.
    """
    from matplotlib.backends.backend_pdf import PdfPages

    n = 0
    with replacing(path) as temporary, PdfPages(temporary, metadata={"CreationDate": None}) as pdf:
        for name, figure in figures:
            _write_page(pdf, figure, CAPTIONS[name])
            n += 1
    return n


def _write_page(pdf: "PdfPages", figure: "Figure", caption: str) -> None:
    """Write a page that is larger than the figure: the caption stands below it, outside."""
    from matplotlib.transforms import Bbox

    width, height = figure.get_size_inches()
    head, _, rest = caption.partition(": ")
    lines = textwrap.wrap(f"{head}. {rest}", _LETTERS_A_LINE)
    aside = 0.5 * (_PAGE[0] - width)
    written = figure.text(
        *((_MARGIN - aside) / width, -0.2 / height),
        "\n".join(lines),
        fontsize=_LETTERS,
        va="top",
        linespacing=1.35,
        in_layout=False,
    )
    top = height + _MARGIN
    page = Bbox([[-aside, top - _PAGE[1]], [width + aside, top]])
    for legend in figure.legends:  # they would go to the page's lower edge
        legend.set_bbox_to_anchor((0, 0, 1, 1), transform=figure.transFigure)
    pdf.savefig(figure, bbox_inches=page, dpi=_RASTER)
    written.remove()
