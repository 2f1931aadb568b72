"""What a set will take, by drawing a few of its frames before it starts."""
from __future__ import annotations

import dataclasses
import os
import shutil
import time
from typing import Any

from .draw import Renderer
from .plan import Plan

_FRAMES = 6
#: A tar has whole blocks of 512 bytes, and a block before each file.
_BLOCK = 512


@dataclasses.dataclass(frozen=True)
class Estimate:
    """seconds and bytes are a frame's; start_s: of a worker."""
    frames: int
    drawn: int
    seconds: float
    bytes: float
    start_s: float
    threads: int

    def hours(self, workers: int) -> float:
        return self.frames * self.seconds / workers / 3600.0

    def total(self) -> float:
        return self.frames * self.bytes

    def to_json(self, workers: int) -> dict[str, Any]:
        return {"frames": self.frames, "measured": self.drawn,
                "secondsPerFrame": round(self.seconds, 4),
                "bytesPerFrame": round(self.bytes),
                "bytes": round(self.total()), "workers": workers,
                "threads": self.threads,
                "hours": round(self.hours(workers), 4),
                "workerHours": round(self.hours(1), 4)}


def measure(plan: Plan, device: str, threads: int) -> tuple[Estimate,
                                                            dict[str, str]]:
    """Draws frames from all over the plan with one worker that has `threads`
    of the machine; then also what draws them. The first, for which shaders are
    compiled, is not counted. Raises Refusal where the daemon refuses one."""
    n = plan.length
    count = min(_FRAMES, plan.frames)
    scenes = sorted({i * (plan.frames // n) // max(1, -(-count // n))
                     for i in range(-(-count // n))})
    frames = [s * n + j for s in scenes for j in range(min(n, count))][:count]
    begin = time.monotonic()
    with Renderer(plan, device, threads) as renderer:
        renderer.files_of(frames[-1])
        start_s = time.monotonic() - begin
        begin, size = time.monotonic(), 0
        for frame in frames:
            size += sum(_BLOCK + -(-len(data) // _BLOCK) * _BLOCK
                        for data in renderer.files_of(frame).values())
        seconds = (time.monotonic() - begin) / len(frames)
        return Estimate(plan.frames, len(frames), seconds, size / len(frames),
                        start_s, threads), renderer.made_by


def room(path: str) -> int:
    """Bytes that are free where the directory is or will be."""
    path = os.path.abspath(path)
    while not os.path.isdir(path):
        path = os.path.dirname(path)
    return shutil.disk_usage(path).free
