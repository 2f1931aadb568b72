"""An exercise on several nodes, for tests: etcd's members, daemons on them, and
a reader of the log that shares nothing with the daemon but the schema."""
import base64
import contextlib
import hashlib
import http.client
import json
import os
import shutil
import ssl
import subprocess
import tempfile
import threading
import time

from pelagos_daemon import Daemon, free_port, schema, until

VIEW = {"entity": 1, "width": 64, "height": 36}


def b64(text):
    return base64.b64encode(text.encode()).decode()


def has_etcd():
    return shutil.which("etcd") is not None


class Member:
    """An etcd on its own address; may be killed and started again."""

    def __init__(self, name, host, client, peer, folder, prefix=(),
                 tls=None):
        self.name, self.host, self.client = name, host, client
        self.tls = tls  # folder of ca, member's and client's PEM files
        self.peer, self.folder, self.prefix = peer, folder, list(prefix)
        self.process = None

    @property
    def url(self):
        scheme = "https" if self.tls else "http"
        return f"{scheme}://{self.host}:{self.client}"

    def start(self, peers, new=True):
        mine = f"http://{self.host}:{self.peer}"
        with open(os.path.join(self.folder, self.name + ".log"), "ab") as log:
            self.process = subprocess.Popen(
                self.prefix + [
                    "etcd", "--name", self.name, "--data-dir",
                    os.path.join(self.folder, self.name + ".etcd"),
                    "--listen-client-urls", self.url,
                    "--advertise-client-urls", self.url,
                    "--listen-peer-urls", mine,
                    "--initial-advertise-peer-urls", mine,
                    "--initial-cluster", ",".join(
                        f"{p.name}=http://{p.host}:{p.peer}" for p in peers),
                    "--initial-cluster-state", "new" if new else "existing",
                    "--heartbeat-interval", "30", "--election-timeout", "300",
                    "--auto-compaction-mode", "revision",
                    "--auto-compaction-retention", "10000"] + (
                        ["--client-cert-auth", "--trusted-ca-file",
                         self.tls + "/ca.pem", "--cert-file",
                         self.tls + "/member.pem", "--key-file",
                         self.tls + "/member.key"] if self.tls else []),
                stdout=log, stderr=log, stdin=subprocess.DEVNULL)

    def post(self, path, body, timeout=5):
        if self.tls:
            trust = ssl.create_default_context(cafile=self.tls + "/ca.pem")
            trust.load_cert_chain(self.tls + "/node.pem",
                                  self.tls + "/node.key")
            connection = http.client.HTTPSConnection(
                self.host, self.client, timeout=timeout, context=trust)
        else:
            connection = http.client.HTTPConnection(self.host, self.client,
                                                    timeout=timeout)
        with contextlib.closing(connection):
            connection.request("POST", path, json.dumps(body))
            answer = connection.getresponse()
            return json.loads(answer.read())

    def leads(self):
        with contextlib.suppress(OSError, ValueError, KeyError):
            status = self.post("/v3/maintenance/status", {}, timeout=1)
            return status["header"]["member_id"] == status["leader"]
        return False

    def kill(self):
        self.process.kill()
        self.process.wait()

    def stop(self):
        if self.process and self.process.poll() is None:
            self.process.kill()
            self.process.wait()


def certificates(folder):
    """An authority, a member's certificate and a node's."""
    def openssl(*words):
        subprocess.run(["openssl", *words], check=True, cwd=folder,
                       capture_output=True)
    key = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes")
    openssl("req", "-x509", *key, "-keyout", "ca.key", "-out", "ca.pem",
            "-subj", "/CN=authority", "-days", "2")
    for name in ("member", "node"):
        openssl("req", *key, "-keyout", f"{name}.key", "-out", f"{name}.csr",
                "-subj", f"/CN={name}")
        with open(os.path.join(folder, "ext"), "w") as f:
            f.write("subjectAltName=IP:127.0.0.1\n"
                    "extendedKeyUsage=serverAuth,clientAuth\n")
        openssl("x509", "-req", "-in", f"{name}.csr", "-CA", "ca.pem",
                "-CAkey", "ca.key", "-CAcreateserial", "-days", "2",
                "-extfile", "ext", "-out", f"{name}.pem")


class Store:
    """One or three members on loopback, or given ones."""

    def __init__(self, count=1, members=None, tls=False):
        self.folder = tempfile.mkdtemp(prefix="pelagos-etcd-")
        if tls:
            certificates(self.folder)
        self.members = members or [
            Member(f"s{i}", "127.0.0.1", free_port(), free_port(), self.folder,
                   tls=self.folder if tls else None)
            for i in range(count)]
        for member in self.members:
            member.folder = self.folder
            member.start(self.members)
        until("etcd elects", self.leader)

    def leader(self):
        return next((m for m in self.members if m.leads()), None)

    def url(self, exercise="bridge"):
        return ",".join(m.url for m in self.members) + "/" + exercise

    def restart(self, member):
        member.start(self.members, new=False)

    def stop(self):
        for member in self.members:
            member.stop()
        shutil.rmtree(self.folder, ignore_errors=True)

    def put(self, key, value):
        self.members[0].post("/v3/kv/put", {
            "key": b64(key), "value": base64.b64encode(value).decode()})

    def get(self, key):
        """The value of a key, by any member that answers."""
        for member in self.members:
            with contextlib.suppress(OSError, ValueError):
                answer = member.post("/v3/kv/range", {"key": b64(key)})
                kvs = answer.get("kvs")
                return base64.b64decode(kvs[0]["value"]) if kvs else None
        raise AssertionError("no etcd answers")


class Log(threading.Thread):
    """Every sealed frame of an exercise, as one member tells it, in order."""

    def __init__(self, member, exercise="bridge", from_revision=1):
        super().__init__(daemon=True)
        self.member, self.exercise = member, exercise
        self.from_revision = from_revision
        self.pb = schema()
        self.frames = []  # (version, SealedFrame, when it was heard)
        self.process = None
        self.start()

    def run(self):
        body = json.dumps({"create_request": {
            "key": b64(f"{self.exercise}/log"),
            "start_revision": str(self.from_revision)}})
        command = self.member.prefix + [
            "curl", "-sN", "--noproxy", "*", "-d", body,
            self.member.url + "/v3/watch"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE)
        for line in self.process.stdout:
            result = json.loads(line).get("result", {})
            for event in result.get("events", ()):
                kv = event["kv"]
                frame = self.pb.SealedFrame.FromString(
                    base64.b64decode(kv["value"]))
                self.frames.append((int(kv["version"]), frame,
                                    time.monotonic()))

    def stop(self):
        if self.process:
            self.process.kill()
            self.process.wait()
        self.join()

    def last(self):
        return self.frames[-1][0] if self.frames else 0

    def check(self):
        """No gap, no frame twice, seals that name their frame; revisions that
        rise by one; terms that do not fall."""
        term, revision = 0, None
        for i, (version, frame, _) in enumerate(self.frames):
            assert version == self.frames[0][0] + i, (version, i)
            assert frame.seal.number == version, (frame.seal.number, version)
            assert frame.seal.term >= term, (frame.seal.term, term)
            term = frame.seal.term
            for entry in frame.entries:
                assert revision is None or entry.revision == revision + 1, (
                    version, entry.revision, revision)
                revision = entry.revision

    def commands(self):
        """Every patch in the order of the log, with its frame."""
        return [(version, entry.patch) for version, frame, _ in self.frames
                for entry in frame.entries]


class Node(Daemon):
    """A daemon of the exercise; extra: more options."""

    def __init__(self, name, store, *extra, prefix=(), host="127.0.0.1",
                 fps=30, wait_s=60, quality="full"):
        self.name = name
        self.host = host
        super().__init__("--exercise", store.url(), "--exercise-node", name,
                         "--fps", str(fps), "--quality", quality,
                         "--realtime", "off", "--encoder-threads", "1",
                         *extra, wait_s=wait_s)

    def cluster(self):
        return self.get("/v1/cluster", timeout=5).json()

    def is_master(self):
        with contextlib.suppress(OSError, ValueError):
            return self.cluster().get("role") == "MASTER"
        return False

    def follows(self):
        with contextlib.suppress(OSError, ValueError):
            return self.cluster().get("role") == "FOLLOWER"
        return False

    def kill(self):
        """kill -9, and what it had is gone."""
        self.process.kill()
        self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


def packed_digest(state):
    """As a seal has it, of a State in Python."""
    return hashlib.sha256(state.SerializeToString(deterministic=True)).digest()
