# SPDX-License-Identifier: BSD-3-Clause
"""Sphinx configuration. `make docs` builds with warnings as errors and needs no network."""

import re
import sys
from importlib.metadata import version as installed
from pathlib import Path

from sphinx.ext import autosummary

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "kane"
author = "the kane developers"
copyright = "2026, the kane developers"  # the name that Sphinx expects
release = version = installed("kane")

extensions = [
    "katex_math",
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
]
exclude_patterns = ["_build"]

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

suppress_warnings = ["ref.python"]  # words of types, such as "coordinates", are attributes of several classes
default_role = "code"  # single backticks in docstrings
toc_object_entries_show_parents = "hide"
autosummary_generate = False
autosummary.WELL_KNOWN_ABBREVIATIONS += ("sec.", "ch.", "eq.")  # a point there does not end a summary
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
napoleon_google_docstring = False
napoleon_use_ivar = True  # fields of records are described once, under Attributes
napoleon_use_rtype = False
napoleon_custom_sections = ["Equation", "Equations", "Shape", "Unit", "Units", "Source", "Sources", "Errors"]

html_math_renderer = "katex"
html_static_path = ["_static", "../src/kane/present/assets"]
html_css_files = ["pages.css"]
html_theme = "pydata_sphinx_theme"
html_title = "kane"
html_theme_options = {
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "header_links_before_dropdown": 6,
    "footer_start": ["copyright"],
    "footer_end": [],
}
html_context = {"default_mode": "auto"}
html_sidebars = {"index": [], "gallery": [], "tutorial/*": []}
html_show_sourcelink = False
html_copy_source = False

_LITERAL = re.compile(r"(``.+?``|`[^`]+`_?|^\s*:[^:]+:)")  # code, roles and names of fields


def escape_formulas(app, what, name, obj, options, lines):
    """Let `|v|` and a lone `F_` in a docstring's prose be text, not reStructuredText references."""
    for i, line in enumerate(lines):
        if line.lstrip().startswith((".. ", ">>>", "...")):
            continue
        parts = _LITERAL.split(line)
        parts[::2] = [re.sub(r"(?<!\\)\||(?<=\w)_(?!\w)", r"\\\g<0>", part) for part in parts[::2]]
        lines[i] = "".join(parts)


def setup(app):
    """Register after napoleon, which has turned sections into fields by then."""
    app.connect("autodoc-process-docstring", escape_formulas, priority=900)
    return {"parallel_read_safe": True}
