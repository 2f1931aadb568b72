#!/usr/bin/env python3
"""Writes the OpenAPI 3.1 document of /v1/openapi.json.

openapi.py PROTO VERSION OUT.json

Paths are the rows of routes.def, forms the messages of the schema with their
units (`x-unit`), ranges and defaults. What is neither is in FORMS and ANSWERS.
"""
import json
import os
import re
import sys

import deffile
import fields
from google.protobuf import descriptor_pb2

F = descriptor_pb2.FieldDescriptorProto
LONG = {F.TYPE_INT64, F.TYPE_UINT64, F.TYPE_SINT64, F.TYPE_FIXED64,
        F.TYPE_SFIXED64}
UNSIGNED = {F.TYPE_UINT32, F.TYPE_FIXED32}
PARTS = re.compile(r"\{(\w+)\}")
LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")

TEXT = {"type": "string"}
COUNT = {"type": "integer", "minimum": 0}
NUMBER = {"type": "number"}


def refer(name, kind="schemas"):
    return {"$ref": f"#/components/{kind}/{name}"}


def form(properties, required=(), text=""):
    out = {"type": "object", "properties": properties,
           "additionalProperties": False}
    if required:
        out["required"] = list(required)
    if text:
        out["description"] = text
    return out


def forms(schema):
    """JSON that no message of the schema describes."""
    codes = [name for name, _, _ in schema.enums["ErrorCode"][1]]
    value = {"description": "as the field is in State; null: absent"}
    words = {"type": "array", "items": TEXT}
    missing = form({"path": TEXT, "value": TEXT, "reason": TEXT},
                   ("path", "value", "reason"))
    told = {"path": TEXT, "unit": TEXT, "minimum": NUMBER, "maximum": NUMBER}
    return {
        "Problem": form(
            {"type": {"const": "about:blank"}, "title": TEXT,
             "status": {"type": "integer", "minimum": 400, "maximum": 599},
             "code": {"type": "string", "enum": codes},
             "detail": TEXT, "value": TEXT, **told},
            ("type", "title", "status", "code"),
            "Why a request was refused, as RFC 9457 has it: the field at fault "
            "by its path, its value, unit and legal range."),
        "Health": form(
            {"status": {"enum": ["ok", "stuck", "stopping"]}, "version": TEXT,
             "revision": {"type": "string", "pattern": "^[0-9]+$"},
             "missing": {"type": "array", "items": missing}, "device": TEXT,
             "role": {"enum": ["watch", "steer", "instruct"]},
             "quality": {"type": "number", "minimum": 0, "maximum": 1}},
            ("status",)),
        "Ready": form(
            {"status": {"enum": ["ready", "starting", "joining", "stuck",
                                 "stopping"]}}, ("status",)),
        "Session": form({"role": {"enum": ["watch", "steer", "instruct"]},
                         "routes": words, "fields": words},
                        ("role", "routes", "fields")),
        "FieldValue": form({"value": value, **told}, ("path", "value")),
        "Fields": form({"fields": {"type": "array", "items": form(
            {"doc": TEXT, "values": words, "unusable": words, "spectra": words,
             **told},
            ("path", "doc"))}}, ("fields",)),
        "Views": form({"views": {"type": "array", "items": refer("View")}},
                      ("views",)),
        "Presets": form({"presets": {"type": "array",
                                     "items": refer("Preset")}},
                        ("presets",)),
    }


IGNORED = "X-Pelagos-Ignored"
HEADERS = {
    "ETag": ("revision of the state, for If-Match", TEXT),
    "X-Pelagos-Frame": ("frame number, counted since the daemon's start",
                        COUNT),
    "X-Pelagos-Time": ("simulated time that the picture shows [s]", NUMBER),
    "X-Pelagos-Revision": ("of the state that it shows", COUNT),
    "X-Pelagos-Stale": ("inputs that were silent; `poses` is no input: a ship "
                        "that moves stands, since her last pose is older than "
                        "clock.reckoning; `none`", TEXT),
    "X-Pelagos-Notice": ("what an edit switched off besides", TEXT),
    "X-Pelagos-Ground": ("`inside`: the camera is in the ground", TEXT),
    "X-Pelagos-Host-Frame": ("newest frame of a CIGI host", COUNT),
    "X-Pelagos-Unix": ("the daemon's clock as it answers: UTC [s]", NUMBER),
    "X-Pelagos-Render-Ms": ("drawing [ms]", NUMBER),
    "X-Pelagos-Encode-Ms": ("encoding [ms]", NUMBER),
    "X-Pelagos-Device": ("that drew it, of several from 0", COUNT),
    IGNORED: ("parameters that are not known here, percent-encoded", TEXT),
}
MOMENT = [name for name in HEADERS if name.startswith("X-") and
          not name.endswith(("-Ms", "-Unix", "-Device", "-Ignored",
                             "-Notice"))]
COST = ["X-Pelagos-Render-Ms", "X-Pelagos-Encode-Ms", "X-Pelagos-Device"]
TAGGED = ("State", "FieldValue")
# Answers that are not JSON: type, headers.
ANSWERS = {
    "page": (("text/html", "text/css", "text/javascript", "application/json",
              "image/svg+xml"), ["ETag"]),
    "metrics": (("text/plain",), []),
    "csv": (("text/csv",), []),
    "soundings": (("application/octet-stream",), []),
    "schema": (("text/plain",), ["ETag"]),
    "pictures": (("multipart/mixed",), MOMENT),
    "mjpeg": (("multipart/x-mixed-replace",), ["X-Pelagos-Unix"]),
    "ts": (("video/mp2t",), ["X-Pelagos-Unix"]),
    "hls": (("application/vnd.apple.mpegurl",), []),
    "hlsPart": (("video/mp2t",), []),
}


SDP = "application/sdp"


def edits(method, path):
    """Whether it changes the state."""
    return (method in ("PATCH", "PUT", "DELETE") and
            not path.startswith(("v1/whep", "v1/cluster")))


# Forms that an answer may be asked for in, beside JSON.
FILES = {"Series": ("text/csv", "application/netcdf"),
         "Spectrum": ("text/plain", "application/netcdf", "application/x-tar")}
# A value of parameters that have a form of their own.
EXAMPLES = {"sweep": "windSpeed=5,10", "points": "0,0;25,-10"}


class Document:
    def __init__(self, schema, folder):
        self.schema = schema
        self.schemas = forms(schema)
        self.formats = {row[1]: row[2] for row in fields.formats()}
        self.parameters = {row[0]: row[1:] for row in deffile.rows(
            os.path.join(folder, "routes.def"), "PEL_PARAMETER")}

    # --- forms of the schema ------------------------------------------------

    def of_type(self, field, patch=False):
        """One value of a field, as JSON has it."""
        proto = field.proto
        if proto.type == F.TYPE_MESSAGE:
            name = proto.type_name.split(".")[-1]
            return refer(self.message(name, patch))
        if proto.type == F.TYPE_ENUM:
            return refer(self.enum(proto.type_name.split(".")[-1]))
        if proto.type == F.TYPE_BOOL:
            return {"type": "boolean"}
        if proto.type == F.TYPE_BYTES:
            return {"type": "string", "contentEncoding": "base64"}
        if proto.type == F.TYPE_STRING:
            return {"type": "string"} if not field.most_bytes else {
                "type": "string",
                "maxLength": fields.BOUNDS[field.most_bytes]}
        if proto.type in LONG:
            return {"type": "string", "pattern": "^-?[0-9]+$"}
        real = proto.type in (F.TYPE_DOUBLE, F.TYPE_FLOAT)
        out = {"type": "number" if real else "integer"}
        if field.minimum is not None:
            out["minimum"], out["maximum"] = field.minimum, field.maximum
        elif proto.type in UNSIGNED:
            out["minimum"] = 0
        return out

    def of_field(self, field, patch=False):
        out = self.of_type(field, patch)
        if field.repeated:
            items = out
            if "$ref" in out and field.proto.type == F.TYPE_MESSAGE:
                items = {"anyOf": [out, {
                    "type": "array", "items": {},
                    "description": "its fields in order"}]}
            out = {"type": "array", "items": items}
            if patch and self.key_of(field):
                out = {"anyOf": [out, {
                    "type": "object", "description": "by name or id",
                    "additionalProperties": {"anyOf": [
                        self.of_type(field, patch), {"type": "null"}]}}]}
        if patch:
            out = {"anyOf": [out, {"type": "null"}]}
        if field.doc:
            out["description"] = field.doc
        if field.unit and field.unit != "1":
            out["x-unit"] = field.unit
        default = fields.default_of(field).strip("`")
        if default and not patch:
            out["default"] = (float(default) if field.number else
                              default == "true"
                              if field.proto.type == F.TYPE_BOOL else default)
        return out

    def key_of(self, field):
        if field.proto.type != F.TYPE_MESSAGE:
            return None
        name = field.proto.type_name.split(".")[-1]
        return next((f for f in self.schema.messages[name][1] if f.key), None)

    def message(self, name, patch=False):
        """Puts the form of a message among the schemas; its name there."""
        known = name + ("Patch" if patch else "")
        if known not in self.schemas:
            self.schemas[known] = None  # a message of itself ends here
            doc, all_fields = self.schema.messages[name]
            text = f"A merge patch of {name}." if patch else doc
            # A state that is sent takes its lists as objects of their elements.
            sent = name in ("Patch", "Exercise")
            self.schemas[known] = form(
                {f.name: self.of_field(f, patch or (sent and f.name == "state"))
                 for f in all_fields}, (), text)
        return known

    def enum(self, name):
        if name not in self.schemas:
            doc, values = self.schema.enums[name]
            lines = [doc] + [f"{v}: {text}" for v, _, text in values if text]
            self.schemas[name] = {
                "type": "string", "enum": [v for v, _, _ in values],
                "description": "\n\n".join(line for line in lines if line)}
        return name

    # --- routes -------------------------------------------------------------

    def of_message(self, message):
        """The fields of a message as parameters."""
        return [self.parameter(f.name, self.of_field(f), f.doc)
                for f in self.schema.messages[message][1]
                if f.proto.type != F.TYPE_MESSAGE]

    def parameter(self, name, schema, text, place="query"):
        schema = dict(schema)
        schema.pop("description", None)
        # A name that generators take its default for, not a type of their own.
        known = self.schemas.get(schema.get("$ref", "").split("/")[-1])
        if known:
            del schema["$ref"]
            schema = {"type": known["type"], "enum": known["enum"], **schema}
        out = {"name": name, "in": place, "schema": schema}
        if place == "path":
            out["required"] = True
        if text:
            out["description"] = text
        return out

    def named(self, word):
        name, kind, low, high, unit, text = self.parameters[word]
        if kind in self.schema.messages:
            field = next(f for f in self.schema.messages[kind][1]
                         if f.name == name)
            return self.parameter(name, self.of_field(field), field.doc)
        out = {"type": kind}
        if kind not in ("string", "number", "integer"):
            out = {"enum": kind.split()}
        if low:
            out["minimum"], out["maximum"] = float(low), float(high)
        if unit not in ("", "1"):
            out["x-unit"] = unit
        out = self.parameter(name, out, text)
        if name in EXAMPLES:
            out["example"] = EXAMPLES[name]
        return out

    def query(self, words, question):
        out = []
        for word in words.split():
            if word in self.schema.messages:  # itself, or of its questions
                kind = next((f.proto.type_name.split(".")[-1]
                             for f in self.schema.messages[word][1]
                             if f.name == question), word)
                out += self.of_message(kind)
                out.append({"name": "state", "in": "query", "style": "form",
                            "explode": True, "description":
                            "paths of the state (`sky.sunElevation=5`), for "
                            "this answer only",
                            "schema": {"type": "object"}})
            else:
                out.append(self.named(word))
        # A row of routes.def says more than a message's field of that name.
        return list({p["name"]: p for p in reversed(out)}.values())[::-1]

    @staticmethod
    def headers(names):
        return {name: {"description": HEADERS[name][0],
                       "schema": HEADERS[name][1]} for name in names}

    def answer(self, kind, ending):
        """The answer of success by its status."""
        if kind == "nothing":
            return {"204": {"description": "it is gone"}}
        if kind == "sdp":
            return {"201": {
                "description": "an answer, with every candidate",
                "content": {SDP: {}}, "headers": {"Location": {
                    "description": "the session, which DELETE ends",
                    "schema": TEXT}}}}
        if kind == "live":
            return {"101": {"description": "a WebSocket, see proto/live.md"}}
        if kind == "openapi":
            return {"200": {"description": "this document", "content": {
                "application/json": {"schema": {"type": "object"}}},
                "headers": self.headers(["ETag"])}}
        if kind == "picture":
            mime = self.formats[ending]
            schema = (refer(self.message("FrameTruth"))
                      if mime == "application/json" else {})
            return {"200": {"description": "the picture",
                            "content": {mime: {"schema": schema}},
                            "headers": self.headers(MOMENT + COST)}}
        if kind in ANSWERS:
            types, names = ANSWERS[kind]
            out = {"description": kind,
                   "content": {t: {} for t in types}}
            if names:
                out["headers"] = self.headers(names)
            return {"200": out}
        if kind in self.schema.messages:
            self.message(kind)
        out = {"description": kind,
               "content": {"application/json": {"schema": refer(kind)}}}
        out["content"].update({t: {} for t in FILES.get(kind, ())})
        if kind in TAGGED:
            out["headers"] = self.headers(["ETag"])
        return {"200": out}

    def refusals(self, route, path):
        method, _, flags, _, _, body, answer, _ = route
        codes = {"400", "503"}
        codes |= {"404"} if "{" in path or "/debrief/" in path else set()
        codes |= set() if "ROUTE_OPEN" in flags else {"401"}
        codes |= {"403"} if "ROUTE_COSTLY" in flags or method != "GET" else \
            set()
        codes |= {"413", "415"} if body else set()
        # What asks for a thing that is not loaded, open or to be had.
        codes |= {"409"} if path.strip("/") in (
            "v1/exercise", "v1/exercise.csv", "v1/recording",
            "v1/debrief") else set()
        if edits(method, path):
            codes |= {"409", "412"}
        codes |= {"409"} if path.startswith(("v1/cluster/place",
                                             "v1/soundings")) else set()
        if answer == "live":
            codes |= {"403", "426", "429"}
        if path.startswith("v1/clock"):
            codes.add("409")
        out = {code: refer("Problem", "responses") for code in codes}
        if answer in ("Health", "Ready"):
            out["503"] = {"description": "it is not so", "content": {
                "application/json": {"schema": refer(answer)}}}
        if answer == "ClusterPlace":
            out["503"] = {"description": "another node draws it", "content": {
                "application/json": {"schema": refer(answer)}}}
        if answer in ("page", "schema", "openapi"):
            out["304"] = {"description": "as If-None-Match has it"}
        out["default"] = refer("Problem", "responses")
        return out

    def body(self, kind, flags):
        if kind == "merge":
            schema = refer(self.message("State", patch=True))
            types = ("application/merge-patch+json", "application/json")
        elif kind == "sdp":
            return {"required": True, "content": {SDP: {}}}
        else:
            schema = refer(self.message(kind))
            types = ("application/json",)
        return {"required": "ROUTE_EMPTY_OK" not in flags,
                "content": {t: {"schema": schema} for t in types}}

    def operation(self, route, path, ending, question):
        method, _, flags, handler, query, body, answer, text = route
        id_words = [w for w in re.split(r"[^A-Za-z0-9]+", path) if w]
        out = {"operationId": "_".join([method.lower()] + (id_words or ["page"])),
               "summary": LINK.sub(r"\1", text).replace("`", "")
               .split(". ")[0].split(";")[0],
               "description": LINK.sub(r"\1", text)}
        parameters = [self.parameter(name, TEXT, "", "path")
                      for name in PARTS.findall(path)]
        parameters += self.query(query, question)
        if edits(method, path):
            parameters.append(refer("IfMatch", "parameters"))
        if answer in ("page", "schema", "openapi"):
            parameters.append(refer("IfNoneMatch", "parameters"))
        if parameters:
            out["parameters"] = parameters
        if body:
            out["requestBody"] = self.body(body, flags)
        answers = self.answer(answer, ending)
        if method == "PUT":
            answers["201"] = dict(answers["200"], description="it is new")
        if "ROUTE_LAX" in flags and "200" in answers:
            answers["200"].setdefault("headers", {}).update(
                self.headers([IGNORED]))
        answers.update(self.refusals(route, path))
        out["responses"] = dict(sorted(answers.items()))
        if "ROUTE_OPEN" in flags:
            out["security"] = []
        return method.lower(), out

    def expanded(self, path):
        """The paths of a row: one for each format, each question."""
        if "{ending}" in path:
            return [(path.replace("{ending}", e), e, None)
                    for e in self.formats]
        if "{question}" in path:
            names = [f.name for f in self.schema.messages["OpticsQuery"][1]
                     if f.proto.HasField("oneof_index")]
            return [(path.replace("{question}", n), None, n) for n in names]
        return [(path, None, None)]

    def make(self, version):
        paths = {}
        for route in fields.routes():
            for path, ending, question in self.expanded(route[1]):
                method, operation = self.operation(route, path, ending,
                                                   question)
                paths.setdefault("/" + path, {})[method] = operation
        problem = {"application/problem+json": {"schema": refer("Problem")}}
        tag = {"in": "header", "schema": TEXT}
        return {
            "openapi": "3.1.0",
            "info": {"title": "Pelagos", "version": version,
                     "license": {"name": "MIT", "identifier": "MIT"},
                     "description":
                     "A daemon that draws the ocean and answers questions "
                     "about it. Each GET may be a HEAD, but that of a "
                     "WebSocket. Angles are degrees, headings true and "
                     "clockwise from north; `x-unit` is a field's unit. "
                     "Doubles that are not finite are null."},
            "servers": [{"url": "/"}],
            "security": [{}, {"bearer": []}, {"basic": []}],
            "paths": paths,
            "components": {
                "schemas": dict(sorted(self.schemas.items())),
                "responses": {"Problem": {"description": "refused",
                                          "headers": self.headers([IGNORED]),
                                          "content": problem}},
                "parameters": {
                    "IfMatch": dict(tag, name="If-Match", description=
                                    "holds for this revision only"),
                    "IfNoneMatch": dict(tag, name="If-None-Match",
                                        description="304 if it is the same")},
                "securitySchemes": {
                    "bearer": {"type": "http", "scheme": "bearer"},
                    "basic": {"type": "http", "scheme": "basic"}}}}


def main(argv):
    proto, version, out = argv[1:]
    document = Document(fields.Schema(proto), os.path.dirname(proto))
    with open(out, "w", encoding="utf-8") as file:
        json.dump(document.make(version), file, ensure_ascii=False,
                  separators=(",", ":"))
        file.write("\n")


if __name__ == "__main__":
    main(sys.argv)
