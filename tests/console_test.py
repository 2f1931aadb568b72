#!/usr/bin/python3
"""--console: pelagosd polls pymodbus's server as a bridge console."""
import asyncio
import logging
import os
import socket
import struct
import sys
import tempfile
import threading
import time

from pymodbus.datastore import (ModbusSequentialDataBlock, ModbusServerContext,
                                ModbusSlaveContext, ModbusSparseDataBlock)
from pymodbus.server.async_io import ModbusTcpServer

from modbus_test import check
from pelagos_daemon import SLOW_S, Daemon, free_port, until

TABLE = """
# a console: wheel, lever, a knob, two switches
holding  0 i16 entities.1.heading scale=0.1 deadband=0.15
holding  1 u16 entities.1.speed   scale=0.01 max=15 stale=0
holding  2 f32 sea.windSpeed      order=cdab
input    7 f32 sky.visibility
coil     0 bit entities.1.roll    scale=5
discrete 4 bit sea.spectrum
"""


class Console:
    """pymodbus's server in a thread of its own."""

    def __init__(self, port, holding=8):
        self.port = port
        # zero_mode: addresses as they are on the wire
        self.slave = ModbusSlaveContext(
            di=ModbusSequentialDataBlock(0, [0] * 16),
            co=ModbusSequentialDataBlock(0, [0] * 16),
            hr=ModbusSequentialDataBlock(0, [0] * holding),
            ir=ModbusSparseDataBlock({7: 0, 8: 0}), zero_mode=True)
        self.loop = asyncio.new_event_loop()
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.ready = threading.Event()
        self.thread.start()
        check(self.ready.wait(10), "the console's server")

    def _run(self):
        asyncio.set_event_loop(self.loop)

        async def serve():
            self.server = ModbusTcpServer(
                ModbusServerContext(slaves={3: self.slave}, single=False),
                address=("127.0.0.1", self.port), allow_reuse_address=True)
            self.ready.set()
            try:
                await self.server.serve_forever()
            except asyncio.CancelledError:
                pass

        self.loop.run_until_complete(serve())

    def set(self, kind, address, *values):
        self.slave.setValues({"coil": 1, "discrete": 2, "holding": 3,
                              "input": 4}[kind], address, list(values))

    def stop(self):
        asyncio.run_coroutine_threadsafe(self.server.shutdown(),
                                         self.loop).result(10)
        self.thread.join(10)


def float_words(value, swapped=False):
    words = struct.unpack(">HH", struct.pack(">f", value))
    return words[::-1] if swapped else words


def ship(daemon):
    return next(e for e in daemon.state()["entities"] if int(e["id"]) == 1)


def metric(daemon, name):
    return daemon.metrics()["pelagos_console_" + name]


def set_all(console):
    console.set("holding", 0, 1234, 725, *float_words(13.25, swapped=True))
    console.set("input", 7, *float_words(9000.0))
    console.set("coil", 0, 1)
    console.set("discrete", 4, 1)


def polled(daemon, count):
    """The console has been asked that often again."""
    wanted = metric(daemon, "polls_total") + count
    until(f"{count} polls", lambda: metric(daemon, "polls_total") >= wanted)


def polls(daemon, console):
    set_all(console)
    until("heading", lambda: abs(ship(daemon)["heading"] - 123.4) < 1e-9)
    state, own = daemon.state(), ship(daemon)
    check(own["speed"] == 7.25 and own["roll"] == 5, f"{own}")
    check(state["sea"]["windSpeed"] == 13.25, "wind")
    check(state["sea"]["spectrum"] == "JONSWAP", "spectrum")
    check(state["sky"]["visibility"] == 9000, "visibility")
    check(metric(daemon, "state") == 1, "live")
    # Nothing moves: nothing is edited, and another's edit is left alone.
    revision = state["revision"]
    begin, before = time.monotonic(), metric(daemon, "polls_total")
    polled(daemon, 10)
    polls_done = metric(daemon, "polls_total") - before
    check(polls_done <= 20 * (time.monotonic() - begin) + 2, "20 Hz")
    check(daemon.state()["revision"] == revision, "no news, no edit")
    daemon.patch({"sea": {"windSpeed": 4}})
    console.set("holding", 0, 1235)  # inside the deadband
    polled(daemon, 3)
    check(daemon.state()["sea"]["windSpeed"] == 4, "left alone")
    check(ship(daemon)["heading"] != 123.5, "deadband")
    console.set("holding", 0, 1300)
    until("a turn", lambda: abs(ship(daemon)["heading"] - 130) < 1e-9)
    console.set("holding", 1, 65000)
    until("held at max", lambda: ship(daemon)["speed"] == 15)


def out_of_range(daemon, console):
    console.set("holding", 2, *float_words(31.0, swapped=True))
    console.set("holding", 0, 900)
    until("the rest of the poll",
          lambda: abs(ship(daemon)["heading"] - 90) < 1e-9)
    check(daemon.state()["sea"]["windSpeed"] == 4, "31 m/s was refused")
    console.set("holding", 2, *float_words(float("nan"), swapped=True))
    polled(daemon, 3)
    check(daemon.state()["sea"]["windSpeed"] == 4, "NaN was refused")
    check(metric(daemon, "out_of_range_total") > 0, "counted")
    console.set("holding", 2, *float_words(6.0, swapped=True))
    until("back in range", lambda: daemon.state()["sea"]["windSpeed"] == 6)


def goes_and_comes(daemon, console, port):
    """The console stops: stale, the lever safe; it comes back: all anew."""
    console.stop()
    until("stale", lambda: metric(daemon, "state") == 2)
    check(ship(daemon)["speed"] == 0, "the lever's safe value")
    check(daemon.state()["sea"]["windSpeed"] == 6, "the others are held")
    check("CON-003" in daemon.log(), "the log says so")
    # After 0.25 s, then twice as long each time.
    begin, before = time.monotonic(), metric(daemon, "failures_total")
    until("two more tries",
          lambda: metric(daemon, "failures_total") >= before + 2)
    failures = metric(daemon, "failures_total") - before
    spent = time.monotonic() - begin
    check(failures <= 4 * spent + 2, f"{failures} tries in {spent} s")
    console = Console(port)
    set_all(console)
    until("live again", lambda: metric(daemon, "state") == 1)
    until("all values anew", lambda: ship(daemon)["speed"] == 7.25
          and daemon.state()["sea"]["windSpeed"] == 13.25)
    return console


def bad_consoles(folder):
    """Silence, bytes that are no answer, endless bytes, exceptions."""
    port = free_port()
    listener = socket.create_server(("127.0.0.1", port))
    listener.settimeout(SLOW_S)
    with Daemon("--console", f"127.0.0.1:{port}", "--console-table",
                os.path.join(folder, "table"), "--console-timeout",
                "100") as daemon:
        silent, _ = listener.accept()
        until("a time-out", lambda: metric(daemon, "timeouts_total") >= 1)
        for junk in (b"\xff" * 300, b"HTTP/1.1 200 OK\r\n\r\n",
                     b"\0\1\0\0\0\3\3\x83\2" * 9):
            before = metric(daemon, "malformed_total")
            peer, _ = listener.accept()
            peer.recv(64)
            peer.sendall(junk)
            until("counted",
                  lambda n=before: metric(daemon, "malformed_total") > n)
            peer.close()
        silent.close()
        listener.close()
        check(metric(daemon, "state") == 0, "never polled")
        check(metric(daemon, "edits_total") == 0, "no edit")
        check(daemon.alive(), "alive")
    port = free_port()
    console = Console(port, holding=2)  # no address 2: exception 2
    with Daemon("--console", f"127.0.0.1:{port}", "--console-table",
                os.path.join(folder, "table"), "--console-unit", "3",
                "--console-timeout", "10000") as daemon:
        until("exceptions", lambda: metric(daemon, "exceptions_total") > 3)
        check("exception 2" in daemon.log(), "named")
        check(metric(daemon, "polls_total") == 0, "no whole poll")
        check(metric(daemon, "connections_total") == 1, "stays connected")
    console.stop()


def refused(folder):
    bad = os.path.join(folder, "bad")
    with open(bad, "w") as f:
        f.write("holding 1 i16 sea.windSpeed\nholding x i16 sea.fetch\n")
    for options, says in (
            (("--console", "127.0.0.1:502"), "go together"),
            (("--console-table", bad), "go together"),
            (("--console", "127.0.0.1:502", "--console-table", bad), "line 2"),
            (("--console", "127.0.0.1:502", "--console-table",
              bad + ".none"), "bad.none")):
        try:
            daemon = Daemon(*options)  # listens before it reads the table
        except RuntimeError as error:
            check(says in str(error), f"{options}: {error}")
            continue
        with daemon:
            check(daemon.process.wait(SLOW_S) == 1, f"{options} were taken")
            check(says in daemon.log(), daemon.log())


def main():
    logging.disable(logging.CRITICAL)  # pymodbus tells of every reset
    with tempfile.TemporaryDirectory(prefix="pelagos-console-") as folder:
        table = os.path.join(folder, "table")
        with open(table, "w") as f:
            f.write(TABLE)
        port = free_port()
        console = Console(port)
        with Daemon("--console", f"127.0.0.1:{port}", "--console-table", table,
                    "--console-unit", "3", "--console-rate", "20",
                    "--console-stale", "2000") as daemon:
            for part in (polls, out_of_range):
                print(f"== {part.__name__}", flush=True)
                part(daemon, console)
            print("== goes_and_comes", flush=True)
            goes_and_comes(daemon, console, port).stop()
        for part in (bad_consoles, refused):
            print(f"== {part.__name__}", flush=True)
            part(folder)


if __name__ == "__main__":
    sys.exit(main())
