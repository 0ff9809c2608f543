"""What kind of file system a folder is on, and what follows from it for a table that several nodes see."""

import errno
import os
import re
import stat
from pathlib import Path

# Kinds, as the system calls them, that other machines see too. Those of the second line keep what their nodes have read
# in step, so that nodes may write one file at once; with the others only one node can be trusted with a table.
SHARED = ("nfs", "cifs", "smb", "fuse.", "9p", "beegfs", "afs", "virtiofs")
COHERENT = ("lustre", "gpfs", "mmfs", "ceph", "panfs", "pvfs", "orangefs")
CANNOT_FLUSH = (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP)  # what a file system says that has no flush; no row is lost


def kind_of(place: Path) -> str:
    """The kind of file system that holds this path, which need not exist."""
    try:
        lines = os.fsdecode(Path("/proc/mounts").read_bytes()).split("\n")  # a name may hold any other end of a line
    except OSError:
        return "unknown file system"
    real = Path(os.path.realpath(place))
    mounts = (line.split(" ") for line in lines if line)
    names = ((Path(re.sub(r"\\([0-7]{3})", _letter, at)), kind) for _, at, kind, *_ in mounts)
    holding = [(len(at.parts), i, kind) for i, (at, kind) in enumerate(names) if real.is_relative_to(at)]
    return max(holding)[2] if holding else "unknown file system"  # of mounts at one place the last is seen


def _letter(octal: re.Match[str]) -> str:
    """What stands in its place because it would end a name or a line."""
    return chr(int(octal[1], 8))


def is_shared(place: Path) -> bool:
    """Whether other machines may see it."""
    return kind_of(place).startswith((*SHARED, *COHERENT))


def is_coherent(place: Path) -> bool:
    """Whether what one node writes is what the others read next, and nodes may write neighbouring rows at once."""
    return not kind_of(place).startswith(SHARED)


def loses_writes(place: Path) -> bool:
    """Whether a node may go on with what it has read before another one wrote, even where both lock the file.

    NFS asks its server again with every lock.
    """
    return not is_coherent(place) and not kind_of(place).startswith("nfs")


def forget_what_was_read(path: Path) -> None:
    """Let the next reader ask the disk: what this node keeps in memory of a shared file may be older than that.

    Seen on Gluster, where a node that had read a table kept those pages for ever.
    """
    if not is_shared(path):
        return
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # a pipe would wait
    try:
        if stat.S_ISREG(os.fstat(descriptor).st_mode):
            os.posix_fadvise(descriptor, 0, 0, os.POSIX_FADV_DONTNEED)
    finally:
        os.close(descriptor)
