"""Flow charts of Mermaid as Graphviz' dot, for pages without scripts.

Only what `flowchart` has: nodes `name["text"]`, `subgraph name["text"]` … `end`,
edges `a --> b` and `a -- "text" --> b`. Anything else is a ValueError.
"""
import html
import re

NAME = r"([A-Za-z_]\w*)"
NODE = re.compile(NAME + r'(?:[\[(]+"?([^"\])]*)"?[\])]+)?')
EDGE = re.compile(r'\s*(?:--\s*"?(.*?)"?\s*-->|-->(?:\|"?(.*?)"?\|)?)\s*')
SUBGRAPH = re.compile(r"subgraph\s+" + NAME + r'(?:\["?(.*?)"?\])?$')
HEAD = """digraph {
  graph [fontname="Helvetica", fontsize=12, rankdir=%s, nodesep=0.3, compound=true];
  node [fontname="Helvetica", fontsize=11, shape=box, style="rounded,filled",
        fillcolor="#eef5fa", color="#4a7a96"];
  edge [fontname="Helvetica", fontsize=10, color="#4a7a96"];
"""


def label(text):
    """Mermaid's text, with <br> and <b>, as a label of dot."""
    text = html.escape(html.unescape(text), quote=False)
    for tag in ("br", "br/", "b", "/b", "i", "/i"):
        text = text.replace(f"&lt;{tag}&gt;",
                            f"<{'br/' if tag == 'br' else tag}>")
    return f"<{text}>"


def dot(text):
    """The chart as dot."""
    lines = [line.split("%%")[0].strip() for line in text.splitlines()]
    lines = [line for line in lines if line]
    first = re.fullmatch(r"(?:flowchart|graph)\s+(TB|TD|LR|RL|BT)", lines[0])
    if not first:
        raise ValueError(f"no flow chart: {lines[0]}")
    out = [HEAD % first[1].replace("TD", "TB")]
    depth = 0

    def node(line, at):
        found = NODE.match(line, at)
        if not found:
            raise ValueError(f"no node: {line}")
        if found[2] is not None:
            out.append(f"  {found[1]} [label={label(found[2])}];")
        elif not found[0]:
            raise ValueError(f"no node: {line}")
        return found[1], found.end()

    for line in lines[1:]:
        box = SUBGRAPH.match(line)
        if box:
            depth += 1
            out.append(f"  subgraph cluster_{box[1]} {{ "
                       f"label={label(box[2] or box[1])}; "
                       'style="rounded"; color="#9bb8c8";')
            continue
        if line == "end":
            depth -= 1
            out.append("  }")
            continue
        name, at = node(line, 0)
        while at < len(line):
            edge = EDGE.match(line, at)
            if not edge:
                raise ValueError(f"no edge: {line}")
            other, at = node(line, edge.end())
            said = edge[1] or edge[2]
            out.append(f"  {name} -> {other}" +
                       (f" [label={label(' ' + said + ' ')}]" if said else "")
                       + ";")
            name = other
    if depth:
        raise ValueError("a subgraph without its end")
    return "\n".join(out) + "\n}\n"
