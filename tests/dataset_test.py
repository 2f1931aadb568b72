#!/usr/bin/python3
"""pelagosctl dataset: what is wrong with a plan is said before anything is
drawn; a scene is a function of plan and number; workers that are killed leave
nothing half, and the set has the bits of one that nobody disturbed; its files
are read by readers of others.

DATASET_SHARDS, DATASET_FRAMES (of a shard), DATASET_KILLS: of Kills."""
import hashlib
import io
import json
import math
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
import time
import unittest

import numpy as np
from PIL import Image

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, ROOT, until

sys.path.insert(0, os.path.join(ROOT, "clients/python"))
sys.dont_write_bytecode = True
from pelagos.dataset import BadPlan, Plan
from pelagos.dataset.folder import Alarm, Folder
from pelagos.dataset.parquet import Table
from pelagos.dataset.sample import Distribution

SHARDS = int(os.environ.get("DATASET_SHARDS", 5))
FRAMES = int(os.environ.get("DATASET_FRAMES", 4))
KILLS = int(os.environ.get("DATASET_KILLS", 2))
NODE = os.path.join(ROOT, "build/npm")

# Small pictures of a sea that is soon made; what is drawn of it changes.
PLAN = {
    "name": "small", "about": "For a test.", "license": "CC0-1.0", "seed": 3,
    "frames": SHARDS * FRAMES, "shard": FRAMES, "width": 64, "height": 36,
    "sequence": {"frames": 2, "step": 0.5}, "ids": True, "time": 2,
    "state": {"sea": {"synthesiser": "TROCHOIDS"},
              "views": [{"name": "eye", "entity": 1, "up": 6}]},
    "ranges": {"sky.sunElevation": {"uniform": [10, 60]},
               "sky.sunAzimuth": {"integer": [0, 359]},
               "views.eye.yaw": {"normal": [0, 20], "within": [-40, 40]},
               "sea.windDirection": {"choice": [90, 180], "chance": 0.5},
               "views.eye.tone": {"choice": ["FILMIC", "LINEAR"]}},
    "traffic": [{"models": ["tug", "usv", "cardinal-north"],
                 "count": {"integer": [1, 3]},
                 "distance": {"uniform": [20, 60]},
                 "bearing": {"uniform": [-15, 15]}}]}


def ctl(*words, status=0, **more):
    done = subprocess.run([os.path.join(BIN, "pelagosctl"), "dataset", *words],
                          capture_output=True, text=True, **more)
    if status is not None and done.returncode != status:
        raise AssertionError(f"{words}: {done.returncode}\n{done.stdout}"
                             f"{done.stderr}")
    return done


def changed(**more):
    return {**json.loads(json.dumps(PLAN)), **more}


class Plans(unittest.TestCase):
    # What is changed of the plan, and what is said of it.
    WRONG = [
        ({"nmae": "x"}, r"no 'nmae'; did you mean name\?"),
        ({"name": "a/b"}, r"name is 'a/b', 1 to 64 of"),
        ({"frames": 7}, r"frames is 7, a multiple of sequence.frames \(2\)"),
        ({"frames": 0}, r"frames is 0, a whole number from 1 to"),
        ({"frames": None}, r"frames \(a number\) or scenes"),
        ({"quality": 101}, r"quality is 101, a whole number from 1 to 100"),
        ({"picture": "gif"}, r"picture is 'gif', one of jpg, png, none"),
        ({"layers": ["deep"]}, r"layers: there is no 'deep'"),
        ({"view": "wing"}, r"view is 'wing', one of state.views"),
        ({"width": 8}, r"width: views.eye.width is 8, a whole number from 16 "
         r"to 4096 px"),
        ({"time": -1}, r"time is -1, a number from 0"),
        ({"state": {"sea": {"windSpeed": 99}}},
         r"state: sea.windSpeed is 99, a number from 0 to 30 m/s"),
        ({"state": {"sea": {"spectrum": "JONSWOP"}}},
         r"sea.spectrum is 'JONSWOP', one of .*did you mean JONSWAP\?"),
        ({"state": {"seas": {}}}, r"no field 'seas'; did you mean sea\?"),
        ({"state": {"entities": [{"id": 1}, {"id": 1}]}}, r"has id 1 twice"),
        ({"ranges": {"sea.windSpeed": {"uniform": [2, 31]}}},
         r"ranges.sea.windSpeed: sea.windSpeed is 31.0, a number from 0 to 30"),
        ({"ranges": {"sea.windSpede": {"uniform": [2, 3]}}},
         r"no field 'sea.windSpede'; did you mean windSpeed\?"),
        ({"ranges": {"sea": {"uniform": [2, 3]}}}, r"'sea' is no single field"),
        ({"ranges": {"sea.windSpeed": {"unifrom": [2, 3]}}},
         r"'unifrom' is no distribution"),
        ({"ranges": {"sea.windSpeed": {"uniform": [3, 2]}}},
         r"uniform takes \[lowest, highest\], not \[3, 2\]"),
        ({"ranges": {"sea.windSpeed": {"logUniform": [0, 2]}}},
         r"logUniform takes"),
        ({"ranges": {"sea.windSpeed": {"normal": [0, 1], "within": [20, 30]}}},
         r"nothing of this normal distribution is within \[20, 30\]"),
        ({"ranges": {"sea.windSpeed": {"choice": [1, 2], "weights": [1]}}},
         r"weights are as many as the values"),
        ({"ranges": {"views.wing.up": {"uniform": [2, 3]}}},
         r"ranges.views.wing.up: there is no views.wing in the plan's state"),
        ({"ranges": {"clock.time": {"uniform": [2, 3]}}},
         r"`time` says the moment"),
        ({"traffic": [{"models": ["tgu"]}]}, r"no model 'tgu'; did you mean "
         r"tug\?"),
        ({"traffic": [{"models": ["tug"], "sped": 1}]},
         r"traffic\[0\]: there is no field 'sped'; did you mean speed\?"),
        ({"traffic": [{"models": ["tug"], "speed": 300}]},
         r"speed is 300, a number from 0 to 200 m/s"),
        ({"directories": {"models": "nowhere"}}, r"is no directory"),
    ]

    def test_what_is_wrong_is_said(self):
        for change, said in self.WRONG:
            with self.subTest(change), self.assertRaisesRegex(BadPlan, said):
                Plan(changed(**change))

    def test_by_the_command_line(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "plan.json")
            for text, said in (
                    ("{", "no JSON"), ('{"seed": 1, "seed": 2}', "twice"),
                    ("[" * 100000, "line 1 is nested deeper than 32"),
                    ('{"seed": 1,\n"state": ' + '{"a":' * 40 + "1" + "}" * 41,
                     "line 2 is nested deeper than 32"),
                    ('{"state": {"sea": {"windSpeed": 1e999}}}',
                     "1e999 is no finite number"),
                    ('{"seed": NaN}', "NaN is no finite number"),
                    (json.dumps(changed(frames=7)), "frames is 7")):
                pathlib.Path(path).write_text(text)
                done = ctl("run", path, "-o", os.path.join(folder, "out"),
                           status=2)
                self.assertIn(said, done.stderr)
                self.assertIn("plan.json", done.stderr)
            self.assertEqual(os.listdir(folder), ["plan.json"])
            self.assertIn("did you mean plan?",
                          ctl("plna", path, status=2).stderr)
            self.assertIn("print or submit",
                          ctl("run", path, "--slurm", "now", status=2).stderr)
            self.assertIn("no data set", ctl("status", folder,
                                             status=2).stderr)


class Draws(unittest.TestCase):
    def test_a_scene_is_a_function_of_its_number(self):
        """In any order, of a plan that was read before or not."""
        plan = Plan(changed())
        forth = [plan.scene(i) for i in range(8)]
        back = [Plan(plan.content).scene(i) for i in reversed(range(8))][::-1]
        self.assertEqual(forth, back)
        self.assertEqual(Plan(plan.content).digest(), plan.digest())
        self.assertNotEqual(Plan(changed(seed=4)).scene(0), forth[0])
        self.assertEqual(len({json.dumps(s.patch) for s in forth}), 8)

    def test_uniform_is_what_the_manual_says(self):
        """SHA-256 of "seed/scene/name/k", its first 53 bits."""
        d = Distribution({"uniform": [-5, 5]}, "here")
        for scene in range(50):
            bits = bin(int(hashlib.sha256(f"9/{scene}/a.b/0".encode())
                           .hexdigest(), 16))[2:].zfill(256)[:53]
            self.assertAlmostEqual(d.draw(9, scene, "a.b"),
                                   -5 + 10 * int(bits, 2) / 2**53, 7)

    def test_distributions(self):
        """Quantiles of 20,000 draws. By Dvoretzky, Kiefer, Wolfowitz the
        empirical distribution is within 0.0125 of the true one but for 4 of
        1,000 seeds, 2 exp(-2 n e2), and the seed is fixed."""
        n, e = 20_000, 0.0125

        def phi(x):
            return 0.5 * (1 + math.erf(x / math.sqrt(2)))

        for spec, cdf in (
                ({"uniform": [2, 16]}, lambda x: (x - 2) / 14),
                ({"logUniform": [3, 3000]}, lambda x: math.log10(x / 3) / 3),
                ({"normal": [10, 4], "within": [4, 30]},
                 lambda x: (phi((x - 10) / 4) - phi(-1.5))
                 / (phi(5) - phi(-1.5)))):
            d = Distribution(spec, "here")
            values = np.sort([d.draw(1, i, "x") for i in range(n)])
            own = np.array([cdf(x) for x in values])
            self.assertLess(abs(own - np.arange(n) / n).max(), e, spec)
            self.assertGreaterEqual(values[0], d.low)
            self.assertLessEqual(values[-1], d.high)
        # Counts: binomial, five deviations.
        d = Distribution({"choice": ["a", "b", "c"], "weights": [1, 0, 3]},
                         "here")
        drawn = [d.draw(1, i, "x") for i in range(n)]
        self.assertNotIn("b", drawn)
        self.assertLess(abs(drawn.count("c") / n - 0.75),
                        5 * math.sqrt(0.75 * 0.25 / n))
        d = Distribution({"integer": [1, 4]}, "here")
        drawn = [d.draw(1, i, "x") for i in range(n)]
        self.assertEqual(set(drawn), {1, 2, 3, 4})
        d = Distribution({"uniform": [0, 1], "chance": 0.2}, "here")
        drawn = [d.draw(1, i, "x") for i in range(n)]
        self.assertLess(abs(1 - drawn.count(None) / n - 0.2),
                        5 * math.sqrt(0.16 / n))

    def test_grid(self):
        """Every combination, once a round."""
        plan = Plan(changed(frames=12, shard=12, sequence=None, ranges={
            "sea.windSpeed": {"grid": [3, 6, 9]},
            "sky.sunElevation": {"grid": [20, 40]}}))
        got = [tuple(plan.scene(i).parameters.values()) for i in range(12)]
        self.assertEqual(len(set(got[:6])), 6)
        self.assertEqual(got[:6], got[6:])

    def test_traffic_is_where_it_was_said(self):
        """At the scene's moment, by plane trigonometry: a metre in 900."""
        plan = Plan(changed(time=100, frames=200, traffic=[
            {"models": ["tug", "ferry"], "count": 4, "speed": 5,
             "distance": {"uniform": [300, 900]}}]))
        seen = 0
        for number in range(50):
            scene = plan.scene(number)
            eye = scene.patch["entities"][0]
            yaw = scene.patch["views"][0]["yaw"]
            places = []
            for ship in scene.patch["entities"][1:]:
                turn = math.radians(ship["course"])
                north = (ship["latitude"] - 52.6) * 111_278 + 500 * math.cos(
                    turn)
                east = ((ship["longitude"] - 5.2) * 67_730
                        + 500 * math.sin(turn))
                away = math.hypot(north, east)
                self.assertTrue(299 <= away <= 901, away)
                bearing = math.degrees(math.atan2(east, north)) - yaw
                self.assertLess(abs((bearing + 180) % 360 - 180), 28.2)
                half = 93 if ship["model"]["name"] == "ferry" else 16
                for n, e, h in places:
                    self.assertGreater(math.hypot(n - north, e - east),
                                       9 + h + half)
                places.append((north, east, half))
                seen += 1
            self.assertEqual(eye.get("speed", 0), 0)
        self.assertGreater(seen, 150)


def node(script, *words):
    """Runs a script where npm's packages are; None: they are not."""
    if not (shutil.which("node") and os.path.isdir(os.path.join(
            NODE, "node_modules/hyparquet"))):
        return None
    path = os.path.join(NODE, f"dataset-{os.getpid()}.mjs")
    pathlib.Path(path).write_text(script)
    try:
        return json.loads(subprocess.run(
            ["node", path, *words], capture_output=True, check=True).stdout)
    finally:
        os.unlink(path)


READ_PARQUET = """
import fs from "fs";
import { parquetReadObjects } from "hyparquet";
import * as wasm from "parquet-wasm";
import { tableFromIPC } from "apache-arrow";
const data = fs.readFileSync(process.argv[2]);
const plain = (_, v) => typeof v === "bigint" ? Number(v) : v;
const file = data.buffer.slice(data.byteOffset,
                               data.byteOffset + data.length);
const one = await parquetReadObjects({ file });
const table = tableFromIPC(wasm.readParquet(new Uint8Array(data))
                               .intoIPCStream());
const other = [];
for (let i = 0; i < table.numRows; i++) other.push(table.get(i).toJSON());
console.log(JSON.stringify([one, other], plain));
"""


class Parquet(unittest.TestCase):
    def test_two_readers_agree(self):
        """hyparquet (JavaScript) and parquet-wasm (Arrow's, in Rust)."""
        rows = [{"a": i * 7919 - 2**40 if i % 3 else None,
                 "b": i / 7 if i % 5 else None,
                 "c": "ä|" * (i % 4) if i % 2 else None}
                for i in range(1000)]
        rows += [{"a": None, "b": -0.5, "c": ""}] * 200
        with tempfile.NamedTemporaryFile(suffix=".parquet") as file:
            table = Table(file, {"a": "int", "b": "float", "c": "str"},
                          "a test", {"key": "value"})
            for row in rows:
                table.add(row)
            table.close()
            file.flush()
            read = node(READ_PARQUET, file.name)
        if read is None:
            self.skipTest("hyparquet and parquet-wasm of npm are not "
                          "installed: make deps")
        self.assertEqual(read[0], rows)
        self.assertEqual(read[1], rows)


def size_of(path):
    try:
        return os.path.getsize(path)
    except OSError:  # it is whole by now
        return 0


def is_gone(pid):
    try:
        with open(f"/proc/{pid}/stat", encoding="latin-1") as f:
            return f.read().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def family(pid):
    """The process's descendants, by their ids."""
    parents = {}
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                with open(f"/proc/{entry}/stat", encoding="latin-1") as f:
                    fields = f.read().rpartition(")")[2].split()
                parents.setdefault(int(fields[1]), []).append(int(entry))
            except OSError:
                pass
    out, more = [], [pid]
    while more:
        children = parents.get(more.pop(), [])
        out += children
        more += children
    return out


class Sets(unittest.TestCase):
    """Two sets of one plan: one drawn by two workers who are killed again and
    again, the other by one whom nobody disturbs."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="pelagos-test-")
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.path = os.path.join(cls.folder, "plan.json")
        pathlib.Path(cls.path).write_text(json.dumps(PLAN))
        cls.calm = os.path.join(cls.folder, "calm")
        cls.wild = os.path.join(cls.folder, "wild")
        cls.said = ctl("run", cls.path, "-o", cls.calm, "--workers",
                       "2" if KILLS > 9 else "1").stdout
        cls.kills = cls.disturb()

    @classmethod
    def disturb(cls):
        """Runs it with workers, daemons and the whole of it killed; what was
        killed."""
        dice, killed, cls.seen = random.Random(5), [], {}
        command = [os.path.join(BIN, "pelagosctl"), "dataset", "run",
                   cls.path, "-o", cls.wild, "--workers", "2", "--quiet",
                   "--no-estimate"]
        with open(os.path.join(cls.folder, "log"), "wb") as log:
            while True:
                run = subprocess.Popen(command, stdout=log, stderr=log)
                while run.poll() is None:
                    if len(killed) < KILLS:
                        cls.kill_one(run.pid, dice, killed)
                    else:
                        time.sleep(0.05)
                if run.returncode == 0:
                    return killed
                if run.returncode != -signal.SIGKILL:
                    log.flush()
                    raise AssertionError(pathlib.Path(
                        cls.folder, "log").read_text())

    @classmethod
    def parts(cls):
        """Shards that are not whole."""
        return pathlib.Path(cls.wild, "shards").glob(".*")

    @classmethod
    def kill_one(cls, pid, dice, killed):
        """One of the run's processes: a worker, a daemon, or all of it, once
        one has a shard half done that is more than at the last kill. (A worker
        gives up where its daemon ends three times at one frame.)"""
        ours = family(pid)
        sizes = {p: size_of(p) for p in cls.parts()}
        half = [p for p, size in sizes.items() if size > cls.seen.get(p, 0)
                and p.suffix[1:].isdigit() and int(p.suffix[1:]) in ours]
        if not half:
            time.sleep(0.01)
            return
        time.sleep(dice.uniform(0, 0.6))
        workers = [int(p.suffix[1:]) for p in half]
        victim = dice.choice(dice.choices(
            [[pid], workers, [p for w in workers for p in family(w)] or [pid]],
            [1, 2, 2])[0])
        try:
            name = pathlib.Path(f"/proc/{victim}/comm").read_text().strip()
            os.kill(victim, signal.SIGKILL)
        except OSError:
            return
        cls.seen = sizes
        killed.append("all of it" if victim == pid else name)
        # Not the same again before anything has begun.
        until("it is gone", lambda: is_gone(victim), 30)

    def test_the_estimate_comes_first(self):
        self.assertRegex(self.said, r"measured on \d+ of its frames: \d+ ms "
                         r"and \d+ kB a frame")
        self.assertRegex(self.said, r"\d+ frames, .*a second")

    def test_killed_or_not_the_bits_are_the_same(self):
        self.assertEqual(len(self.kills), KILLS, "there was nobody to kill")
        if KILLS > 9:
            self.assertGreater(len(set(self.kills)), 2, self.kills)
        print(f"killed: {', '.join(self.kills)}", file=sys.stderr)
        names = sorted(os.listdir(os.path.join(self.calm, "shards")))
        self.assertEqual(names, [f"{i:05}.tar" for i in range(SHARDS)])
        self.assertEqual(sorted(os.listdir(os.path.join(
            self.wild, "shards"))), names, "something half was left")
        for name in names:
            one, other = (pathlib.Path(f, "shards", name).read_bytes()
                          for f in (self.calm, self.wild))
            self.assertEqual(hashlib.sha256(one).digest(),
                             hashlib.sha256(other).digest(), name)
        for name in ("index.parquet", "annotations.json", "SHA256SUMS",
                     "README.md"):
            self.assertEqual(pathlib.Path(self.calm, name).read_bytes(),
                             pathlib.Path(self.wild, name).read_bytes(), name)
        done = subprocess.run(["sha256sum", "-c", "--quiet", "SHA256SUMS"],
                              cwd=self.wild, capture_output=True)
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        self.assertFalse(os.path.exists(os.path.join(self.wild, "alarms")))

    def samples(self):
        """Of each frame its files by their endings."""
        out = {}
        for shard in sorted(pathlib.Path(self.wild, "shards").iterdir()):
            with tarfile.open(shard) as tar:
                for member in tar:
                    self.assertEqual((member.mtime, member.uid, member.uname),
                                     (0, 0, ""))
                    key, _, ending = member.name.partition(".")
                    files = out.setdefault(key, {})
                    self.assertNotIn(ending, files, key)
                    files[ending] = tar.extractfile(member).read()
        return out

    def test_every_frame_once(self):
        samples = self.samples()
        self.assertEqual(sorted(samples), [f"{i:09}" for i in range(
            SHARDS * FRAMES)])
        about = [json.loads(s["json"]) for s in samples.values()]
        self.assertEqual(len({a["id"] for a in about}), SHARDS * FRAMES)
        self.assertEqual([a["frame"] for a in about],
                         list(range(SHARDS * FRAMES)))
        self.assertEqual([a["scene"] for a in about[:4]], [0, 0, 1, 1])
        self.assertEqual([a["time"] for a in about[:4]], [2, 2.5, 2, 2.5])
        pictures = {hashlib.sha256(s["jpg"]).digest()
                    for s in samples.values()}
        self.assertEqual(len(pictures), SHARDS * FRAMES)

    def test_files_by_readers_of_others(self):
        coco = json.loads(pathlib.Path(
            self.wild, "annotations.json").read_text())
        boxes = {}
        for a in coco["annotations"]:
            boxes.setdefault(a["image_id"], []).append(a)
        self.assertEqual([a["id"] for a in coco["annotations"]],
                         list(range(1, 1 + len(coco["annotations"]))))
        categories = {c["id"]: c["name"] for c in coco["categories"]}
        samples = self.samples()
        checked = 0
        for image in coco["images"][:60]:
            files = samples[image["file_name"].split(".")[0]]
            with Image.open(io.BytesIO(files["jpg"])) as picture:
                self.assertEqual(picture.size, (64, 36))
                self.assertEqual(picture.format, "JPEG")
            with Image.open(io.BytesIO(files["ids.png"])) as picture:
                ids = np.array(picture).astype(np.int64)
            about = json.loads(files["json"])
            models = {e["id"]: e["model"]["name"]
                      for e in about["state"]["entities"] if "model" in e}
            left = set(np.unique(ids)) - {0}
            for a in boxes.get(image["id"], []):
                mask = ids == a["entity"] + 1
                left.discard(a["entity"] + 1)
                # Runs down the columns, by their definition.
                flat, value = [], 0
                for run in a["segmentation"]["counts"]:
                    flat += [value] * run
                    value = 1 - value
                self.assertTrue((np.array(flat).reshape(64, 36).T
                                 == mask).all())
                rows, columns = np.nonzero(mask)
                self.assertEqual(a["bbox"], [
                    columns.min(), rows.min(),
                    columns.max() - columns.min() + 1,
                    rows.max() - rows.min() + 1])
                self.assertEqual(a["area"], mask.sum())
                self.assertIn(categories[a["category_id"]],
                              models[a["entity"]])
                checked += 1
            self.assertEqual(left, set(), "pixels without a box")
        self.assertGreater(checked, 20)

    def test_exr(self):
        if not shutil.which("exrheader"):
            self.skipTest("exrheader is not installed: openexr")
        path = os.path.join(self.folder, "one.exr")
        pathlib.Path(path).write_bytes(self.samples()["000000003"]["exr"])
        text = subprocess.run(["exrheader", path], capture_output=True,
                              text=True, check=True).stdout
        for channel in ("depth.Z", "id.I", "class.K"):
            self.assertIn(channel, text)
        self.assertIn("(63 35)", text)

    def test_index(self):
        read = node(READ_PARQUET, os.path.join(self.wild, "index.parquet"))
        if read is None:
            self.skipTest("hyparquet and parquet-wasm of npm are not "
                          "installed: make deps")
        self.assertEqual(read[0], read[1])
        samples = self.samples()
        self.assertEqual(len(read[0]), len(samples))
        for row, (key, files) in zip(read[0], sorted(samples.items())):
            about = json.loads(files["json"])
            self.assertEqual(row["id"], about["id"])
            self.assertEqual(row["frame"], int(key))
            self.assertEqual(row["bytes"], sum(map(len, files.values())))
            for path, value in about["parameters"].items():
                self.assertEqual(row[path], value)
        self.assertIn(None, [row["sea.windDirection"] for row in read[0]])

    def test_card(self):
        text = pathlib.Path(self.wild, "README.md").read_text()
        for path, words in (("sky.sunElevation", "uniform, 10 to 60"),
                            ("views.eye.tone", "choice of FILMIC, LINEAR")):
            self.assertRegex(text, rf"\| `{re.escape(path)}` \|.*{words}")
        self.assertIn("CC0-1.0", text)
        plan = json.loads(re.search(r"```json\n(.*?)```", text, re.S)[1])
        self.assertEqual(Plan(plan).digest(), Plan(changed()).digest())
        self.assertIn(Plan(plan).digest(), text)

    def test_status_and_what_is_missing(self):
        copy = os.path.join(self.folder, "copy")
        shutil.copytree(self.wild, copy)
        os.unlink(os.path.join(copy, "shards/00001.tar"))
        # All of them within a tenth of a second, a hundred seconds after the
        # set began, as workers end them.
        now = time.time()
        os.utime(os.path.join(copy, "set.json"), (now - 100, now - 100))
        for i, shard in enumerate(pathlib.Path(copy, "shards").glob("*.tar")):
            os.utime(shard, (now - 1 + i * 0.1 / SHARDS,) * 2)
        togo = json.loads(ctl("status", copy, "--json").stdout)["hoursToGo"]
        self.assertAlmostEqual(togo, 100 / (SHARDS - 1) / 3600,
                               delta=30 / (SHARDS - 1) / 3600 + 0.0005)
        said = json.loads(ctl("status", copy, "--json").stdout)
        self.assertEqual((said["shards"], said["done"], said["framesDone"],
                          said["drawnNow"], said["alarms"]),
                         (SHARDS, SHARDS - 1, (SHARDS - 1) * FRAMES, 0, 0))
        self.assertIn("the first is 00001", ctl("merge", copy,
                                                status=1).stderr)
        part = json.loads(ctl("merge", copy, "--partial", "--json").stdout)
        self.assertEqual(part["frames"], (SHARDS - 1) * FRAMES)
        # One who draws it is seen while he does.
        with Folder(copy).claim(1) as mine:
            self.assertTrue(mine)
            with Folder(copy).claim(1) as another:
                self.assertFalse(another)
            self.assertEqual(json.loads(ctl("status", copy, "--json").stdout
                                        )["drawnNow"], 1)
        # A shard that another has drawn meanwhile, with other bits.
        folder = Folder(copy)
        shutil.copy(folder.shard(2), folder.shard(1))
        shutil.copy(folder.shard(1), folder.at("shards/.00001.twin.1"))
        folder.publish(1, folder.at("shards/.00001.twin.1"))
        self.assertFalse(os.path.exists(folder.at("shards/.00001.twin.1")))
        pathlib.Path(folder.at("shards/.00001.other.1")).write_bytes(b"x")
        with self.assertRaisesRegex(Alarm, "other bits"):
            folder.publish(1, folder.at("shards/.00001.other.1"))
        self.assertIn("ALARM: 1", ctl("status", copy).stdout)
        self.assertIn("other bits", ctl("merge", copy, status=1).stderr)

    def test_sets_do_not_mix(self):
        path = os.path.join(self.folder, "other.json")
        pathlib.Path(path).write_text(json.dumps(changed(seed=4)))
        self.assertIn("another plan", ctl("run", path, "-o", self.wild,
                                          status=2).stderr)
        with self.assertRaisesRegex(BadPlan, "another device"):
            Folder(self.wild).open(Plan(changed()), {
                "program": Folder(self.wild).set()["program"],
                "device": "a GPU"})

    def test_what_the_daemon_refuses(self):
        """Before the set begins, with the frame that it is."""
        path = os.path.join(self.folder, "refused.json")
        plan = changed(name="refused")
        plan["state"]["views"][0]["frustum"] = {
            "left": 5, "right": -5, "top": 5, "bottom": -5}
        pathlib.Path(path).write_text(json.dumps(plan))
        out = os.path.join(self.folder, "refused")
        done = ctl("run", path, "-o", out, status=4)
        self.assertRegex(done.stderr, r"frame \d+ \(scene \d+\): .*frustum")
        self.assertFalse(os.path.exists(out))


if __name__ == "__main__":
    unittest.main()
