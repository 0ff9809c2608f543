"""Bounds what a power failure can cost: finished rows go from the system's memory to the disk every so often."""

import errno
import os
import threading
from pathlib import Path

from sweep.errors import InputError
from sweep.log import say

UNABLE = (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP)  # file systems that cannot flush; nothing is known to be lost


class Flusher:
    """A thread that flushes an open table every `every` seconds and at the end.

    On a local disk that is the whole file; on a network file system what this machine has written.
    """

    def __init__(self, path: Path, every: float) -> None:
        self._path, self._every, self._closing = path, every, threading.Event()
        self._descriptor, self._lost = os.open(path, os.O_RDONLY), False
        self._thread = threading.Thread(target=self._run, name="flusher", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._closing.wait(self._every) and self._flush():
            pass

    def _flush(self) -> bool:
        try:
            os.fsync(self._descriptor)
        except OSError as error:
            self._lost = error.errno not in UNABLE
            say(f"{self._path}: cannot be flushed to the disk ({error.strerror}); a power failure may cost rows")
            return False
        return True

    def close(self) -> None:
        """Flush what the last batches wrote. InputError where the disk has not taken all that was written."""
        self._closing.set()
        self._thread.join()
        lost = self._lost or (not self._flush() and self._lost)
        os.close(self._descriptor)
        if lost:
            raise InputError(
                f"{self._path}: its disk has not taken all rows; mend that, copy the table, then run again: torn rows "
                "are found and computed again"
            )
