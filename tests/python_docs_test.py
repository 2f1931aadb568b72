#!/usr/bin/python3
"""The reference of the Python client: made without a warning, every name that
the package exports is in it, and docstrings are laid out as `help()` shows
them."""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "clients/python"), str(ROOT / "clients/python/docs")]
sys.dont_write_bytecode = True
import pelagos
import plaindoc

# Numbers and tuples, which Sphinx has no page of.
PLAIN = {"EARTH_RADIUS", "FORMATS", "LAYERS", "MODEL_CLASSES",
         "STANDARD_REFRACTION", "VERSION", "Geographic", "Local"}


class Reference(unittest.TestCase):
    def test_all_is_there(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(
                ["make", "-s", "-C", str(ROOT), "python-docs",
                 f"PYTHON_DOCS={folder}"], capture_output=True, text=True,
                env={k: v for k, v in os.environ.items()
                     if not k.startswith("MAKE")})
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            pages = {p.name: p.read_text() for p in
                     pathlib.Path(folder).glob("*.html")}
        anchors = set(re.findall(r'id="pelagos\.([\w.]+)"', "".join(
            pages.values())))
        named = {anchor.split(".")[-1] for anchor in anchors}
        self.assertEqual(set(pelagos.__all__) - named - PLAIN, set())
        # A row of a docstring is an entry, an example is code.
        self.assertRegex(pages["ocean.html"],
                         r'<dt><code[^>]*><span class="pre">cafile</span>')
        self.assertRegex(pages["ocean.html"], r'<div class="highlight"><pre>'
                         r'<span></span><span class="n">ocean</span>')
        self.assertNotIn("system-message", "".join(pages.values()))

    def test_layout(self):
        text = ["Does a thing.", "", "name    what_ *it* is", "        and `x`",
                "other   last", "", "    code()", "", "End."]
        self.assertEqual(plaindoc.told(text), [
            "Does a thing.", "", "``name``", "   what\\_ \\*it\\* is",
            "   and ``x``", "``other``", "   last", "", "::", "",
            "       code()", "", "End.", ""])


if __name__ == "__main__":
    unittest.main(verbosity=2)
