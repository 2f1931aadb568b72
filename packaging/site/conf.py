"""Sphinx's configuration of the documentation site: `make site`.

Its sources are those that prepare.py lays out in a folder of their own.
"""
import os
import pathlib
import re
import sys

TREE = pathlib.Path(os.environ["PELAGOS_TREE"])
sys.path.insert(0, str(TREE / "clients/python"))

project = "Pelagos"
author = "Pelagos contributors"
copyright = "2026, " + author
release = version = (TREE / "VERSION").read_text(encoding="utf-8").strip()

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.graphviz"]
root_doc = "index"
language = "en"
myst_heading_anchors = 4
myst_enable_extensions = ["html_image"]
# Blocks of shell and JSON have places for names in them.
suppress_warnings = ["misc.highlighting_failure"]
nitpicky = False

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_mock_imports = ["cv2"]
default_role = "code"  # one backtick, as in Markdown
# The interface, not where a class is defined within the package.
add_module_names = False

graphviz_output_format = "svg"

html_theme = "furo"
html_title = f"Pelagos {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
# The same bytes whenever it is built.
html_last_updated_fmt = None


def indented_as_it_stands(_app, _what, _name, _obj, _options, lines):
    """Docstrings have tables and code by indentation alone."""
    out, block = [], []

    def flush():
        while block and not block[-1].strip():
            block.pop()
        if block:
            out.extend(["", ".. code-block:: text", ""])
            out.extend("   " + line for line in block)
            out.append("")
        block.clear()

    follows = ""  # the last line that is not indented
    for line in lines:
        if line[:1].isspace() and line.strip() and (
                block or not re.match(r"\.\. |:|[-*] |\d+\. ", follows)):
            block.append(line)
        elif block and not line.strip():
            block.append(line)
        else:
            flush()
            out.append(line)
            follows = line if line.strip() and not line[0].isspace() else follows
    flush()
    lines[:] = out


def setup(app):
    """Sphinx calls it."""
    app.connect("autodoc-process-docstring", indented_as_it_stands)
