"""`python -m analysis` in a folder that holds a kernel.py, a sweep.py or a random.py of the user's.

Python looks there before it looks into its libraries, and `python -m` imports the package before its `__main__` could
forbid it. While it does, `sys.argv` begins with "-m". Only a user's own analysis.py cannot be helped from here: it is
run instead. The script `analysis` is safe from that too.
"""

import os
import sys

if sys.argv[:1] == ["-m"] and "analysis" in sys.orig_argv and sys.path[:1] in ([""], [os.getcwd()]):  # noqa: PTH109
    del sys.path[0]
