#!/usr/bin/python3
"""A renderer that hangs: its thread is held by ptrace, so that it waits as one
whose driver never answers. systemd and /healthz are told; and it goes on."""
import ctypes
import os
import socket
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import Daemon, until

SEIZE, INTERRUPT, DETACH = 0x4206, 0x4207, 17
WATCHDOG_S = 1.0


class Held:
    """One thread of another process stands still."""

    def __init__(self, thread):
        self.libc = ctypes.CDLL(None, use_errno=True)
        self.libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_int,
                                     ctypes.c_void_p, ctypes.c_void_p]
        self.thread = thread
        try:
            self.trace(SEIZE)
        except PermissionError as error:
            raise unittest.SkipTest("ptrace is not permitted") from error
        self.trace(INTERRUPT)
        os.waitpid(thread, 0x40000000)  # __WALL

    def trace(self, request):
        if self.libc.ptrace(request, self.thread, None, None) != 0:
            raise OSError(ctypes.get_errno(), "ptrace")

    def let_go(self):
        self.trace(DETACH)


def thread_named(pid, name):
    for thread in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{thread}/comm", encoding="utf-8") as f:
            if f.read().strip() == name:
                return int(thread)
    raise LookupError(name)


class Systemd:
    """What the daemon tells it: when, and whether it is the watchdog's."""

    def __init__(self, folder):
        self.path = os.path.join(folder, "notify")
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(self.path)
        self.fed = 0
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        while True:
            self.fed += b"WATCHDOG=1" in self.socket.recv(4096)


class Watchdog(unittest.TestCase):
    def test_a_renderer_that_hangs(self):
        with tempfile.TemporaryDirectory() as folder:
            systemd = Systemd(folder)
            os.environ["NOTIFY_SOCKET"] = systemd.path
            os.environ["WATCHDOG_USEC"] = str(int(WATCHDOG_S * 1e6))
            try:
                daemon = Daemon("--device", "software")
            finally:
                del os.environ["NOTIFY_SOCKET"], os.environ["WATCHDOG_USEC"]
            with daemon:
                self.hang(daemon, systemd)

    def hang(self, daemon, systemd):
        path = "/v1/views/bridge/frame.png?width=64&height=36"
        daemon.patch({"views": {"bridge": {}}})
        self.assertEqual(daemon.get(path).status, 200)
        until("the watchdog is fed", lambda: systemd.fed > 1)
        held = Held(thread_named(daemon.process.pid, "render"))
        answers = []
        asks = threading.Thread(
            target=lambda: answers.append(daemon.get(path, timeout=300)))
        asks.start()
        begun = time.monotonic()
        until("/healthz says so", lambda: daemon.get("/healthz").status == 503,
              pause_s=0.2)
        print(f"noticed after {time.monotonic() - begun:.1f} s (2)")
        until("the log says so", lambda: "FRM-002" in daemon.log())
        fed = systemd.fed
        time.sleep(3 * WATCHDOG_S)  # nothing to wait for: it must not come
        self.assertLessEqual(systemd.fed, fed + 1)
        self.assertFalse(answers)
        held.let_go()
        asks.join()
        self.assertEqual(answers[0].status, 200)
        until("all is well", lambda: daemon.get("/healthz").status == 200)
        until("the watchdog is fed again", lambda: systemd.fed > fed + 1)


if __name__ == "__main__":
    unittest.main(verbosity=2)
