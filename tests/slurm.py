"""A real SLURM of one node on this machine: munged, slurmctld and slurmd, with everything in one folder of its own."""

import os
import pwd
import re
import secrets
import shutil
import socket
import subprocess
import time
from pathlib import Path

DAEMONS = ("munged", "slurmctld", "slurmd")
COMMANDS = ("sbatch", "squeue", "scancel", "scontrol", "salloc", "sinfo", "srun", "setpriv")
SYSTEM = "/usr/sbin:/usr/bin:/sbin:/bin"
START_LIMIT = 60.0  # seconds
CPUS = 4  # whatever the machine has

CONF = """
ClusterName=test
SlurmctldHost=localhost(127.0.0.1)
SlurmUser={user}
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=10
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
JobRequeue=1
KillWait=5
MinJobAge=300
ReturnToService=2
SlurmdParameters=config_overrides
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
SchedulerParameters=batch_sched_delay=0,bf_interval=1,sched_interval=1,sched_min_interval=0
NodeName=localhost NodeAddr=127.0.0.1 CPUs={cpus} Sockets=1 CoresPerSocket={cpus} ThreadsPerCore=1 RealMemory=1000
PartitionName=test Nodes=localhost Default=YES MaxTime=1-00 State=UP
"""


def why_not() -> str:
    """Why there can be no SLURM here; empty where there can."""
    if os.getuid() != 0:
        return "starting SLURM's daemons needs root"
    missing = [name for name in (*DAEMONS, *COMMANDS) if shutil.which(name, path=SYSTEM) is None]
    return f"{', '.join(missing)} not installed: apt-get install slurm-wlm munge" if missing else ""


class Cluster:
    """Running from `start` to `stop`."""

    def __init__(self, folder: Path) -> None:
        """`folder`: empty, with a short path (sockets), not writable by others (munge)."""
        self.folder = folder
        self._daemons: list[subprocess.Popen[bytes]] = []

    def start(self) -> None:
        """Start the daemons; AssertionError with their logs where the node is not idle in time."""
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        key = self.folder / "munge.key"
        key.write_bytes(secrets.token_bytes(128))
        key.chmod(0o400)
        with socket.socket() as one, socket.socket() as two:
            ports = [(sock.bind(("127.0.0.1", 0)), sock.getsockname()[1])[1] for sock in (one, two)]
        user = pwd.getpwuid(os.getuid()).pw_name
        self.conf.write_text(CONF.format(folder=self.folder, ports=ports, cpus=CPUS, user=user))
        kinds = {"key-file": "key", "pid-file": "pid", "log-file": "log", "seed-file": "seed", "socket": "socket"}
        places = [f"--{option}={self.folder}/munge.{kind}" for option, kind in kinds.items()]
        self._daemon("munged", "--foreground", "--force", *places)
        self._until(lambda: (self.folder / "munge.socket").exists())
        self._daemon("slurmctld", "-D", "-c", "-f", str(self.conf))
        self._daemon("slurmd", "-D", "-f", str(self.conf), "-N", "localhost")
        self._until(lambda: "State=IDLE" in self.command("scontrol", "show", "node", check=False))

    @property
    def conf(self) -> Path:
        """What SLURM_CONF must name."""
        return self.folder / "slurm.conf"

    def _daemon(self, *command: str) -> None:
        dying = ["setpriv", "--pdeathsig", "KILL"]  # with the tests, however they end
        log = (self.folder / f"{command[0]}.out").open("wb")
        environment = {"PATH": SYSTEM, "SLURM_CONF": str(self.conf)}
        self._daemons.append(subprocess.Popen([*dying, *command], stdout=log, stderr=log, env=environment))
        log.close()

    def _until(self, ready) -> None:
        until = time.monotonic() + START_LIMIT
        while not ready():
            ended = [str(daemon.args) for daemon in self._daemons if daemon.poll() is not None]
            assert not ended and time.monotonic() < until, f"{ended or 'too slow'}:\n{self.logs()}"
            time.sleep(0.1)

    def logs(self) -> str:
        """The last that each daemon said."""
        files = sorted([*self.folder.glob("*.log"), *self.folder.glob("*.out")])
        return "\n".join(f"{file.name}: ...{file.read_text(errors='replace')[-4000:]}" for file in files)

    def command(self, *command: str, check: bool = True) -> str:
        """What one of SLURM's commands prints."""
        environment = {"PATH": SYSTEM, "SLURM_CONF": str(self.conf)}
        answer = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=False)
        assert answer.returncode == 0 or not check, f"{command}: {answer.stderr}"
        return answer.stdout

    def job(self, job: str) -> dict[str, str]:
        """What SLURM knows of a job or of one task of an array."""
        return dict(re.findall(r"(\w+)=(\S+)", self.command("scontrol", "show", "job", job)))

    def stop(self) -> None:
        """End every job, then the daemons, and remove the folder."""
        if len(self._daemons) == len(DAEMONS):
            jobs = self.command("squeue", "-h", "-r", "-o", "%i", check=False).split()
            for job in jobs:
                self.command("scancel", "--signal=KILL", "--full", job, check=False)
                self.command("scancel", job, check=False)
            until = time.monotonic() + 20
            while self.command("squeue", "-h", check=False) and time.monotonic() < until:
                time.sleep(0.2)
        for daemon in reversed(self._daemons):
            daemon.terminate()
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        shutil.rmtree(self.folder, ignore_errors=True)
