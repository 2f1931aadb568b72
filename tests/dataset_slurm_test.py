#!/usr/bin/python3
"""A data set by Slurm itself: slurmctld, slurmd and munged of Debian, one node
on this machine, with ports and folders of the test's own. A task is killed and
requeued, and the set has the bits of one that was drawn without Slurm."""
import getpass
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from pelagos_daemon import BIN, free_port, until

PROGRAMS = ["slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "munged"]
PLAN = {"name": "queued", "frames": 12, "shard": 3, "width": 48, "height": 32,
        "labels": False, "layers": [], "picture": "png",
        "state": {"sea": {"synthesiser": "TROCHOIDS"},
                  "views": [{"name": "eye", "up": 8}]},
        "ranges": {"sky.sunElevation": {"uniform": [10, 60]}}}
CONF = """
ClusterName=test
SlurmctldHost=localhost
SlurmctldPort={control}
SlurmdPort={node}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
SlurmdParameters=config_overrides
SchedulerParameters=batch_sched_delay=0
KillWait=2
NodeName=localhost CPUs=2 RealMemory=1000 State=UNKNOWN
PartitionName=all Nodes=localhost Default=YES MaxTime=INFINITE State=UP
"""


def ctl(*words, status=0, **more):
    done = subprocess.run([os.path.join(BIN, "pelagosctl"), "dataset", *words],
                          capture_output=True, text=True, **more)
    if done.returncode != status:
        raise AssertionError(f"{words}: {done.returncode}\n{done.stdout}"
                             f"{done.stderr}")
    return done.stdout


class Script(unittest.TestCase):
    def test_what_is_submitted(self):
        """Without Slurm: the script, and what a task of it does."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "plan.json")
            pathlib.Path(path).write_text(json.dumps(PLAN))
            out = os.path.join(folder, "out")
            text = ctl("run", path, "-o", out, "--slurm", "print",
                       "--no-estimate", "--threads", "3", "--tasks", "2",
                       "--sbatch=--partition=cpu", "--sbatch=--mem=2G")
            self.assertFalse(os.path.exists(out))
            for line in ("#!/bin/sh", "#SBATCH --array=0-1",
                         "#SBATCH --requeue", "#SBATCH --cpus-per-task=3",
                         "#SBATCH --partition=cpu", "#SBATCH --mem=2G"):
                self.assertIn(line, text.splitlines())
            done = subprocess.run(["sh", "-n"], input=text, text=True)
            self.assertEqual(done.returncode, 0)
            empty = {"PATH": "/nowhere"}
            done = subprocess.run(
                [os.path.join(BIN, "pelagosctl"), "dataset", "run", path, "-o",
                 out, "--slurm", "submit", "--no-estimate"],
                capture_output=True, text=True, env=empty)
            self.assertEqual(done.returncode, 1)
            self.assertIn("sbatch is not here", done.stderr)


class Slurm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        missing = [p for p in PROGRAMS if not shutil.which(
            p, path=os.environ["PATH"] + ":/usr/sbin")]
        if missing:
            raise unittest.SkipTest(", ".join(missing) + " of slurm-wlm and "
                                    "munge are not installed: make deps")
        if os.geteuid():
            raise unittest.SkipTest("slurmd runs as root alone")
        cls.folder = tempfile.mkdtemp(prefix="pelagos-test-")
        cls.addClassCleanup(shutil.rmtree, cls.folder, True)
        cls.services = []
        cls.addClassCleanup(cls.stop)
        for name in ("state", "spool"):
            os.mkdir(os.path.join(cls.folder, name))
        key = os.path.join(cls.folder, "key")
        with open(os.open(key, os.O_CREAT | os.O_WRONLY, 0o400), "wb") as f:
            f.write(os.urandom(1024))
        conf = os.path.join(cls.folder, "slurm.conf")
        pathlib.Path(conf).write_text(CONF.format(
            folder=cls.folder, user=getpass.getuser(), control=free_port(),
            node=free_port()))
        os.environ["SLURM_CONF"] = conf
        cls.start("munged", "--foreground", "--force", f"--key-file={key}",
                  *(f"--{what}-file={cls.folder}/munge.{what}"
                    for what in ("pid", "seed", "log")),
                  f"--socket={cls.folder}/munge.socket")
        until("munged listens", lambda: os.path.exists(
            os.path.join(cls.folder, "munge.socket")))
        cls.start("slurmctld", "-D", "-f", conf)
        cls.start("slurmd", "-D", "-f", conf, "-N", "localhost")
        until("the node is idle", lambda: "IDLE" in cls.slurm(
            "scontrol", "show", "node", "localhost"), 60, 0.2)

    @classmethod
    def start(cls, name, *words):
        log = open(os.path.join(cls.folder, name + ".out"), "wb")
        cls.services.append(subprocess.Popen(
            [shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin"),
             *words], stdout=log, stderr=log, stdin=subprocess.DEVNULL))
        log.close()

    @classmethod
    def stop(cls):
        for service in reversed(cls.services):
            service.terminate()
            try:
                service.wait(20)
            except subprocess.TimeoutExpired:
                service.kill()
                service.wait()

    @classmethod
    def slurm(cls, *words):
        return subprocess.run(words, capture_output=True, text=True).stdout

    def test_a_set(self):
        path = os.path.join(self.folder, "plan.json")
        pathlib.Path(path).write_text(json.dumps(PLAN))
        calm = os.path.join(self.folder, "calm")
        ctl("run", path, "-o", calm, "--workers", "1", "--no-estimate")
        out = os.path.join(self.folder, "out")
        said = json.loads(ctl("run", path, "-o", out, "--slurm", "submit",
                              "--no-estimate", "--threads", "1", "--json"))
        self.assertEqual(said["tasks"], 4)
        # One task comes to its end by the scheduler, and is put back.
        until("a task runs", lambda: "R" in self.slurm(
            "squeue", "-h", "-o", "%t", "-j", said["job"]).split())
        self.slurm("scontrol", "requeue", f"{said['job']}_0")
        began = time.monotonic()
        while not os.path.exists(os.path.join(out, "README.md")):
            left = self.slurm("squeue", "-h", "-o", "%i %t %r")
            # What waits for its turn again waits up to two minutes.
            self.slurm("scontrol", "update", f"JobId={said['job']}_0",
                       "StartTime=now")
            if time.monotonic() - began > 240:
                logs = "".join(p.read_text() for p in pathlib.Path(
                    out).glob("slurm-*.log"))
                self.fail(f"not merged: {left}\n{logs}")
            time.sleep(0.3)
        for name in sorted(os.listdir(os.path.join(calm, "shards"))):
            one, other = (pathlib.Path(f, "shards", name).read_bytes()
                          for f in (calm, out))
            self.assertEqual(one, other, name)
        self.assertEqual(pathlib.Path(calm, "SHA256SUMS").read_bytes(),
                         pathlib.Path(out, "SHA256SUMS").read_bytes())


if __name__ == "__main__":
    unittest.main()
