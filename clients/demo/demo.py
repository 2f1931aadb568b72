#!/usr/bin/python3
"""A short voyage: starts pelagosd on the software device, steers it through
every input it has, and leaves pictures and a summary in build/demo/.

    NMEA over UDP   position, heading, heel, trim, wind (pelagosctl replay)
    Modbus/TCP      the wind, in steps
    HTTP            more views; ships and the buoys of a channel; the pictures
                    that are compared
    protobuf        the Sun (pelagosctl set); JPEGs, EXR and the clip
"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

from parts import (Daemon, Modbus, Trouble, Viewer, difference, percentile,
                   placed, say, since_start)

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("PELAGOS_BIN", ROOT / "build"))
OUT = pathlib.Path(os.environ.get("PELAGOS_DEMO", ROOT / "build/demo"))
VOYAGE = ROOT / "clients/voyage/voyage.nmea"
TRAFFIC = ROOT / "clients/web/harbour.json"  # the page's harbour
SAIL_S = 40.0  # wall time of the voyage
WIND_STEPS = (5.0, 9.0, 13.0, 17.0)  # m/s, by Modbus
SIZE = (960, 540)
# Fixed to the world: between two of its pictures only sea and sky can differ.
STATION = {"up": 15, "yaw": 0, "pitch": -4, "width": 320, "height": 180}
WING = {"entity": 1, "forward": -4, "right": 9, "up": 14, "yaw": 100,
        "pitch": -8, "fieldOfView": 75, "width": SIZE[0], "height": SIZE[1]}
# Own ship's shape, from before its wheelhouse and from astern.
SHIP = {"model": {"name": "patrol-boat"}}
BRIDGE = {"forward": 9, "up": 9}
LAST_COURSE = 275  # the voyage ends on it: there the traffic is
CHASE = {"entity": 1, "forward": -80, "right": 25, "up": 20, "yaw": -14,
         "pitch": -9, "level": True, "width": SIZE[0], "height": SIZE[1]}


def voyage_seconds():
    """How long the log runs, by its RMC sentences."""
    stamps = [line.split(",")[1] for line in VOYAGE.read_text().splitlines()
              if line[3:6] == "RMC"]
    seconds = [int(s[:2]) * 3600 + int(s[2:4]) * 60 + float(s[4:])
               for s in stamps if s]
    return (seconds[-1] - seconds[0]) % 86400


def ship(state):
    entity = next(e for e in state["entities"] if e["id"] == 1)
    return {key: entity.get(key, 0.0) for key in
            ("latitude", "longitude", "heading", "pitch", "roll", "speed")}


def changed(before, after):
    return {key: [round(before[key], 6), round(after[key], 6)]
            for key in before if before[key] != after[key]}


class Demo:
    def __init__(self, daemon):
        self.daemon = daemon
        self.pictures, self.inputs = [], {}
        self.replay = self.before = None

    def shoot(self, view, name):
        done = self.daemon.ctl("frame", view, OUT / name)
        self.pictures.append(name)
        say(f"{name}: {done['bytes'] // 1000} kB")

    def compare(self, view, change):
        """Mean difference of two pictures for one moment, one drawn before
        and one after `change`."""
        moment = self.daemon.state()["clock"]["time"]
        before = self.daemon.small(view, moment)
        change()
        return difference(before, self.daemon.small(view, moment))

    def add_view(self):
        self.daemon.request("PUT", "/v1/views/wing", WING)
        self.daemon.request("PUT", "/v1/views/station", STATION)
        self.daemon.request("PUT", "/v1/views/chase", CHASE)
        self.daemon.patch({"entities": {"1": SHIP},
                           "views": {"bridge": BRIDGE}})
        names = [v["name"] for v in self.daemon.state()["views"]]
        self.inputs["HTTP"] = {"added views": ["wing", "station", "chase"],
                               "views": names}
        say(f"HTTP: PUT wing, station and chase; views are now {', '.join(names)}")

    def set_sail(self):
        seconds = voyage_seconds()
        speed = max(1.0, seconds / SAIL_S)
        say(f"NMEA: {VOYAGE.name}, {seconds:.0f} s of sentences at "
            f"{speed:.2g} times their pace")
        self.before = self.daemon.state()
        self.replay = subprocess.Popen(
            [BIN / "pelagosctl", "--server",
             f"tcp:127.0.0.1:{self.daemon.tcp}", "replay", VOYAGE,
             "--speed", f"{speed:.4f}", "--json",
             "--to", f"127.0.0.1:{self.daemon.nmea}"],
            stdout=subprocess.PIPE, text=True)
        diff = self.compare("bridge", lambda: time.sleep(SAIL_S * 0.15))
        state = self.daemon.state()
        was, sea = self.before["sea"], state["sea"]
        self.inputs["NMEA"] = {
            "wind m/s": [round(s["windSpeed"], 2) for s in (was, sea)],
            "wind from deg": [round(s["windDirection"], 1)
                              for s in (was, sea)],
            "picture difference": round(diff, 2)}
        say(f"NMEA: heading {ship(state)['heading']:.1f}, heel "
            f"{ship(state)['roll']:.1f}, trim {ship(state)['pitch']:.1f} deg, "
            f"wind {sea['windSpeed']:.1f} m/s; picture differs by "
            f"{diff:.1f} of 255")

    def meet_ships(self):
        """Ships and a channel's buoys, ahead of where own ship is now."""
        things = json.loads(TRAFFIC.read_text())
        entities = placed({**ship(self.daemon.state()),
                           "heading": LAST_COURSE}, things)
        diff = self.compare("bridge", lambda: self.daemon.patch(
            {"clock": {"reckoning": 3600}, "entities": entities}))
        self.inputs["ships and buoys"] = {
            "added": len(things), "picture difference": round(diff, 2)}
        say(f"HTTP: {len(things)} ships and buoys; picture differs by "
            f"{diff:.1f} of 255")
        for view in ("bridge", "chase"):
            self.shoot(view, f"0-{view}-ships.jpg")

    def raise_wind(self):
        console = Modbus(self.daemon.modbus)
        steps = self.inputs["Modbus"] = []
        for number, wind in enumerate(WIND_STEPS, 1):
            sea = self.daemon.state()["sea"]
            diff = self.compare("station", lambda: console.wind(
                wind, sea["windDirection"]))
            after = self.daemon.state()["sea"]["windSpeed"]
            steps.append({"written m/s": wind,
                          "wind m/s": [round(sea["windSpeed"], 2), after],
                          "picture difference": round(diff, 2)})
            say(f"Modbus: wind {sea['windSpeed']:.1f} -> {after:.1f} m/s; "
                f"picture differs by {diff:.1f} of 255")
            for view in ("bridge", "wing"):
                self.shoot(view, f"{number}-{view}-{wind:02.0f}mps.jpg")
            time.sleep(1.0)

    def lower_sun(self):
        def change():
            heading = ship(self.daemon.state())["heading"]
            self.daemon.ctl("set", "sky.sunElevation=10",
                            f"sky.sunAzimuth={(heading + 60) % 360:.1f}",
                            as_json=False)
        before = self.daemon.state()["sky"].get("sunElevation", "by date")
        diff = self.compare("station", change)
        self.inputs["protobuf"] = {"sky.sunElevation": [before, 10],
                                   "picture difference": round(diff, 2)}
        say(f"protobuf: Sun at 10 deg, 60 deg off the bow; picture differs by "
            f"{diff:.1f} of 255")
        for view in ("bridge", "wing"):
            self.shoot(view, f"5-{view}-low-sun.jpg")

    def instruments(self):
        done = self.daemon.ctl("frame", "bridge", OUT / "bridge.exr",
                               "--width", 640, "--height", 360,
                               "--layers", "radiance,depth,normal")
        say(f"bridge.exr: radiance, depth, normal, {done['bytes'] // 1000} kB")
        answer = self.daemon.ctl("surface", 0, 0, 50, 0, 0, 50)
        heights = [round(p["height"], 3) for p in answer["points"]]
        self.inputs["surface query"] = {"heights m": heights}
        say(f"surface at three points: {heights} m")

    def film(self):
        done = self.daemon.ctl("record", "bridge", OUT / "clip.mkv",
                               "--exact", "--seconds", 5, "--fps", 10,
                               "--overwrite",
                               "--width", 640, "--height", 360)
        say(f"clip.mkv: {done['frames']} frames of the bridge, 5 s, "
            f"{done['bytes'] // 1000} kB")
        return done["frames"]

    def measure(self):
        """Frames of the bridge as fast as they come."""
        say("bench: the bridge as fast as it can be drawn")
        return self.daemon.ctl("bench", "--views", "bridge", "--seconds", 4,
                               "--sizes", "x".join(map(str, SIZE)))[0]

    def arrive(self):
        say("NMEA: on until the voyage ends")
        try:
            text, _ = self.replay.communicate(timeout=SAIL_S + 30)
        except subprocess.TimeoutExpired as late:
            raise Trouble("the voyage does not end") from late
        if self.replay.returncode != 0:
            raise Trouble("pelagosctl replay failed")
        nmea = self.inputs["NMEA"]
        nmea["sentences"] = json.loads(text)["sentences"]
        nmea["own ship"] = changed(ship(self.before),
                                   ship(self.daemon.state()))

    def stop(self):
        if self.replay and self.replay.poll() is None:
            self.replay.terminate()
            self.replay.wait()


def summarise(demo, viewer, clip_frames, bench):
    """Writes summary.json and summary.txt; returns the text."""
    gaps_ms = [1000 * (b - a) for a, b in zip(viewer.times, viewer.times[1:])]
    live = {"frames": len(viewer.times),
            "median ms": round(percentile(gaps_ms, 0.5), 1),
            "p95 ms": round(percentile(gaps_ms, 0.95), 1)}
    drawing = {"size": f"{bench['width']}x{bench['height']}",
               "frames": bench["frames"],
               "median ms": round(bench["answerMsMedian"], 1),
               "p95 ms": round(bench["answerMsP95"], 1)}
    summary = {
        "seconds": round(since_start(), 1),
        "frames": sum([len(viewer.times), len(demo.pictures), clip_frames,
                       bench["frames"]]),
        "ready s": round(demo.daemon.ready_s, 2),
        "live view": live, "one view alone": drawing, "clip frames": clip_frames,
        "resident MB": round(demo.daemon.resident_mb(), 1),
        "pictures": demo.pictures + ["bridge.exr", "clip.mkv"],
        "inputs": demo.inputs, "metrics": demo.daemon.metrics(),
    }
    (OUT / "summary.json").write_text(json.dumps(summary, indent=2) + "\n")
    lines = [
        f"ready after      {summary['ready s']} s",
        f"frames           {summary['frames']} in {summary['seconds']} s",
        f"live view        {live['frames']} frames, from one to the next "
        f"median {live['median ms']} ms, p95 {live['p95 ms']} ms",
        f"one view alone   {drawing['frames']} frames of {drawing['size']}, "
        f"asked for to there median {drawing['median ms']} ms, p95 "
        f"{drawing['p95 ms']} ms",
        f"clip             {clip_frames} frames",
        f"resident memory  {summary['resident MB']} MB",
        "", "what each input changed (picture difference: mean, of 255)"]
    for name, what in demo.inputs.items():
        for entry in what if isinstance(what, list) else [what]:
            lines.append(f"  {name:14} {json.dumps(entry)[1:-1]}")
    text = "\n".join(lines) + "\n"
    (OUT / "summary.txt").write_text(text)
    return text


def check(demo, viewer):
    """What must have happened."""
    steps = demo.inputs["Modbus"]
    facts = {
        "six JPEGs": len(demo.pictures) >= 6,
        "the EXR": (OUT / "bridge.exr").stat().st_size > 100_000,
        "the clip": (OUT / "clip.mkv").stat().st_size > 10_000,
        "the live view": len(viewer.times) > 10,
        "the heading moved": "heading" in demo.inputs["NMEA"]["own ship"],
        "Modbus set the wind": all(
            abs(s["wind m/s"][1] - s["written m/s"]) < 0.01 for s in steps),
        "the ships show":
            demo.inputs["ships and buoys"]["picture difference"] > 0.2,
        "the wind shows": all(s["picture difference"] > 0.2
                              for s in steps[1:]),
    }
    missing = [name for name, holds in facts.items() if not holds]
    if missing:
        raise Trouble("did not happen: " + ", ".join(missing))


def sail(daemon):
    demo = Demo(daemon)
    viewer = Viewer(daemon.http, "bridge")
    try:
        daemon.ctl("set", f"views.bridge.width={SIZE[0]}",
                   f"views.bridge.height={SIZE[1]}", as_json=False)
        demo.add_view()
        viewer.start()
        demo.set_sail()
        demo.meet_ships()
        demo.raise_wind()
        demo.lower_sun()
        demo.instruments()
        demo.arrive()
        viewer.stop()
        clip_frames = demo.film()
        bench = demo.measure()
        print("\n" + summarise(demo, viewer, clip_frames, bench), flush=True)
        check(demo, viewer)
    finally:
        viewer.stop()
        demo.stop()


def main():
    # A terminated demonstration tidies up as an ended one does.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    daemon = Daemon(BIN, OUT / "pelagosd.log")
    try:
        say("pelagosd on the software device")
        daemon.start()
        say(f"it answers after {daemon.ready_s:.2f} s")
        sail(daemon)
    except Trouble as trouble:
        print(f"demo: {trouble}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    finally:
        daemon.stop()
    print(f"pictures and summary: {os.path.relpath(OUT)}/\n"
          "keep it running:      make run\n"
          "and look at it:       http://127.0.0.1:8080/")
    return 0


sys.exit(main())
