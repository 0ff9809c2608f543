"""The schedulers that the sweep knows. Another one is a file beside `slurm.py` and its name in `ALL`."""

import shutil
from collections.abc import Mapping

from sweep.site.hosts import Hosts
from sweep.site.lsf import Lsf
from sweep.site.pbs import Pbs
from sweep.site.scheduler import Scheduler
from sweep.site.slurm import Slurm

ALL: tuple[Scheduler, ...] = (Slurm(), Pbs(), Lsf(), Hosts())
AUTO = "auto"  # the choice of the scheduler whose command is there


def names() -> str:
    """For people."""
    return " or ".join(each.name for each in ALL)


def chosen(name: str = AUTO) -> Scheduler:
    """The scheduler of that name; by default one whose command is there, else the first."""
    if name != AUTO:
        return next(each for each in ALL if each.name == name)
    return next((each for each in ALL if each.automatic and shutil.which(each.command)), ALL[0])


def job(environment: Mapping[str, str]) -> str:
    """The job that this process belongs to, for the table's list of runs; empty outside of any."""
    return next((text for each in ALL if (text := each.job(environment))), "")


def end(environment: Mapping[str, str]) -> float | None:
    """When a scheduler ends this process's job, in seconds since 1970; None where none does."""
    return next((instant for each in ALL if (instant := each.end(environment)) is not None), None)
