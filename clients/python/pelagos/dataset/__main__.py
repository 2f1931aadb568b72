"""The program behind `pelagosctl dataset`: pelagos-dataset plan|run|status|
merge|work."""
from __future__ import annotations

import argparse
import json
import os
import re
import signal
import sys
import time
from typing import Any

from ..errors import MissingPackage, PelagosError
from . import slurm
from .draw import Refusal, Renderer
from .estimate import Estimate, measure, room
from .fields import BadPlan
from .folder import Alarm, Folder
from .merge import Incomplete, merge
from .plan import Plan, read_plan
from .work import Crew, worker_main

# As pelagosctl's: failed here, the command line, refused by pelagosd.
FAILED, USAGE, REFUSED, INTERRUPTED = 1, 2, 4, 130
_POLL_S = 0.2
_LINE_S = 30.0


def say(text: str) -> None:
    print(f"pelagosctl: {text}", file=sys.stderr)


def _options(words: "list[str] | None") -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="pelagos-dataset")
    parser.add_argument("verb", choices=["plan", "run", "status", "merge",
                                         "work"])
    parser.add_argument("path")
    parser.add_argument("--output", default="")
    parser.add_argument("--workers", type=int, default=0)
    parser.add_argument("--device", default="")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--slurm", choices=["print", "submit"])
    parser.add_argument("--sbatch", default="")
    parser.add_argument("--task", type=int)
    parser.add_argument("--tasks", type=int, default=0)
    parser.add_argument("--start", type=int, default=0)
    for flag in ("partial", "progress", "json", "quiet", "no-estimate"):
        parser.add_argument(f"--{flag}", action="store_true")
    return parser.parse_args(words)


def _shared(options: argparse.Namespace) -> tuple[int, int]:
    """Workers, and the threads of each."""
    cores = len(os.sched_getaffinity(0))
    workers = options.workers or (min(4, cores) if not options.slurm else 1)
    return workers, options.threads or max(1, cores // workers)


def _print_estimate(plan: Plan, e: Estimate, made_by: dict[str, str],
                    options: argparse.Namespace, workers: int) -> None:
    if options.json:
        print(json.dumps({**e.to_json(workers), **made_by, "shards":
                          plan.shards, "digest": plan.digest()}))
        return
    if options.quiet:
        return
    print(f"{plan.name}: {plan.frames} frames in {plan.shards} shards, "
          f"{made_by['program']}, {made_by['device']}")
    print(f"measured on {e.drawn} of its frames: {1e3 * e.seconds:.0f} ms and "
          f"{e.bytes / 1e3:.0f} kB a frame with {e.threads} "
          f"{'thread' if e.threads == 1 else 'threads'}, "
          f"{e.start_s:.1f} s to start")
    print(f"all of it: {_bytes(e.total())}, {_hours(e.hours(1))} of one "
          "worker" + (f", {_hours(e.hours(workers))} with {workers}"
                      if workers > 1 else ""))
    print(f"plan {plan.digest()}")


def _bytes(count: float) -> str:
    return (f"{count / 1e12:.2f} TB" if count >= 1e12 else
            f"{count / 1e9:.2f} GB" if count >= 1e9 else
            f"{count / 1e6:.1f} MB")


def _hours(hours: float) -> str:
    return (f"{hours:.1f} h" if hours >= 1 else f"{60 * hours:.1f} min"
            if hours >= 1 / 60 else f"{3600 * hours:.0f} s")


def _measure(plan: Plan, threads: int, options: argparse.Namespace
             ) -> tuple[Estimate, dict[str, str]]:
    """Says on a terminal which frame is drawn: the first take a while."""
    shown = sys.stderr.isatty() and not options.quiet

    def on_frame(at: int, count: int) -> None:
        if shown:
            print(f"\rmeasuring: frame {at + 1} of {count} ", end="",
                  file=sys.stderr, flush=True)
    try:
        return measure(plan, options.device.split(",")[0], threads, on_frame)
    finally:
        if shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def _plan(options: argparse.Namespace) -> int:
    plan = read_plan(options.path)
    workers, threads = _shared(options)
    estimate, made_by = _measure(plan, threads, options)
    _print_estimate(plan, estimate, made_by, options, workers)
    return 0


def _run(options: argparse.Namespace) -> int:
    plan = read_plan(options.path)
    folder = Folder(options.output or plan.name)
    workers, threads = _shared(options)
    if options.slurm:
        threads = options.threads or 1
    fresh = not os.path.exists(folder.at("set.json"))
    if not fresh and folder.set()["digest"] != plan.digest():
        raise BadPlan(f"{folder.path} is of another plan: say another "
                      "directory with --output, or remove it")
    if fresh and options.slurm != "print":
        _begin(plan, folder, workers, threads, options)
    if options.slurm:
        return _by_slurm(options, plan, folder, threads)
    workers = min(workers, max(1, len(folder.missing(plan))))
    status = _watch(folder, plan, workers, threads, options)
    if status == 0:
        return _merge_and_say(folder, options)
    return status


def _begin(plan: Plan, folder: Folder, workers: int, threads: int,
           options: argparse.Namespace) -> None:
    """Measures what the set will take, and makes its directory."""
    if options.no_estimate:
        with Renderer(plan, options.device.split(",")[0], threads) as one:
            folder.open(plan, one.made_by)
        return
    estimate, made_by = _measure(plan, threads, options)
    if not options.json:
        _print_estimate(plan, estimate, made_by, options, workers)
    free = room(folder.path)
    if estimate.total() > free:
        raise OSError(
            f"{_bytes(estimate.total())} are wanted and {_bytes(free)} are "
            f"free at {os.path.abspath(folder.path)}: make room, say another "
            "--output, or draw fewer frames or layers")
    folder.open(plan, made_by)


def _watch(folder: Folder, plan: Plan, workers: int, threads: int,
           options: argparse.Namespace) -> int:
    left = sum(len(plan.frames_of(n)) for n in folder.missing(plan))
    if left == 0:
        return 0
    if left < plan.frames and not options.quiet and not options.json:
        print(f"{plan.frames - left} frames are there, {left} are to be drawn")

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, interrupt)
    crew = Crew(folder, workers, options.device.split(","), threads)
    terminal = sys.stderr.isatty() and not options.quiet
    begin = last = time.monotonic()
    try:
        while (status := crew.poll()) is None:
            now = time.monotonic()
            if not options.quiet and (terminal or now - last > _LINE_S):
                last = now
                _progress(crew.frames, left, now - begin, terminal)
            time.sleep(_POLL_S)
    except KeyboardInterrupt:
        crew.stop()
        say(f"interrupted; {len(folder.done(plan))} of {plan.shards} shards "
            "are there, each whole: the same command goes on")
        return INTERRUPTED
    if terminal:
        print("\r\033[K", end="", file=sys.stderr)
    if status == 0 and not options.quiet and not options.json:
        taken = time.monotonic() - begin
        print(f"{crew.frames} frames, {_bytes(crew.bytes)}, in "
              f"{_hours(taken / 3600)}: {crew.frames / taken:.2f} a second")
    return status


def _progress(drawn: int, wanted: int, spent: float, terminal: bool) -> None:
    rate = drawn / spent if spent > 0 else 0.0
    rest = (wanted - drawn) / rate / 3600 if rate > 0 else 0.0
    print(f"{chr(13) if terminal else ''}{drawn} of {wanted} frames, "
          f"{rate:.1f} a second, {_hours(rest)} to go  ",
          end="" if terminal else "\n", file=sys.stderr, flush=True)


def _by_slurm(options: argparse.Namespace, plan: Plan, folder: Folder,
              threads: int) -> int:
    program = os.environ.get("PELAGOS_CTL", "pelagosctl")
    missing = max(1, len(folder.missing(plan)))
    tasks = min(options.tasks or slurm.MOST_TASKS, plan.shards,
                slurm.MOST_TASKS)
    more = [o for o in options.sbatch.split(";") if o]
    text = slurm.script(folder, plan, program, tasks, options.device, threads,
                        more)
    if options.slurm == "print":
        print(text, end="")
        return 0
    job = slurm.submit(text)
    after = slurm.submit(slurm.merge_script(folder, plan, program, more),
                         f"--dependency=afterok:{job}")
    if options.json:
        print(json.dumps({"job": job, "merge": after, "tasks": tasks}))
    else:
        print(f"job {job}: {tasks} tasks for {missing} shards; job {after} "
              f"merges after them. `pelagosctl dataset status {folder.path}` "
              "says how far it is")
    return 0


def _merge_and_say(folder: Folder, options: argparse.Namespace) -> int:
    said = merge(folder, options.partial)
    if options.json:
        print(json.dumps(said))
    elif not options.quiet:
        print(f"{folder.path}: {said['frames']} frames, {said['boxes']} boxes "
              f"in {said['shards']} shards, {_bytes(said['bytes'])}; README.md "
              "says what is in it")
    return 0


def _status(options: argparse.Namespace) -> int:
    folder = Folder(options.path)
    plan = folder.plan()
    done, claimed = folder.done(plan), folder.claimed(plan)
    sizes = [os.stat(folder.shard(n)) for n in done]
    frames = sum(len(plan.frames_of(n)) for n in done)
    said: dict[str, Any] = {
        "shards": plan.shards, "done": len(done), "drawnNow": len(claimed),
        "frames": plan.frames, "framesDone": frames,
        "bytes": sum(s.st_size for s in sizes), "merged": os.path.exists(
            folder.at("index.parquet")),
        "alarms": len(os.listdir(folder.at("alarms")))
        if os.path.isdir(folder.at("alarms")) else 0}
    # Workers end their shards together: not from one to the next.
    now = time.time()
    since = max(now - 600, os.stat(folder.at("set.json")).st_mtime)
    rate = sum(s.st_mtime > since for s in sizes) / max(now - since, 1.0)
    if rate > 0 and len(done) < plan.shards:
        said["hoursToGo"] = round((plan.shards - len(done)) / rate / 3600, 3)
    if options.json:
        print(json.dumps(said))
        return 0
    print(f"{plan.name}: {len(done)} of {plan.shards} shards, {frames} of "
          f"{plan.frames} frames, {_bytes(said['bytes'])}; {len(claimed)} "
          "drawn now")
    if "hoursToGo" in said:
        print(f"{_hours(said['hoursToGo'])} to go, by the last ten minutes")
    if said["alarms"]:
        print(f"ALARM: {said['alarms']} shards came out with other bits the "
              f"second time, see {folder.at('alarms')}")
    return 0


def main(words: "list[str] | None" = None) -> int:
    options = _options(words)
    try:
        if options.workers < 0 or options.threads < 0 or options.tasks < 0:
            raise BadPlan("workers, threads and tasks are not below 0")
        if options.device and not re.fullmatch(r"[\w.:,/-]+", options.device):
            raise BadPlan(f"--device {options.device}: names, with commas "
                          "between them")
        if options.verb == "work":
            if options.task is not None and not (
                    0 <= options.task < options.tasks):
                raise BadPlan(f"--task {options.task}: 0 to --tasks - 1 is "
                              "wanted")
            return worker_main(options.path, options)
        if options.verb == "merge":
            return _merge_and_say(Folder(options.path), options)
        return {"plan": _plan, "run": _run, "status": _status}[options.verb](
            options)
    except Refusal as error:
        say(str(error))
        return REFUSED
    except BadPlan as error:
        say(str(error))
        return USAGE
    except (MissingPackage, PelagosError, Alarm, Incomplete, RuntimeError,
            OSError) as error:
        say(str(error))
        return FAILED
    except KeyboardInterrupt:
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
