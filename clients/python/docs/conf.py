"""Sphinx: `make python-docs` writes build/python-docs. Another project's site
takes the pages as they are: these extensions and both folders in sys.path."""
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

from pelagos import __version__  # noqa: E402

project = "Pelagos for Python"
author = "Pelagos"
version = release = __version__
extensions = ["sphinx.ext.autodoc", "plaindoc"]
html_theme = "furo"
html_title = f"Pelagos for Python {version}"
smartquotes = False
html_show_sourcelink = False
html_copy_source = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True}
add_module_names = False
