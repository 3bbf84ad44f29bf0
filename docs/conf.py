"""Configuration of the documentation site: ``make docs`` builds it, offline, with warnings as errors."""

import sys
from pathlib import Path

from numpydoc.xref import DEFAULT_LINKS
from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

import echoplan

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "echoplan"
author = "The echoplan developers"
project_copyright = "The echoplan developers, Apache License 2.0"
version = release = echoplan.__version__

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "sphinx_design",
    "generated_pages",
]
exclude_patterns = ["_build"]
nitpicky = True

# Anchors as on GitHub, where the same pages are read.
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence", "html_image"]

# Types are in the docstrings, with shapes and units, which annotations do not have.
autodoc_typehints = "none"
autodoc_preserve_defaults = True
autodoc_default_options = {"exclude-members": "model_config"}
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_xref_param_type = True
numpydoc_xref_ignore = "all"
# Only to names of this site: types of Python and NumPy have their pages elsewhere, and the site is built offline.
numpydoc_xref_aliases = {name: name for name in DEFAULT_LINKS} | {
    name: f"echoplan.{name}" for name in echoplan.__all__ if name[0].isupper()
}

html_theme = "pydata_sphinx_theme"
html_title = "echoplan"
html_show_sourcelink = False
html_theme_options = {
    "navbar_align": "left",
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}
html_sidebars: dict[str, list[str]] = {"index": []}


def setup(app: Sphinx) -> None:
    """Show tables and files for which Pygments has no lexer as plain text."""
    for name in ("csv", "tum"):
        app.add_lexer(name, TextLexer)
