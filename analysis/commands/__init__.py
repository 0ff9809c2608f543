"""The subcommands of `analysis`, one file each, named by `analysis.cli.COMMANDS`.

Each file has a function `add`, which adds the command to the command line and sets `command`: the function that takes
the parsed arguments, writes the picture and its CSV, and returns the lines to print.
"""
