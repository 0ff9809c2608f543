"""`python -m sweep.called`: the command line as `sweep.run` starts it, which stops when its caller is gone.

The caller holds the other end of stdin, which mpirun hands on to rank 0: whatever ends the caller closes it.
"""

import os
import signal
import stat
import sys
import threading

from sweep import cli
from sweep.site import launch


def main() -> int:
    """As `sweep`; the exit status."""
    if launch.stated_rank(os.environ) == 0 and _is_held():
        threading.Thread(target=_stop_with_caller, daemon=True).start()
    return cli.main()


def _is_held() -> bool:
    """Whether stdin has another end: a launcher may hand on nothing."""
    mode = os.fstat(0).st_mode
    return stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)


def _stop_with_caller() -> None:
    """As by a signal: what is finished is kept."""
    while os.read(0, 1):
        pass
    os.kill(os.getpid(), signal.SIGTERM)


if __name__ == "__main__":
    sys.exit(main())
