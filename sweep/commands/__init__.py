"""The subcommands of `sweep`, one file each: `add` puts it into the grammar and sets `command`, what it does.

The first of several ranks does it alone, unless the command sets `on_all_ranks`.
"""

from sweep.commands import audit, doctor, export, join, merge, plan, run, show, status, submit

ALL = (plan, submit, run, join, status, show, audit, merge, export, doctor)  # in the order of the help
