#!/usr/bin/python3
"""Checks every #include against the table of rooms in docs/architecture.md.

A row of that table names a room and the rooms it may include; a file belongs
to the room with the longest matching path. Some libraries have a room of
their own as well: only the renderer talks GL, only net talks HTTP.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
LIBRARIES = {
    "epoxy/": {"server/render"},
    "microhttpd.h": {"server/net"},
    "modbus": {"server/bridges", "clients/demo"},
    # The benchmark of streams (tests) times these two by themselves.
    "turbojpeg.h": {"server/encode", "tests"},
    "jpeglib.h": {"server/encode", "server/models/reader"},
    # libpelagos links none of it: an example reads frames by it.
    "openexr.h": {"server/encode", "server/seabed/reader",
                  "server/panorama/reader", "clients/lib"},
    "gdal": {"server/seabed/reader", "tests"},
    "cpl_": {"server/seabed/reader", "tests"},
    "ogr_": {"server/seabed/reader", "tests"},
    "hdf5": {"server/seabed/reader", "tests"},
    "eccodes.h": {"server/weather/reader"},
    "gst/": {"server/encode", "server/net", "clients/pelagosctl", "tests"},
    "libyuv": {"server/encode"},
    "wslay/": {"server/net"},
    "curl/": {"server/cluster"},
    # Golden pictures are read by tests.
    "spng.h": {"server/encode", "server/models/reader", "tests"},
    "assimp/": {"server/models/reader"},
}
GENERATED = {"pelagos.pb-c.h": "proto", "protobuf-c/": None}


def read_table():
    text = (ROOT / "docs/architecture.md").read_text()
    rooms = {}
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("| `") or len(cells) != 3:
            continue
        name = re.match(r"`([^`]+)`", cells[0]).group(1)
        rooms[name] = set(re.findall(r"`([^`]+)`", cells[2]))
        rooms[name].add(name)
    unknown = set().union(*rooms.values()) - set(rooms) - {"all"}
    if not rooms or unknown:
        sys.exit(f"layers: bad table in docs/architecture.md: {unknown}")
    return rooms


def room_of(path, rooms):
    inside = [room for room in rooms
              if path == room or path.startswith(room + "/")]
    return max(inside, key=len, default=None)


def find_header(source, name):
    """Path from the root of the header that `name` in `source` means."""
    for folder in (source.parent, ROOT / "server", ROOT / "proto",
                   ROOT / "clients", ROOT):
        if (folder / name).is_file():
            return str((folder / name).resolve().relative_to(ROOT))
    return None


def check(source, rooms):
    path = str(source.relative_to(ROOT))
    room = room_of(path, rooms)
    if room is None:
        return [f"{path}: in no room of docs/architecture.md"]
    allowed = rooms[room]
    complaints = []
    for number, line in enumerate(source.read_text().splitlines(), 1):
        match = re.match(r'\s*#\s*include\s+(["<])([^">]+)[">]', line)
        if not match:
            continue
        name = match.group(2)
        for library, owners in LIBRARIES.items():
            if name.startswith(library) and room not in owners:
                complaints.append(f"{path}:{number}: <{name}> belongs to "
                                  + ", ".join(sorted(owners)))
        if match.group(1) == "<":
            continue
        target = GENERATED.get(name)
        header = find_header(source, name)
        if target is None and header is not None:
            target = room_of(header, rooms)
        if target is None:
            complaints.append(f"{path}:{number}: no such header: {name}")
        elif "all" not in allowed and target not in allowed:
            complaints.append(f"{path}:{number}: {room} may not include "
                              f"{target} ({name})")
    return complaints


def main():
    rooms = read_table()
    complaints, files = [], 0
    for folder in ("server", "proto", "clients", "tests"):
        for source in sorted((ROOT / folder).rglob("*.[ch]")):
            files += 1
            complaints += check(source, rooms)
    for complaint in complaints:
        print(complaint)
    print(f"layers: {files} files, {len(complaints)} walls broken")
    sys.exit(1 if complaints else 0)


main()
