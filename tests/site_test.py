#!/usr/bin/python3
"""The documentation site: it builds without a warning, every link within it
leads somewhere, its search finds what the pages say; a dead link is told."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[1]
BIN = pathlib.Path(os.environ.get("PELAGOS_BIN", ROOT / "build/release/bin"))
SITE = ROOT / "packaging/site"
sys.path.insert(0, str(SITE))
import mermaid  # noqa: E402


def run(*args):
    return subprocess.run([str(a) for a in args], capture_output=True,
                          text=True, timeout=600)


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="pelagos-site-")
        cls.addClassCleanup(folder.cleanup)
        cls.work = pathlib.Path(folder.name)
        cls.man = cls.work / "man"
        cls.man.mkdir()
        for name, command in (("pelagosd.8", ["pelagosd", "--print-man"]),
                              ("pelagosctl.1", ["pelagosctl", "manual"])):
            said = run(BIN / command[0], *command[1:])
            (cls.man / name).write_text(said.stdout, encoding="utf-8")
        cls.openapi = BIN.parent / "gen/openapi.json"
        cls.site = cls.work / "site"
        cls.build = run(SITE / "build.sh", cls.openapi, cls.man, cls.site)

    def test_builds_without_a_warning(self):
        self.assertEqual(self.build.returncode, 0, self.build.stderr)
        self.assertEqual(self.build.stderr, "")
        self.assertRegex(self.build.stdout,
                         r"^site: \d\d pages, \d{4,} links within")

    def text(self, page):
        return (self.site / page).read_text(encoding="utf-8")

    def test_pages(self):
        for page in (ROOT / "docs").glob("*.md"):
            if page.name.endswith(".in.md"):
                continue
            self.assertTrue(
                (self.site / "docs" / (page.stem + ".html")).is_file(), page)
        for page in (ROOT / "docs/physics").glob("*.md"):
            self.assertTrue(
                (self.site / "docs/physics" / (page.stem + ".html")).is_file(),
                page)
        for word in ("GET /v1/state", "PATCH /v1/state", "FrameRequest"):
            self.assertIn(word, self.text("http.html"))
        self.assertIn('id="pelagos.client.Ocean.surface"',
                      self.text("python.html"))
        self.assertIn("--token-file", self.text("programs.html"))
        for word in ('id="weatherfield"', "Mean wind speed 10 m above the sea"):
            self.assertIn(word, self.text("proto/manual.html"))
        self.assertRegex(self.text("docs/architecture.html"),
                         r"graphviz-[0-9a-f]+\.svg")
        self.assertGreater(
            len(list((self.site / "_images").glob("*.jpg"))), 40)

    def test_needs_no_network(self):
        for page in self.site.rglob("*.html"):
            for link in re.findall(r'<(?:script|link|img)[^>]*(?:src|href)='
                                   r'"([^"]*)"', page.read_text("utf-8")):
                self.assertNotRegex(link, "^(https?:)?//", page)

    def test_search(self):
        index = self.text("searchindex.js")
        for word in ("bathymetri", "watchdog", "caustic", "modbus"):
            self.assertIn(word, index)

    def tree(self):
        """A copy of what the pages are made of."""
        tree = self.work / self.id()
        for name in ("docs", "proto", "clients", "packaging",
                     "tests/validate"):
            shutil.copytree(ROOT / name, tree / name)
        for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md"):
            shutil.copy(ROOT / name, tree)
        return tree

    def prepare(self, tree):
        return run("/usr/bin/python3", "-B", SITE / "prepare.py", tree,
                   self.openapi, self.man, self.work / "source")

    def test_a_dead_link_is_told(self):
        tree = self.tree()
        self.assertEqual(self.prepare(tree).returncode, 0)
        with open(tree / "docs/lights.md", "a", encoding="utf-8") as f:
            f.write("\n[x](nowhere.md) `[y](neither.md)`\n"
                    "\n```\n[z](code.md)\n```\n")
        said = self.prepare(tree)
        self.assertEqual((said.returncode, said.stderr),
                         (1, "docs/lights.md: nowhere.md leads nowhere\n"))

    def test_a_dead_anchor_is_told(self):
        site = self.work / self.id()
        shutil.copytree(self.site, site)
        with open(site / "docs/lights.html", "a", encoding="utf-8") as f:
            f.write('<a href="models.html#no-such">x</a>')
        said = run("/usr/bin/python3", "-B", SITE / "links.py", site)
        self.assertEqual(said.returncode, 1)
        self.assertEqual(said.stderr, "docs/lights.html: "
                         "models.html#no-such has no such anchor\n")


class Charts(unittest.TestCase):
    def test_chart(self):
        said = mermaid.dot('flowchart LR\n subgraph s["a room"]\n'
                           '  a["x<br><b>y & z</b>"]\n end\n'
                           ' a -- "by, hand" --> b --> c["end"]\n')
        for part in ("rankdir=LR", "subgraph cluster_s { label=<a room>",
                     "a [label=<x<br/><b>y &amp; z</b>>];",
                     "a -> b [label=< by, hand >];", "b -> c;"):
            self.assertIn(part, said)
        dot = subprocess.run(["dot", "-Tsvg"], input=said, text=True,
                             capture_output=True, check=True)
        self.assertIn("by, hand", dot.stdout)
        self.assertEqual(dot.stderr, "")

    def test_what_it_is_not(self):
        for text in ("sequenceDiagram\n a->>b: x", "flowchart TB\n a ~~> b",
                     "flowchart TB\n subgraph x\n a --> b"):
            with self.assertRaises(ValueError):
                mermaid.dot(text)


if __name__ == "__main__":
    unittest.main()
