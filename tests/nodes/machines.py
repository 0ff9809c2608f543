"""Machines with a name, processes and a network of their own, joined by a switch: one tree of processes each.

Whatever a machine has (mounts, network devices, shared memory) belongs to its namespaces, and goes with its processes.
"""

import contextlib
import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

NETWORK = "10.77.0"  # addresses of the machines; seen by nobody else
BOOT = """
set -e
mount --make-rprivate /
hostname {name}
mount -t tmpfs tmpfs /run
mount -t tmpfs tmpfs /dev/shm
mkdir -m 0755 /run/sshd
mount --bind {own}/tmp /tmp
mount --bind {folder}/hosts /etc/hosts
[ ! -d /var/log/glusterfs ] || mount --bind {own}/log /var/log/glusterfs
ip link set lo up
echo up > {own}/up
while :; do sleep infinity & wait $!; done  # process 1 must bury the dead, as daemons look for the living
"""
WAIT = 60.0  # seconds for a machine to start


def why_not() -> str:
    """Why there can be no simulated machines here; empty where there can."""
    if os.getuid() != 0:
        return "simulated machines need root"
    if missing := [name for name in ("ip", "unshare", "nsenter", "setpriv") if shutil.which(name) is None]:
        return f"{', '.join(missing)} not installed: apt-get install iproute2 util-linux"
    tried = subprocess.run(["unshare", "-n", "-m", "-u", "-i", "-p", "-f", "true"], capture_output=True, check=False)
    return f"no namespaces: {tried.stderr.decode().strip()}" if tried.returncode else ""


def quick(*command: object, timeout: float = 60.0) -> str:
    """What a command prints; CalledProcessError where it fails."""
    words = [str(word) for word in command]
    return subprocess.run(words, check=True, capture_output=True, text=True, timeout=timeout).stdout


class Switch:
    """What the machines are plugged into."""

    def __init__(self) -> None:
        self._process = _started("unshare", "-n", "sleep", "infinity")
        until = time.monotonic() + WAIT
        while _network_of(self._process.pid) == _network_of(os.getpid()):
            assert time.monotonic() < until, "no network namespace"
            time.sleep(0.01)
        self.do("ip", "link", "add", "bridge", "type", "bridge")
        self.do("ip", "link", "set", "bridge", "up")

    def do(self, *command: str) -> None:
        """Run a command in the switch's network."""
        quick("nsenter", "-t", self._process.pid, "-n", *command)

    def plug(self, port: str, pid: int, number: int) -> None:
        """Join the network of process `pid` to this one, as a machine with that last number of the address."""
        self.do(*["ip", "link", "add"], port, *["type", "veth", "peer", "name", "eth0", "netns"], str(pid))
        self.do("ip", "link", "set", port, "master", "bridge", "up")
        quick("nsenter", "-t", pid, "-n", *f"ip address add {NETWORK}.{number}/24 dev eth0".split())
        quick("nsenter", "-t", pid, "-n", *["ip", "link", "set", "eth0", "up"])

    def unplug(self) -> None:
        """End the switch."""
        self._process.kill()
        self._process.wait()


class Machine:
    """One machine, from `boot` to `power_off`, any number of times."""

    def __init__(self, name: str, number: int, folder: Path, switch: Switch) -> None:
        """`folder`: of all machines; it holds `hosts`, and what is each machine's own."""
        self.name, self._number, self._folder, self._switch = name, number, folder, switch
        self._own, self._top, self._pid = folder / name, None, 0
        self._started: list[subprocess.Popen[str]] = []
        for name in ("tmp", "log"):
            (self._own / name).mkdir(parents=True)

    def boot(self) -> None:
        """Start it."""
        (self._own / "up").unlink(missing_ok=True)
        script = BOOT.format(name=self.name, own=self._own, folder=self._folder)
        kinds = ("-u", "-m", "-i", "-n", "-p", "-f", "--mount-proc", "--kill-child=KILL")
        self._top = _started("unshare", *kinds, "bash", "-c", script)
        until = time.monotonic() + WAIT
        while not (self._own / "up").exists():
            assert self._top.poll() is None and time.monotonic() < until, f"{self.name} does not start"
            time.sleep(0.01)
        self._pid = int(Path(f"/proc/{self._top.pid}/task/{self._top.pid}/children").read_text().split()[0])
        self._switch.plug(self.name, self._pid, self._number)

    @property
    def is_on(self) -> bool:
        """Whether it runs."""
        return self._top is not None

    @property
    def address(self) -> str:
        """In the network."""
        return f"{NETWORK}.{self._number}"

    def command(self, *command: object) -> list[str]:
        """A command line that runs a command on this machine."""
        return ["nsenter", "-t", str(self._pid), "-a", "--wd=/", *map(str, command)]

    def on(self, *command: object, timeout: float = 60.0, **how) -> "subprocess.CompletedProcess[str]":
        """Run a command on this machine to its end."""
        how = {"capture_output": True, "text": True, "stdin": subprocess.DEVNULL, "check": False} | how
        return subprocess.run(self.command(*command), timeout=timeout, **how)

    def start(self, *command: object, **how) -> "subprocess.Popen[str]":
        """Start a command on this machine; it dies with the caller, and with the machine."""
        process = subprocess.Popen(["setpriv", "--pdeathsig", "KILL", *self.command(*command)], text=True, **how)
        self._started.append(process)
        return process

    def cut(self) -> None:
        """Pull its cable."""
        self._switch.do("ip", "link", "set", self.name, "down")

    def mend(self) -> None:
        """Plug its cable in."""
        self._switch.do("ip", "link", "set", self.name, "up")

    def power_off(self) -> None:
        """Switch it off, without a last word on the network."""
        if self._top is None:
            return
        self.cut()
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._pid, signal.SIGKILL)  # process 1: the others of its namespace die with it
        self._top.wait(WAIT)
        self._top = None
        for process in self._started:
            process.wait(WAIT)
        self._started.clear()
        with contextlib.suppress(subprocess.CalledProcessError):  # it has gone with the network of its other end
            self._switch.do("ip", "link", "delete", self.name)


def _network_of(pid: int) -> str:
    return str(Path(f"/proc/{pid}/ns/net").readlink())


def _started(*command: str) -> "subprocess.Popen[bytes]":
    """A process that dies with this one."""
    quiet = subprocess.DEVNULL
    return subprocess.Popen(["setpriv", "--pdeathsig", "KILL", *command], stdin=quiet, stdout=quiet, stderr=quiet)
