"""Sphinx configuration of the handbook."""

from __future__ import annotations

import vulnus

project = "vulnus"
author = "The vulnus developers"
version = release = vulnus.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinxcontrib.bibtex"]
bibtex_bibfiles = ["theory/refs.bib"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "vulnus"
exclude_patterns = ["_build"]
autodoc_typehints = "signature"
