"""Sphinx: everything is built without network, and every warning is an error (``make docs``)."""

from __future__ import annotations

import logging
import sys
import warnings
from importlib.metadata import version as installed
from pathlib import Path

import yaml

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

# Sphinx listens to everybody; scikit-fem tells of every assembly
logging.getLogger("skfem").setLevel(logging.WARNING)

# a warning in an example stands on its page, in a line without the folder of this build
warnings.formatwarning = lambda message, category, *place: f"{category.__name__}: {message}\n"

project = "oblique-impact"
copyright = "the authors of oblique-impact"
version = release = installed("oblique-impact")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "numpydoc",
    "docstrings",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",
    "equation",
    "scenario_keys",
    "command_line",
    "history_variables",
    "player",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "_ext", "pictures"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist", "substitution"]
myst_heading_anchors = 3
# how to cite this version, from CITATION.cff
cited = yaml.safe_load((HERE.parent / "CITATION.cff").read_text(encoding="utf-8"))
authors = " and ".join(author["name"] for author in cited["authors"])
myst_substitutions = {
    "citation": f"""```bibtex
@software{{oblique_impact,
  author  = {{{{{authors}}}}},
  title   = {{{cited["title"]}}},
  version = {{{cited["version"]}}},
  year    = {{{cited["date-released"].year}}},
  note    = {{License: {cited["license"]}}}
}}
```"""
}
default_role = "code"
highlight_language = "text"  # code blocks name their language; literal blocks of docstrings are formulas

# references are checked: a name that is documented here must exist, foreign ones have no pages in this site
nitpicky = True
nitpick_ignore_regex = [
    ("py:.*", r"(numpy|np|xr|xarray|scipy|pydantic|typer|matplotlib|mpl|skfem|numba|PIL|pyvista|pv|vtk)\..*"),
    ("py:.*", r"(collections|pathlib|os|enum|abc|typing|types|functools|importlib|jinja2)\..*"),
    ("py:class", r"oblique_impact\.scenario\.tables\._\w+|lambda"),  # validators inside of an annotation
]

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_default_options = {"members": True}
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

# examples run on every build, even unchanged: their pictures are those of the present program
sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "ignore_pattern": "paper_demo|explore",
    "run_stale_examples": True,
    "abort_on_example_error": True,
    "within_subsection_order": "gallery.place",
    "image_scrapers": ("gallery.scrape",),
    "capture_repr": (),
    "reset_modules": (),
    "notebook_extensions": {".py"},
    "download_all_examples": False,
    "write_computation_times": False,
    "min_reported_time": 1000,
    "show_signature": False,
    "thumbnail_size": (540, 360),
    # names in the code of an example lead to their documentation
    "doc_module": ("oblique_impact",),
}

mathjax_path = "mathjax/tex-chtml.js"  # in the site: it needs no network
numfig = math_numfig = True
html_theme = "furo"
html_title = "oblique-impact"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_search_scorer = str(HERE / "search.js")  # else sought where the build is started
html_copy_source = False
html_show_sourcelink = False
html_last_updated_fmt = None
