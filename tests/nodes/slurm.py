"""SLURM on the simulated machines: munged on each, slurmctld on head, slurmd on the nodes."""

import time
from pathlib import Path

from ..slurm import CONF, SYSTEM
from ..slurm import why_not as why_no_slurm  # noqa: F401
from .machines import Machine

CPUS = 2  # of each node
START_LIMIT = 60.0  # seconds


def start_slurm(folder: Path, machines: dict[str, Machine]) -> None:
    """Start the daemons; AssertionError where the nodes are not idle in time."""
    (folder / "state").mkdir()
    (folder / "slurm.conf").write_text(_conf(folder, machines))
    environment = {"PATH": SYSTEM, "SLURM_CONF": str(folder / "slurm.conf")}
    for machine in machines.values():
        start_daemons(folder, machine)
    until = time.monotonic() + START_LIMIT
    head, asked = machines["head"], ("sinfo", "-h", "-N", "-o", "%T")
    while (told := head.on(*asked, env=environment).stdout.split()) != ["idle"] * (len(machines) - 1):
        assert time.monotonic() < until, f"{told}: {_logs(folder)}"
        time.sleep(0.1)


def start_daemons(folder: Path, machine: Machine) -> None:
    """What a machine starts of SLURM when it boots."""
    own = folder / machine.name
    environment = {"PATH": SYSTEM, "SLURM_CONF": str(folder / "slurm.conf")}
    log = (own / "daemons").open("ab")
    how = {"env": environment, "stdout": log, "stderr": log}
    (own / "spool").mkdir(exist_ok=True)
    places = {"key-file": folder / "munge.key", "socket": "/run/munge.socket"}
    places |= {f"{kind}-file": f"/run/munge.{kind}" for kind in ("pid", "log", "seed")}
    machine.start("munged", "--foreground", "--force", *(f"--{name}={place}" for name, place in places.items()), **how)
    until = time.monotonic() + START_LIMIT
    while machine.on("test", "-S", "/run/munge.socket").returncode:
        assert time.monotonic() < until, _logs(folder)
        time.sleep(0.1)
    if machine.name == "head":
        machine.start("slurmctld", "-D", "-c", **how)
    else:
        machine.start("slurmd", "-D", "-N", machine.name, **how)
    log.close()


def _conf(folder: Path, machines: dict[str, Machine]) -> str:
    """That of the SLURM of one node, with other machines."""
    text = CONF.format(folder=folder, ports=(6817, 6818), cpus=CPUS, user="root")
    replaced = {
        "SlurmctldHost": f"head({machines['head'].address})",
        "AuthInfo": "socket=/run/munge.socket,cred_expire=10",
        "SlurmdPidFile": "/run/slurmd.pid",
        "SlurmctldPidFile": "/run/slurmctld.pid",
        "SlurmdSpoolDir": f"{folder}/%n/spool",
        "SlurmdLogFile": f"{folder}/%n/slurmd.log",
    }
    lines = [line for line in text.splitlines() if not line.startswith(("NodeName", "PartitionName"))]
    for i, line in enumerate(lines):
        if (name := line.partition("=")[0]) in replaced:
            lines[i] = f"{name}={replaced[name]}"
    nodes = [name for name in machines if name != "head"]
    lines += ["SlurmdTimeout=30"]
    size = f"CPUs={CPUS} Sockets=1 CoresPerSocket={CPUS} ThreadsPerCore=1 RealMemory=1000"
    lines += [f"NodeName={name} NodeHostname={name} NodeAddr={machines[name].address} {size}" for name in nodes]
    lines += [f"PartitionName=test Nodes={','.join(nodes)} Default=YES MaxTime=1-00 State=UP"]
    return "\n".join(lines) + "\n"


def _logs(folder: Path) -> str:
    files = sorted([*folder.glob("*.log"), *folder.glob("*/*.log"), *folder.glob("*/daemons")])
    return "\n".join(f"{file.name}: ...{file.read_text(errors='replace')[-3000:]}" for file in files)
