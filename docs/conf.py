"""Sphinx: everything is built without network, and every warning is an error (``make docs``)."""

from __future__ import annotations

import logging
import sys
from importlib.metadata import version as installed
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

# Sphinx listens to everybody; scikit-fem tells of every assembly
logging.getLogger("skfem").setLevel(logging.WARNING)

project = "oblique-impact"
copyright = "the authors of oblique-impact"
version = release = installed("oblique-impact")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "numpydoc",
    "docstrings",
    "mathml",
    "scenario_keys",
    "command_line",
    "history_variables",
    "gallery",
]
exclude_patterns = ["_build", "_ext"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
default_role = "code"
highlight_language = "text"  # code blocks name their language; literal blocks of docstrings are formulas

# references are checked: a name that is documented here must exist, foreign ones have no pages in this site
nitpicky = True
nitpick_ignore_regex = [
    ("py:.*", r"(numpy|np|xr|xarray|scipy|pydantic|typer|matplotlib|mpl|skfem|numba|PIL|pyvista|pv|vtk)\..*"),
    ("py:.*", r"(collections|pathlib|os|enum|abc|typing|types|functools|importlib|jinja2)\..*"),
    ("py:class", r"oblique_impact\.tables\._\w+"),  # validators inside of an annotation
]

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_default_options = {"members": True}
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

html_math_renderer = "mathml"
numfig = math_numfig = True
html_theme = "furo"
html_title = "oblique-impact"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_last_updated_fmt = None
