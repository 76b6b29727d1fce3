"""Settings of the documentation: `make docs` builds it into out/docs."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "_ext")]

from handsim_docs import SUBSTITUTIONS, VERSION  # noqa: E402, found by the line above

project = "handsim"
author = "The handsim developers"
copyright = "The handsim developers"
version = release = VERSION

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "numpydoc",
    "handsim_docs",
    "mathml_pages",
    "task_gallery",
]
exclude_patterns = ["_ext", "**/.ipynb_checkpoints"]
default_role = "py:obj"

html_theme = "furo"
html_title = f"handsim {version}"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_js_files = ["films.js"]

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath", "substitution"]
myst_heading_anchors = 3
myst_substitutions = SUBSTITUTIONS

# Notebooks are executed where they have changed since the last build (out/.jupyter_cache).
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 600

autodoc_default_options = {"members": True, "member-order": "bysource", "no-value": True}
viewcode_follow_imported_members = False  # names are documented where they are defined
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
numpydoc_show_class_members = False
