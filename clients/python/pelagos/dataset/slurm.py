"""Data sets by Slurm: an array of tasks, and one that merges after them."""
from __future__ import annotations

import os
import shlex
import shutil
import subprocess

from .folder import Folder
from .plan import Plan

#: Slurm's MaxArraySize unless a cluster says more.
MOST_TASKS = 1000


def script(folder: Folder, plan: Plan, program: str, tasks: int,
           device: str, threads: int, more: list[str]) -> str:
    """Of sbatch. Task i draws shards i, i + tasks, i + 2 tasks, …"""
    path = os.path.abspath(folder.path)
    words = [program, "dataset", "work", path, "--threads", str(threads),
             "--tasks", str(tasks)]
    if device:
        words += ["--device", device]
    lines = ["#!/bin/sh", f"#SBATCH --job-name={plan.name}",
             f"#SBATCH --array=0-{tasks - 1}", "#SBATCH --requeue",
             f"#SBATCH --cpus-per-task={threads}",
             f"#SBATCH --output={path}/slurm-%A_%a.log",
             "#SBATCH --open-mode=append",
             *(f"#SBATCH {option}" for option in more),
             f"PELAGOS_DAEMON={shlex.quote(os.environ['PELAGOS_DAEMON'])}; "
             "export PELAGOS_DAEMON" if os.environ.get("PELAGOS_DAEMON")
             else "", f"exec {shlex.join(words)} --task "
             '"$SLURM_ARRAY_TASK_ID"']
    return "\n".join(line for line in lines if line) + "\n"


def merge_script(folder: Folder, plan: Plan, program: str,
                 more: list[str]) -> str:
    path = os.path.abspath(folder.path)
    return "\n".join([
        "#!/bin/sh", f"#SBATCH --job-name={plan.name}-merge",
        f"#SBATCH --output={path}/slurm-merge.log",
        *(f"#SBATCH {option}" for option in more),
        f"exec {shlex.join([program, 'dataset', 'merge', path])}"]) + "\n"


def submit(text: str, *options: str) -> str:
    """The number of the job; RuntimeError says what sbatch says."""
    sbatch = shutil.which("sbatch")
    if not sbatch:
        raise RuntimeError("sbatch is not here: on a machine of a Slurm "
                           "cluster `--slurm submit` works; `--slurm print` "
                           "prints the script")
    done = subprocess.run([sbatch, "--parsable", *options], input=text,
                          capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"sbatch refused it: {done.stderr.strip()}")
    return done.stdout.strip().partition(";")[0]
