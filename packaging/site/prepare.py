"""Lays out the sources of the documentation site.

prepare.py TREE OPENAPI.json MANUALS OUT

The Markdown is what the tree has; links to files that are no pages lead to
copies of these. A link without its target is an error. The pages of the HTTP
interface, of the programs and of the Python package are made here.
"""
import json
import pathlib
import posixpath
import re
import shutil
import subprocess
import sys

import mermaid

PHYSICS = ["waves", "foam", "wakes", "light", "water", "underwater", "bottom",
           "atmosphere", "clouds", "night", "space", "objects", "ships",
           "lamps", "eye", "sensors", "places"]
# Captions of the index and what stands below them; a page of docs/ or proto/
# that is not named here stands at the end of its folder's part.
PARTS = [
    ("Using it", "docs", ["docs/install.md", "docs/gallery/README.md",
                          "docs/page.md", "docs/models.md", "docs/lights.md",
                          "docs/datasets.md",
                          "docs/reliability.md", "docs/log.md",
                          "docs/benchmarks.md", "docs/planning.md"]),
    ("Interfaces", "proto", ["proto/manual.md", "http.md", "proto/live.md",
                             "programs.md", "clients/python/README.md",
                             "python.md",
                             "clients/ros2/pelagos_bridge/README.md"]),
    ("How it works", None, ["docs/life-of-a-frame.md",
                            "docs/life-of-an-edit.md", "docs/glossary.md",
                            "docs/physics/README.md",
                            *[f"docs/physics/{page}.md" for page in PHYSICS],
                            "docs/validation.md",
                            "tests/validate/undertrace/README.md",
                            "tests/validate/spacetrace/README.md",
                            "docs/architecture.md",
                            "docs/machines.md"]),
    ("Project", None, ["CHANGELOG.md", "CONTRIBUTING.md"]),
]
MADE = {"http.md", "programs.md", "python.md"}
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")
FENCE = re.compile(r"^(```+|~~~+)")


class Site:
    """The tree, the folder of the site's sources, what is wrong so far."""

    def __init__(self, tree, out):
        self.tree, self.out = pathlib.Path(tree), pathlib.Path(out)
        self.faults = []
        self.parts = []
        named = {page for _, _, pages in PARTS for page in pages}
        for caption, folder, pages in PARTS:
            pages = [p for p in pages
                     if p in MADE or (self.tree / p).is_file()]
            if folder:
                pages += sorted(
                    p for p in (f.relative_to(self.tree).as_posix()
                                for f in (self.tree / folder).glob("*.md"))
                    if not p.endswith(".in.md") and p not in named)
            self.parts.append((caption, pages))
        self.pages = {"README.md"} | {p for _, ps in self.parts for p in ps}

    def write(self, page, text):
        path = self.out / ("index.md" if page == "README.md" else page)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def target(self, page, link):
        """The link as the site has it."""
        path, _, anchor = link.partition("#")
        if re.match(r"[a-z][a-z0-9+.-]*:", link) or not path:
            return link
        found = posixpath.normpath(
            posixpath.join(posixpath.dirname(page), path))
        for index in ("README.md", "index.md"):
            if (self.tree / found / index).is_file():
                found = posixpath.join(found, index)
        if not (self.tree / found).is_file() and found not in MADE:
            self.faults.append(f"{page}: {link} leads nowhere")
            return link
        if found not in self.pages:
            copy = self.out / found
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(self.tree / found, copy)
            anchor = ""
        if found == "README.md":
            found = "index.md"
        back = posixpath.relpath(found, posixpath.dirname(page) or ".")
        return back + ("#" + anchor if anchor else "")

    def line(self, page, line):
        def one(match):
            mark, text, link = match.groups()
            # A picture may be the text of a link.
            text = LINK.sub(one, text)
            return f"{mark}[{text}]({self.target(page, link)})"
        # What is between backticks is code.
        pieces = re.split(r"(`+[^`]+`+)", line)
        if len(pieces) == 1 or not LINK.search(line):
            return LINK.sub(one, line)
        hidden = []
        for i in range(1, len(pieces), 2):
            hidden.append(pieces[i])
            pieces[i] = f"\0{len(hidden) - 1}\0"
        return re.sub("\0(\\d+)\0", lambda m: hidden[int(m[1])],
                      LINK.sub(one, "".join(pieces)))

    def whole_manual(self):
        """The manual with every message as a table: the tree leaves those to
        pelagos.proto."""
        made = self.out / "manual.md"
        self.out.mkdir(parents=True, exist_ok=True)
        proto = self.tree / "proto"
        subprocess.run(["/usr/bin/python3", "-B", proto / "fields.py", "whole",
                        proto / "pelagos.proto", made,
                        proto / "manual.in.md"], check=True)
        text = made.read_text(encoding="utf-8")
        made.unlink()
        return text

    def page(self, name):
        """A page of the tree, its links and charts as the site has them."""
        text = self.whole_manual() if name == "proto/manual.md" else \
            (self.tree / name).read_text(encoding="utf-8")
        out, fence, chart = [], None, []
        for line in text.split("\n"):
            mark = FENCE.match(line)
            if fence:
                if mark and line.strip() == fence:
                    if chart is not None:
                        out += self.chart(name, chart)
                    else:
                        out.append(line)
                    fence, chart = None, None
                elif chart is not None:
                    chart.append(line)
                else:
                    out.append(line)
            elif mark:
                fence = mark[1]
                chart = [] if line.strip() == fence + "mermaid" else None
                if chart is None:
                    out.append(line)
            else:
                out.append(self.line(name, line))
        return "\n".join(out)

    def chart(self, page, lines):
        try:
            return ["```{graphviz}", mermaid.dot("\n".join(lines)), "```"]
        except ValueError as e:
            print(f"{page}: a chart stays text: {e}", file=sys.stderr)
            return ["```text", *lines, "```"]

    def index(self):
        out = [self.page("README.md"), ""]
        for caption, pages in self.parts:
            out += ["```{toctree}", ":hidden:", f":caption: {caption}", ""]
            out += [p.removesuffix(".md") for p in pages] + ["```", ""]
        self.write("README.md", "\n".join(out))


def cell(text):
    return " ".join(str(text).split()).replace("|", "\\|")


def http_page(document):
    """The OpenAPI document for people; links of its texts are the manual's."""
    def text_of(thing):
        return re.sub(r"\]\(#", "](proto/manual.md#",
                      thing.get("description", ""))

    def resolve(thing):
        while "$ref" in thing:
            at = document
            for key in thing["$ref"][2:].split("/"):
                at = at[key.replace("~1", "/").replace("~0", "~")]
            thing = at
        return thing

    def form(schema):
        if "$ref" in schema:
            name = schema["$ref"].split("/")[-1]
            return f"`{name}`"
        if "anyOf" in schema or "oneOf" in schema:
            return " or ".join(map(form, schema.get("anyOf",
                                                    schema.get("oneOf"))))
        kind = schema.get("type", "any")
        return ", ".join(kind) if isinstance(kind, list) else kind

    def content(kind, what):
        said = form(what.get("schema", {}))
        return kind if said == "any" else f"{kind}: {cell(said)}"

    def limits(schema):
        said = []
        if "enum" in schema:
            said.append(", ".join(f"`{v}`" for v in schema["enum"]))
        if "minimum" in schema or "maximum" in schema:
            said.append(f"{schema.get('minimum', '')} to "
                        f"{schema.get('maximum', '')}")
        if schema.get("x-unit", "1") != "1":
            said.append(schema["x-unit"])
        return " ".join(said)

    out = ["# HTTP interface", "",
           "What `GET /v1/openapi.json` answers, for people; the document "
           "itself, for [generators of clients](openapi.json), is OpenAPI "
           f"{document['openapi']}. The [manual](proto/manual.md) has the "
           "messages, field by field.", "",
           "What has a default may be left out of a request; "
           "`openapi-typescript` has to be told so, by "
           "`--default-non-nullable=false`.", ""]
    for path, item in sorted(document["paths"].items()):
        for method, operation in item.items():
            if method in ("parameters", "summary", "description"):
                continue
            out += [f"## {method.upper()} {path}", "",
                    text_of(operation) or operation.get("summary", ""), ""]
            parameters = [resolve(p) for p in item.get("parameters", [])
                          + operation.get("parameters", [])]
            if parameters:
                out += ["| parameter | in | form | range | |",
                        "|---|---|---|---|---|"]
                for p in parameters:
                    schema = p.get("schema", {})
                    out.append("| `{}` | {} | {} | {} | {} |".format(
                        p["name"], p["in"], cell(form(schema)),
                        cell(limits(schema)), cell(text_of(p))))
                out.append("")
            out += ["| status | body |", "|---|---|"]
            body = operation.get("requestBody")
            for kind, what in (resolve(body)["content"].items()
                               if body else ()):
                out.append(f"| request | {content(kind, what)} |")
            for status, answer in operation["responses"].items():
                contents = resolve(answer).get("content", {})
                out.append("| {} | {} |".format(status, "<br>".join(
                    content(*c) for c in contents.items()) or "none"))
            out.append("")
    return "\n".join(out)


def programs_page(folder):
    """The manual pages as a terminal of 80 columns shows them."""
    out = ["# Programs", ""]
    for page in sorted(pathlib.Path(folder).glob("*.[18]")):
        said = subprocess.run(
            ["groff", "-mandoc", "-Tutf8", "-Kutf8", "-P-cbou", "-rLL=80n",
             page], capture_output=True, check=True).stdout.decode()
        said = re.sub(r".\x08", "", said)
        out += [f"## {page.stem}", "", "```text", said.strip("\n"), "```", ""]
    return "\n".join(out)


def python_page(tree):
    """Every public module of the package, by autodoc."""
    out = ["# Python package", "", "What `import pelagos` has. Its "
           "[introduction](clients/python/README.md) comes first.", ""]
    folder = tree / "clients/python/pelagos"
    # The client first: it is where a reader starts.
    names = sorted((f.stem for f in folder.glob("*.py")
                    if f.stem not in ("__init__", "need")),
                   key=lambda n: (n != "client", n != "parts", n == "schema", n))
    for name in names:
        out += [f"## pelagos.{name}", "", "```{eval-rst}",
                f".. automodule:: pelagos.{name}", "   :members:",
                "   :undoc-members:" if name == "errors" else "", "```", ""]
    return "\n".join(out)


def main():
    tree, openapi, manuals, out = map(pathlib.Path, sys.argv[1:])
    shutil.rmtree(out, ignore_errors=True)
    site = Site(tree, out)
    for page in sorted(site.pages - MADE - {"README.md"}):
        site.write(page, site.page(page))
    site.index()
    with open(openapi, encoding="utf-8") as f:
        site.write("http.md", http_page(json.load(f)))
    shutil.copyfile(openapi, out / "openapi.json")
    site.write("programs.md", programs_page(manuals))
    site.write("python.md", python_page(tree))
    here = pathlib.Path(__file__).parent
    (out / "_static").mkdir()
    shutil.copyfile(here / "site.css", out / "_static/site.css")
    shutil.copyfile(here / "conf.py", out / "conf.py")
    for fault in site.faults:
        print(fault, file=sys.stderr)
    sys.exit(bool(site.faults))


if __name__ == "__main__":
    main()
