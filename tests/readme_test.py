#!/usr/bin/python3
"""Every fenced block of the READMEs runs as it is printed.

In a network namespace of its own, so that the printed ports are free, with
`ocean.example` for 127.0.0.1, from a copy of what a checkout has. Each block
has a rule in BLOCKS, in the order of the text; a block without one, or a rule
without its block, fails. What a test cannot do is replaced by programs before
the others in PATH, and by nothing else:

  make demo, check, run   make -n: the target is there. What `make run` starts
                          is what runs while the tour is taken
  sudo make install       make install with DESTDIR
  sudo apt install P…     each package is installed already
  pip                     --no-index, --no-build-isolation: no network
  mbpoll, pelagosctl      wait longer than their one and ten seconds
  ffplay                  ffmpeg reads five pictures of the same source, by the
                          same options
  pelagosd                --device software; until its block's ports listen
  nginx                   packaging/nginx/pelagos.conf, with the certificate of
                          the block before
  C                       the block in main(), with #include
"""
import contextlib
import os
import pathlib
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import textwrap
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
BIN = pathlib.Path(os.environ.get("PELAGOS_BIN", ROOT / "build/release/bin"))
INSIDE = "PELAGOS_README_NAMESPACE"
SLOW_S = 300
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.S | re.M)


class Failed(Exception):
    pass


def blocks_of(name):
    """(language, text, line) of each fenced block."""
    text = (ROOT / name).read_text(encoding="utf-8")
    return [(m[1], m[2], text.count("\n", 0, m.start()) + 2)
            for m in FENCE.finditer(text)]


def listens(port):
    with socket.socket() as s:
        return s.connect_ex(("127.0.0.1", port)) == 0


class Place:
    """The copy of a checkout, the programs before the others, daemons."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.dest = self.folder / "dest"
        self.shims = self.folder / "shims"
        self.work = self.folder / "checkout"
        self.started = []
        self.python = None  # the namespace of the Python blocks so far
        self.work.mkdir()
        self.shims.mkdir()
        for name in ("clients", "packaging", "proto"):
            shutil.copytree(ROOT / name, self.work / name,
                            ignore=shutil.ignore_patterns("node_modules"))
        (self.work / "build").mkdir()
        self.env = {
            "PATH": f"{self.shims}:{self.dest}/usr/local/bin:/usr/sbin:"
                    "/usr/bin:/sbin:/bin",
            "HOME": str(self.folder), "LANG": "C.UTF-8",
            "PIP_NO_INDEX": "1", "PIP_NO_BUILD_ISOLATION": "false",
            "PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_QUIET": "1",
            "PKG_CONFIG_PATH": f"{self.dest}/usr/local/lib/pkgconfig",
            # Below DESTDIR `make install` tells the loader nothing.
            "LD_LIBRARY_PATH": f"{self.dest}/usr/local/lib",
        }
        self.variant = self.current_variant()
        self.write_shims()

    @staticmethod
    def current_variant():
        """The make variables that the programs at hand were built with."""
        for variable in ("", "DEV=1"):
            plan = subprocess.run(
                ["make", "-n", *variable.split(), "all"], cwd=ROOT,
                capture_output=True, text=True, check=False)
            # Which uPlot there is is looked at each time, so the page is in every
            # plan.
            compiled = [line for line in plan.stdout.splitlines()
                        if " -c " in line and "/gen/pages." not in line]
            if plan.returncode == 0 and not compiled:
                return variable
        raise Failed("the programs in build/ are not of this source: `make`")

    def shim(self, name, text):
        path = self.shims / name
        path.write_text("#!/bin/bash\n" + textwrap.dedent(text))
        path.chmod(0o755)

    def write_shims(self):
        self.shim("make", f"""\
            case "$1" in
            demo|check|run) exec /usr/bin/make -C {ROOT} -n "$1" >/dev/null ;;
            install) exec /usr/bin/make -s -C {ROOT} {self.variant} \\
                         DESTDIR={self.dest} install ;;
            *) echo "no rule for make $*" >&2; exit 1 ;;
            esac
            """)
        self.shim("sudo", """\
            if [ "$1 $2" = "apt install" ]; then
                shift 2; exec dpkg -s "$@" >/dev/null
            fi
            exec "$@"
            """)
        self.shim("ffplay", """\
            n=$(ffmpeg -v error "${@:1:$#-1}" -i "${@: -1}" -frames:v 5 \
                -f framecrc - | grep -c '^0,')
            [ "$n" = 5 ] || { echo "ffplay $*: $n pictures" >&2; exit 1; }
            """)
        # A commit is answered when its sea is there; to write again what was
        # not answered in time changes nothing.
        self.shim("mbpoll", """\
            for i in $(seq 30); do
                said=$(/usr/bin/mbpoll -o 10 "$@" 2>&1) && exit 0
                [[ $said = *"timed out"* ]] || break
            done
            echo "$said" >&2; exit 1
            """)
        self.shim("pelagosctl", f"""\
            exec {BIN}/pelagosctl --timeout {SLOW_S} "$@"
            """)
        (self.work / "build/pelagosctl").symlink_to(self.shims / "pelagosctl")
        self.shim("pelagosd", f'exec {BIN}/pelagosd --device software "$@"\n')
        (self.work / "build/pelagosd").symlink_to(self.shims / "pelagosd")
        self.shim("pkg-config", f"""\
            exec /usr/bin/pkg-config \\
                --define-variable=prefix={self.dest}/usr/local "$@"
            """)

    def run(self, command, **more):
        done = subprocess.run(
            command, cwd=self.work, env=self.env, capture_output=True,
            text=True, errors="replace", timeout=SLOW_S,
            stdin=subprocess.DEVNULL, check=False, **more)
        if done.returncode != 0:
            raise Failed(f"{command}: status {done.returncode}\n"
                         f"{done.stdout[-2000:]}{done.stderr[-2000:]}")
        return done.stdout + done.stderr

    def start(self, command, ports):
        """A program that goes on; until its ports listen."""
        with open(self.folder / f"log{len(self.started)}", "wb") as log:
            process = subprocess.Popen(
                command, cwd=self.work, env=self.env, stdout=log, stderr=log,
                stdin=subprocess.DEVNULL, start_new_session=True)
        self.started.append(process)
        end = time.monotonic() + SLOW_S
        while not all(listens(port) for port in ports):
            if process.poll() is not None or time.monotonic() > end:
                raise Failed(f"{command} does not listen on {ports}:\n" +
                             pathlib.Path(log.name).read_text())
            time.sleep(0.1)

    def stop(self):
        for process in self.started:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
            process.wait(SLOW_S)
        self.started = []

    # --- daemons ------------------------------------------------------------

    def make_run(self, *options):
        """What `make run` starts, as make says it; all its ports."""
        self.stop()
        plan = subprocess.run(
            ["make", "-C", ROOT, "-n", "--no-print-directory", "run",
             f"ARGS={shlex.join(options)}"], capture_output=True, text=True,
            check=True).stdout.splitlines()
        self.sh(plan[-2])  # the folder of its recordings
        self.start(shlex.split(plan[-1]), (8080, 7878, 8554, 1502))

    def https(self):
        """The nginx that the manual puts before the daemon."""
        conf = (self.work / "packaging/nginx/pelagos.conf").read_text()
        for old, new in (("/etc/pelagos/tls/fullchain.pem", "cert.pem"),
                         ("/etc/pelagos/tls/privkey.pem", "key.pem")):
            conf = conf.replace(old, str(self.work / new))
        (self.folder / "pelagos.conf").write_text(
            re.sub(r" *listen \[::\].*\n", "", conf))
        temporary = "".join(
            f"{name}_temp_path {self.folder}/{name};" for name in (
                "client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
        (self.folder / "nginx.conf").write_text(
            f"user root; daemon off; master_process off; pid {self.folder}/nginx.pid;"
            f"error_log {self.folder}/error.log; events {{ }}"
            f"http {{ access_log off; {temporary}"
            f"include {self.folder}/pelagos.conf; }}")
        self.start(["nginx", "-p", str(self.folder), "-c",
                    str(self.folder / "nginx.conf"), "-e",
                    f"{self.folder}/error.log"], (443,))

    def files_of_yours(self):
        """bay.tif and a recorded session in two segments."""
        rows = "\n".join(" ".join(str(x - y - 40) for x in range(64))
                         for y in range(64))
        (self.work / "bay.asc").write_text(
            "ncols 64\nnrows 64\nxllcorner 5.1\nyllcorner 52.5\n"
            f"cellsize 0.003\n{rows}\n")
        self.run(["gdal_translate", "-q", "-a_srs", "EPSG:4326", "bay.asc",
                  "bay.tif"])
        self.make_run("--record", "bug.pelog", "--record-segment", "0.0625",
                      "--bathymetry", ".")
        patch = ["build/pelagosctl", "set"]
        for wind in range(5, 15):
            self.run(patch + [f"sea.windSpeed={wind}"])
        many = " ".join(f"views.bridge.yaw={yaw % 90}"
                        for yaw in range(100))
        end = time.monotonic() + SLOW_S
        while not (self.work / "bug.pelog.000001").exists():
            self.run(patch + many.split()[:60])
            if time.monotonic() > end:
                raise Failed("no second segment")

    def python_page(self):
        """After the client's own page, which made the virtual environment;
        with the view that the tour made."""
        self.python = None
        wing = re.search(r"^curl .*/v1/views/wing$",
                         (ROOT / "README.md").read_text(), re.M)
        self.sh(wing[0])

    # --- kinds of blocks ----------------------------------------------------

    def sh(self, text):
        self.run(["bash", "-euo", "pipefail", "-c", text])

    def serve(self, text):
        """A block that ends in a daemon that stays."""
        self.stop()
        self.start(["bash", "-euo", "pipefail", "-c", text],
                   (8080, 7878, 8554))
        self.https()

    def session(self, text):
        """`$ command` and what it prints."""
        for part in re.split(r"^\$ ", text, flags=re.M)[1:]:
            command, _, printed = part.partition("\n")
            done = subprocess.run(
                ["bash", "-c", command], cwd=self.work, env=self.env,
                capture_output=True, text=True, timeout=SLOW_S, check=False)
            if done.stdout + done.stderr != printed:
                raise Failed(f"$ {command}\nprints {done.stdout}{done.stderr}"
                             f"not {printed}")

    def c(self, text):
        (self.work / "block.c").write_text(
            "#include <stdio.h>\n#include \"pelagos.h\"\nint main(void)\n{\n"
            f"{text}\nreturn frame && frame->data.len > 1000 ? 0 : 1;\n}}\n")
        # A first picture may take a busy machine longer than the block waits.
        self.sh("build/pelagosctl frame bridge first.jpg")
        self.sh("cc -Wall -Werror block.c $(pkg-config --cflags --libs "
                "pelagos) -o block && ./block")

    def python_block(self, text):
        """Blocks of one page go on from each other, as pasted."""
        self.python = (self.python or "") + text
        self.run(["venv/bin/python", "-c", self.python])

    def python_session(self, text):
        """`>>> line`, and how the last line of the error begins."""
        for part in re.split(r"^>>> ", text, flags=re.M)[1:]:
            line, _, printed = part.partition("\n")
            done = subprocess.run(
                ["venv/bin/python", "-c",
                 f"from pelagos import Ocean\nocean = Ocean()\n{line}\n"],
                cwd=self.work, env=self.env, capture_output=True, text=True,
                timeout=SLOW_S, check=False)
            if not done.stderr.endswith(printed):
                raise Failed(f">>> {line}\nprints {done.stderr}not {printed}")


NO_CODE = None  # a formula
# Of each page the blocks in order: a word of it, its kind, what goes before.
BLOCKS = {
    "README.md": [
        ("make demo", Place.sh, None),
        ("sudo make install", Place.sh, None),
        ("curl -o bridge.jpg", Place.sh, Place.make_run),
        ("bay.tif", Place.sh, Place.files_of_yours),
        ("$ build/pelagosctl", Place.session, None),
        ("pel_client_connect", Place.c, None),
        ("import pelagos", Place.python_block, Place.python_page),
        ("openssl rand", Place.serve, None),
        ("tls:ocean.example", Place.sh, None),
    ],
    "clients/python/README.md": [
        ("pip install", Place.sh, None),
        ("from pelagos import", Place.python_block, Place.make_run),
        ("Texelstroom", Place.python_block, None),
        ("x = R (X", NO_CODE, None),
        ("ocean.reset(42", Place.python_block, None),
        (">>> ocean", Place.python_session, None),
    ],
    "CONTRIBUTING.md": [],
}


def check_page(place, page, counts):
    found, rules = blocks_of(page), BLOCKS[page]
    if len(found) != len(rules):
        raise Failed(f"{page} has {len(found)} blocks, {len(rules)} rules: "
                     "see BLOCKS in tests/readme_test.py")
    for (_, text, line), (word, kind, before) in zip(found, rules):
        if word not in text:
            raise Failed(f"{page}:{line}: no {word!r} in this block: see "
                         "BLOCKS in tests/readme_test.py")
        what = f"{page}:{line}: {word}"
        if kind is NO_CODE:
            counts["no code"] += 1
            print(f"no code   {what}")
            continue
        begun = time.monotonic()
        try:
            if before is Place.python_page:
                check_page(place, "clients/python/README.md", counts)
            if before:
                before(place)
            kind(place, text)
        except (Failed, subprocess.TimeoutExpired) as failure:
            counts["failed"] += 1
            print(f"FAILED    {what}\n{failure}")
            continue
        counts["ran"] += 1
        print(f"ran {time.monotonic() - begun:5.1f} s {what}", flush=True)


def missing():
    tools = ("ip", "ffmpeg", "mbpoll", "nginx", "openssl", "curl", "cc",
             "gdal_translate", "pkg-config")
    return [t for t in tools if not shutil.which(t, path="/usr/sbin:/usr/bin")]


def inside():
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    with tempfile.TemporaryDirectory(prefix="pelagos-readme-") as folder:
        hosts = pathlib.Path(folder) / "hosts"
        hosts.write_text("127.0.0.1 localhost ocean.example\n")
        subprocess.run(["mount", "--bind", hosts, "/etc/hosts"], check=True)
        counts = {"ran": 0, "failed": 0, "no code": 0}
        place = Place(folder)
        try:
            check_page(place, "README.md", counts)
            check_page(place, "CONTRIBUTING.md", counts)
        finally:
            place.stop()
            subprocess.run(["umount", "/etc/hosts"], check=True)
        print(", ".join(f"{n} {what}" for what, n in counts.items()))
        return 1 if counts["failed"] else 0


def main():
    if os.environ.get(INSIDE):
        return inside()
    if lacking := missing():
        print(f"not installed: {', '.join(lacking)}")
        return 77
    own = ["unshare", "--user", "--map-root-user", "--net", "--mount"]
    if subprocess.run(own + ["true"], capture_output=True,
                      check=False).returncode != 0:
        print("no network namespace of its own is to be had (unshare)")
        return 77
    return subprocess.run(own + [sys.executable, "-B", __file__],
                          env={**os.environ, INSIDE: "1"},
                          check=False).returncode


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Failed as failure:
        sys.exit(f"FAILED: {failure}")
