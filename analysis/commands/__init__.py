"""The subcommands of `python -m analysis`, one file each: `add` puts it into the grammar and sets `command`.

`command` takes the parsed arguments, writes picture and CSV, and returns the lines to print.
"""

from analysis.commands import atlas, best, collapse, paper, plane, tradeoff, transition

ALL = (best, plane, transition, collapse, tradeoff, atlas, paper)  # in the order of the help
