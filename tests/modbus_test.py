#!/usr/bin/python3
"""Modbus/TCP of a running pelagosd with real clients: pymodbus and mbpoll."""
import io
import itertools
import json
import os
import random
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time

from pymodbus.client import ModbusTcpClient
from pymodbus.constants import Endian
from pymodbus.mei_message import ReadDeviceInformationRequest
from pymodbus.payload import BinaryPayloadBuilder, BinaryPayloadDecoder
from pymodbus.transaction import ModbusRtuFramer

from PIL import Image

from pelagos_daemon import ROOT, SANITIZED, SLOW_S, Daemon, free_port, until

WIND, HEADING, COMMIT, HEARTBEAT, SPEED, VIEW_YAW = 10, 64, 5, 4, 70, 100
VIEW = {"views": [{"name": "bridge", "width": 160, "height": 90}]}


def check(condition, text):
    if not condition:
        raise AssertionError(text)


def floats(*values):
    builder = BinaryPayloadBuilder(byteorder=Endian.Big, wordorder=Endian.Big)
    for value in values:
        builder.add_32bit_float(value)
    return builder.to_registers()


def decoder(answer):
    check(not answer.isError(), f"{answer}")
    return BinaryPayloadDecoder.fromRegisters(
        answer.registers, byteorder=Endian.Big, wordorder=Endian.Big)


def mbpoll(port, *words):
    done = subprocess.run(
        ["mbpoll", "-m", "tcp", "-p", str(port), "-a", "1", "-0", "-q",
         *map(str, words)], capture_output=True, text=True, timeout=SLOW_S,
        check=False)
    return done.returncode, done.stdout + done.stderr


def own_ship(daemon):
    return next(e for e in daemon.state()["entities"] if int(e["id"]) == 1)


def pixels(daemon):
    """Of one moment, so that only edits change them."""
    answer = daemon.get("/v1/views/bridge/frame.png?time=100")
    check(answer.status == 200, f"{answer}")
    return answer.body


def by_pymodbus(daemon, client):
    check(decoder(client.read_holding_registers(0, 2, slave=1))
          .decode_32bit_uint() == 0x01020304, "the probe")
    probe = decoder(client.read_input_registers(2, 2, slave=1))
    check(probe.decode_32bit_float() == 3.5, "the probe's float")
    picture = pixels(daemon)
    revision = int(daemon.state()["revision"])
    check(not client.write_registers(WIND, floats(14.5, 240), slave=1)
          .isError(), "write wind")
    check(not client.write_registers(HEADING, floats(77.5), slave=1)
          .isError(), "write heading")
    check(int(daemon.state()["revision"]) == revision, "staged only")
    check(pixels(daemon) == picture, "a staged value shows")
    staged = decoder(client.read_holding_registers(WIND, 4, slave=1))
    check((staged.decode_32bit_float(), staged.decode_32bit_float())
          == (14.5, 240), "staged values read back")
    check(not client.write_register(COMMIT, 1, slave=1).isError(), "commit")
    state = daemon.state()
    check(int(state["revision"]) == revision + 1, "one edit for all")
    check(state["sea"]["windSpeed"] == 14.5, "wind")
    check(state["sea"]["windDirection"] == 240, "direction")
    check(own_ship(daemon)["heading"] == 77.5, "heading")
    check(pixels(daemon) != picture, "the next frame shows it")
    time_s = decoder(client.read_input_registers(8, 4, slave=1))
    check(abs(time_s.decode_64bit_float() - daemon.state()["clock"]["time"])
          < 1, "the clock")
    frames = decoder(client.read_input_registers(6, 2, slave=1))
    check(frames.decode_32bit_uint() > 0, "frames are counted")


def refusals(daemon, client):
    picture, state = pixels(daemon), daemon.state()
    for registers, code in ((floats(30.5, 240), 3), (floats(-1), 3),
                            (floats(float("nan")), 3),
                            (floats(14.5, 361) + [1], 3)):
        answer = client.write_registers(WIND, registers, slave=1)
        check(answer.isError() and answer.exception_code == code,
              f"{registers}: {answer}")
    for address in (6, 11, 179, 500):
        answer = client.write_register(address, 1, slave=1)
        check(answer.isError() and answer.exception_code == 2,
              f"{address}: {answer}")
    answer = client.read_holding_registers(230, 20, slave=1)
    check(answer.exception_code == 2, f"{answer}")
    answer = client.read_holding_registers(0, 2, slave=9)
    check(answer.exception_code == 11, f"unit 9: {answer}")
    client.write_register(COMMIT, 1, slave=1)
    after = daemon.state()
    check(after["revision"] == state["revision"], "revision")
    check(after["sea"] == state["sea"], "the sea changed")
    check(pixels(daemon) == picture, "the picture changed")


def by_mbpoll(daemon, port):
    if not shutil.which("mbpoll"):
        print("mbpoll is not installed: left out")
        return
    status, text = mbpoll(port, "-r", WIND, "-t", "4:float", "-B",
                          "127.0.0.1", 9.25, 200)
    check(status == 0, text)
    status, text = mbpoll(port, "-r", HEADING, "-t", "4:float", "-B",
                          "127.0.0.1", 12)
    check(status == 0, text)
    check(daemon.state()["sea"]["windSpeed"] != 9.25, "staged only")
    status, text = mbpoll(port, "-r", COMMIT, "-t", "4", "127.0.0.1", 1)
    check(status == 0, text)
    check(daemon.state()["sea"]["windSpeed"] == 9.25, "wind by mbpoll")
    check(own_ship(daemon)["heading"] == 12, "heading by mbpoll")
    status, text = mbpoll(port, "-r", WIND, "-t", "4:float", "-B",
                          "127.0.0.1", 99)
    check(status != 0 and "Illegal data value" in text, text)
    status, text = mbpoll(port, "-r", WIND, "-c", 2, "-1", "-t", "4:float",
                          "-B", "127.0.0.1")
    check(status == 0 and "9.25" in text and "200" in text, text)


def by_modbus_serial(daemon, port, unit=1):
    """npm's client, from another language and another hand."""
    if not shutil.which("node") or not os.path.isdir(
            os.path.join(ROOT, "build", "npm", "node_modules",
                         "modbus-serial")):
        print("modbus-serial is not installed: left out")
        return
    done = subprocess.run(
        ["node", os.path.join(ROOT, "tests", "modbus_serial.js"), str(port),
         str(unit)], capture_output=True, text=True, timeout=SLOW_S,
        check=False)
    check(done.returncode == 0, done.stderr)
    saw = json.loads(done.stdout)
    check(saw == {"probe": [0x01020304, 3.5], "wind": 7.25, "many": 50,
                  "alarms": [False] * 5, "coils": [True, True],
                  "refused": [3, 2, 2]}, saw)
    state = daemon.state()
    check((state["sea"]["windSpeed"], state["sea"]["windDirection"]) ==
          (7.25, 100), "wind by modbus-serial")
    check(own_ship(daemon)["heading"] == 33.5, "heading by modbus-serial")


def several_units():
    """Three sources, each with its order, ship, view, stage and heartbeat."""
    port = free_port()
    safe = "views.wing.yaw=0,views.wing.pitch=-5"
    folder = tempfile.TemporaryDirectory()
    state = os.path.join(folder.name, "state.json")
    with Daemon("--state", state) as daemon:  # a safe view must be there
        done = daemon.patch({
            "entities": {"7": {}, "8": {}}, "sources": {"mark": True},
            "views": {"bridge": {"width": 160, "height": 90},
                      "wing": {"entity": 7}}})
        check(done.status == 200, f"{done}")
    with Daemon("--modbus", f"127.0.0.1:{port}", "--modbus-units",
                "1,2:cdab:7:1,3:dcba:8", "--modbus-heartbeat", "1500",
                "--modbus-extrapolate", "300", "--modbus-safe", safe,
                "--state", state) as daemon:
        client = ModbusTcpClient("127.0.0.1", port, timeout=SLOW_S)
        check(client.connect(), "connect")

        def words(value, order):
            raw = struct.pack(">f", value)
            raw = {"abcd": raw, "cdab": raw[2:] + raw[:2],
                   "dcba": raw[::-1]}[order]
            return list(struct.unpack(">HH", raw))

        def entity(id):
            return next(e for e in daemon.state()["entities"]
                        if int(e["id"]) == id)

        for unit, order in ((1, "abcd"), (2, "cdab"), (3, "dcba")):
            probe = client.read_input_registers(2, 2, slave=unit)
            check(probe.registers == words(3.5, order), f"probe of {unit}")
            client.write_registers(HEADING, words(unit * 11.5, order),
                                   slave=unit)
        client.write_registers(VIEW_YAW, words(40, "cdab"), slave=2)
        client.write_registers(SPEED, words(4, "cdab"), slave=2)
        client.write_register(COMMIT, 1, slave=2)  # of unit 2 alone
        check([entity(i)["heading"] for i in (1, 7, 8)] == [0, 23, 0],
              "stages of units are not one")
        view = daemon.state()["views"][1]
        check((view["name"], view["yaw"]) == ("wing", 40), f"{view}")
        for unit in (1, 3):
            client.write_register(COMMIT, 1, slave=unit)
        check([entity(i)["heading"] for i in (1, 7, 8)] == [11.5, 23, 34.5],
              "each its own")
        answer = client.read_holding_registers(0, 2, slave=4)
        check(answer.exception_code == 11, "unit 4")

        # Unit 2 falls silent; unit 3 does not.
        for unit in (2, 3):
            client.write_register(HEARTBEAT, 1, slave=unit)
        beats = itertools.count()

        def sources():
            client.write_register(HEARTBEAT, next(beats) & 0xFFFF, slave=3)
            metrics = daemon.metrics()
            return [metrics[f'pelagos_modbus_source{{unit="{u}"}}']
                    for u in (1, 2, 3)]
        until("unit 2 alone is silent", lambda: sources() == [0, 3, 1])
        check(entity(7)["speed"] == 0, "its ship is stopped")
        view = daemon.state()["views"][1]
        check((view["yaw"], view["pitch"]) == (0, -5), f"no safe view: {view}")
        answer = daemon.get("/v1/views/bridge/frame.png")
        check(answer.headers["X-Pelagos-Stale"] == "modbus", answer.headers)
        alarms = client.read_discrete_inputs(0, 7, slave=2).bits[:7]
        check(alarms == [True, True] + [False] * 5, f"{alarms}")
        daemon.patch({"sources": {"cigiStale": True}})
        client.write_register(HEARTBEAT, 77, slave=3)
        alarms = client.read_discrete_inputs(0, 7, slave=3).bits[:7]
        check(alarms == [True] + [False] * 4 + [True, False], f"{alarms}")
        corner = Image.open(io.BytesIO(answer.body)).convert("RGB")
        check(corner.getpixel((0, 0)) == (255, 176, 0), "no mark")
        client.write_register(HEARTBEAT, 9, slave=2)
        check(not daemon.state()["sources"]["modbusStale"], "stale")
        client.close()


def bad_options():
    for options, says in (
            (("--modbus-units", "1,1"), "twice"),
            (("--modbus-units", "1:bacd"), "1:bacd"),
            (("--modbus-units", "248"), "248"),
            (("--modbus-units", ""), "modbus-units"),
            (("--modbus-safe", "views.bridge.jaw=0"), "views.bridge.jaw"),
            (("--modbus-safe", "views.brige.yaw=5"), "view called brige"),
            (("--modbus-safe", "views.bridge.yaw"), "PATH=VALUE")):
        port = free_port()
        try:
            with Daemon("--modbus", f"127.0.0.1:{port}", *options):
                raise AssertionError(f"{options} were taken")
        except RuntimeError as error:
            check(says in str(error), f"{options}: {error}")


def heartbeat(daemon, client):
    client.write_registers(SPEED, floats(6), slave=1)
    client.write_register(COMMIT, 1, slave=1)
    client.write_register(HEARTBEAT, 1, slave=1)
    seen = []
    beats = itertools.count(2)

    def look():
        """(source, speed), both of the same moment of the daemon's."""
        state = daemon.state()
        stale = state["sources"]["modbusStale"]
        moment = (bool(stale), next(e["speed"] for e in state["entities"]
                                    if int(e["id"]) == 1))
        if not seen or seen[-1] != moment:
            seen.append(moment)
        return moment

    def falls_silent():
        """Live, then stale but reckoned on, then stopped. A test that is held
        up itself misses moments: once more."""
        seen.clear()
        client.write_registers(SPEED, floats(6), slave=1)
        client.write_register(COMMIT, 1, slave=1)
        client.write_register(HEARTBEAT, next(beats), slave=1)
        until("held", lambda: look() == (True, 0))
        return seen == [(False, 6), (True, 6), (True, 0)]
    until("live, reckoned on, stopped", falls_silent)
    check(client.read_discrete_inputs(0, 5, slave=1).bits[:2] == [True, True],
          "alarm")
    check(daemon.metrics()['pelagos_modbus_source{unit="any"}'] == 3,
          "held in metrics")
    source = client.read_input_registers(16, 1, slave=1).registers[0]
    check(source == 3, f"held: {source}")

    def live_again():
        client.write_register(HEARTBEAT, next(beats), slave=1)
        return client.read_input_registers(16, 1, slave=1).registers[0] == 1
    until("live again", live_again)
    # At rest before what follows, which counts edits.
    until("held again", lambda: client.read_input_registers(
        16, 1, slave=1).registers[0] == 3)


def send_bad(port, adu):
    with socket.create_connection(("127.0.0.1", port), SLOW_S) as s:
        s.sendall(adu)
        try:
            return s.recv(300)
        except OSError:
            return b""


def malformed(daemon, port):
    """1,000 bad ADUs: refused or the connection closed, nothing changed."""
    draw = random.Random(1)
    revision = daemon.state()["revision"]
    before = daemon.metrics()
    for i in range(1000):
        body = bytes(draw.randrange(256) for _ in range(draw.randrange(2, 40)))
        head = struct.pack(">HHHB", i, 0, len(body) + 1, 1)
        kind = i % 5
        if kind == 0:
            head = struct.pack(">HHHB", i, draw.randrange(1, 65536),
                               len(body) + 1, 1)
        elif kind == 1:
            head = struct.pack(">HHHB", i, 0, draw.choice(
                (0, 1, draw.randrange(255, 65536))), 1)
        elif kind == 2:
            body = bytes([draw.randrange(24, 256)]) + body
            head = struct.pack(">HHHB", i, 0, len(body) + 1, 1)
        elif kind == 3:
            body = bytes([16]) + struct.pack(
                ">HH", 10, draw.randrange(1, 100)) + body
            head = struct.pack(">HHHB", i, 0, len(body) + 1, 1)
        else:
            body = bytes([3]) + struct.pack(
                ">HH", draw.randrange(240, 65536), 1)
            head = struct.pack(">HHHB", i, 0, len(body) + 1, 1)
        answer = send_bad(port, head + body)
        check(answer == b"" or answer[7] & 0x80, f"{i}: taken: {answer}")
    now = daemon.metrics()
    rose = sum(now[k] - before[k] for k in now
               if k.startswith(("pelagos_modbus_exceptions_total",
                                "pelagos_modbus_malformed_total")))
    check(daemon.alive(), "the daemon died")
    check(rose == 1000, f"{rose} of 1000 counted")
    check(daemon.state()["revision"] == revision, "the state changed")


def flood(daemon, port):
    """Sixteen clients ask without end and read what comes; one more is served
    in its turn: about as many answers of theirs later as they have under
    way."""
    ask = struct.pack(">HHHBBHH", 7, 0, 6, 1, 3, 0, 125) * 20
    stop, answered = threading.Event(), [0]

    def pour():
        with socket.create_connection(("127.0.0.1", port), SLOW_S) as s:
            while not stop.is_set():
                s.sendall(ask)
                got = 0
                while got < 20 * 259:
                    got += len(s.recv(65536))
                answered[0] += 20
    threads = [threading.Thread(target=pour, daemon=True) for _ in range(16)]
    before, waits, turns = daemon.rss(), [], []
    for t in threads:
        t.start()
    end = time.monotonic() + 2
    while time.monotonic() < end or len(waits) < 20:
        begin, theirs = time.monotonic(), answered[0]
        check(len(send_bad(port, ask[:12])) == 259, "a good client's answer")
        waits.append(1e3 * (time.monotonic() - begin))
        turns.append(answered[0] - theirs)
        time.sleep(0.01)
    stop.set()
    for t in threads:
        t.join(SLOW_S)
    waits.sort()
    turns.sort()
    grown = (daemon.rss() - before) / (1 << 20)
    print(f"flood: {answered[0] / 2:.0f} requests/s by 16 clients; another "
          f"waits {waits[len(waits) // 2]:.1f} ms, p99 "
          f"{waits[int(len(waits) * 0.99)]:.1f} ms, {turns[len(turns) // 2]} "
          f"answers of theirs; grown by {grown:.1f} MiB")
    # Connecting, asking and closing take a turn or two each, and this script
    # is one of the 17 that want a core: a hundred rounds of 16 x 20.
    check(turns[len(turns) // 2] < 100 * 320, f"{turns}")
    check(SANITIZED or grown < 8, f"{grown} MiB")


def slow_client(daemon, port):
    """A gateway sends its request in pieces, over a second and a half: it is
    answered. One that never ends its request goes, and the log says so."""
    request = bytes([0, 7, 0, 0, 0, 6, 1, 3, 0, 0, 0, 2])
    with socket.create_connection(("127.0.0.1", port), SLOW_S) as gateway, \
            socket.create_connection(("127.0.0.1", port), SLOW_S) as endless:
        endless.sendall(request[:9])
        for byte in request:
            gateway.sendall(bytes([byte]))
            time.sleep(0.12)
        check(gateway.recv(100)[9:13] == bytes([1, 2, 3, 4]), "slow but whole")
        check(endless.recv(100) == b"", "never whole: closed")
    check(daemon.metrics()["pelagos_modbus_late_total"] == 1, "counted")
    check("MBS-010 a Modbus connection was closed: 9 of 12 bytes" in
          daemon.log(), "logged")


TO, CHOICE, ACTION = 220, 222, 223
LOAD, START, PAUSE, REWIND, STOP = 6, 7, 8, 9, 10
IDLE, READY, RUNNING, PAUSED, ENDED = range(5)
EXERCISE = {
    "title": "Fog at two seconds",
    "state": {"ownShip": {"on": True}, "entities": [
        {"id": 1, "latitude": 52.6, "longitude": 5.2},
        {"id": 3, "latitude": 52.6, "longitude": 5.2,
         "helm": {"on": True}}]},
    "events": [
        {"name": "fog", "when": [{"at": 2}],
         "patch": {"state": {"sky": {"visibility": 800}}}},
        {"name": "rain", "when": [{"after": "fog", "delay": 1}],
         "patch": {"state": {"sky": {"rain": 3}}}}]}


def exercises():
    """Chosen, loaded, started, paused, rewound, gone on with and stopped by
    registers alone; what cannot be is an exception and a line of the log."""
    port = free_port()
    folder = tempfile.TemporaryDirectory()
    for name in ("b-fog", "a-other", "C-upper"):
        with open(os.path.join(folder.name, name + ".json"), "w") as file:
            json.dump(EXERCISE, file)
    with Daemon("--modbus", f"127.0.0.1:{port}",
                f"--exercises={folder.name}") as daemon:
        client = ModbusTcpClient("127.0.0.1", port, timeout=SLOW_S)
        check(client.connect(), "connect")

        def status():
            """Phase, number, time, fired, events, exercises, facts,
            groundings, collisions: of the registers."""
            answer = decoder(client.read_input_registers(40, 14, slave=1))
            return (answer.decode_16bit_uint(), answer.decode_16bit_uint(),
                    answer.decode_64bit_float(), answer.decode_32bit_uint(),
                    answer.decode_16bit_uint(), answer.decode_16bit_uint(),
                    answer.decode_32bit_uint(), answer.decode_16bit_uint(),
                    answer.decode_16bit_uint())

        def write(address, *words):
            answer = client.write_registers(address, list(words), slave=1)
            check(not answer.isError(), f"{address} {words}: {answer}")

        def refused(address, *words, says=None):  # soon after, not again
            before, counted = daemon.state(), client.read_input_registers(
                22, 2, slave=1).registers[1]
            answer = client.write_registers(address, list(words), slave=1)
            check(answer.isError() and answer.exception_code == 3,
                  f"{address} {words}: {answer}")
            after = daemon.state()
            check(before["exercise"] == after["exercise"], "it changed")
            check(client.read_input_registers(22, 2, slave=1).registers[1]
                  == counted + 1, "it is not counted")
            if says:
                lines = [line for line in daemon.log().splitlines()
                         if "MBS-012" in line]
                check(lines and says in lines[-1], f"{says}: {lines}")

        def phase():
            return daemon.state()["exercise"]["phase"]
        check(status() == (IDLE, 65535, 0, 0, 0, 3, 0, 0, 0), f"{status()}")
        chosen = client.read_holding_registers(CHOICE, 1, slave=1)
        check(chosen.registers == [65535], f"{chosen}")
        refused(ACTION, LOAD, says="none is chosen")
        refused(CHOICE, 3)
        for action in (0, 5, 11, 65535):
            refused(ACTION, action)
        for to in (float("nan"), -1, 2e9):
            refused(TO, *floats(to))

        # Sorted as bytes are: C-upper, a-other, b-fog.
        check(daemon.patch({"clock": {"mode": "STEPPED"}}).status == 200, "")
        write(CHOICE, 2)
        refused(ACTION, START)
        write(ACTION, LOAD)
        check(daemon.state()["exercise"]["name"] == "b-fog", "loaded")
        check(status()[:6] == (READY, 2, 0, 0, 2, 3), f"{status()}")
        # What is chosen stays so when another comes before it.
        with open(os.path.join(folder.name, "B.json"), "w") as file:
            json.dump(EXERCISE, file)
        chosen = client.read_holding_registers(CHOICE, 1, slave=1)
        check(chosen.registers == [3], f"{chosen}")
        refused(ACTION, PAUSE)
        write(ACTION, START)
        check(phase() == "RUNNING", "started")
        daemon.request("POST", "/v1/clock/step", {"seconds": 3.5})
        # Two ships in one place: they touch.
        check(status() == (RUNNING, 3, 3.5, 2, 2, 4, 4, 0, 1), f"{status()}")
        last = client.read_holding_registers(ACTION, 1, slave=1)
        check(last.registers == [START], f"{last}")
        write(ACTION, PAUSE)
        check(phase() == "PAUSED", "paused")
        write(WIND, *floats(9, 100))
        write(TO, *floats(2.5), 3, REWIND)
        check(status()[:4] == (PAUSED, 3, 2.5, 1), f"{status()}")
        check(daemon.state()["sea"]["windSpeed"] != 9, "a stage is no command")
        refused(TO, *floats(99), 3, REWIND)
        to = decoder(client.read_holding_registers(TO, 2, slave=1))
        check(to.decode_32bit_float() == 2.5, "nothing of the request stays")
        write(ACTION, START)
        daemon.request("POST", "/v1/clock/step", {"seconds": 1.5})
        check(status()[2:4] == (4, 2), f"{status()}")
        write(ACTION, STOP)
        check(status()[0] == ENDED, f"{status()}")
        # All in one request, by another hand; B comes first now.
        code, text = mbpoll(port, "-r", CHOICE, "-t", 4, "127.0.0.1", 0, LOAD)
        check(code == 0, text)
        check(daemon.state()["exercise"]["name"] == "B", "by mbpoll")
        code, text = mbpoll(port, "-r", ACTION, "-t", 4, "127.0.0.1", PAUSE)
        check(code != 0 and "Illegal data value" in text, text)
        client.close()


def identity(client):
    """Function 43/14, basic and regular."""
    for code, count in ((1, 3), (2, 7)):
        said = client.execute(ReadDeviceInformationRequest(code, 0, slave=1))
        check(not said.isError(), f"{said}")
        check(len(said.information) == count, f"{said.information}")
        check(said.information[0] == b"Pelagos", f"{said.information}")
        with open(os.path.join(ROOT, "VERSION"), encoding="ascii") as f:
            check(said.information[2].decode() == f.read().strip(),
                  f"{said.information}")


def over_rtu():
    """RTU over TCP by pymodbus' own framer."""
    port = free_port()
    with Daemon("--modbus", f"127.0.0.1:{port}", "--modbus-framing", "rtu",
                "--state", "off") as daemon:
        client = ModbusTcpClient("127.0.0.1", port, framer=ModbusRtuFramer,
                                 timeout=SLOW_S)
        check(client.connect(), "connect by RTU")
        check(decoder(client.read_holding_registers(0, 2, slave=1))
              .decode_32bit_uint() == 0x01020304, "the probe by RTU")
        check(not client.write_registers(WIND, floats(11.5, 200), slave=1)
              .isError(), "write wind by RTU")
        check(not client.write_register(COMMIT, 1, slave=1).isError(), "commit")
        until("the wind is set by RTU",
              lambda: daemon.state()["sea"]["windSpeed"] == 11.5)
        client.close()


def main():
    port = free_port()
    with Daemon("--modbus", f"127.0.0.1:{port}", "--modbus-heartbeat", "300",
                "--modbus-extrapolate", "500", "--state", "off") as daemon:
        check(daemon.patch(VIEW).status == 200, "view size")
        client = ModbusTcpClient("127.0.0.1", port, timeout=SLOW_S)
        check(client.connect(), "connect")
        by_pymodbus(daemon, client)
        identity(client)
        refusals(daemon, client)
        by_mbpoll(daemon, port)
        by_modbus_serial(daemon, port)
        heartbeat(daemon, client)
        client.close()
        malformed(daemon, port)
        slow_client(daemon, port)
        flood(daemon, port)
    over_rtu()
    several_units()
    exercises()
    bad_options()
    print("pymodbus, mbpoll, modbus-serial, heartbeat, 1000 bad ADUs, a slow "
          "client, three units, a safe view, exercises")


if __name__ == "__main__":
    try:
        main()
    except AssertionError as failure:
        sys.exit(f"FAILED: {failure}")
