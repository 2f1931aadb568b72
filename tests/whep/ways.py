#!/usr/bin/python3
"""WebRTC where a player cannot reach the daemon, by a STUN and TURN server that
we did not write (coturn), in network namespaces. Root's; `make viewers-check`."""
import contextlib
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

TESTS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path[:0] = [TESTS, os.path.join(TESTS, "cluster")]

TOKEN = "desk-token-0123456789"
VIEW = "/v1/views/bridge/whep"
PICTURES = 30  # a second of them: the way stands, it was no lucky packet
# The daemon's own address where it is behind a translator.
HIDDEN = "10.80.0.1"


def play(address, gathers):
    """The player's process, in its namespace: an offer as a line of JSON, the
    answer back, then a line a picture."""
    from whep_client import Player
    player = Player(address=address)
    print(json.dumps(player.gathered() if gathers else player.offer()),
          flush=True)
    player.answered(json.loads(sys.stdin.readline()))
    while player.frame(60):
        print("picture", flush=True)


class Ways(unittest.TestCase):
    def setUp(self):
        import spaces
        self.net = spaces.Net(("sea", "server", "player"), subnet=79)
        self.addCleanup(self.net.close)
        self.folder = tempfile.mkdtemp(prefix="pelagos-test-")
        self.addCleanup(shutil.rmtree, self.folder)
        server = self.net.hosts["server"]
        # Without a file of settings: libnice asks by RFC 3489, which Debian's
        # own forbids (no-stun-backward-compatibility).
        self.start("server", "turnserver", "-n", "--no-cli", "--no-tls",
                   "--no-dtls", "--listening-ip", server, "--relay-ip", server,
                   "--lt-cred-mech", "--user", "watch:word", "--realm", "sea",
                   "--log-file", "stdout", "--pidfile",
                   os.path.join(self.folder, "pid"))

    def start(self, name, *words, **more):
        log = open(os.path.join(self.folder, words[0].split("/")[-1]), "wb")
        more = {"stdin": subprocess.DEVNULL, "stdout": log, "stderr": log,
                **more}
        process = subprocess.Popen(self.net.prefix(name) + list(words), **more)
        log.close()

        def end():
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                if pipe:
                    pipe.close()
        self.addCleanup(end)
        return process

    def daemon(self, address, servers, *more):
        from pelagos_daemon import BIN
        token = os.path.join(self.folder, "tokens")
        with open(token, "w", encoding="utf-8") as f:
            f.write(f"{TOKEN} instruct desk\n")
        os.chmod(token, 0o600)
        self.address = address
        daemon = self.start(
            "sea", os.path.join(BIN, "pelagosd"), "--http", f"{address}:8080",
            "--plain", "--token-file", token, "--tcp", "off", "--rtsp", "off",
            "--modbus", "off", "--nmea", "off", "--unix", "off", "--device",
            "software", *(("--whep-servers", servers) if servers else ()),
            *more)
        while self.http("GET", "/healthz")[0] != 200:
            self.assertIsNone(daemon.poll(), self.log("pelagosd"))
            time.sleep(0.2)
        status, said = self.http("PATCH", "/v1/state", json.dumps({
            "views": [{"name": "bridge", "entity": 1, "width": 160,
                       "height": 90}]}), "application/json")
        self.assertEqual(status, 200, said)

    def http(self, method, path, body="", kind="text/plain", at="sea"):
        """(status, body), asked from that machine."""
        done = subprocess.run(
            self.net.prefix(at) + [
                "curl", "-s", "-m", "60", "-X", method, "-w", "\n%{http_code}",
                "-H", f"Authorization: Bearer {TOKEN}", "-H",
                f"Content-Type: {kind}", "--data-binary", "@-",
                f"http://{self.address}:8080{path}"],
            input=body, capture_output=True, text=True)
        text, status = done.stdout.rsplit("\n", 1)
        return int(status), text

    def log(self, name):
        with open(os.path.join(self.folder, name), errors="replace") as f:
            return f.read()[-4000:]

    def pictures(self, seconds, gathers=True, at="sea"):
        """The answer, and how many pictures come within that time. gathers: the
        offer has candidates; at: where it is sent from."""
        player = self.start("player", sys.executable, os.path.abspath(__file__),
                            "--play", self.net.hosts["player"],
                            "yes" if gathers else "no",
                            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                            text=True, bufsize=1)
        offer = json.loads(player.stdout.readline())
        status, answer = self.http("POST", VIEW, offer, "application/sdp", at)
        self.assertEqual(status, 201, answer)
        player.stdin.write(json.dumps(answer) + "\n")
        player.stdin.flush()
        end, seen = time.monotonic() + seconds, 0
        while seen < PICTURES and (left := end - time.monotonic()) > 0:
            if select.select([player.stdout], [], [], left)[0]:
                seen += player.stdout.readline() == "picture\n"
        return answer, seen

    def keep_apart(self):
        """The daemon and the player reach the server and not each other by
        UDP."""
        for name, other in (("sea", "player"), ("player", "sea")):
            self.net.filter(self.net.spaces[name],
                            f"ip saddr {self.net.hosts[other]} meta l4proto udp "
                            "drop")

    def test_by_a_relay(self):
        self.keep_apart()
        server = self.net.hosts["server"]
        # Somebody else asks for the player.
        self.daemon(self.net.hosts["sea"], f"turn://watch:word@{server}:3478",
                    "--whep-peers", self.net.hosts["player"])
        answer, seen = self.pictures(60)
        self.assertRegex(answer, rf"UDP \d+ {server} \d+ typ relay")
        self.assertEqual(seen, PICTURES, self.log("turnserver"))

    def test_by_a_relay_as_browsers_ask(self):
        """They name no address of theirs: the relay lets in who asked."""
        self.keep_apart()
        server = self.net.hosts["server"]
        self.daemon(self.net.hosts["sea"], f"turn://watch:word@{server}:3478")
        _, seen = self.pictures(60, gathers=False, at="player")
        self.assertEqual(seen, PICTURES, self.log("turnserver"))

    def test_without_a_relay(self):
        """What the one above is worth."""
        self.keep_apart()
        self.daemon(self.net.hosts["sea"], None)
        answer, seen = self.pictures(8)
        self.assertNotIn("typ relay", answer)
        self.assertEqual(seen, 0)

    def hide(self):
        """Of the daemon only what a translator makes of its address is seen,
        and nobody comes in whom it has not sent to."""
        space, host = self.net.spaces["sea"], self.net.hosts["sea"]
        self.net.within(space, "ip", "addr", "add", f"{HIDDEN}/32", "dev",
                        "eth0")
        self.net.within(
            space, "nft", "add table ip n; add chain ip n o { type nat hook "
            "postrouting priority srcnat; }; add rule ip n o ip saddr "
            f"{HIDDEN} oifname eth0 snat to {host}")
        self.net.filter(space, f"iifname eth0 ip daddr {HIDDEN} ct state new "
                        "drop")

    def test_behind_a_translator(self):
        self.hide()
        self.daemon(HIDDEN, f"stun://{self.net.hosts['server']}:3478",
                    "--whep-peers", self.net.hosts["player"])
        answer, seen = self.pictures(60)
        self.assertRegex(
            answer, rf"UDP \d+ {self.net.hosts['sea']} \d+ typ srflx")
        self.assertEqual(seen, PICTURES, self.log("pelagosd"))


def main():
    if sys.argv[1:2] == ["--play"]:
        with contextlib.suppress(KeyboardInterrupt, BrokenPipeError):
            play(sys.argv[2], sys.argv[3] == "yes")
        return
    if os.geteuid() != 0 or not shutil.which("turnserver"):
        print("needs root and coturn")
        sys.exit(77)
    unittest.main(verbosity=2)


if __name__ == "__main__":
    main()
