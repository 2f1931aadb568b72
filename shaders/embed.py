#!/usr/bin/env python3
"""Flattens, validates and embeds the shaders.

usage: embed.py OUT.c SHADER...

`#include "lib/x.glsl"` is replaced by the file, once for each shader. What is
embedded is exactly what glslangValidator saw, with a line map so that a
compiler's message can be traced to its file. lib/layers.glsl is made here from
proto/layers.def, and embedded by itself too, for PELAGOS_SHADER_DIR.
"""
import os
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "proto"))
import deffile  # noqa: E402

LAYERS = "lib/layers.glsl"
TYPES = {1: "float", 2: "vec2", 3: "vec3"}
STORED = {1: "vec4({})", 2: "vec4({}, 0.0, 0.0)", 3: "vec4({}, 1.0)"}
INCLUDE = re.compile(r'^\s*#include\s+"([^"]+)"\s*$')


def layers_glsl(table):
    """What the shading of a pixel gives, and each layer by its place; what has
    the first row's unit is light."""
    table = deffile.rows(table, "PEL_LAYER")
    rows = [(i, row[1], len(row[3]), row[6]) for i, row in enumerate(table)]
    light = [row[1] for row in table if row[5] == table[0][5]]
    guards = (("SURFACE", "PEL_LAYERS"), ("WATER", "PEL_WATER_PARTS"))
    out = ["// Made from proto/layers.def by shaders/embed.py."]
    out += [f"const int AT_{name.upper()} = {i};" for i, name, _, _ in rows]
    out += ["", "struct shaded {", "    vec3 radiance;"]
    for source, guard in guards:
        out += [f"#ifdef {guard}"]
        out += [f"    {TYPES[n]} {name};" for _, name, n, of in rows
                if of == source]
        out += ["#endif"]
    out += ["};", "", "// Adds all that is light.",
            "void add_light(inout shaded sum, shaded s, float weight)", "{",
            "    sum.radiance += weight * s.radiance;"]
    for source, guard in guards:
        out += [f"#ifdef {guard}"]
        out += [f"    sum.{name} += weight * s.{name};"
                for _, name, _, of in rows if of == source and name in light]
        out += ["#endif"]
    out += ["}", "", "// Puts other light in its place.",
            "void take_light(inout shaded s, shaded light)", "{",
            "    s.radiance = light.radiance;"]
    for source, guard in guards:
        out += [f"#ifdef {guard}"]
        out += [f"    s.{name} = light.{name};"
                for _, name, _, of in rows if of == source and name in light]
        out += ["#endif"]
    out += ["}", "", "// Without any layer but this.",
            "shaded only_light(vec3 radiance)", "{", "    shaded s;",
            "    s.radiance = radiance;"]
    for source, guard in guards:
        out += [f"#ifdef {guard}"]
        out += [f"    s.{name} = {TYPES[n]}(0.0);" for _, name, n, of in rows
                if of == source]
        out += ["#endif"]
    out += ["    return s;", "}", "", "#ifdef PEL_LAYERS",
            "vec4 layer_of(shaded s, int layer)", "{", "    switch (layer) {"]
    for source, guard in guards:
        out += [f"#ifdef {guard}"]
        for i, name, n, of in rows:
            if of == source:
                out += [f"    case {i}:",
                        f"        return {STORED[n].format('s.' + name)};"]
        out += ["#endif"]
    out += ["    }", "    return vec4(0.0);", "}", "#endif"]
    return out


def flatten(path, root, seen, out):
    if path == os.path.join(root, LAYERS):
        table = os.path.join(root, "..", "proto", "layers.def")
        lines = layers_glsl(table)
    else:
        with open(path, encoding="utf-8") as file:
            lines = file.read().splitlines()
    for number, line in enumerate(lines, 1):
        match = INCLUDE.match(line)
        if not match:
            out.append((os.path.relpath(path, root), number, line))
            continue
        inner = os.path.join(root, match.group(1))
        if inner not in seen:
            seen.add(inner)
            flatten(inner, root, seen, out)


def validate(path, text, stage):
    with tempfile.NamedTemporaryFile("w", suffix="." + stage, delete=False) as f:
        f.write(text)
    run = subprocess.run(["glslangValidator", f.name], capture_output=True,
                         text=True)
    os.unlink(f.name)
    if run.returncode != 0:
        sys.exit(f"{path}: not valid GLSL\n{run.stdout}{run.stderr}")


def c_string(text):
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return "\n".join(f'    "{line}\\n"' for line in escaped.split("\n"))


def main():
    out_path, paths = sys.argv[1], sorted(sys.argv[2:])
    root = os.path.dirname(os.path.abspath(paths[0])) if paths else "."
    paths.append(os.path.join(root, LAYERS))
    entries, chunks = [], []
    for index, path in enumerate(paths):
        lines = []
        flatten(path, root, set(), lines)
        text = "\n".join(line for _, _, line in lines)
        if not path.endswith(LAYERS):
            validate(path, text, path.rsplit(".", 1)[1])
        runs, last = [], None
        for flat, (name, number, _) in enumerate(lines, 1):
            if last is None or name != last[0] or number != last[1] + 1:
                runs.append(f'    {{ {flat}, {number}, "{name}" }},')
            last = (name, number)
        chunks.append(f"static const char text_{index}[] =\n{c_string(text)};\n"
                      f"static const struct pel_shader_line lines_{index}[] = {{\n"
                      + "\n".join(runs) + "\n};\n")
        entries.append(f'    {{ "{os.path.relpath(path, root)}", text_{index}, '
                       f"lines_{index}, {len(runs)} }},")
    with open(out_path, "w", encoding="utf-8") as f:
        f.write("/* generated by shaders/embed.py */\n"
                '#include "render/shader.h"\n\n' + "\n".join(chunks)
                + "\nconst struct pel_shader_source pel_shader_sources[] = {\n"
                + "\n".join(entries)
                + "\n    { 0 },\n};\n")


if __name__ == "__main__":
    main()
