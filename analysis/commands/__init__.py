"""The subcommands of `analysis`, one file each: `add` puts it into the grammar and sets `command`.

`command` takes the parsed arguments, writes picture and CSV where there is one, and returns the lines to print.
"""

from analysis.commands import atlas, best, collapse, findings, paper, plane, tradeoff, transition

ALL = (best, plane, transition, collapse, findings, tradeoff, atlas, paper)  # in the order of the help
