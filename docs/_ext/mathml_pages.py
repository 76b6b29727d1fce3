"""Formulas as MathML, which browsers draw themselves: pages need no script from elsewhere.

docutils turns LaTeX into it. What it does not know is a warning, and fails `make docs`.
"""

import re
from typing import Any

from docutils import nodes
from docutils.utils.math import MathError, latex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging

log = logging.getLogger(__name__)


def visit_math(translator: Any, node: nodes.math) -> None:
    """Write a formula within a line."""
    translator.body.append(_mathml(node, as_block=False))
    raise nodes.SkipNode


def visit_displaymath(translator: Any, node: nodes.math_block) -> None:
    """Write a formula that stands by itself."""
    translator.body.append(f'<div class="math">{_mathml(node, as_block=True)}</div>\n')
    raise nodes.SkipNode


def mathml(latex: str, as_block: bool) -> str:
    """Return a formula as MathML, with what browsers do not space as they do in LaTeX.

    There is a thin space behind ln and its like, unless a bracket follows. Bars that stand for
    an amount are as high as letters and have no space beside them.
    """
    made = latex2mathml.tex2mathml(latex.strip(), as_block=as_block)
    made = re.sub(
        r"(<mo>&ApplyFunction;</mo>)(?=\s*<m(?!o\b))", r'\1<mspace width="0.17em"></mspace>', made
    )
    bar = r'<mo stretchy="false" lspace="0" rspace="0">\1</mo>'
    return re.sub(r"<mo\b[^>]*>([|∥‖])</mo>", bar, made)


def _mathml(node: nodes.Element, as_block: bool) -> str:
    try:
        return mathml(node.astext(), as_block)
    except MathError as error:
        log.warning("%s in %r", error, node.astext(), location=node)
        return ""


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the renderer, which conf.py names."""
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displaymath, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
