"""node1, node2 and head: the nodes compute, head has the disk that all share (Gluster) and SLURM's controller."""

import secrets
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

from .machines import Machine, Switch, quick
from .machines import why_not as why_no_machines
from .slurm import start_slurm, why_no_slurm

NODES = ("node1", "node2")
WAIT = 60.0  # seconds for each daemon
SSHD = """
Port 22
HostKey {folder}/key
AuthorizedKeysFile {folder}/key.pub
StrictModes no
UsePAM no
PermitRootLogin yes
"""
SSH = """
Host *
StrictHostKeyChecking no
UserKnownHostsFile /dev/null
IdentityFile {folder}/key
LogLevel ERROR
ConnectTimeout 10
"""
# Gluster's daemon starts Python sixteen times (the one that PYTHON names; if it cannot, it ends), for copies to other
# sites, which nobody asks for here. Without that part it answers in a third of a second.
HIDE_GEO_REPLICATION = """
cd /usr/lib/*/glusterfs
mkdir /run/glusterfs
mount --bind . /run/glusterfs
mount -t tmpfs tmpfs "$PWD"
ln -s /run/glusterfs/[0-9]* "$PWD"
"""
GLUSTER = "apt-get install glusterfs-server glusterfs-client"


def why_not() -> str:
    """Why there can be no such cluster here; empty where there can."""
    if why := why_no_machines():
        return why
    if not Path("/dev/fuse").exists():
        return "no /dev/fuse"
    names = ("glusterd", "glusterfs", "gluster", "mount.glusterfs")
    if missing := [name for name in names if shutil.which(name, path="/usr/sbin:/usr/bin:/sbin") is None]:
        return f"{', '.join(missing)} not installed: {GLUSTER}"
    return why_no_slurm()


class Cluster:
    """Runs from `start` to `close`; `work` is the folder that the nodes share, `brick` where its files really lie."""

    def __init__(self) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="nodes-", dir="/var/tmp"))  # /tmp is each machine's own
        self.folder.chmod(0o755)
        self.work, self.brick = self.folder / "work", self.folder / "brick"
        for folder in (self.work, self.brick):
            folder.mkdir()
        self.switch = Switch()
        self.machines = {
            name: Machine(name, number, self.folder, self.switch) for number, name in enumerate((*NODES, "head"), 1)
        }
        self.node1, self.node2, self.head = self.machines.values()
        lines = [f"{machine.address} {name}" for name, machine in self.machines.items()]
        (self.folder / "hosts").write_text("127.0.0.1 localhost\n" + "\n".join(lines) + "\n")
        (self.folder / "munge.key").write_bytes(secrets.token_bytes(128))
        (self.folder / "munge.key").chmod(0o400)

    def start(self, slurm: bool = True) -> None:
        """Start machines, disk and daemons."""
        if shutil.which("sshd", path="/usr/sbin"):
            quick("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", self.folder / "key")
            (self.folder / "sshd.conf").write_text(SSHD.format(folder=self.folder))
            (self.folder / "ssh.conf").write_text(SSH.format(folder=self.folder))
            self.ssh.write_text(f'#!/bin/sh\nexec ssh -F {self.folder}/ssh.conf "$@"\n')
            self.ssh.chmod(0o755)
        for machine in self.machines.values():
            machine.boot()
        self._storage()
        for name in NODES:
            self.bring_up(self.machines[name])
        if slurm:
            start_slurm(self.folder, self.machines)

    @property
    def ssh(self) -> Path:
        """The command that reaches one node from another, without questions."""
        return self.folder / "ssh"

    def bring_up(self, node: Machine) -> None:
        """What a node starts when it boots: the shared folder, and a server for ssh."""
        self.mount(node)
        if (self.folder / "sshd.conf").exists():
            node.on("/usr/sbin/sshd", "-f", self.folder / "sshd.conf", check=True)

    def _storage(self) -> None:
        self.head.on("sh", "-ec", HIDE_GEO_REPLICATION, check=True)
        own = self.folder / "gluster"
        own.mkdir()
        with (own / "out").open("wb") as log:
            self.head.start("glusterd", "-N", "--xlator-option", f"*.working-directory={own}", stdout=log, stderr=log)
        logs = own / "out", self.folder / "head" / "log" / "glusterd.log"
        until(lambda: self._gluster("volume", "list", check=False).returncode == 0, "glusterd", *logs)
        self._gluster("volume", "create", "vol", f"head:{self.brick}", "force")
        self._gluster("volume", "start", "vol")

    def _gluster(self, *words: str, check: bool = True) -> "subprocess.CompletedProcess[str]":
        return self.head.on("gluster", "--mode=script", *words, check=check)

    def mount(self, node: Machine) -> None:
        """Mount the shared folder on a node."""
        log = self.folder / node.name / "mount.log"
        until(
            lambda: (
                node.on("mount", "-t", "glusterfs", "-o", f"log-file={log}", "head:/vol", self.work).returncode == 0
                and node.on("mountpoint", "-q", self.work).returncode == 0
            ),
            f"mount on {node.name}",
        )

    def kill_brick(self) -> None:
        """The process that serves the disk dies."""
        self.head.on("pkill", "-KILL", "-x", "glusterfsd")

    def revive_brick(self) -> None:
        """And is there again."""
        self._gluster("volume", "start", "vol", "force")

    def close(self) -> None:
        """Switch everything off and remove every trace."""
        for machine in self.machines.values():
            machine.power_off()
        self.switch.unplug()
        shutil.rmtree(self.folder, ignore_errors=True)


def until(ready, what: str, *logs: Path) -> None:
    """Wait for it; where it does not come, its logs' last lines say why."""
    end = time.monotonic() + WAIT
    while not ready():
        assert time.monotonic() < end, "\n".join([f"{what}: too slow", *(_end_of(log) for log in logs)])
        time.sleep(0.1)


def _end_of(log: Path) -> str:
    lines = log.read_text(errors="replace").splitlines() if log.exists() else ["no such file"]
    return "\n".join([f"{log}:", *lines[-40:]])
