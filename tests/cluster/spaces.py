"""Machines for a test: network namespaces on one bridge, with loss and cuts by
nft. Root's."""
import contextlib
import os
import socket
import subprocess
import tempfile
import time

from cluster_case import Member
from pelagos_daemon import BIN, Session, schema, until

PREFIX = f"pel{os.getpid() % 10000}"


def ip(*words, check=True):
    return subprocess.run(["ip", *words], check=check, capture_output=True,
                          text=True)


class Net:
    """`hub` holds the bridge; each machine has one end of a veth. Two at once
    have different subnets."""

    def __init__(self, names, subnet=77):
        self.hub = f"{PREFIX}hub"
        self.hosts = {}
        self.spaces = {n: f"{PREFIX}{n}" for n in names}
        ip("netns", "add", self.hub)
        self.within(self.hub, "ip", "link", "add", "br0", "type", "bridge")
        self.within(self.hub, "ip", "link", "set", "br0", "up")
        for i, (name, space) in enumerate(self.spaces.items()):
            self.hosts[name] = f"10.{subnet}.0.{i + 1}"
            ip("netns", "add", space)
            ip("link", "add", "eth0", "netns", space, "type", "veth", "peer",
               "name", f"v{i}", "netns", self.hub)
            self.within(self.hub, "ip", "link", "set", f"v{i}", "master", "br0",
                        "up")
            self.within(space, "ip", "addr", "add",
                        f"{self.hosts[name]}/24", "dev", "eth0")
            self.within(space, "ip", "link", "set", "eth0", "up")
            self.within(space, "ip", "link", "set", "lo", "up")

        # The test itself looks on from here.
        self.end = f"{PREFIX}x"
        ip("link", "add", self.end, "type", "veth", "peer", "name", "vx",
           "netns", self.hub)
        self.within(self.hub, "ip", "link", "set", "vx", "master", "br0", "up")
        ip("addr", "add", f"10.{subnet}.0.200/24", "dev", self.end)
        ip("link", "set", self.end, "up")

    @staticmethod
    def within(space, *words):
        subprocess.run(["ip", "netns", "exec", space, *words], check=True)

    def prefix(self, name):
        return ["ip", "netns", "exec", self.spaces[name]]

    def loss(self, percent):
        """Of what each machine receives, 0: none."""
        for space in self.spaces.values():
            self.filter(space, f"iifname eth0 numgen random mod 100 < {percent}"
                        " drop" if percent else None)

    def cut(self, names):
        """These machines reach each other and nobody else; (): all do."""
        for name, space in self.spaces.items():
            inside = {self.hosts[n] for n in names}
            others = ", ".join(sorted(set(self.hosts.values()) - inside
                                      if name in names else inside))
            self.filter(space, f"ip saddr {{ {others} }} drop"
                        if names and others else None)

    def filter(self, space, rule):
        script = "add table inet t; delete table inet t; "
        if rule:
            script += ("add table inet t; add chain inet t i { type filter hook "
                       f"input priority 0; }}; add rule inet t i {rule}")
        self.within(space, "nft", script)

    def close(self):
        ip("link", "del", self.end, check=False)
        for space in [*self.spaces.values(), self.hub]:
            ip("netns", "del", space, check=False)


class Machine:
    """A daemon in a namespace, spoken to by its Unix socket."""

    def __init__(self, net, name, url, folder, fps=60):
        self.net, self.name, self.url, self.fps = net, name, url, fps
        self.folder = folder
        self.socket = os.path.join(folder, f"{name}.sock")
        self.log_path = os.path.join(folder, f"{name}.log")
        self.process = None

    def start(self):
        with contextlib.suppress(OSError):
            os.unlink(self.socket)
        with open(self.log_path, "ab") as log:
            self.process = subprocess.Popen(
                self.net.prefix(self.name) + [
                    os.path.join(BIN, "pelagosd"), "--http", "off", "--tcp",
                    "off", "--rtsp", "off", "--modbus", "off", "--nmea", "off",
                    "--unix", self.socket, "--device", "software",
                    "--encoder-threads", "1", "--realtime", "off",
                    "--fps", str(self.fps), "--quality", "full",
                    "--exercise", self.url, "--exercise-node", self.name,
                    "--exercise-address", self.net.hosts[self.name]],
                stdout=log, stderr=log, stdin=subprocess.DEVNULL)

    def session(self, timeout=10):
        s = socket.socket(socket.AF_UNIX)
        s.settimeout(timeout)
        s.connect(self.socket)
        return Session(s)

    def cluster(self):
        with self.session(3) as s:
            return s.ask(cluster={}).cluster

    def has_role(self, *roles):
        pb = schema()
        with contextlib.suppress(OSError, AttributeError):
            return pb.ClusterRole.Name(self.cluster().role) in roles
        return False

    def alive(self):
        return self.process is not None and self.process.poll() is None

    def kill(self):
        self.process.kill()
        self.process.wait()

    def log(self):
        with open(self.log_path, errors="replace") as f:
            return f.read()


def members(net, names):
    return [Member(n, net.hosts[n], 2379, 2380, None, net.prefix(n))
            for n in names]


def folder():
    return tempfile.mkdtemp(prefix="pelagos-cluster-")


def await_part(machine, seconds=60):
    until(f"{machine.name} takes part",
          lambda: machine.has_role("MASTER", "FOLLOWER"), seconds)


def now():
    return time.monotonic()
