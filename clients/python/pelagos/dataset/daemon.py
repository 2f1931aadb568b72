"""A pelagosd of a worker's own: on loopback, behind a token, and gone with the
worker however that ends."""
from __future__ import annotations

import ctypes
import os
import re
import secrets
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable

from ..client import Ocean
from ..errors import PelagosError, Unreachable

_START_S = 120.0
_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of prctl(2)


def leash() -> Callable[[], None]:
    """For Popen's preexec_fn: the child is killed when its parent ends."""
    prctl, parent = ctypes.CDLL(None).prctl, os.getpid()

    def tie() -> None:
        prctl(_DEATH_SIGNAL, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)

    return tie


def find_daemon() -> str:
    """Of $PELAGOS_DAEMON, which pelagosctl sets, else of the PATH."""
    found = os.environ.get("PELAGOS_DAEMON") or shutil.which("pelagosd")
    if not found:
        raise Unreachable("pelagosd is not installed here, or not in the PATH: "
                          "PELAGOS_DAEMON=/path/to/pelagosd names one")
    return found


class OwnDaemon:
    """Starts at once; `ocean` speaks to it.

    device   of pelagosd --device; "": its choice
    threads  that the software device may keep busy
    """

    def __init__(self, device: str, threads: int,
                 directories: dict[str, str]) -> None:
        self.folder = tempfile.mkdtemp(prefix="pelagos-dataset-")
        token = secrets.token_urlsafe(24)
        token_path = os.path.join(self.folder, "token")
        with open(os.open(token_path, os.O_CREAT | os.O_WRONLY, 0o600), "w",
                  encoding="ascii") as file:
            file.write(token + "\n")
        self.log_path = os.path.join(self.folder, "log")
        command = [find_daemon(), "--http", "127.0.0.1:0", "--tcp", "off",
                   "--unix", "off", "--rtsp", "off", "--modbus", "off",
                   "--nmea", "off", "--state", "off", "--quality", "full",
                   "--token-file", token_path]
        for name, path in directories.items():
            command += [f"--{name}", path]
        if device:
            command += ["--device", device]
        with open(self.log_path, "wb") as log:
            self.process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                preexec_fn=leash(),
                env={**os.environ, "LP_NUM_THREADS": str(threads)})
        try:
            self.ocean = Ocean(f"http://127.0.0.1:{self._port()}",
                               token=token, timeout=300.0)
            self._answers()
        except BaseException:
            self.stop()
            raise

    def _port(self) -> int:
        end = time.monotonic() + _START_S
        while time.monotonic() < end:
            if found := re.search(r"NET-002 .*:(\d+)/", self.log()):
                return int(found.group(1))
            self._alive()
            time.sleep(0.02)
        raise Unreachable(f"pelagosd does not listen:\n{self.log()}")

    def _answers(self) -> None:
        end = time.monotonic() + _START_S
        while True:
            try:
                self.health = self.ocean.health()
                return
            except PelagosError:
                self._alive()
                if time.monotonic() > end:
                    raise
                time.sleep(0.02)

    def _alive(self) -> None:
        if self.process.poll() is not None:
            lines = "\n".join(self.log().splitlines()[-8:])
            raise Unreachable(f"pelagosd ended at its start:\n{lines}")

    def log(self) -> str:
        with open(self.log_path, encoding="utf-8", errors="replace") as file:
            return file.read()

    def stop(self) -> None:
        """Nothing is to be kept of it."""
        self.process.kill()
        self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)
