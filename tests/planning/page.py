#!/usr/bin/python3
"""Writes docs/planning.md: docs/planning.in.md with each @name@ replaced by
what the model makes of the figures.

page.py [TREE]    TREE: whose docs are read and written (this tree)
"""
import pathlib
import re
import sys

import figures
from model import (FULL, HD, NAMES, UHD, Frames, K, Log, M, Model, Need,
                   Viewers)

G, T = 1e9, 1e12
# What a reader chooses, and what the examples choose.
MACHINE = {"cores": 32, "bits": 10 * G, "load": 0.7}
LARGER = {**MACHINE, "cores": 64}
PRICE = {"machine": 0.1, "device": 2.5, "core": 0.04}
CAMERAS = (1, 10, 100, 1000, 10000)
HZ, EXERCISE_HZ, SLOW_HZ = 30, 60, 1
WINDOWS, WINDOW_HZ = (5, 25, 100), 60
FLEET, WATCHING, READERS = 20, 1000, 500
SET, SET_SIZE, TASKS, THREADS = 10 * M, (640, 360), 200, 8
MEMBERS = 3
SENTENCE = re.compile(r"@(\w+)@")


def say(x):
    """Three digits, or all of a whole number."""
    if abs(x - round(x)) < 1e-9 or x >= 100:
        return f"{round(x):,}"
    return f"{x:.1f}".removesuffix(".0") if x >= 10 else f"{x:.2g}"


def percent(x):
    return say(float(f"{100 * x:.2g}"))


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(r) + " |" for r in rows])


def source(figure):
    """Where a figure stands, as a link."""
    name = pathlib.PurePath(figure.file).name
    if not figure.heading:
        return f"`{figure.file}`"
    anchor = re.sub(r"[^\w -]", "", figure.heading.lower()).replace(" ", "-")
    link = name if figure.file.startswith("docs/") else f"../{figure.file}"
    return f"[{name.removesuffix('.md')}, {figure.heading}]({link}#{anchor})"


class Page:
    def __init__(self, found):
        self.f, self.model = found, Model(found)
        self.say = {}
        for part in (self.short, self.symbols, self.alone, self.checks,
                     self.first, self.log, self.academy, self.fleet,
                     self.frames, self.stress):
            part()

    def of(self, name, which=0):
        return self.f[name].values[which]

    def need(self, cameras, codec="h264", size=HD, rate=HZ, machine=None,
             traffic=False):
        return Need(self.model, cameras, size, rate, codec,
                    machine or MACHINE, traffic)

    def short(self):
        def first(n):
            fullest = n.shares[n.order[0]]
            return f"{n.order[0]} ({say(n.next_machines)})" if fullest > 1 \
                else f"none; fullest: {n.order[0]}, {percent(fullest)} %"

        def row(n):
            return [say(n.cameras), say(n.pictures), say(n.devices),
                    say(n.cores), say(n.machines), first(n), say(n.bits / G),
                    say(n.states)]

        def traffic(n):
            more = 1 + self.of("hull") / 100
            return [say(n.cameras), say(n.devices), say(n.machines), first(n),
                    say(n.software), say(n.software * more)]
        self.say["table_traffic"] = table(
            ["cameras", "devices", "machines", "what fills them first",
             "cores without a GPU, open sea", "with traffic"],
            [traffic(self.need(n, traffic=True)) for n in CAMERAS])
        for codec in "h264", "jpeg":
            self.say[f"table_{codec}"] = table(
                ["cameras", "pictures/s", "devices", "cores", "machines",
                 "what fills them first", "Gbit/s", "logs"],
                [row(self.need(n, codec)) for n in CAMERAS])
            self.say[f"{'hd' if codec == 'h264' else codec}_mbit"] = say(
                self.model.bits(HD, codec, HZ) / M)
        self.say |= {
            "jpeg_quality": say(self.of("jpeg_kb")),
            "least_n": say(CAMERAS[0]), "most_n": say(CAMERAS[-1]),
            "hz": say(HZ), "hd": NAMES[HD], "uhd": NAMES[UHD],
            "full": NAMES[FULL], "m_cores": say(MACHINE["cores"]),
            "m_cores2": say(LARGER["cores"]),
            "m_gbit": say(MACHINE["bits"] / G),
            "load_percent": percent(MACHINE["load"])}

    def symbols(self):
        m, f = self.model, self.f
        rows = [
            ["t0", f"{say(m.picture_s * M)} µs",
             "computed: a line through the next two", ""],
            ["t1", f"{say(m.pixel_s * 1e12)} ps a pixel", "likewise", ""],
            ["", f"{say(self.of('drawn_720'))} pictures/s of {NAMES[HD]}",
             "measured", f"{source(f['drawn_720'])}; H100"],
            ["", f"{say(self.of('drawn_2160'))} pictures/s of {NAMES[UHD]}",
             "measured", f"{source(f['drawn_2160'])}; H100"],
            ["t with traffic", f"{say(self.of('traffic_ms', 2))} + "
             f"{say(self.of('traffic_ms', 3))} · (p / 921,600) ms",
             f"measured at {NAMES[HD]}: raster, and shade, which is taken to "
             "go by pixels; a hull and buoys",
             f"{source(f['traffic_ms'])}; H200"],
            ["c, JPEG", f"{say(m.core['jpeg'])} pictures/s and core",
             f"measured: {say(self.of('jpeg_2'))} with 2 cores; the device "
             "codes them",
             f"{source(f['jpeg_2'])}; H200, {NAMES[HD]}"],
            ["c, H.264", f"{say(m.core['h264'])} pictures/s and core",
             "measured, the least: 64 views at "
             f"{say(self.of('h264_slow', 3))} Hz on 16 slow cores; elsewhere "
             f"{say(self.of('h264_16'))} with 16 (H200, trochoids), "
             f"{say(self.of('h264_32'))} with 32 (H100)",
             f"{source(f['h264_slow'])}; a GPU, 16 cores"],
            ["s", f"{say(self.of('core_ms'))} ms of a core, {NAMES[HD]}",
             "measured, cascades, 8 m/s, whitecaps",
             f"{source(f['core_ms'])}; two EPYC cores"],
            ["e", f"{say(self.of('h264_core_ms'))} ms of a core, {NAMES[HD]}",
             "measured, x264", f"{source(f['h264_core_ms'])}; the same"],
            [", ".join(say(self.of(k)) for k in ("views", "streams",
                                                  "pixels")),
             "views, live views, pixels", "limits",
             "[manual, Limits](../proto/manual.md#limits)"],
            ["b, H.264",
             f"{say(self.of('kbps') / K)} Mbit/s · (p / 921,600)^0.75",
             "a setting, the daemon's own, `bitrate`",
             "[live](../proto/live.md), `server/encode/video.c`"],
            ["b, JPEG", f"{say(self.of('jpeg_kb', 1))} to "
             f"{say(self.of('jpeg_kb', 2))} kB a picture; the larger one "
             "counts, by pixels", "measured", source(f["jpeg_kb"])],
            ["u", say(MACHINE["load"]), "chosen", ""]]
        self.say["table_symbols"] = table(
            ["", "is", "kind", "where and on what"], rows)

    def alone(self):
        m = self.model
        rows = [[NAMES[s]] + [say(m.most_rate(s, c)) + " Hz"
                              for c in ("h264", "jpeg")]
                for s in (HD, FULL, UHD)]
        rows[0] += ["H.264 measured: " + source(self.f["h264_slow"])
                    + "; the slower machine, "
                    f"live views at most {say(self.of('live_hz'))} Hz"]
        rows[1] += ["by pixels"]
        rows[2] += ["H.264 by pixels, JPEG measured: "
                    + source(self.f["jpeg_alone"])]
        self.say["table_alone"] = table(["one view", "H.264", "JPEG", ""],
                                        rows)

    def checks(self):
        m, rows = self.model, []

        def check(what, said, name, seen, on):
            rows.append([what, say(said), say(seen), say(said / seen),
                         f"{source(self.f[name])}; {on}"])
            return said / seen
        check(f"a view of {NAMES[UHD]} in H.264, Hz", m.most_rate(UHD, "h264"),
              "h264_2160", self.of("h264_2160") / 8, "eight views, H100")
        large = check(f"eight views of {NAMES[UHD]} as JPEG, pictures/s",
                      1 / m.device_s(UHD), "jpeg_2160", self.of("jpeg_2160"),
                      "H100")
        check(f"{NAMES[HD]} as JPEG, pictures/s", 1 / m.device_s(HD),
              "jpeg_by", self.of("jpeg_by"), "64 views, H100")
        check(f"{NAMES[UHD]} drawn, pictures/s", 1 / m.device_s(UHD),
              "drawn_2160_h200", self.of("drawn_2160_h200"), "H200")
        cores = [check(f"{NAMES[HD]} in H.264 on 16 cores, pictures/s",
                       16 * m.core["h264"], "h264_16", self.of("h264_16"),
                       "64 views, trochoids, H200"),
                 check(f"{NAMES[HD]} in H.264 on 32 cores, pictures/s",
                       32 * m.core["h264"], "h264_32", self.of("h264_32"),
                       "32 views, H100")]
        self.say |= {
            "table_checks": table(["", "formula", "measured", "ratio", ""],
                                  rows),
            "worst_cores": say(1 / min(cores)),
            "jpeg_off": percent(1 - 1 / large),
            "triangles": say(self.of("traffic_ms")),
            "buoys": say(self.of("traffic_ms", 1)),
            "hull": say(self.of("hull")),
            "one_by_one": say(self.of("together")),
            "together": say(self.of("together", 1))}

    def first(self):
        f, n = self.f, [self.need(c) for c in CAMERAS]
        jpeg = [self.need(c, "jpeg") for c in CAMERAS]
        place = self.need(n[0].places)
        share = 1 - 1 / 8  # of a source's connections, for live views
        self.say |= {f"n{i}": say(c) for i, c in enumerate(CAMERAS)}
        self.say |= {
            "one_software": say(n[0].software),
            "two_cores_hz": say(2 * HZ / n[0].software),
            "resident": say(self.of("resident")),
            "soak": say(self.of("soak_mb")),
            "n1_device": percent(n[1].devices), "n1_cores": say(n[1].cores),
            "n1_software": say(n[1].software),
            "source_live": say(int(self.of("source") * share)),
            "loopback_live": say(int(self.of("loopback") * share)),
            "rtsp": say(self.of("rtsp")),
            "views": say(self.of("views")),
            "streams": say(self.of("streams")),
            "pixels": say(self.of("pixels")),
            "pays": say(self.pays()), "slower": say(self.slower()),
            "mpixels": say(self.of("pixels") / M),
            "n2_h264": say(n[2].machines),
            "place_device": percent(place.devices),
            "place_cores": say(place.cores),
            "n3_gbit": say(jpeg[3].bits / G),
            "n4_h264": say(n[4].machines), "n4_jpeg": say(jpeg[4].machines),
            "n4_logs": say(n[4].states), "n4_mbit": say(n[4].bits / G),
            "n4_jpeg_gbit": say(jpeg[4].bits / G),
            **{f"{k}_{n}": say(self.of(k, i))
               for k in ("drawn_by", "jpeg_by", "h264_by")
               for i, n in enumerate((1, 2, 4))}}

    def slower(self):
        """Times that a picture with traffic takes the device."""
        return self.model.traffic_s(HD) / self.model.device_s(HD)

    def pays(self):
        """Cameras from which cores cost more than a device, by PRICE."""
        n = self.need(1)
        return int(PRICE["device"] / PRICE["core"]
                   / (n.software - n.cores)) + 1

    def log(self):
        seal, busy = self.f["seal_ms"].values, self.f["seal_busy_ms"].values
        nodes = sorted({int(self.of("nodes_seen")), 8, 16, 32,
                        int(self.of("nodes"))})
        rows = [[say(n), say(log.puts), say(log.told)] for n in nodes
                for log in [Log(n, EXERCISE_HZ)]]
        self.say |= {
            "table_log": table(["nodes", "values put a second",
                                "values told a second"], rows),
            "nodes": say(self.of("nodes")),
            "nodes_seen": say(self.of("nodes_seen")),
            "exercise_hz": say(EXERCISE_HZ),
            "exercise_period": say(K / EXERCISE_HZ),
            "seal_load": say(seal[2]), "busy_load": say(busy[2]),
            "seal_p50": say(seal[0]), "seal_p99": say(seal[1]),
            "seal_busy_p50": say(busy[0]), "seal_busy_p99": say(busy[1]),
            "seal_rate": say(K / seal[0]), "seal_rate_slow": say(K / seal[1]),
            "state_s": say(self.of("state_s")),
            "state_kb": say(self.of("state_kb")),
            "entities": say(self.of("entities")),
            "members": say(MEMBERS),
            "gap_master": self.of("gaps_s"), "gap_both": self.of("gap_both_s"),
            "restart": self.of("restart_s"), "lost": say(self.of("lost_ms"))}

    def academy(self):
        m = self.model

        def windows(n, machine=None, traffic=False):
            return self.need(n, size=FULL, rate=WINDOW_HZ, machine=machine,
                             traffic=traffic)
        needs = [windows(n) for n in WINDOWS]
        busy = [windows(n, traffic=True) for n in WINDOWS]
        one = needs[0].cores / WINDOWS[0]
        def fit(machine, cores):
            return int(machine["cores"] * machine["load"] / cores)
        self.say |= {f"a{i}": say(n) for i, n in enumerate(WINDOWS)}
        self.say |= {
            "table_academy": table(
                ["windows", "pictures/s", "cores", "exercises", "Mbit/s",
                 "cores without a GPU, open sea"],
                [[say(n.cameras), say(n.pictures), say(n.cores),
                  say(n.states), say(n.bits / M), say(n.software)]
                 for n in needs]),
            "table_windows": table(
                ["windows", "open sea: devices", "machines", "fullest",
                 "traffic: devices", "machines", "fullest", "money an hour"],
                [[say(n.cameras)]
                 + [w for x in (n, t) for w in (
                     say(x.devices), say(x.machines), x.order[0])]
                 + [say(t.cost(PRICE))] for n, t in zip(needs, busy)]),
            "a0_machines": say(busy[0].machines),
            "a_hz": say(WINDOW_HZ), "a_core": say(one),
            "a_device": percent(needs[0].devices / WINDOWS[0]),
            "a_traffic": percent(busy[0].devices / WINDOWS[0]),
            "full_mbit": say(m.bits(FULL, "h264", None) / M),
            "full_alone": say(m.most_rate(FULL, "h264")),
            "uhd_alone": say(m.most_rate(UHD, "h264")),
            "uhd_seen": say(self.of("h264_2160") / 8),
            "uhd_jpeg_two": say(self.of("jpeg_2160", 1) / 8),
            "a_each": say(fit(MACHINE, one)),
            "a_more": say(min(fit(LARGER, one), needs[0].places)),
            "a1_machines": say(busy[1].machines),
            "a2_exercises": say(needs[2].states),
            "a2_bridges": say(WINDOWS[2] // WINDOWS[0]),
            "a0_software": say(needs[0].software),
            "p_machine": say(PRICE["machine"]),
            "p_device": say(PRICE["device"]), "p_core": say(PRICE["core"])}

    def fleet(self):
        need = self.need(FLEET)
        edge = MACHINE["bits"]
        v = Viewers(self.model, FLEET, HD, WATCHING, edge, MACHINE["load"])
        self.say |= {
            "f_cameras": say(FLEET), "f_viewers": say(WATCHING),
            "f_daemons": "one" if need.machines == 1 else say(need.machines),
            "f_traffic": say(self.need(FLEET, traffic=True).machines),
            "f_cores": say(need.cores), "f_device": percent(need.devices),
            "f_software": say(need.software), "f_gbit": say(v.all / G),
            "f_wall": say(v.wall / G), "f_edge": say(edge / G),
            "f_carrying": say(v.carrying), "f_edges": say(v.edges),
            "f_origin": say(v.origin / M), "f_readers": say(READERS)}

    def frames(self):
        cores = TASKS * THREADS
        d = Frames(self.f, SET, cores, SET_SIZE)
        self.say |= {
            "d_million": say(SET / M), "d_size": NAMES[SET_SIZE],
            "d_s": self.of("set_s"), "d_kb": say(self.of("set_kb")),
            "d_exr_mb": say(self.of("exr_kb") / K),
            "d_core_h": say(d.core_h), "d_tasks": say(TASKS),
            "d_threads": say(THREADS), "d_hours": say(d.hours),
            "d_tb": say(d.bytes / T), "d_exr_h": say(d.exr_h),
            "d_cost": say(d.core_h * PRICE["core"]),
            "d_mb_s": say(d.bytes / M / d.hours / 3600),
            "d_gpu_ms": say(self.model.device_s(SET_SIZE) * K)}

    def stress(self):
        n = self.need(CAMERAS[-1])
        slow = self.need(CAMERAS[-1], rate=SLOW_HZ)
        each = n.cost(PRICE) / n.machines
        self.say |= {
            "s_cameras": say(n.cameras), "s_machines": say(n.machines),
            "s_cores": say(n.cores),
            "s_cores_bought": say(n.machines * MACHINE["cores"]),
            "s_devices": say(n.devices), "s_gbit": say(n.bits / G),
            "s_cost": say(n.cost(PRICE)),
            "s_idle": percent(1 - n.devices / n.machines),
            "s_next": say(n.next_machines),
            "s_next_cost": say(n.next_machines * each),
            "s_traffic": say(self.need(CAMERAS[-1], traffic=True).machines),
            "s_slow_hz": say(SLOW_HZ), "s_slow": say(slow.machines),
            "s_logs": say(n.states), "s_members": say(n.states * MEMBERS)}

    def write(self, text):
        """The page: each name of the text replaced."""
        return SENTENCE.sub(lambda m: str(self.say[m[1]]), text)


def made(tree):
    tree = pathlib.Path(tree)
    text = (tree / "docs/planning.in.md").read_text(encoding="utf-8")
    return Page(figures.read(tree)).write(text)


def main():
    tree = pathlib.Path(sys.argv[1]) if sys.argv[1:] else figures.ROOT
    try:
        text = made(tree)
    except figures.Missing as e:
        sys.exit(f"planning: {e}")
    (tree / "docs/planning.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
