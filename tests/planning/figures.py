"""The figures that docs/planning.md rests on, read where they are written.

Each is a number of a table or a sentence of another page (or of a table of the
code), found by the words about it; so the one place of a figure is the page of
whoever measured it. Words that are not there, or there twice, are an error.
"""
import dataclasses
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
BENCH, CLUSTER = "docs/benchmarks.md", "docs/cluster.md"
BOUNDS = "proto/bounds.def"
GPUS, GPU = "Several GPUs of one host", "On a GPU"
N = r"([\d.,]*\d)"
# A table of that section that has H100, too.
SINCE = r"Since then \(`bench_devices`(?s:.*?)"


def cell(row, column):
    """The number that a cell of that table begins with."""
    return SINCE + rf"\n\| {row}[^|\n]*\|" + r"[^|\n]*\|" * (column - 1) \
        + " " + N


def newest(row):
    """One, two and four devices by the newest of them."""
    return r"\| now \|(?s:.*?)" + rf"\n\| {row}[^|\n]*\|" \
        + r"[^|\n]*\|".join([" " + N] * 3)


def bound(name):
    return rf"PEL_BOUND\(\s*{name}, " + N


# The columns of that table.
H100, H200 = 1, 3
SMALL, LARGE = "64 views 1280×720, drawn", "12 views 3840×2160, drawn"

# name: file, heading (None: the whole file), words with one number or more.
# A figure of several numbers is a list.
SOURCES = {
    # Drawing.
    "drawn_720": (BENCH, GPUS, cell(SMALL, H100)),
    "drawn_2160": (BENCH, GPUS, cell(LARGE, H100)),
    "drawn_2160_h200": (BENCH, GPUS, cell(LARGE, H200)),
    "core_ms": (BENCH, GPU, r"lace, relief(?s:.*?): \d+ and " + N
                + " at 8 m/s"),
    # Triangles, buoys; raster and shade of a picture with them.
    "traffic_ms": (BENCH, GPU, rf"a hull of {N} triangles and {N} buoys "
                   rf"{N} and {N};"),
    "live_hz": (BENCH, GPUS, rf"live views at most {N} Hz"),
    "hull": (BENCH, "Objects", r"hull and \d+ buoys [\d to]+ → [\d to]+ "
             rf"\(\+\d+ to \+{N} %"),
    "together": (BENCH, GPU,
                 rf"64 of 1280×720, views a second \| {N} → {N} "),
    # Drawn and encoded, end to end.
    # One, two and four H200 of one host.
    "drawn_by": (BENCH, GPUS, newest("64 views 1280×720, drawn")),
    "jpeg_by": (BENCH, GPUS, newest("64 views 1280×720, JPEG")),
    "h264_by": (BENCH, GPUS, newest("64 views 1280×720, H.264")),
    # Coded by the device: so many on two cores, and of one large view.
    "jpeg_2": (BENCH, GPUS, r"\| now \|(?s:.*?)\n\| – 2 of the cores \| " + N),
    "jpeg_alone": (BENCH, GPU, r"\| one view 3840×2160, at most 240 Hz \|"
                   r"[^|]*\| " + N),
    "h264_32": (BENCH, GPUS, cell("32 views 1280×720, H.264, live", H100)),
    "h264_16": (BENCH, GPUS, rf"as H\.264 {N}, [\d,]+, [\d,]+ \(the cores; "
                r"the bar is 3,600"),
    "jpeg_2160": (BENCH, GPUS, newest("8 views 3840×2160, JPEG, live")),
    "h264_2160": (BENCH, GPUS, cell("8 views 3840×2160, H.264, live", H100)),
    "h264_slow": (BENCH, GPU, rf"; as H\.264 {N}, {N}, {N}, {N}\. There"),
    # Encoding alone, and what it makes.
    "h264_core_ms": (BENCH, GPU, r"H\.264 \(x264\) \| [^|]*\| [^|]*quiet "
                     + N + r" \|"),
    "exr_ms": (BENCH, "Figures", r"EXR with three layers, 1280×720 \|"
               r"[^|]*; " + N + " ms"),
    "resident": (BENCH, "Figures", r"1920×1080 view \| \d+ to " + N + " MB"),
    # Of several qualities, the stream's own.
    "jpeg_kb": (BENCH, "Bytes", rf"JPEG, quality (80) \| {N} to {N} kB"),
    "exr_kb": (BENCH, "Bytes", r"\| EXR of depth, id and class \| [\d,]+ to "
               + N + " kB"),
    "set_kb": (BENCH, "Bytes", r"640×360, together \| [\d,]+ to " + N
               + " kB"),
    "set_s": ("docs/datasets.md", "What it takes",
              r"s of a core a frame, " + N + " s the second time"),
    "kbps": ("proto/live.md", None, r"by the size: " + N + " for 1280×720"),
    # The log.
    "seal_ms": (CLUSTER, "Figures", rf"p50 and p99 \|[^|]*\| {N}, {N} ms at "
                rf"load {N}"),
    "seal_busy_ms": (CLUSTER, "Figures", rf"p50 and p99 \|[^|]*\|[^;|]*; {N}, "
                     rf"{N} ms "
                     rf"at load {N}"),
    "gaps_s": (CLUSTER, "Figures", r"longest gap \| 0; 0\.5 s \| 0 of [\d,]+; "
               + N),
    "gap_both_s": (CLUSTER, "Figures", r"both at once \| 0; 1\.5 s \| 0 of "
                   r"[\d,]+; " + N),
    "nodes_seen": (CLUSTER, "Figures", r"members of etcd and (four) daemons"),
    "state_s": (CLUSTER, "The log", r"Every " + N + " s, and when it begins"),
    "state_kb": ("docs/architecture.md", "Decisions",
                 r"a state of 256 entities is " + N + " kB"),
    # Limits.
    "nodes": (BOUNDS, None, bound("CLUSTER_NODES")),
    "views": (BOUNDS, None, bound("VIEWS")),
    "entities": (BOUNDS, None, bound("ENTITIES")),
    "pixels": (BOUNDS, None, bound("LIVE_PIXELS")),
    "streams": (BOUNDS, None, bound("LIVE_STREAMS")),
    "loopback": (BOUNDS, None, bound("HTTP_PER_LOOPBACK")),
    "source": (BOUNDS, None, bound("HTTP_PER_SOURCE")),
    "rtsp": (BOUNDS, None, bound("RTSP_CLIENTS")),
    # What goes wrong.
    "restart_s": ("docs/reliability.md", "Disk, memory, device, time",
                  r"500 kills: median " + N + " s"),
    "lost_ms": ("docs/reliability.md", "Disk, memory, device, time",
                r"a picture with a loss takes " + N + " ms at the median"),
    "soak_mb": ("docs/reliability.md", "A mixed load",
                r"at most meanwhile \| [^|]+ \| " + N + " MB"),
}
WORDS = {"four": 4.0}


class Missing(Exception):
    """The words about a figure are not there, or more than once."""


@dataclasses.dataclass
class Figure:
    values: "list[float]"
    file: str
    heading: "str | None"

    @property
    def value(self):
        return self.values[0]


def number(text):
    return WORDS[text] if text in WORDS else float(text.replace(",", ""))


def part(text, heading):
    """What stands below a heading, up to the next of its level."""
    begin = re.search(rf"^## {re.escape(heading)}$", text, re.M)
    if not begin:
        raise Missing(f"no heading {heading}")
    end = re.search(r"^## ", text[begin.end():], re.M)
    return text[begin.end():begin.end() + end.start()] if end \
        else text[begin.end():]


def read(root=ROOT):
    """{name: Figure} of all SOURCES, from the tree at root."""
    found, texts = {}, {}
    for name, (file, heading, words) in SOURCES.items():
        if file not in texts:
            texts[file] = (root / file).read_text(encoding="utf-8")
        text = texts[file]
        try:
            text = part(text, heading) if heading else text
        except Missing as e:
            raise Missing(f"{name}: {file}: {e}") from None
        all_of = [m.groups() for m in re.finditer(words, text)]
        if len(all_of) != 1:
            raise Missing(f"{name}: {file} has {len(all_of)} times: {words}")
        found[name] = Figure([number(t) for t in all_of[0]], file, heading)
    return found
