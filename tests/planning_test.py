#!/usr/bin/python3
"""docs/planning.md: its numbers are what tests/planning makes of the figures,
none is written by hand, another measurement changes the page, a figure that
cannot be found is told; the formulas give what is worked out by hand here."""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/planning"))
import figures  # noqa: E402
import page  # noqa: E402
from model import FULL, HD, UHD, Frames, Log, Model, Need, Viewers  # noqa: E402

# Names, not numbers: of formats, devices and the like.
NAMES = re.compile(r"H\.264|x264|H[12]00|\b4K\b|\bt[01]\b|64 × 36|"
                   r"p / 921,600|\bp99\b")


def text_of(name):
    return (ROOT / name).read_text(encoding="utf-8")


class Page(unittest.TestCase):
    def test_its_numbers_are_the_scripts(self):
        self.assertEqual(text_of("docs/planning.md"), page.made(ROOT),
                         "docs/planning.md is not current: make planning")

    def test_no_number_by_hand(self):
        """Where a digit stands in the text, it is a name's, a link's or
        code's; all other numbers are asked of the script."""
        text = page.SENTENCE.sub("", text_of("docs/planning.in.md"))
        text = re.sub(r"\]\([^)]*\)|`[^`\n]+`", "", text)
        for line in NAMES.sub("", text).split("\n"):
            line = re.sub(r"^\d\. ", "", line)
            self.assertNotRegex(line, r"\d")

    def test_every_figure_is_used(self):
        used = set()

        class Asked(dict):
            def __getitem__(self, name):
                used.add(name)
                return super().__getitem__(name)
        page.Page(Asked(figures.read()))
        self.assertEqual(set(figures.SOURCES) - used, set())

    def test_every_number_of_the_script_is_asked_for(self):
        asked = set(page.SENTENCE.findall(text_of("docs/planning.in.md")))
        self.assertEqual(set(page.Page(figures.read()).say), asked)


class Sources(unittest.TestCase):
    """Of a copy of the pages, one of whose numbers is another."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="pelagos-planning-")
        self.addCleanup(folder.cleanup)
        self.tree = pathlib.Path(folder.name)
        files = {file for file, _, _ in figures.SOURCES.values()}
        for name in files | {"docs/planning.in.md"}:
            (self.tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, self.tree / name)

    def change(self, name, old, new):
        path = self.tree / name
        text = path.read_text(encoding="utf-8")
        self.assertEqual(text.count(old), 1, old)
        path.write_text(text.replace(old, new), encoding="utf-8")

    def write(self):
        return subprocess.run(
            [sys.executable, "-B", str(ROOT / "tests/planning/page.py"),
             str(self.tree)], capture_output=True, text=True, check=False)

    def test_another_measurement_is_another_page(self):
        f = figures.read()["seal_ms"].values
        self.change("docs/cluster.md", f"{f[0]}, {f[1]} ms at load",
                    "2.5, 20 ms at load")
        said = self.write()
        self.assertEqual((said.returncode, said.stderr), (0, ""))
        text = (self.tree / "docs/planning.md").read_text(encoding="utf-8")
        self.assertIn("Seals took 2.5 ms (median) and 20 ms (p99)", text)
        self.assertIn("by the median 400 frames a second, by p99 50;", text)

    def refused(self, why):
        said = self.write()
        self.assertEqual((said.returncode, said.stderr),
                         (1, f"planning: {why}\n"))
        self.assertFalse((self.tree / "docs/planning.md").exists())

    def test_a_figure_that_is_gone_is_told(self):
        self.change("proto/bounds.def", "PEL_BOUND(CLUSTER_NODES,",
                    "PEL_BOUND(NODES,")
        self.refused("nodes: proto/bounds.def has 0 times: "
                     + figures.SOURCES["nodes"][2])

    def test_a_figure_that_is_there_twice_is_told(self):
        with open(self.tree / "proto/live.md", "a", encoding="utf-8") as f:
            f.write("by the size: 4000 for 1280×720\n")
        self.refused("kbps: proto/live.md has 2 times: "
                     + figures.SOURCES["kbps"][2])

    def test_a_heading_that_is_gone_is_told(self):
        self.change("docs/benchmarks.md", "## Bytes", "## Octets")
        self.refused("jpeg_kb: docs/benchmarks.md: no heading Bytes")


def round_figures():
    """Figures that are easy to reckon with."""
    values = {name: [1.0] for name in figures.SOURCES}
    values.update({
        # 100 µs and 900 µs: 0.8 ms over 7,372,800 pixels.
        "drawn_720": [10000.0], "drawn_2160": [1 / 900e-6],
        "h264_32": [6400.0], "h264_16": [4800.0],
        "h264_slow": [180.0, 0, 0, 50.0], "jpeg_2": [500.0],
        "jpeg_alone": [100.0], "core_ms": [96.0],
        "h264_core_ms": [4.0], "views": [64.0], "streams": [64.0],
        "pixels": [2.0 ** 26], "kbps": [5000.0], "jpeg_kb": [80.0, 50.0, 100.0],
        "traffic_ms": [9.0, 9.0, 1.0, 2.0], "live_hz": [240.0], "set_s": [3.6],
        "set_kb": [400.0], "exr_ms": [180.0]})
    return {n: figures.Figure(v, "", None) for n, v in values.items()}


class Formulas(unittest.TestCase):
    """Every expectation is worked out by hand from round_figures."""

    def setUp(self):
        self.model = Model(round_figures())
        self.machine = {"cores": 40, "bits": 1e9, "load": 0.5}

    def need(self, n, codec="h264", size=HD, rate=25, traffic=False):
        return Need(self.model, n, size, rate, codec, self.machine, traffic)

    def test_a_picture(self):
        self.assertAlmostEqual(self.model.device_s(HD), 100e-6)
        # 1,152,000 pixels more by 0.8 / 7,372,800 ms each: 0.125 ms.
        self.assertAlmostEqual(self.model.device_s(FULL), 225e-6)
        self.assertAlmostEqual(self.model.device_s(UHD), 900e-6)
        self.assertAlmostEqual(self.model.traffic_s(UHD), 19e-3)

    def test_the_least_of_what_cores_made(self):
        self.assertEqual(self.model.core, {"h264": 200.0, "jpeg": 250.0})

    def test_a_view_alone(self):
        self.assertAlmostEqual(self.model.most_rate(UHD, "h264"), 20)
        self.assertAlmostEqual(self.model.most_rate(UHD, "jpeg"), 100)
        self.assertEqual(self.model.most_rate(HD, "jpeg"), 240)

    def test_places(self):
        self.assertEqual([self.model.places(s) for s in (
            HD, FULL, UHD)],
            [64, 32, 8])

    def test_what_fills_a_machine(self):
        n = self.need(100)  # 2,500 pictures, 0.25 device, 12.5 cores
        self.assertAlmostEqual(n.devices, 0.25)
        self.assertAlmostEqual(n.cores, 12.5)
        self.assertAlmostEqual(n.software, 250)
        self.assertEqual(n.bits, 500e6)
        # Places 3.125, device 0.5, cores 0.625, network exactly 1.
        self.assertEqual((n.machines, n.next_machines, n.states), (2, 1, 2))
        self.assertEqual(n.order[:2], ["a daemon's places", "the network"])
        busy = self.need(100, traffic=True)  # 2,500 · 3 ms = 7.5, by 0.5
        self.assertEqual((busy.machines, busy.order[0]), (15, "the device"))
        # JPEG: 100 kB · 8 · 25 = 20 Mbit/s each, 2 Gbit/s by 0.5 Gbit/s.
        jpeg = self.need(100, "jpeg")
        self.assertEqual((jpeg.machines, jpeg.order[0]), (4, "the network"))
        self.assertEqual(self.need(64).states, 1)
        self.assertEqual(self.need(65).states, 2)

    def test_cost(self):
        price = {"machine": 1, "device": 2, "core": 0.1}
        self.assertAlmostEqual(self.need(100).cost(price), 2 * 7)

    def test_viewers(self):
        v = Viewers(self.model, 20, HD, 1000, 1e9, 0.5)
        self.assertEqual((v.all, v.carrying, v.edges), (5e9, 10, 11))
        self.assertEqual((v.origin, v.wall), (20 * 5e6 * 11, 100e9))

    def test_frames(self):
        d = Frames(round_figures(), 1000, 10, HD)
        self.assertAlmostEqual(d.core_h, 1)
        self.assertAlmostEqual(d.hours, 0.1)
        self.assertEqual(d.bytes, 400e6)
        self.assertAlmostEqual(d.exr_h, 0.05)

    def test_log(self):
        log = Log(4, 60)
        self.assertEqual((log.puts, log.told, log.period_ms),
                         (64, 256, 1000 / 60))


if __name__ == "__main__":
    unittest.main()
