#!/usr/bin/python3
"""The clients of the project against a daemon with a token and TLS."""
import os
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, CC_FLAGS, ROOT, SLOW_S, Daemon
from security_test import OTHER, TOKEN, Case


class Clients(Case):
    """Ours, by token and through TLS."""
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.daemon = Daemon("--token-file", cls.token, "--tls-cert", cls.cert,
                            "--tls-key", cls.key)
        cls.daemon.patch({"views": [{"name": "bridge", "width": 320,
                                     "height": 180}]},
                         headers={"Authorization": "Bearer " + TOKEN})

    @classmethod
    def tearDownClass(cls):
        cls.daemon.stop()
        super().tearDownClass()

    def ctl(self, *arguments, server="tls:localhost", **environment):
        clean = {k: v for k, v in os.environ.items()
                 if not k.startswith("PELAGOS_") or k == "PELAGOS_BIN"}
        done = subprocess.run(
            [os.path.join(BIN, "pelagosctl"), "--timeout", "60", "--server",
             f"{server}:{self.daemon.tcp_port}", *arguments],
            capture_output=True, text=True, timeout=SLOW_S,
            env={**clean, "PELAGOS_URL": self.daemon.url(""), **environment})
        return done.returncode, done.stdout + done.stderr

    def test_pelagosctl(self):
        ca = {"PELAGOS_CA": self.cert}
        given = ("--token-file", self.token)
        self.assertEqual(self.ctl(*given, "get", "sea.windSpeed", **ca),
                         (0, "8\n"))
        for host in ("tls:127.0.0.1", "tls:localhost"):
            self.assertEqual(self.ctl("get", "sea.windSpeed", server=host,
                                      PELAGOS_TOKEN=TOKEN, **ca), (0, "8\n"))
        self.assertEqual(self.ctl("get", "sea.windSpeed",
                                  PELAGOS_TOKEN_FILE=self.token, **ca),
                         (0, "8\n"))
        path = os.path.join(self.folder, "big.exr")
        self.assertEqual(self.ctl(*given, "frame", "bridge", path, "--width",
                                  "1024", "--height", "1024", "--float",
                                  **ca)[0], 0)
        self.assertGreater(os.path.getsize(path), 8 << 20)
        clip = os.path.join(self.folder, "clip.mkv")
        status, said = self.ctl(*given, "record", "bridge", clip, "--seconds",
                                "1", **ca)
        self.assertEqual(status, 0, said)
        for arguments, environment, says in (
                (given, {}, "self-signed"), (given, {}, "PELAGOS_CA=FILE"),
                ((), ca, "--token-file"),
                ((), {**ca, "PELAGOS_TOKEN": OTHER}, "token is wrong"),
                (("--token-file", "/nowhere"), ca, "cannot read")):
            status, said = self.ctl(*arguments, "get", **environment)
            self.assertNotEqual(status, 0, said)
            self.assertIn(says, said)
        status, said = self.ctl(*given, "get", server="tcp:localhost", **ca)
        self.assertNotEqual(status, 0, "plain, where TLS is spoken")

    def test_c_examples(self):
        """example.c through TLS and save_live.c over HTTP, with the token."""
        built = os.path.dirname(BIN)
        for name, arguments, start in (
                ("example", ["out.jpg", f"tls:localhost:"
                             f"{self.daemon.tcp_port}"], b"\xff\xd8"),
                ("save_live", ["bridge", "out.mjpeg", "0.3",
                               self.daemon.url("")], b"\xff\xd8")):
            program = os.path.join(self.folder, name)
            subprocess.run(
                ["cc", *CC_FLAGS, "-I", os.path.join(ROOT, "clients/lib"), "-I",
                 os.path.join(built, "gen"),
                 os.path.join(ROOT, f"clients/lib/{name}.c"),
                 os.path.join(built, "libpelagos.a"), "-lprotobuf-c", "-lssl",
                 "-lcrypto", "-o", program], check=True)
            for token, status in ((TOKEN, 0), (OTHER, 1)):
                done = subprocess.run(
                    [program, *arguments], cwd=self.folder, timeout=SLOW_S,
                    capture_output=True, text=True, env={
                        **os.environ, "PELAGOS_TOKEN": token,
                        "PELAGOS_CA": self.cert})
                self.assertEqual(done.returncode, status, done.stderr)
            self.assertIn("token is wrong", done.stderr)
            out = next(a for a in arguments if a.startswith("out"))
            with open(os.path.join(self.folder, out), "rb") as f:
                self.assertEqual(f.read(2), start)

    def test_python(self):
        sys.path.insert(0, os.path.join(ROOT, "clients/python"))
        import pelagos
        with self.assertRaises(pelagos.Unauthorized):
            pelagos.Ocean(self.daemon.url("")).state()
        with self.assertRaises(pelagos.Unauthorized):
            pelagos.Ocean(self.daemon.url(""), token=OTHER).state()
        with pelagos.Ocean(self.daemon.url(""), token=TOKEN) as ocean:
            self.assertEqual(ocean["sea.windSpeed"], 8)
            self.assertEqual(ocean.views["bridge"].image().shape,
                             (180, 320, 3))
            for stream in (ocean.views["bridge"].live(),
                           ocean.views["bridge"].live(fps=20),
                           ocean.views["bridge"].video()):
                with stream:
                    self.assertTrue(next(stream).data)
        for name, value in (("PELAGOS_TOKEN", TOKEN),
                            ("PELAGOS_TOKEN_FILE", self.token)):
            os.environ[name] = value
            try:
                self.assertEqual(pelagos.Ocean(self.daemon.url("")
                                               )["sea.windSpeed"], 8)
            finally:
                del os.environ[name]


if __name__ == "__main__":
    unittest.main(verbosity=2)
