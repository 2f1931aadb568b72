"""What a set will take, by drawing a few of its frames before it starts."""
from __future__ import annotations

import dataclasses
import os
import shutil
import time
from collections.abc import Callable
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


def measure(plan: Plan, device: str, threads: int,
            on_frame: Callable[[int, int], None] = lambda at, count: None,
            ) -> tuple[Estimate, dict[str, str]]:
    """Draws frames from all over the plan with one worker that has `threads`
    of the machine; then also what draws them. Every other one is counted, after
    the rest, for which shaders are compiled. `on_frame` is called before each
    with its number and how many there are. Raises Refusal where the daemon
    refuses one."""
    n = plan.length
    count = min(2 * _FRAMES, plan.frames)
    scenes = sorted({i * (plan.frames // n) // max(1, -(-count // n))
                     for i in range(-(-count // n))})
    frames = [s * n + j for s in scenes for j in range(min(n, count))][:count]
    first, counted = frames[1::2] or frames, frames[::2]
    count = len(first) + len(counted)
    begin = time.monotonic()
    with Renderer(plan, device, threads) as renderer:
        start_s = time.monotonic() - begin
        for i, frame in enumerate(first):
            on_frame(i, count)
            renderer.files_of(frame)
        begin, size = time.monotonic(), 0
        for i, frame in enumerate(counted):
            on_frame(len(first) + i, count)
            size += sum(_BLOCK + -(-len(data) // _BLOCK) * _BLOCK
                        for data in renderer.files_of(frame).values())
        seconds = (time.monotonic() - begin) / len(counted)
        return Estimate(plan.frames, len(counted), seconds,
                        size / len(counted), start_s, threads), renderer.made_by


def room(path: str) -> int:
    """Bytes that are free where the directory is or will be."""
    path = os.path.abspath(path)
    while not os.path.isdir(path):
        path = os.path.dirname(path)
    return shutil.disk_usage(path).free
