"""Checks each source by itself, as build/compile_commands.json compiles it.

A source that passed is not looked at again until it, something that it
includes, its flags or the tool changes: build/lint/NAME/ remembers.
"""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATABASE = ROOT / "build/compile_commands.json"
INCLUDE = re.compile(rb'^\s*#\s*include\s*"([^"]+)"', re.M)
SKIPPED = 77


def commands():
    """{path below the root: [word of its compiler's command]}, without -c."""
    if not DATABASE.exists():
        print(f"no {DATABASE.relative_to(ROOT)}: run `make tests`")
        sys.exit(SKIPPED)
    return {entry["file"]: shlex.split(entry["command"])[:-2]
            for entry in json.loads(DATABASE.read_text(encoding="utf-8"))}


def sources(*endings):
    rooms = ("server", "proto", "clients", "tests")
    return sorted(str(path.relative_to(ROOT)) for room in rooms
                  for path in (ROOT / room).rglob("*")
                  if path.suffix in endings)


class Files:
    """Digests of files with all that they include of ours."""

    def __init__(self):
        self.known = {}

    def find(self, name, beside, folders):
        for folder in [beside, *folders]:
            path = os.path.normpath(os.path.join(folder, name))
            if os.path.isfile(path):
                return path
        return None  # a library's: its package's version is not asked

    def of(self, path, folders):
        """{path: digest of its own text} of a file and what it includes."""
        found, left = {}, [path]
        while left:
            at = left.pop()
            if at in found:
                continue
            if at not in self.known:
                data = pathlib.Path(at).read_bytes()
                self.known[at] = (hashlib.sha256(data).hexdigest(),
                                  [n.decode() for n in INCLUDE.findall(data)])
            found[at], names = self.known[at]
            for name in names:
                if there := self.find(name, os.path.dirname(at), folders):
                    left.append(there)
        return found


def check(name, tool, config, jobs, whole=True):
    """jobs: {path: (words of the command, text for its input)}, of every source
    where `whole`: what is remembered of others is forgotten. Prints what is
    wrong; the exit status."""
    os.chdir(ROOT)
    if not shutil.which(tool):
        print(f"no {tool}")
        return SKIPPED
    version = subprocess.run([tool, "--version"], capture_output=True,
                             check=True).stdout
    base = hashlib.sha256(version + config).hexdigest()
    memory = ROOT / "build/lint" / name
    memory.mkdir(parents=True, exist_ok=True)
    files, left = Files(), {}
    keys = set()
    for path, (words, text) in jobs.items():
        folders = [word[2:] for word in words if word.startswith("-I")]
        what = json.dumps([base, path, words, text,
                           sorted(files.of(path, folders).items())])
        key = hashlib.sha256(what.encode()).hexdigest()
        keys.add(key)
        if not (memory / key).exists():
            left[path] = key

    def one(path):
        words, text = jobs[path]
        return subprocess.run(words, input=text, text=True, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    bad = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for path, result in zip(left, pool.map(one, left)):
            if result.returncode == 0:
                (memory / left[path]).touch()
            else:
                bad += 1
                print(f"error: {path}")
                print(result.stdout, end="")
    for old in memory.iterdir():
        if whole and old.name not in keys:
            old.unlink(missing_ok=True)
    print(f"{name}: {len(jobs)} files, {len(left)} of them changed, {bad} bad")
    return 1 if bad else 0
