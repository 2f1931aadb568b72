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
html_theme = "alabaster"
html_theme_options = {"description": "The client of pelagosd",
                      "fixed_sidebar": True}
html_sidebars = {"**": ["about.html", "navigation.html", "searchbox.html"]}
html_show_sourcelink = False
html_copy_source = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True, "show-inheritance": False}
add_module_names = False
# Types that are looked up in no other site.
nitpicky = False
