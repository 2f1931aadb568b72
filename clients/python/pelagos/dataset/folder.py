"""The directory of a data set: its shards, and nothing that a killed worker
leaves half.

    set.json          the plan, its digest, program and device
    shards/00000.tar  there exactly when it is whole: written beside, synced,
                      then linked under its name
    claims/00000      locked by who draws the shard; the lock goes with him
    alarms/           shards that came out otherwise the second time
"""
from __future__ import annotations

import contextlib
import errno
import fcntl
import glob
import io
import json
import os
import socket
import tarfile
from collections.abc import Iterator
from typing import Any

from . import jsontext
from .fields import BadPlan, digest_of
from .plan import Plan


class Alarm(RuntimeError):
    """The same shard was drawn twice with different bits."""


class Folder:
    def __init__(self, path: str) -> None:
        self.path = path

    def at(self, *names: str) -> str:
        return os.path.join(self.path, *names)

    def shard(self, number: int) -> str:
        return self.at("shards", f"{number:05}.tar")

    def has(self, number: int) -> bool:
        return os.path.exists(self.shard(number))

    # --- the set ------------------------------------------------------------

    def open(self, plan: Plan, made_by: dict[str, str]) -> dict[str, Any]:
        """Makes it, or finds it made by the same plan, program and device;
        what set.json says."""
        for name in ("shards", "claims"):
            os.makedirs(self.at(name), exist_ok=True)
        content = {"plan": plan.content, "digest": plan.digest(),
                   "files": plan.files_digest(), "folder":
                   os.path.abspath(plan.folder), **made_by}
        mark = self._part("set.json")
        with open(mark, "wb") as file:
            file.write(json.dumps(content, indent=1, ensure_ascii=False,
                                  sort_keys=True).encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())
        try:
            os.link(mark, self.at("set.json"))
        except FileExistsError:
            pass
        finally:
            os.unlink(mark)
        self._sync(self.path)
        there = self.set()
        for key, words in (("digest", "another plan"),
                           ("program", "another program"),
                           ("device", "another device")):
            if there.get(key) != content[key]:
                raise BadPlan(
                    f"{self.path} is of {words} ({there.get(key)}, not "
                    f"{content[key]}): its frames would not go together; say "
                    "another directory with --output")
        return there

    def set(self) -> dict[str, Any]:
        try:
            with open(self.at("set.json"), encoding="utf-8") as file:
                content = jsontext.parse(file.read())
        except FileNotFoundError:
            raise BadPlan(f"{self.path} is no data set: it has no set.json"
                          ) from None
        except ValueError as error:
            raise BadPlan(f"{self.at('set.json')}: no JSON: {error}") from None
        if not isinstance(content, dict):
            raise BadPlan(f"{self.at('set.json')} is no JSON object")
        return content

    def plan(self) -> Plan:
        content = self.set()
        return Plan(content["plan"], content.get("folder", "."))

    def done(self, plan: Plan) -> list[int]:
        return [n for n in range(plan.shards) if self.has(n)]

    def missing(self, plan: Plan) -> list[int]:
        return [n for n in range(plan.shards) if not self.has(n)]

    # --- claims -------------------------------------------------------------

    @contextlib.contextmanager
    def claim(self, number: int) -> Iterator[bool]:
        """Whether the shard is ours to draw. Where the file system knows no
        locks it always is: two who draw the same come to the same bits."""
        path = self.at("claims", f"{number:05}")
        fd = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        try:
            locked = True
            try:
                fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
                    yield False
                    return
                locked = False
            if self.has(number):
                yield False
                return
            if locked:  # what a killed worker left
                for left in glob.glob(self.at("shards", f".{number:05}.*")):
                    with contextlib.suppress(FileNotFoundError):
                        os.unlink(left)
            yield True
        finally:
            os.close(fd)

    def claimed(self, plan: Plan) -> list[int]:
        """Missing shards that somebody draws now."""
        out = []
        for number in self.missing(plan):
            try:
                fd = os.open(self.at("claims", f"{number:05}"),
                             os.O_RDONLY | os.O_CLOEXEC)
            except FileNotFoundError:
                continue
            try:
                fcntl.flock(fd, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except OSError:
                out.append(number)
            finally:
                os.close(fd)
        return out

    # --- shards -------------------------------------------------------------

    def _part(self, name: str) -> str:
        host = "".join(c for c in socket.gethostname() if c.isalnum())
        return self.at(os.path.dirname(name), f".{os.path.basename(name)}."
                       f"{host}.{os.getpid()}")

    def writer(self, number: int) -> "ShardWriter":
        return ShardWriter(self, number, self._part(f"shards/{number:05}"))

    def publish(self, number: int, part: str) -> None:
        """The whole shard under its name, at once and once."""
        try:
            os.link(part, self.shard(number))
        except FileExistsError:
            if digest_of(part) != digest_of(self.shard(number)):
                os.makedirs(self.at("alarms"), exist_ok=True)
                kept = self.at("alarms", os.path.basename(part).lstrip(".")
                               + ".tar")
                os.rename(part, kept)
                raise Alarm(
                    f"{self.shard(number)} was there and has other bits than "
                    f"{kept}: two machines or programs that are not alike drew "
                    "this set") from None
        os.unlink(part)
        self._sync(self.at("shards"))

    @staticmethod
    def _sync(folder: str) -> None:
        fd = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(fd)
        finally:
            os.close(fd)


class ShardWriter:
    """A tar without anything of the day or the machine in it."""

    def __init__(self, folder: Folder, number: int, part: str) -> None:
        self.folder, self.number, self.part = folder, number, part
        self.file = open(part, "wb")  # pylint: disable=consider-using-with
        self.tar = tarfile.open(fileobj=self.file, mode="w",
                                format=tarfile.USTAR_FORMAT)

    def add(self, frame: int, files: dict[str, bytes]) -> None:
        for ending in sorted(files):
            info = tarfile.TarInfo(f"{frame:09}.{ending}")
            info.size, info.mode = len(files[ending]), 0o644
            self.tar.addfile(info, io.BytesIO(files[ending]))

    def commit(self) -> None:
        self.tar.close()
        self.file.flush()
        os.fsync(self.file.fileno())
        self.file.close()
        self.folder.publish(self.number, self.part)

    def abort(self) -> None:
        self.file.close()
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self.part)

