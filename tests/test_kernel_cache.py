"""Compiled code is kept between processes, and never survives an edit of any file of the kernel."""

import contextlib
import gc
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numba
import pytest
from numba.core import event

import kernel
from kernel.cache import _File
from kernel.jit import compiling, jit

pytestmark = pytest.mark.slow

PROGRAM = """
import kernel
from kernel.model import tension
print(kernel.__file__, tension(kernel.Bistable(), -0.25))
"""


WARM = """
import sys
import kernel
from kernel import integrate
kernel.ke_ratio(5, 1e-3, 1.0, 1.0)
assert "numba.typed.typeddict" not in sys.modules
assert "called" not in vars(integrate.peak_of)
"""


def test_a_process_that_finds_the_kernel_compiled_loads_nothing_to_compile_with_and_makes_no_parts():
    kernel.ke_ratio(5, 1e-3, 1.0, 1.0)  # now it is kept
    subprocess.run([sys.executable, "-P", "-c", WARM], check=True, timeout=240)


def test_an_edit_of_one_file_is_seen_by_the_compiled_code_of_the_others(tmp_path):
    copy = tmp_path / "kernel"
    shutil.copytree(Path(kernel.__file__).parent, copy, ignore=shutil.ignore_patterns("__pycache__"))

    def force() -> float:
        environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        run = subprocess.run(
            [sys.executable, "-c", PROGRAM],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=True,
            timeout=240,
        )
        file, number = run.stdout.split()
        assert file.startswith(str(tmp_path))
        return float(number)

    before = force()
    assert force() == before
    law = copy / "laws" / "bistable.py"
    stamp = law.stat()
    law.write_text(law.read_text().replace("(self.c3 * m + self.c2)", "(self.c3 * m - self.c2)"))
    os.utime(law, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    assert force() != before


@pytest.mark.parametrize("fails", [False, True])
def test_garbage_is_not_looked_for_while_numba_compiles_and_is_again_afterwards(fails):
    @jit
    def inner(x):
        return x.no_such_name if fails else x + 1

    @jit
    def outer(x):
        return 2 * inner(x)

    states: list[bool] = []
    with compiling(lambda _: states.append(gc.isenabled())), contextlib.suppress(numba.TypingError):
        outer(1.0)
    assert states
    assert not any(states[:-1])
    assert gc.isenabled()


def test_nobody_is_told_of_the_calls_of_llvm_while_numba_compiles():
    @jit
    def new(x):
        return x + 1

    with event.install_recorder("numba:llvm_lock") as told:
        new(1.0)
    assert not told.buffer


def test_compiling_is_told_function_by_function_and_only_where_something_is_compiled():
    new = float(time.time_ns())  # else what an earlier run of this test has kept would serve

    @jit
    def inner(x):
        return x + new

    @jit
    def outer(x):
        return 2 * inner(x)

    seen: list[int] = []
    with compiling(seen.append):
        assert outer(1.0) == 2 * (1.0 + new)
    assert seen == [0, 1, 2]
    with compiling(seen.append):
        outer(2.0)
    outer(1)
    assert seen == [0, 1, 2]


def test_what_only_compiled_code_calls_is_no_machine_code_until_python_calls_it():
    @jit
    def inner(x):
        return x * x + 0.1

    @jit
    def around(x):
        return 2.0 * inner(x)

    told = around(0.3)
    assert list(inner.called.overloads) == [(numba.float64,)]
    assert not inner.from_python.overloads
    assert not around.called.overloads
    assert told == 2.0 * inner(0.3)
    assert list(inner.from_python.overloads) == [(numba.float64,)]


FULL = """
import errno, os
from kernel import cache
from kernel.jit import jit

def full(*_):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

cache._File._open_for_write = full

@jit
def doubled(x):
    return 2 * x

print(repr(cache.why_not_kept()), doubled(1.5), repr(cache.why_not_kept()))
"""


def test_a_function_that_cannot_be_kept_serves_the_process_that_has_compiled_it(tmp_path):
    (tmp_path / "full.py").write_text(FULL)
    command, environment = [sys.executable, "full.py"], {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    told = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True, timeout=240
    )
    assert told.stdout == "'' 3.0 'No space left on device'\n"


def test_two_processes_that_compile_one_function_at_once_keep_two_codes_apart(tmp_path):
    """Each begins where nothing is kept yet, so each would take the first number for what it keeps."""
    one, other = (_File(str(tmp_path), "f-1.py3", "stamp") for _ in range(2))
    index = other._load_index
    other._load_index = lambda: {}
    one.save("of a float", "code for a float")
    other.save("of an array", "code for an array")
    other._load_index = index
    assert one.load("of an array") == "code for an array"
    assert one.load("of a float") in (None, "code for a float")
    one.save("of a float", "code for a float")
    assert (one.load("of a float"), one.load("of an array")) == ("code for a float", "code for an array")
