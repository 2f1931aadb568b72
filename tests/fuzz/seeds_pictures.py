"""Seeds of the fuzzers of rasters, pictures and what stands in glTF. For
seeds.py."""
import struct
import zlib


# --- rasters ------------------------------------------------------------------

def grid(columns=4, rows=4, corner="xllcorner 5.19\nyllcorner 52.59\n",
         cell="0.005", values="1 2 -3.5 4 -9999 ", none="NODATA_value -9999\n"):
    return (f"ncols {columns}\nnrows {rows}\n{corner}cellsize {cell}\n{none}"
            + values * (columns * rows // 4)).encode()


def tiff(geo=True, epsg=4326, tiepoint=(0, 0, 0, 5.19, 52.61, 0),
         scale=(0.005, 0.005, 0), side=4, values=None, extra=()):
    """Little-endian, one strip of floats, with GeoTIFF's keys."""
    body = struct.pack(f"<{side * side}f", *(values or [
        (k % 7) - 5.0 for k in range(side * side)]))
    model = 2 if epsg == 4326 else 1
    keys = (1, 1, 0, 3, 1024, 0, 1, model, 1025, 0, 1, 1,
            2048 if model == 2 else 3072, 0, 1, epsg)
    tags = [(256, 4, 1, side), (257, 4, 1, side), (258, 3, 1, 32),
            (259, 3, 1, 1), (262, 3, 1, 1), (273, 4, 1, 8), (277, 3, 1, 1),
            (278, 4, 1, side), (279, 4, 1, len(body)), (339, 3, 1, 3)]
    blobs = []
    if geo:
        blobs = [(33550, 12, 3, struct.pack("<3d", *scale)),
                 (33922, 12, 6, struct.pack("<6d", *tiepoint))]
        blobs += [(34735, 3, len(keys), struct.pack(f"<{len(keys)}H", *keys))
                  ] if epsg else []
    blobs += extra
    at = 8 + len(body)
    data = b""
    for tag, kind, count, blob in blobs:
        tags.append((tag, kind, count, at + len(data)))
        data += blob + bytes(len(blob) % 2)
    ifd = at + len(data)
    out = b"II*\0" + struct.pack("<I", ifd) + body + data
    out += struct.pack("<H", len(tags))
    for tag, kind, count, value in sorted(tags):
        out += struct.pack("<HHII", tag, kind, count, value)
    return out + bytes(4)


def netcdf_grid(name="elevation", more="", lat="52.6 52.605 52.61", second=""):
    return "\n".join([
        "d lat 3", "d lon 3", "v lat d lat", "a units degrees_north",
        "v lon d lon", "a units degrees_east", f"v {name} f lat lon", more,
        second, f"= lat {lat}", "= lon 5.19 5.195 5.2", f"= {name} 1 -2 3",
        "= z 4 5", "= other 6"]).encode()


def exr(width=4, height=4, channels=("Y",), kind=2, tiled=False, window=None,
        cut=0, parts=0, values=0.5):
    """OpenEXR without compression: kind 1 halves, 2 floats."""
    def attribute(name, form, data):
        return name + b"\0" + form + b"\0" + struct.pack("<I", len(data)) + data
    box = struct.pack("<4i", *(window or (0, 0, width - 1, height - 1)))
    head = attribute(b"channels", b"chlist", b"".join(
        c.encode() + b"\0" + struct.pack("<iB3xii", kind, 0, 1, 1)
        for c in channels) + b"\0")
    head += attribute(b"compression", b"compression", b"\0")
    head += attribute(b"dataWindow", b"box2i", box)
    head += attribute(b"displayWindow", b"box2i", box)
    head += attribute(b"lineOrder", b"lineOrder", b"\0")
    head += attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
    head += attribute(b"screenWindowCenter", b"v2f", bytes(8))
    head += attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1))
    if tiled:
        head += attribute(b"tiles", b"tiledesc", struct.pack("<IIB", 4, 4, 0))
    start = b"\x76\x2f\x31\x01" + struct.pack(
        "<I", 2 | (0x200 if tiled else 0) | parts) + head + b"\0"
    line = struct.pack("<f", values) if kind == 2 else struct.pack("<e", values)
    row = line * width * len(channels)
    at = len(start) + 8 * height
    table, lines = b"", b""
    for y in range(height):
        table += struct.pack("<Q", at + len(lines))
        lines += struct.pack("<iI", y + (window or (0, 0))[1], len(row)) + row
    whole = start + table + lines
    return whole[:len(whole) - cut]


def raster_seeds():
    files = {
        "grid": grid(), "grid-cut": grid(values="1 2 x "), "grid-metres": grid(
            corner="xllcorner 500000\nyllcorner 5820000\n", cell="10"),
        "grid-one": grid(1, 1), "grid-far": grid(
            corner="xllcorner 45\nyllcorner -50\n"), "grid-coarse": grid(
            corner="xllcorner 0\nyllcorner 50\n", cell="3"),
        "grid-fine": grid(cell="1e-9"), "grid-empty": grid(values="-9999 " * 5),
        "grid-pole": grid(corner="xllcorner 0\nyllcorner 89\n", cell="0.25"),
        "tiff": tiff(), "tiff-plain": tiff(geo=False), "tiff-bare": tiff(epsg=0),
        "tiff-utm": tiff(epsg=32631, scale=(10, 10, 0), tiepoint=(
            0, 0, 0, 648000, 5830000, 0)), "tiff-cut": tiff()[:90],
        "tiff-nan": tiff(values=[float("nan")] * 16), "tiff-flat": tiff(
            values=[-4.0] * 16), "tiff-wrong": tiff(epsg=4),
        "tiff-large": tiff(side=40, scale=(1e-3, 1e-3, 0)),
        "tiff-units": tiff(extra=[(42112, 2, 64, (
            b'<GDALMetadata><Item name="UNITTYPE" sample="0" role="unittype">ft'
            b'</Item></GDALMetadata>').ljust(64, b"\0"))]),
        "exr": exr(), "exr-z": exr(channels=("A", "Z")), "exr-cut": exr(cut=9),
        "exr-tiled": exr(tiled=True), "exr-parts": exr(parts=0x1000),
        "exr-one": exr(1, 1), "none": b"other bytes", "empty": b"",
        "hdf5": b"\x89HDF\r\n\x1a\n" + bytes(90)}
    for name, data in files.items():
        for how in (0, 1, 2, 3):
            yield f"{name}-{how}", bytes([how]) + data
    for i, data in enumerate((
            netcdf_grid(), netcdf_grid("z"), netcdf_grid(more="a units ft"),
            netcdf_grid(more="a positive down"), netcdf_grid(
                second="v other f lat lon"), netcdf_grid(
                second="v z f lat lon"), netcdf_grid("x", second="v other f lat "
                                                     "lon"),
            netcdf_grid(more="a scale_factor #2"), netcdf_grid(lat="1 5 60"),
            b"d x 2")):
        for how in (4, 5):
            yield f"netcdf-{i}-{how}", bytes([how]) + data
            yield f"hdf5-{i}-{how}", bytes([how + 8, 111]) + data
    for letter in b"esdvo":
        yield f"hands-on-{letter}", bytes([28, letter]) + netcdf_grid()


# --- pictures -----------------------------------------------------------------

def radiance(columns=16, rows=8, head="#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n",
             order="-Y {} +X {}\n", body=None, pixel=b"\x80\x40\x20\x81"):
    body = pixel * (columns * rows) if body is None else body
    return (head + order.format(rows, columns)).encode() + body


def png(width=3, height=3, kind=6, bad=False, interlace=0, cut=0):
    def chunk(name, data):
        return (struct.pack(">I", len(data)) + name + data + struct.pack(
            ">I", zlib.crc32(name + data) ^ bad))
    channels = {0: 1, 2: 3, 6: 4}[kind]
    rows = b"".join(b"\0" + bytes(range(channels * width % 256)).ljust(
        channels * width, b"\7") for _ in range(height))
    if interlace: # only its first pass has pixels, of a picture of 1 × 1
        rows = b"\0" + bytes(channels)
    out = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(
        ">2I5B", width, height, 8, kind, 0, 0, interlace))
    out += chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return out[:len(out) - cut]


def jpeg(width=8, height=8, cut=0):
    """Grey, one block, whose only code says zero for all."""
    def part(mark, data):
        return b"\xff" + bytes([mark]) + struct.pack(">H", 2 + len(data)) + data
    out = b"\xff\xd8" + part(0xdb, b"\0" + b"\1" * 64)
    out += part(0xc0, struct.pack(">BHHB3B", 8, height, width, 1, 1, 0x11, 0))
    for table in (0, 0x10):
        out += part(0xc4, bytes([table, 1] + [0] * 15 + [0]))
    out += part(0xda, b"\1\1\0\0\x3f\0")
    blocks = -(-width // 8) * -(-height // 8)
    out += bytes((2 * blocks + 7) // 8) + b"\xff\xd9"
    return out[:len(out) - cut]


def picture_seeds():
    run = b"".join(bytes([2, 2, 0, 16]) + (bytes([128 + 16, 7]) * 3 + bytes(
        [16]) + bytes(range(120, 136))) for _ in range(8))
    for i, data in enumerate((
            radiance(), radiance(body=run), radiance(body=run[:-9]),
            radiance(body=run.replace(b"\2\2\0\x10", b"\2\2\0\x11")),
            radiance(body=b"\2\2\0\x10\0"), radiance(body=b"\2\2\0\x10\xff"),
            radiance(body=b"\2\2\0\x10\x90"), radiance(body=b"\1\1\1\3" * 128),
            radiance(pixel=b"\1\2\3\0"), radiance(head="#!\n"), b"", b"#?\n",
            radiance(pixel=b"\xff\xff\xff\xff"), radiance(order="+Y {} +X {}\n"),
            radiance(head="#?\nFORMAT=32-bit_rle_xyze\n\n"),
            radiance(head="#?\n" + "EXPOSURE=1\n" * 200), radiance(16, 9),
            radiance(8192, 4096, body=b""), radiance(4, 2),
            radiance(order="-Y {} +X {} \n"), radiance(head="#?\r\n\r\n"))):
        yield f"radiance-{i}", b"R" + data
    rgb = ("B", "G", "R")
    for i, data in enumerate((
            exr(16, 8, rgb), exr(16, 8), exr(16, 8, ("A", *rgb)),
            exr(16, 8, rgb, kind=1), exr(16, 8, ("B", "G")), exr(4, 4, rgb),
            exr(16, 8, rgb, cut=30), exr(16, 8, rgb, tiled=True),
            exr(16, 8, rgb, parts=0x1000), exr(16, 8, rgb, window=(
                5, 9, 20, 16)), exr(16, 8, rgb, window=(0, 0, -9, -9)),
            exr(16, 8, rgb, window=(-2 ** 31, 0, 2 ** 31 - 1, 7)),
            exr(16, 8, rgb, values=float("nan")), exr(16, 8, ("x",)), b"")):
        yield f"exr-{i}", b"E" + data
        yield f"heights-{i}", b"H" + data
    for i, data in enumerate((
            exr(), exr(channels=("Y", "Z")), exr(channels=("a", "height")),
            exr(kind=1), exr(channels=()), exr(cut=9), exr(kind=0))):
        yield f"heights-more-{i}", b"H" + data
    for i, data in enumerate((
            png(), png(kind=0), png(kind=2), png(200, 3), png(3, 200), png(0, 3),
            png(20000, 1), png(cut=20), png(bad=True), png(1, 1, interlace=1),
            png(3, 3, interlace=1), jpeg(), jpeg(100, 9), jpeg(cut=3),
            jpeg(60000, 8), jpeg(cut=40), b"\xff\xd8\xff", b"GIF89a")):
        yield f"texture-{i}", b"T" + data
    required = '{{"extensionsRequired": [{}]}}'
    for i, text in enumerate((
            required.format('"KHR_draco_mesh_compression"'),
            required.format('"KHR_materials_unlit", "KHR_texture_transform"'),
            required.format('"EXT_' + "x" * 90 + '"'), required.format(""),
            required.format('"KHR_draco"'), '{"extensionsRequired": ["KHR',
            '{"extensionsRequired"', "{}", required.format('"a')[:-3])):
        yield f"gltf-{i}", "G" + text
        data = text.encode()
        for length in (len(data), 4, 1 << 31):
            yield f"glb-{i}-{length}", b"GglTF" + struct.pack(
                "<4I", 2, 20 + len(data), length, 0x4e4f534a) + data


SEEDS = [("raster", raster_seeds), ("picture", picture_seeds)]
