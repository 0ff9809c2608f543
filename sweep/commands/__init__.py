"""The subcommands of `sweep`, one file each: `add` puts it into the grammar and sets `command`, what it does."""

from sweep.commands import audit, doctor, plan, run, show, status

ALL = (plan, run, status, show, audit, doctor)  # in the order of the help
