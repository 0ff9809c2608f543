"""The subcommands of `sweep`, one file each: `add` puts it into the grammar and sets `command`, what it does."""

from sweep.commands import audit, plan, run, show, status

ALL = (plan, run, status, show, audit)  # in the order of the help
