"""`python -m analysis` in a folder that holds a kernel.py, a sweep.py or a random.py of the user's.

Python looks for modules in the current folder first, and `python -m` imports this package before its `__main__` could
forbid that. Meanwhile `sys.argv` begins with "-m", by which this file knows the case and takes the folder off the path.
An analysis.py of the user's is run in place of this package; only the script `analysis` is safe from that.
"""

import os
import sys

if sys.argv[:1] == ["-m"] and "analysis" in sys.orig_argv and sys.path[:1] in ([""], [os.getcwd()]):  # noqa: PTH109
    del sys.path[0]
