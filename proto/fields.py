#!/usr/bin/env python3
"""Derives tables from the comments of pelagos.proto.

fields.py c PROTO OUT.c                    the table behind fields.h
fields.py manual PROTO OUT.md TEMPLATE.md  the manual: the template with its
                                           tables; `whole` adds every message
fields.py python PROTO OUT.py              the state as Python's dataclasses
"""
import keyword
import os
import re
import subprocess
import sys
import tempfile
import textwrap

import deffile
from google.protobuf import descriptor_pb2

F = descriptor_pb2.FieldDescriptorProto
TEXT_BYTES = "TEXT_BYTES"  # of a text that says nothing else
NUMBERS = {F.TYPE_DOUBLE, F.TYPE_FLOAT, F.TYPE_INT32, F.TYPE_INT64,
           F.TYPE_UINT32, F.TYPE_UINT64, F.TYPE_SINT32, F.TYPE_SINT64,
           F.TYPE_FIXED32, F.TYPE_FIXED64, F.TYPE_SFIXED32, F.TYPE_SFIXED64}
BRACKET = re.compile(r"\s*\[([^\][]*)\]\s*$")
TYPE_NAMES = {F.TYPE_DOUBLE: "double", F.TYPE_FLOAT: "float",
              F.TYPE_UINT32: "uint32", F.TYPE_UINT64: "uint64",
              F.TYPE_FIXED64: "fixed64",
              F.TYPE_INT32: "int32", F.TYPE_INT64: "int64",
              F.TYPE_SINT32: "sint32", F.TYPE_SINT64: "sint64",
              F.TYPE_BOOL: "bool", F.TYPE_STRING: "string",
              F.TYPE_BYTES: "bytes"}


class SchemaError(Exception):
    pass


def read_schema(path):
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "set")
        subprocess.run(["protoc", "--proto_path=" + os.path.dirname(path),
                        "--include_source_info", "--descriptor_set_out=" + out,
                        path], check=True)
        with open(out, "rb") as f:
            files = descriptor_pb2.FileDescriptorSet.FromString(f.read())
    return files.file[0]


def bounds():
    """Rows of bounds.def."""
    return deffile.rows(os.path.join(os.path.dirname(os.path.abspath(
        __file__)), "bounds.def"), "PEL_BOUND")


class Field:
    def __init__(self, proto, comment, where):
        self.proto = proto
        self.where = where
        self.name = proto.json_name
        self.unit = self.minimum = self.maximum = None
        self.most_bytes = None  # the name of a bound; of a text
        self.key = False
        text = " ".join(comment.split())
        match = BRACKET.search(text)
        self.doc = text[:match.start()] if match else text
        if match:
            self.read_bracket(match.group(1))

    def read_bracket(self, text):
        parts = [p.strip() for p in text.split(";")]
        if parts[-1].startswith("at most "):
            self.most_bytes = parts.pop()[len("at most "):]
            if self.most_bytes not in BOUNDS:
                raise SchemaError(f"{self.where}: bounds.def has no "
                                  f"{self.most_bytes}")
            if not parts:
                return
        if len(parts) > 2 or not parts[0]:
            raise SchemaError(f"{self.where}: cannot read [{text}]")
        if parts[0] == "key":
            self.key = True
        else:
            self.unit = parts[0]
        if len(parts) == 2:
            ends = parts[1].split("..")
            try:
                self.minimum, self.maximum = (float(e) for e in ends)
            except ValueError:
                raise SchemaError(f"{self.where}: cannot read the range in "
                                  f"[{text}]; write [unit; min .. max]")
            if not self.minimum < self.maximum:
                raise SchemaError(f"{self.where}: empty range [{text}]")

    @property
    def number(self):
        return self.proto.type in NUMBERS

    @property
    def bound(self):
        """The name of what bounds a text."""
        return self.most_bytes or TEXT_BYTES

    @property
    def repeated(self):
        return self.proto.label == F.LABEL_REPEATED


BOUNDS = {row[0]: int(row[1]) for row in bounds()}


class Schema:
    def __init__(self, path):
        self.file = read_schema(path)
        self.comments = {tuple(l.path): l.leading_comments
                         for l in self.file.source_code_info.location}
        self.messages = {}  # name -> (doc, fields by number)
        self.enums = {}     # name -> (doc, [(name, number, doc)])
        for i, message in enumerate(self.file.message_type):
            if message.nested_type or message.enum_type:
                raise SchemaError(f"{message.name}: nested types are not used")
            fields = [Field(f, self.comments.get((4, i, 2, k), ""),
                            f"{message.name}.{f.name}")
                      for k, f in enumerate(message.field)]
            # protobuf-c sorts descriptors by number.
            fields.sort(key=lambda f: f.proto.number)
            self.messages[message.name] = (self.comment(4, i), fields)
        for i, enum in enumerate(self.file.enum_type):
            values = [(v.name, v.number, self.comment(5, i, 2, k))
                      for k, v in enumerate(enum.value)]
            self.enums[enum.name] = (self.comment(5, i), values)
        self.check_state("State", "")

    def comment(self, *path):
        return " ".join(self.comments.get(path, "").split())

    def check_state(self, name, parents):
        """Numbers below State need a unit; types must not recurse."""
        if name in parents.split("/"):
            raise SchemaError(f"{name} contains itself: protobuf-c has no "
                              "depth limit")
        for field in self.messages[name][1]:
            if field.proto.type == F.TYPE_MESSAGE:
                child = field.proto.type_name.split(".")[-1]
                self.check_state(child, parents + "/" + name)
            elif field.number and field.unit is None and not field.key:
                raise SchemaError(
                    f"{field.where} is a number without a unit: end its "
                    "comment with [unit; min .. max], [unit] or [key]")


def quote(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def write_c(schema, path):
    out = ["/* Generated by proto/fields.py from pelagos.proto. */",
           '#include "fields.h"', "", '#include "bounds.h"', '#include "pelagos.pb-c.h"', ""]
    for name, (_, fields) in schema.messages.items():
        if not fields:
            continue
        out.append(f"static const struct pel_field {name.lower()}_fields[] = {{")
        for f in fields:
            ranged = f.minimum is not None
            out.append("    { %s, %s, %s, %r, %r, %s, PEL_BOUND_%s,\n"
                       "      %s }," % (
                quote(f.name), quote(f.unit) if f.unit else "NULL",
                "true" if ranged else "false",
                f.minimum if ranged else 0.0, f.maximum if ranged else 0.0,
                "true" if f.key else "false", f.bound, quote(f.doc)))
        out.append("};")
        out.append("")
    out.append("const struct pel_field_table pel_field_tables[] = {")
    for name, (doc, fields) in schema.messages.items():
        symbol = re.sub(r"(?<!^)([A-Z])", r"_\1", name).lower()
        table = f"{name.lower()}_fields" if fields else "NULL"
        out.append(f"    {{ &pelagos__{symbol}__descriptor, {table},\n"
                   f"      {quote(doc)} }},")
    out.append("};")
    out.append("const size_t pel_field_table_count =")
    out.append("    sizeof pel_field_tables / sizeof pel_field_tables[0];")
    with open(path, "w", encoding="utf-8") as f:
        f.write("\n".join(out) + "\n")


def plain(number):
    return f"{number:.15g}"


def type_of(field):
    proto = field.proto
    name = TYPE_NAMES.get(proto.type)
    if name is None:
        name = proto.type_name.split(".")[-1]
        name = f"[{name}](#{name.lower()})"
    return name + (" list" if field.repeated else "")


def range_of(field):
    if field.most_bytes:
        return f"at most {BOUNDS[field.most_bytes]} bytes"
    if field.minimum is None:
        return ""
    return f"{plain(field.minimum)} to {plain(field.maximum)}"


def short(number):
    """A number with no more than eight characters where it has a power."""
    text = plain(number)
    power = f"{number:.6g}".replace("e+0", "e").replace("e+", "e")
    return power if len(text) > 8 and float(power) == number else text


def form_of(field):
    """Type, unit, range, default: `m/s, 0..30, = 8`; a double is not named
    where anything else is said."""
    parts = [field.unit if field.unit != "1" else ""]
    if field.most_bytes or field.minimum is None:
        parts.append(range_of(field))
    else:
        parts.append(f"{short(field.minimum)}..{short(field.maximum)}")
    default = default_of(field)
    parts.append("= " + (default if default.startswith("`")
                         else short(float(default))) if default else "")
    parts = [part for part in parts if part]
    kind = type_of(field)
    return ", ".join(parts if kind == "double" and parts else [kind] + parts)


def default_of(field):
    proto = field.proto
    if not proto.HasField("default_value"):
        return ""
    if field.number:
        return plain(float(proto.default_value))
    return f"`{proto.default_value}`"


def sentence(field):
    oneof = "One of these. " if field.proto.HasField("oneof_index") else ""
    key = "Key of the list. " if field.key else ""
    return (oneof + key + field.doc).strip().replace("|", "\\|")


def table(head, rows):
    """A table, without the columns that are empty throughout."""
    used = [i for i in range(len(head)) if any(row[i] for row in rows)]
    lines = [[head[i] for i in used], ["---"] * len(used)]
    lines += [[row[i] for i in used] for row in rows]
    return ["|" + "|".join(f" {cell} " if cell != "---" else cell
                           for cell in line) + "|" for line in lines]


def layers():
    return deffile.rows(os.path.join(os.path.dirname(__file__), "layers.def"),
                        "PEL_LAYER")


def layer_table():
    out = []
    for _, _, name, channels, samples, unit, source, text in layers():
        prefix = "" if source == "LIGHT" else name + "."
        wide = ", always 32 bits" if samples == "FLOAT" else ""
        out.append([f"`{name}`", f"`{prefix}{' '.join(channels)}`{wide}",
                    "" if unit == "1" else unit, text])
    return table(["layer", "channels", "unit", ""], out)


def formats():
    return deffile.rows(os.path.join(os.path.dirname(__file__), "formats.def"),
                        "PEL_FORMAT")


def models():
    """Rows of kinds.def."""
    return deffile.rows(os.path.join(os.path.dirname(os.path.dirname(
        os.path.abspath(__file__))), "server/models/kinds.def"),
        "PEL_BUILTIN")


def format_table():
    return table(["format", "ending", "Content-Type", ""],
                 [[f"`{name}`", f"`.{ending}`", f"`{mime}`", text]
                  for name, ending, mime, _, _, text in formats()])


def bound_table():
    out = []
    for _, value, unit, where, what, after, counter in bounds():
        number = int(value)
        if unit == "bytes" and number % 1024 == 0:
            shown = (f"{number >> 20} MiB" if number % (1 << 20) == 0
                     else f"{number >> 10} KiB")
        else:
            shown = f"{number:,} {unit}".strip()
        out.append([where, what, shown, after, ", ".join(
            f"`{name}`" for name in counter.replace('\\"', '"').split(", "))])
    return table(["", "what", "at most", "what happens to the next",
                  "counter of `/metrics`"], out)


def routes():
    """Method, path, flags, handler, query, body, answer, text."""
    return deffile.rows(os.path.join(os.path.dirname(__file__), "routes.def"),
                        "PEL_ROUTE")


def route_table():
    return table(["method and path", "body", "answer"],
                 [[f"`{method} /{path}`",
                   {"merge": "merge patch", "sdp": "SDP"}[body]
                   if body in ("merge", "sdp") else
                   f"[{body}](#{body.lower()})" if body else "", text]
                  for method, path, _, _, _, body, _, text in routes()])


def lax_routes():
    """Those that ignore parameters which they do not know."""
    names = [f"`/{path}`" for _, path, flags, *_ in routes()
             if "ROUTE_LAX" in flags]
    return [name + "," for name in names[:-1]] + [names[-1] + "."]


TABLES = {"@layers@": layer_table, "@formats@": format_table,
          "@bounds@": bound_table, "@routes@": route_table,
          "@lax@": lax_routes}


def message_tables(schema):
    """Lines of the schema's messages and enums, a table each."""
    out = []
    for name, (doc, fields) in schema.messages.items():
        out += ["", f"## {name}"] + ([doc] if doc else [])
        if fields:
            out += [""] + table(
                ["field", "form", "meaning"],
                [[f"`{f.name}`", form_of(f), sentence(f)] for f in fields])
    for name, (doc, values) in schema.enums.items():
        out += ["", f"## {name}"] + ([doc] if doc else []) + [""]
        out += table(["value", "no.", "meaning"],
                     [[f"`{v}`", str(n), d] for v, n, d in values])
    return out


def write_manual(schema, path, template, whole):
    """The template with its tables; whole: and every message, as the site has
    it, where the tree has pelagos.proto for that."""
    with open(template, encoding="utf-8") as f:
        out = f.read().rstrip().split("\n")
    for name, make in TABLES.items():
        place = out.index(name)
        out[place:place + 1] = make()
    if whole:
        out += message_tables(schema)
    else:
        names = "|".join(n.lower() for n in [*schema.messages, *schema.enums])
        out = [re.sub(rf"\]\(#({names})\)", "](pelagos.proto)", line)
               for line in out]
    with open(path, "w", encoding="utf-8") as f:
        f.write("\n".join(out) + "\n")


PYTHON_TYPES = {F.TYPE_STRING: "str", F.TYPE_BOOL: "bool",
                F.TYPE_DOUBLE: "float", F.TYPE_FLOAT: "float"}


# The state, and the answers that the client reads into classes.
PYTHON_ROOTS = ("State", "Spectrum", "Optics", "Models", "FrameTruth")


def python_name(field):
    """`class` is `class_`."""
    return field.name + ("_" if keyword.iskeyword(field.name) else "")


def wrapped_words(words):
    """Lines that together are the words."""
    lines = textwrap.wrap(words, 62)
    return [line + " " for line in lines[:-1]] + lines[-1:]


def python_field(field, enums):
    """`name: type = _field(default, unit, minimum, maximum)`; of an enumeration
    its words instead of a unit."""
    proto = field.proto
    words = ""
    kind = PYTHON_TYPES.get(proto.type, "int")
    default = "None"
    if proto.type in (F.TYPE_MESSAGE, F.TYPE_ENUM):
        kind = proto.type_name.split(".")[-1]
    if kind in enums:
        words = " ".join(value for value, _, _ in enums[kind][1])
        kind = "str"
    if field.repeated:
        return f"    {python_name(field)}: tuple[{kind}, ...] = ()"
    if proto.HasField("default_value"):
        text = proto.default_value
        default = (repr(text) if kind == "str" else
                   text.capitalize() if kind == "bool" else
                   repr(float(text)) if kind == "float" else text)
    if default == "None":
        kind += " | None"
    ends = [default]
    if field.minimum is not None:
        ends += [repr(field.unit), plain(field.minimum), plain(field.maximum)]
    elif field.unit is not None:
        ends.append(repr(field.unit))
    text = ", ".join(ends)
    if words:
        text += ",\n        words=" + "\n        ".join(
            f'"{line}"' for line in wrapped_words(words))
    return f"    {python_name(field)}: {kind} = _field({text})"


def python_order(schema, name, out):
    """The messages below `name`, those first that others need."""
    for field in schema.messages[name][1]:
        if field.proto.type == F.TYPE_MESSAGE:
            python_order(schema, field.proto.type_name.split(".")[-1], out)
    if name not in out:
        out.append(name)
    return out


def comment_lines(text, indent, prefix):
    return textwrap.wrap(text, 79, initial_indent=indent + prefix,
                         subsequent_indent=indent + prefix)


def write_python(schema, path, version):
    out = ['"""The state and answers as dataclasses: made by `make manual` from',
           'proto/pelagos.proto; edit that.',
           '',
           "Names are those of the wire, with `_` behind those that Python keeps for",
           'itself (`class_`). Angles are degrees. None: absent."""',
           "from __future__ import annotations", "",
           "from dataclasses import dataclass", "",
           "from .record import Record, _field", "",
           "#: Of the client, and of the daemon that it was made with.",
           f'VERSION = "{version}"', "",
           "#: The layers of an EXR picture.", "LAYERS = ("]
    out += [f'    "{row[2]}",' for row in layers()] + [")"]
    out += ["", "#: The formats of pictures, by their endings.",
            "FORMATS = (" + ", ".join(f'"{row[1]}"' for row in formats()) + ")",
            "#: Those of them with layers of floats.", "LINEAR_FORMATS = ("
            + "".join(f'"{row[1]}",' for row in formats()
                      if "PEL_FORMAT_LAYERS" in row[4]) + ")"]
    out += ["#: What entities are, in the order of the layer `class`.",
            "MODEL_CLASSES = ("]
    out += [f'    "{name}",' for name, _, _ in schema.enums["ModelClass"][1]]
    out += [")", "", "#: Length and beam of the built-in models [m].",
            "MODEL_SIZES = {"]
    out += [f'    "{row[0]}": ({row[3]}, {row[4]}),' for row in models()]
    out += ["}"]
    order = []
    for root in PYTHON_ROOTS:
        python_order(schema, root, order)
    for name in order:
        doc, fields = schema.messages[name]
        out += ["", "", "@dataclass(frozen=True)", f"class {name}(Record):"]
        text = textwrap.wrap(f'"""{doc or name + "."}"""', 79,
                             initial_indent="    ", subsequent_indent="    ")
        out += text
        for field in fields:
            parts = [part for part in (field.unit, range_of(field)) if part]
            bracket = f" [{'; '.join(parts)}]" if parts else ""
            out += comment_lines(field.doc + bracket, "    ", "#: ")
            if field.proto.type == F.TYPE_ENUM:
                kind = field.proto.type_name.split(".")[-1]
                values = ", ".join(v for v, _, _ in schema.enums[kind][1])
                out += comment_lines(f"One of {values}.", "    ", "#: ")
            out.append(python_field(field, schema.enums))
    with open(path, "w", encoding="utf-8") as f:
        f.write("\n".join(out) + "\n")


def main(argv):
    if len(argv) == 4 and argv[1] == "c":
        write_c(Schema(argv[2]), argv[3])
    elif len(argv) == 5 and argv[1] == "python":
        write_python(Schema(argv[2]), argv[3], argv[4])
    elif len(argv) == 5 and argv[1] in ("manual", "whole"):
        write_manual(Schema(argv[2]), argv[3], argv[4], argv[1] == "whole")
    else:
        raise SchemaError("usage: fields.py c PROTO OUT | python PROTO OUT "
                          "VERSION | manual | whole PROTO OUT TEMPLATE")


if __name__ == "__main__":
    try:
        main(sys.argv)
    except SchemaError as error:
        sys.exit(f"pelagos.proto: {error}")
