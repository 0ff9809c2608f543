"""The subcommands of `analysis`, one file each, named by `analysis.cli.COMMANDS`.

`add` puts one into the grammar and sets `command`, which takes the parsed arguments, writes picture and CSV where there
is one, and returns the lines to print.
"""
