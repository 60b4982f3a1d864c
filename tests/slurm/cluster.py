"""A Slurm cluster of one node on this machine, for as long as a test needs it.

Munge, slurmctld and slurmd of Debian run with a configuration, keys, sockets and ports of their own, in a
folder of their own, without systemd and without control groups: so it works in a container too. It takes
root, as slurmd does.
"""

import contextlib
import os
import shutil
import socket
import subprocess
import time
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "srun", "scontrol", "squeue", "scancel")
CONFIGURATION = """\
ClusterName=test
SlurmctldHost=localhost(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_interval=1
ReturnToService=2
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
KillWait=5
MailProg=/bin/true
NodeName=localhost NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=main Nodes=localhost Default=YES MaxTime=INFINITE State=UP OverSubscribe=YES:4
"""
SECONDS = 60


def missing():
    """Why there can be no cluster here; empty if there can."""
    path = os.environ["PATH"] + ":/usr/sbin:/sbin"
    absent = [program for program in PROGRAMS if not shutil.which(program, path=path)]
    if absent:
        return "Slurm is not installed: " + " ".join(absent)
    return "" if os.geteuid() == 0 else "slurmd needs root"


def free_ports(count):
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]


class Cluster:
    """A running cluster; `environment` makes Slurm's commands speak to it."""

    def __init__(self, folder, cpus=2):
        self.folder = Path(folder)
        self.daemons = []
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        (self.folder / "slurm.conf").write_text(
            CONFIGURATION.format(folder=self.folder, ports=free_ports(2), cpus=cpus)
        )
        self.environment = dict(
            os.environ,
            SLURM_CONF=str(self.folder / "slurm.conf"),
            PATH=os.environ["PATH"] + ":/usr/sbin:/sbin",
        )
        # A cluster that this test runs in is none of its business.
        for name in [name for name in self.environment if name.startswith(("SLURM_", "SBATCH_", "PMI"))]:
            if name != "SLURM_CONF":
                del self.environment[name]

    def __enter__(self):
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def start(self):
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        self.folder.chmod(0o755)
        munge = self.folder / "munge.socket"
        self.daemon(
            "munged",
            "--foreground",
            "--force",
            f"--socket={munge}",
            f"--key-file={key}",
            f"--pid-file={self.folder}/munged.pid",
            f"--log-file={self.folder}/munged.log",
            f"--seed-file={self.folder}/munged.seed",
            "--num-threads=2",
        )
        self.wait_for(munge.exists, "munged")
        self.daemon("slurmctld", "-D", "-c")
        self.daemon("slurmd", "-D", "-c", "-N", "localhost")
        self.wait_for(
            lambda: "idle" in self.run("sinfo", "--noheader", "--format=%t", check=False), "the node"
        )

    def daemon(self, *command):
        log = open(self.folder / f"{command[0]}.out", "wb")
        self.daemons.append(
            subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL, env=self.environment)
        )
        log.close()

    def stop(self):
        if len(self.daemons) > 1:
            self.run("scancel", "--user=root", check=False)
            with contextlib.suppress(AssertionError):
                self.wait_for(
                    lambda: not self.run("squeue", "--noheader", check=False).strip(), "the queue", 15
                )
        for daemon in reversed(self.daemons):
            daemon.terminate()
        for daemon in self.daemons:
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        self.daemons = []

    def run(self, *command, check=True, **options):
        """A command's standard output."""
        done = subprocess.run(
            list(map(str, command)),
            env={**self.environment, **options.pop("env", {})},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=SECONDS,
            text=True,
            **options,
        )
        assert not check or done.returncode == 0, f"{command}: status {done.returncode}\n{done.stdout}"
        return done.stdout

    def wait_for(self, condition, what, seconds=SECONDS):
        """Until the condition holds; what the daemons said goes with a failure."""
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, f"waited in vain for {what}\n{self.logs()}"
            time.sleep(0.1)

    def logs(self):
        texts = []
        for path in sorted(self.folder.glob("*.log")) + sorted(self.folder.glob("*.out")):
            texts.append(f"--- {path.name}\n" + path.read_text(errors="replace")[-3000:])
        return "\n".join(texts)

    def job(self, number, field):
        """A field of `scontrol show job`."""
        for word in self.run("scontrol", "--oneliner", "show", "job", number, check=False).split():
            if word.startswith(field + "="):
                return word[len(field) + 1 :]
        return ""

    def state(self, number):
        return self.job(number, "JobState")
