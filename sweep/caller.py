"""A sweep from a script or a notebook: the same program as on the command line, started from Python."""

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.hints import shown
from kernel.problems import tried
from kernel.task import WORKERS_MAX
from sweep.errors import ALL_DONE, BAD_INPUT, SOME_FAILED, STOPPED_EARLY, InputError
from sweep.grammar import REFUSED_BY
from sweep.plan.toml import as_toml
from sweep.schema import DONE, RESULTS, inputs_of, is_ended
from sweep.site import launch
from sweep.store import searched, table

LOOK_EVERY = 0.3  # seconds between looks at how far the table is, at least
LOOK_SHARE = 0.01  # of a core, at most: to count the rows of a large table takes a while
ROWS_SHOWN = 6  # in a notebook
LINES_TOLD = 5  # the last ones that a sweep said, where it ended without a word of its own
OPTIONS = ("--reuse", "--keep-rows", "--recompute")  # that a problem may advise, and `run` does not have
REFUSED = "sweep refuses"  # before a problem, where the log has `sweep`
RANKS_MAX = WORKERS_MAX  # processes that are started here: more cores than any machine has


@dataclass(frozen=True)
class Finished:
    """How a sweep ended, and its table: a path, wherever one is wanted, as in `analysis.load(finished)`.

    Attributes
    ----------
    table : Path
        The HDF5 table.
    done, failed, left : int
        How many rows have their numbers, ended without, or are still to be computed.
    rows : (done,) numpy.ndarray
        The done rows, a structured array, which is read when it is asked for.
    """

    table: Path
    done: int
    failed: int
    left: int

    def __fspath__(self) -> str:
        return str(self.table)

    @property
    def rows(self) -> NDArray[np.void]:
        """The done rows (done,), a structured array with its texts as str: `pandas.DataFrame` takes it."""
        with table.reading(self.table) as file:
            rows = file[RESULTS][()]
        done = rows[(rows["status"] == DONE) & is_ended(rows)]
        kinds = {name: kind for name, (kind, _) in done.dtype.fields.items()}
        text = [(name, f"U{kind.itemsize}" if kind.kind == "S" else kind) for name, kind in kinds.items()]
        return np.asarray(done.astype(text))

    def _repr_html_(self) -> str:
        """For notebooks: how it ended, and the first rows."""
        rows = self.rows[:ROWS_SHOWN]
        names = [name for name in rows.dtype.names or () if name in inputs_of(rows.dtype)]
        names += [name for name in rows.dtype.names or () if name.endswith(("_ratio", "error"))]
        head = "".join(f"<th>{escape(name)}</th>" for name in names)
        lines = "".join("<tr>" + "".join(f"<td>{row[name]:.6g}</td>" for name in names) + "</tr>" for row in rows)
        ended = f"{self.done} done, {self.failed} failed, {self.left} left"
        return f"<p><b>{escape(str(self.table))}</b>: {ended}</p><table><tr>{head}</tr>{lines}</table>"


def run(
    spec: str | os.PathLike[str] | Mapping[str, Any],
    output: str | os.PathLike[str],
    ranks: int = 1,
    progress: bool = True,
    store: str | os.PathLike[str] | None = None,
) -> Finished:
    """Compute a sweep, or what is left of it, and wait for it.

    Where the calling program ends before it, the sweep stops, and the next call goes on.

    Parameters
    ----------
    spec : path or mapping
        A spec in TOML, or the same as a dict: ``{"name": .., "grid": {"N": [..], ..}}``; arrays are lists.
    output : path
        The table; one of the same spec is resumed.
    ranks : int
        Processes, 1 to 1024; with 2 or more the sweep is started under `mpirun`.
    progress : bool
        Whether to show a bar on stderr, in a notebook too.
    store : path, optional
        A folder from which rows are taken that any sweep has put there, and that gets the others. Default: the
        environment variable SWEEP_STORE, if it is set.

    Returns
    -------
    Finished
        The table and how its rows ended. `left` is above 0 where the sweep was stopped early.

    Raises
    ------
    InputError
        For a spec, a table or an environment that cannot be used: one line for each problem.
    RuntimeError
        Where the program ended otherwise, with what it said last.

    Examples
    --------
    >>> import sweep
    >>> grid = {"N": [5, 10], "zeta_T": 1e-3, "M_over_M0": 1, "V_over_V0": [1, 2]}
    >>> finished = sweep.run({"name": "four", "grid": grid}, "four.h5", progress=False)
    >>> finished.done, finished.rows["N"].tolist()
    (4, [5, 5, 10, 10])
    """
    text = _check(spec, output, ranks, progress, store)
    path = Path(output)
    with ExitStack() as stack:
        file = stack.enter_context(_written(text)) if isinstance(spec, Mapping) else Path(spec)
        words = ["run", os.path.join(".", file), f"--output={path}"]  # noqa: PTH118  # a path may begin with a hyphen
        command = [*_launcher(ranks), sys.executable, "-P", "-m", "sweep.called", *words]
        command += [] if store is None else [f"--store={os.fspath(store)}"]
        status, said = _watched(command, path, progress)
    if status == BAD_INPUT:
        own = f"{file}: " if isinstance(spec, Mapping) else ""  # a file that the user does not know
        problems = [line.removeprefix(f"{REFUSED}: ") for line in said if line.startswith(REFUSED)] or said
        raise InputError(*(_in_python(problem.removeprefix(own)) for problem in problems))
    return _finished(path, status, said)


def _in_python(problem: str) -> str:
    """The words of the command line as those of `run`, which has no options but its arguments."""
    told = problem.replace("give another -o", "give another output").replace("-o must", "output must")
    options = ", ".join(option for option in OPTIONS if f"{option} " in f"{told} ")
    return f"{told} ({options}: of `sweep run` on the command line)" if options else told


def _check(spec: Any, output: Any, ranks: Any, progress: Any, store: Any) -> str:
    """The text of a spec that is a dict; InputError naming every problem."""
    problems, text, unwritable = list[str](), "", list[str]()
    if isinstance(spec, Mapping):
        text, unwritable = as_toml(spec)
        problems += unwritable
    elif not _is_path(spec):
        problems.append(f"spec: must be the path of a spec, or the same as a dict, got {shown(spec)}")
    if not _is_path(output):
        problems.append(f"output: must be the path of a table, got {shown(output)}")
    if isinstance(ranks, bool) or not isinstance(ranks, int | np.integer) or not 1 <= ranks <= RANKS_MAX:
        problems.append(f"ranks: must be a whole number from 1 to {RANKS_MAX}, got {shown(ranks)}")
    if not isinstance(progress, bool):
        problems.append(f"progress: must be True or False, got {shown(progress)}")
    if not (store is None or (_is_path(store) and os.fspath(store))):
        problems.append(f"store: must be the path of a folder, got {shown(store)}")
    if problems:
        raise InputError(*problems, *_others(spec, text, output, unwritable))
    return text


def _is_path(given: Any) -> bool:
    """Whether it can be the name of a file, which holds no NUL and no half a letter."""
    try:
        return isinstance(given, str | os.PathLike) and b"\0" not in os.fsencode(given)
    except UnicodeEncodeError:
        return False


def _others(spec: Any, text: str, output: Any, unwritable: Sequence[str]) -> list[str]:
    """What the program that is not started would tell, but of values that TOML has no word for, and what stands there.

    text: of a spec that is a dict.
    """
    from sweep.plan.spec import parse_spec, read_spec  # pydantic, which a sound call needs in the other program only
    from sweep.prepare import Options, refuse_bad_names

    checks: list[Callable[[], Any]] = [lambda: parse_spec(text, "")] if isinstance(spec, Mapping) else []
    checks += [lambda: read_spec(Path(spec))] if _is_path(spec) else []
    checks += [lambda: refuse_bad_names(Options(Path(), Path(output)))] if _is_path(output) else []
    lines = [line.removeprefix(": ") for line in tried(checks, InputError, lambda error: error.problems)[1]]
    places = [f"{line.partition(':')[0]}." for line in unwritable]
    keys = [f"{line.partition(':')[0]}." for line in lines]
    same = [any(k.startswith(at) or (at.startswith(k) and k.count(".") > 1) for at in places) for k in keys]
    return [_in_python(line) for line, told in zip(lines, same, strict=True) if not told]


@contextmanager
def _written(text: str) -> Iterator[Path]:
    """A file that holds a spec, in the current folder where that can be: files that it names lie beside it."""
    here = Path.cwd()
    folder = here if os.access(here, os.W_OK) else None
    with tempfile.NamedTemporaryFile("w", encoding="utf-8", suffix=".toml", dir=folder) as file:
        file.write(text)
        file.flush()
        yield Path(file.name)


def _launcher(ranks: int) -> list[str]:
    if ranks == 1:
        return []
    if (found := launch.mpirun()) is None:
        raise InputError(f"ranks: {ranks} need mpirun, and there is none beside {sys.executable} or on the PATH")
    return [found, "-n", str(ranks)]


def _watched(command: list[str], path: Path, progress: bool) -> tuple[int, list[str]]:
    """Run the command and show how far the table is; its exit status and what it said on stderr."""
    ours = launch.without_launcher(os.environ) | {REFUSED_BY: REFUSED}
    none, pipe = subprocess.DEVNULL, subprocess.PIPE
    with subprocess.Popen(  # whose stdin ends with it, or with this process
        command, stdin=pipe, stdout=none, stderr=pipe, text=True, errors="replace", env=ours, start_new_session=True
    ) as process:
        said: list[str] = []
        assert process.stderr is not None
        reader = threading.Thread(target=lambda lines: said.extend(map(str.rstrip, lines)), args=[process.stderr])
        reader.start()
        try:
            _follow(process, path, progress)
        except KeyboardInterrupt:  # ours alone: told to end, it writes what is finished
            process.send_signal(signal.SIGTERM)
            process.wait()
            raise
        finally:
            reader.join()
    return process.returncode, [line for line in said if line]


def _follow(process: "subprocess.Popen[str]", path: Path, progress: bool) -> None:
    if not progress or sys.stderr is None:  # as in a program without a terminal
        process.wait()
        return
    from tqdm import tqdm

    with ExitStack() as stack:
        bar = cache(lambda: stack.enter_context(tqdm(desc=path.name, unit=" tasks")))  # once there is a table
        pause = LOOK_EVERY
        while True:
            with suppress(subprocess.TimeoutExpired):
                process.wait(pause)
            began = time.thread_time()
            with suppress(InputError, OSError):  # not there yet, or just being written
                _show(bar, path)
            pause = max(LOOK_EVERY, (time.thread_time() - began) / LOOK_SHARE)
            if process.returncode is not None:
                return


def _show(bar: Callable[[], Any], path: Path) -> None:
    ended, left = _counts(path)
    bar().total, bar().n = ended.total() + left, ended.total()
    bar().refresh()


def _counts(path: Path) -> tuple[Counter[str], int]:
    """How the rows of a table ended, and how many are left."""
    with table.reading(path) as file:
        return searched.counts(file)


def _finished(path: Path, status: int, said: list[str]) -> Finished:
    crashed = any(line.startswith("Traceback") for line in said)  # which ends with 1, as a run with failed rows does
    if crashed or status not in (ALL_DONE, SOME_FAILED, STOPPED_EARLY):
        raise RuntimeError("\n".join(["the sweep ended early, run it again:", *said[-LINES_TOLD:]]))
    ended, left = _counts(path)
    done = ended[DONE.decode()]
    return Finished(path, done, ended.total() - done, left)
