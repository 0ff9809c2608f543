"""A search by a sampler of the user's own: a file of Python with a class `Sampler`, which asks and is told in rounds.

What it asks for follows from what it was told alone: the rows of a round in the order in which it asked, whole rounds
only, without the columns that differ between two runs. A sweep that goes on tells it the same rounds again. So its
choice is the same for any number of ranks and after kills, as long as it draws nothing without a seed of its own.
"""

import hashlib
import runpy
import traceback
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from kernel.hints import shown
from sweep.errors import InputError
from sweep.files import no_file
from sweep.plan.search import Search
from sweep.plan.tasks import Ids, Tasks
from sweep.schema import content_columns

CLASS = "Sampler"
# Rounds in a row that ask for nothing but what earlier ones have asked for, after which the search is over: a sampler
# that has settled would be told the same for ever.
REPEATS_MAX = 1000


class Sampler(Protocol):
    """What the file must have under this name."""

    def __init__(self, axes: dict[str, NDArray[Any]]) -> None:
        """`axes`: the values of every axis of the grid, in the order of a task's inputs."""

    def ask(self) -> Any:
        """The tasks of a round, (n, number of axes): places of values on the axes, from 0; none, or None, ends it."""

    def tell(self, rows: NDArray[np.void]) -> None:
        """Take in the rows (n,) of the last round, in its order; some may be chaotic or failed."""


def sha256(path: Path) -> str:
    """Of the file, which the table keeps: another one's choice would be another sweep. OSError where it has none.

    ValueError where it is no file: a pipe would be waited for, and some devices never end.
    """
    if kind := no_file(path):
        raise ValueError(f"it is a {kind}")
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def loaded(path: Path) -> type[Sampler]:
    """The class in the file, which is run; InputError where it has none."""
    with _in_words(path, "cannot be run"):
        found = runpy.run_path(str(path)).get(CLASS)
    lacks = [name for name in ("ask", "tell") if not callable(getattr(found, name, None))]
    if not isinstance(found, type) or lacks:
        raise InputError(f"search.file: {path} must have a class {CLASS} with the methods ask and tell")
    return found


@contextmanager
def _in_words(path: Path, what: str) -> Iterator[None]:
    """Whatever the user's code raises, leaving among it, is told in one line, with the place in the file."""
    try:
        yield
    except (Exception, SystemExit) as error:
        frames = traceback.extract_tb(error.__traceback__)
        lines = [frame.lineno for frame in frames if frame.filename == str(path)] or [getattr(error, "lineno", None)]
        where = f" (line {lines[-1]})" if lines[-1] else ""
        raised = traceback.format_exception_only(error)[-1].strip()
        raise InputError(f"search.file: {path} {what}: {raised}{where}") from None


class Unsteered(Search):
    """The search where nobody steers it, as in a look at its table: it asks for nothing."""

    def __init__(self, tasks: Tasks, of: str) -> None:
        self.tasks, self.of = tasks, of

    def ask(self) -> Ids:
        """Nothing."""
        return np.empty(0, np.int64)


class Own(Unsteered):
    """The search steered by the sampler."""

    def __init__(self, tasks: Tasks, of: str, path: Path) -> None:
        super().__init__(tasks, of)
        self._path, sampler = path, loaded(path)
        with self._calling("__init__"):
            self._sampler = sampler(dict(tasks.axes))
        self._rows = dict[int, NDArray[np.void]]()  # all that is known, by task
        self._round: Ids | None = None  # what the sampler has asked for and not been told
        self._out, self._over = np.zeros(len(tasks), np.bool_), False
        self._named, self._repeats = np.zeros(len(tasks), np.bool_), 0  # by any round; rounds without a new task

    def tell(self, ids: Ids, rows: NDArray[np.void]) -> None:
        """Whatever the order in which they come."""
        shown = rows[list(content_columns(rows.dtype))]
        self._rows |= {task: shown[k] for k, task in enumerate(ids.tolist())}

    def ask(self) -> Ids:
        """What is missing of the round; of the next one where nothing is."""
        while not self._over:
            if self._round is None:
                self._round = self._asked()
                self._repeats = self._repeats + 1 if self._named[self._round].all() else 0
                self._named[self._round] = True
            missing = np.array(sorted({task for task in self._round.tolist() if task not in self._rows}), np.int64)
            if len(missing):
                new = missing[~self._out[missing]]
                self._out[new] = True
                return new
            if len(self._round):
                rows = np.stack([self._rows[task] for task in self._round.tolist()])
                with self._calling("tell"):
                    self._sampler.tell(rows)
            self._over, self._round = not len(self._round) or self._repeats >= REPEATS_MAX, None
        return super().ask()

    def _calling(self, method: str) -> AbstractContextManager[None]:
        return _in_words(self._path, f"failed in {CLASS}.{method}")

    def _asked(self) -> Ids:
        """The tasks of the next round; InputError where they are none."""
        lengths = [len(values) for values in self.tasks.axes.values()]
        with self._calling("ask"):
            answer = self._sampler.ask()
        try:
            places = np.asarray([] if answer is None else answer)
        except ValueError:  # rows of several lengths
            places = np.array(None)
        if not places.size:
            return np.empty(0, np.int64)
        whole = places.dtype.kind in "iu" and places.ndim == 2 and places.shape[1] == len(lengths)
        if not whole or (places < 0).any() or (places >= lengths).any():
            raise InputError(
                f"search.file: {self._path}: ask must give whole numbers (n, {len(lengths)}), each from 0 and below "
                f"the length of its axis ({', '.join(map(str, lengths))}), got {shown(answer)}"
            )
        return np.asarray(np.ravel_multi_index(tuple(places.T), tuple(lengths)), np.int64)
