"""The subcommands of `python -m analysis`, one file each: `add` puts it into the grammar and sets `command`.

`command` takes the parsed arguments, writes picture and CSV, and returns the lines to print.
"""

from analysis.commands import atlas, best, plane, tradeoff

ALL = (best, plane, tradeoff, atlas)  # in the order of the help
