"""Workers: each draws shards that are missing, until none is."""
from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from typing import Any, TextIO

from ..errors import PelagosError
from .daemon import leash
from .draw import Refusal, Renderer
from .fields import BadPlan
from .folder import Alarm, Folder
from .plan import Plan

# Exit statuses of a worker beside 0.
FAILED, REFUSED = 1, 4
_WAIT_S = 0.5
#: Workers that may end one after the other without a frame between them.
_DEATHS = 5


def work(folder: Folder, device: str = "", threads: int = 0,
         shards: Iterable[int] | None = None, start: int = 0,
         progress: TextIO | None = None) -> None:
    """Draws the shards (none: all) that are missing, from the `start`th on;
    one that another draws is waited for, since he may die."""
    plan = folder.plan()
    there = folder.set()
    wanted = sorted(range(plan.shards) if shards is None else shards)
    wanted = wanted[start % len(wanted):] + wanted[:start % len(wanted)] \
        if wanted else []
    if all(folder.has(n) for n in wanted):
        return
    with Renderer(plan, device, threads or os.cpu_count() or 1,
                  there["files"]) as renderer:
        folder.open(plan, renderer.made_by)
        while left := [n for n in wanted if not folder.has(n)]:
            drawn = False
            for number in left:
                with folder.claim(number) as mine:
                    if mine:
                        _draw(folder, plan, renderer, number, progress)
                        drawn = True
            if not drawn:
                time.sleep(_WAIT_S)


def _draw(folder: Folder, plan: Plan, renderer: Renderer, number: int,
          progress: TextIO | None) -> None:
    shard = folder.writer(number)
    try:
        for frame in plan.frames_of(number):
            files = renderer.files_of(frame)
            shard.add(frame, files)
            if progress:
                print(frame, sum(map(len, files.values())), file=progress,
                      flush=True)
        shard.commit()
    except BaseException:
        shard.abort()
        raise


class Crew:
    """Workers of one machine, each a process with a daemon of its own; one
    that dies is replaced."""

    def __init__(self, folder: Folder, count: int, devices: Sequence[str],
                 threads: int) -> None:
        self.folder, self.devices = folder, devices
        self.count, self.threads = count, threads
        self.plan = folder.plan()
        self.frames = self.bytes = self.deaths = 0
        self.stopped = False
        self.workers: dict[int, subprocess.Popen[bytes]] = {}
        self.unread: dict[int, bytes] = {}
        for slot in range(count):
            self._start(slot)

    def _start(self, slot: int) -> None:
        worker = subprocess.Popen(
            [sys.executable, "-m", "pelagos.dataset", "work",
             self.folder.path, "--progress",
             "--start", str(slot * self.plan.shards // self.count),
             "--threads", str(self.threads),
             "--device", self.devices[slot % len(self.devices)]],
            stdout=subprocess.PIPE, stdin=subprocess.DEVNULL,
            preexec_fn=leash(), env=_environment())
        assert worker.stdout
        os.set_blocking(worker.stdout.fileno(), False)
        self.workers[slot], self.unread[slot] = worker, b""

    def poll(self) -> int | None:
        """Reads what is new; None while somebody works, else 0, or the status
        of one who failed."""
        for slot, worker in list(self.workers.items()):
            status = worker.poll()
            self._read(slot, worker)
            if status is None:
                continue
            del self.workers[slot]
            if status == 0 or self.stopped:
                continue
            if status in (FAILED, REFUSED):  # it has said why
                self.stop()
                return status
            self.deaths += 1
            if self.deaths > _DEATHS:
                print(f"pelagosctl: {self.deaths} workers ended one after the "
                      "other without a frame between them", file=sys.stderr)
                self.stop()
                return FAILED
            self._start(slot)
        if self.workers:
            return None
        return 0 if not self.folder.missing(self.plan) else FAILED

    def _read(self, slot: int, worker: "subprocess.Popen[bytes]") -> None:
        assert worker.stdout
        try:
            while more := os.read(worker.stdout.fileno(), 65536):
                self.unread[slot] += more
        except BlockingIOError:
            pass
        *lines, self.unread[slot] = self.unread[slot].split(b"\n")
        for line in lines:
            self.frames += 1
            self.bytes += int(line.split()[1])
            self.deaths = 0

    def stop(self) -> None:
        """What they have begun is left out; whole shards stay."""
        self.stopped = True
        for worker in self.workers.values():
            worker.terminate()
        for worker in self.workers.values():
            worker.wait()


def _environment() -> dict[str, str]:
    """This package for the workers, wherever it was found."""
    package = os.path.dirname(os.path.dirname(os.path.dirname(
        os.path.abspath(__file__))))
    return {**os.environ, "PYTHONPATH": os.pathsep.join(
        [package, *filter(None, [os.environ.get("PYTHONPATH")])])}


def worker_main(folder: str, options: Any) -> int:
    """One worker as a process."""
    def end(*_: object) -> None:
        raise SystemExit(130)

    signal.signal(signal.SIGTERM, end)
    signal.signal(signal.SIGINT, end)
    place = Folder(folder)
    shards = None
    try:
        if options.task is not None:
            plan = place.plan()
            shards = range(options.task, plan.shards, options.tasks)
        work(place, options.device, options.threads, shards, options.start,
             sys.stdout if options.progress else None)
    except Refusal as error:
        print(f"pelagosctl: {error}", file=sys.stderr)
        return REFUSED
    except (PelagosError, BadPlan, Alarm, OSError) as error:
        print(f"pelagosctl: {error}", file=sys.stderr)
        return FAILED
    return 0
