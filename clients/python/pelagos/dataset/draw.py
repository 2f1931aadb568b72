"""Draws the frames of a plan: the files of each, equal to the bit whoever
draws them, on the same program and device."""
from __future__ import annotations

import concurrent.futures
import hashlib
import json
import struct
import zlib
from typing import TYPE_CHECKING, Any

from .. import need
from ..coco import Coco
from ..errors import PelagosError, Refused
from ..exr import with_number
from .daemon import OwnDaemon
from .plan import Plan, Scene, canonical

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..frame import Frame

_TRIES = 3
_LONGEST_STEP_S = 3600.0


class Renderer:
    """A daemon and the scene that it is in; starts another where one ends."""

    def __init__(self, plan: Plan, device: str = "", threads: int = 1,
                 files: str | None = None) -> None:
        need.numpy()
        self.plan, self.device, self.threads = plan, device, threads
        self.files = plan.files_digest() if files is None else files
        self.daemon: OwnDaemon | None = None
        self.at: tuple[int, float] | None = None  # scene, simulated time
        self.scene: Scene | None = None
        self.pool = concurrent.futures.ThreadPoolExecutor(3)
        self.start()

    def start(self) -> None:
        self.close()
        self.daemon = OwnDaemon(self.device, self.threads,
                                self.plan.directories)
        self.at = None
        health = self.daemon.health
        #: What pictures depend on beside the plan.
        self.made_by = {"program": f"pelagosd {health.get('version', '')}",
                        "device": str(health.get("device", ""))}

    def close(self) -> None:
        if self.daemon:
            self.daemon.stop()
        self.daemon = None

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
        self.pool.shutdown()

    def files_of(self, frame: int) -> dict[str, bytes]:
        """The sample's files by their endings. A daemon that ends is started
        anew; a Refused says which frame it is."""
        for left in reversed(range(_TRIES)):
            try:
                if self.daemon is None:
                    self.start()
                return self._draw(frame)
            except Refused as error:
                raise Refusal(f"frame {frame} (scene {frame // self.plan.length}"
                              f"): {error}") from None
            except PelagosError:
                self.close()
                if left == 0:
                    raise
        raise AssertionError

    def _go_to(self, frame: int) -> Scene:
        assert self.daemon
        ocean, number = self.daemon.ocean, frame // self.plan.length
        if self.at is None or self.at[0] != number or self.scene is None:
            self.at = None
            self.scene = self.plan.scene(number)
            ocean.reset(self.scene.seed, self.scene.patch)
            self.at = number, 0.0
        goal, now = self.plan.moment(self.scene, frame), self.at[1]
        if goal < now:
            self.at = None
            return self._go_to(frame)
        while now < goal:
            now = min(goal, now + _LONGEST_STEP_S)
            ocean.step(until=now)
            self.at = number, now
        return self.scene

    def _draw(self, frame: int) -> dict[str, bytes]:
        assert self.daemon
        plan, c = self.plan, self.plan.content
        scene = self._go_to(frame)
        ocean = self.daemon.ocean
        asked: dict[str, Any] = {}
        layers = list(c["layers"])
        if layers or c["ids"] or c["labels"]:
            mine = layers if not (c["ids"] or c["labels"]) or "id" in layers \
                else [*layers, "id"]
            asked["exr"] = {"layers": mine}
        if c["labels"]:
            asked["json"] = {}
        if c["picture"] != "none":
            asked[c["picture"]] = ({"quality": c["quality"]}
                                   if c["picture"] == "jpg" else {})
        # At once, so that they are drawn as one.
        waiting = {form: self.pool.submit(ocean.frame, plan.view, form, **more)
                   for form, more in asked.items()}
        got: dict[str, Frame] = {f: w.result() for f, w in waiting.items()}
        return self._sample(frame, scene, got)

    def _sample(self, frame: int, scene: Scene, got: "dict[str, Frame]"
                ) -> dict[str, bytes]:
        c, out = self.plan.content, {}
        key = f"{frame:09}"
        if c["picture"] != "none":
            out[c["picture"]] = got[c["picture"]].data
        about: dict[str, Any] = {
            "id": self.frame_id(frame, scene), "frame": frame,
            "scene": frame // self.plan.length,
            "time": self.plan.moment(scene, frame), "seed": scene.seed,
            "parameters": scene.parameters, "state": scene.patch}
        if "exr" in got:
            picture = got["exr"].exr()
            about["width"], about["height"] = picture.width, picture.height
            about["camera"] = {
                name.removeprefix("pelagos."): value
                for name, value in picture.attributes.items()
                if name.startswith("pelagos.") and name != "pelagos.revision"
                and isinstance(value, (int, float, str))}
            if c["layers"]:
                # The revision counts edits since the daemon's start.
                out["exr"] = with_number(got["exr"].data, "pelagos.revision",
                                         0)
        if c["ids"] or c["labels"]:
            np = need.numpy()
            ids = picture.layers["id"].astype(np.int64)
            if c["ids"]:
                out["ids.png"] = png16(ids)
            if c["labels"]:
                truth = got["json"].truth()
                truth.pop("revision", None)
                coco = Coco()
                shown = c["picture"] if c["picture"] != "none" else "exr"
                coco.add(truth, ids, f"{key}.{shown}")
                about["truth"] = truth
                about["annotations"] = coco.annotations
        out["json"] = json.dumps(about, sort_keys=True, ensure_ascii=False,
                                 separators=(",", ":")).encode() + b"\n"
        return out

    def frame_id(self, frame: int, scene: Scene) -> str:
        """SHA-256 of all that the frame's files depend on."""
        c = self.plan.content
        return hashlib.sha256(canonical({
            **self.made_by, "files": self.files, "seed": scene.seed,
            "state": scene.patch, "time": self.plan.moment(scene, frame),
            "steps": [scene.time, self.plan.step], "view": self.plan.view,
            **{k: c[k] for k in ("picture", "quality", "layers", "labels",
                                 "ids")}})).hexdigest()


class Refusal(PelagosError):
    """The daemon refused a frame of the plan; trying again does not help."""


def png16(values: "NDArray[np.int64]") -> bytes:
    """A grey PNG of 16 bits (ISO/IEC 15948)."""
    height, width = values.shape
    lines = values.astype(">u2").tobytes()
    raw = b"".join(b"\0" + lines[2 * width * y:2 * width * (y + 1)]
                   for y in range(height))

    def chunk(name: bytes, data: bytes) -> bytes:
        return (struct.pack(">I", len(data)) + name + data
                + struct.pack(">I", zlib.crc32(name + data)))

    return (b"\x89PNG\r\n\x1a\n"
            + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0,
                                         0, 0))
            + chunk(b"IDAT", zlib.compress(raw, 6)) + chunk(b"IEND", b""))
