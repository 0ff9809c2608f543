"""What is kept of compiled code between processes: the one place that knows numba's cache."""

from typing import Any
from uuid import NAMESPACE_OID, uuid5

import numba
from numba.core import types
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.runtime.nrt import rtsys

from kernel.version import source_hash


class _File(IndexDataCacheFile):
    """What is kept of a function. numba numbers it, so that of two processes one could read the other's for its own."""

    trouble = ""  # of the last function of all that could not be kept

    def save(self, key: Any, data: Any) -> None:
        name = self._data_name(uuid5(NAMESPACE_OID, repr(key)).int)
        try:
            self._save_data(name, data)
            self._save_index(self._load_index() | {key: name})
        except OSError as error:  # of a full disk: what is compiled serves this process all the same
            _File.trouble = error.strerror or str(error)


def why_not_kept() -> str:
    """Why something that this process has compiled could not be kept; empty where all of it was."""
    return _File.trouble


class _Cache(FunctionCache):
    """What is kept of a function, found without the modules that numba imports to compile: a tenth of every start."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)


def kept(compiled: Any, suffix: str) -> Any:
    """The same, kept on the disk under the function's name and this suffix."""
    cache = _Cache(compiled.py_func)
    base = cache._impl.filename_base + suffix
    # numba looks only at the file of the function itself; an edit of what it calls would go unnoticed.
    cache._cache_file = _File(cache.cache_path, base, source_hash())
    # Told by another version, what is kept is not even read: it may name classes that are gone.
    cache._cache_file._version = f"{numba.__version__} {source_hash()}"
    _keep_only_ours(cache._impl)
    compiled._cache = cache
    return compiled


def _keep_only_ours(implementation: Any) -> None:
    """Keep no code for laws from outside of the kernel: who reads the cache next may not have their classes."""
    cachable = implementation.check_cachable
    implementation.check_cachable = lambda result: all(map(_is_ours, result.signature.args)) and cachable(result)


def _is_ours(kind: Any) -> bool:
    """Whether a type has no named tuple from outside of the kernel in it."""
    home = getattr(kind, "instance_class", None)
    parts: Any = kind if isinstance(kind, types.BaseTuple) else ()
    return (home is None or home.__module__.startswith("kernel.")) and all(map(_is_ours, parts))
