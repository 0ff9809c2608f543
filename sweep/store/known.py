"""`sweep run --store DIR`: what of a sweep the store has, what of it may be taken, and what this run adds to it."""

import json
import platform
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kernel.method import SHARED_SPEED_RATIO
from sweep.errors import InputError
from sweep.files import as_text
from sweep.log import say
from sweep.plan.search import COMPUTE, SCREEN, SCREENING, TRY
from sweep.plan.tasks import Ids, TaskList
from sweep.schema import DONE, SCREENED
from sweep.store import table
from sweep.store.reuse import entry, in_words, lacks
from sweep.store.shelf import Shelf, Taken, UselessStoreError
from sweep.store.writers import Writer

if TYPE_CHECKING:
    from sweep.plan.sections import Accuracy
    from sweep.plan.spec import Spec

KEEP_EVERY = 1.0  # seconds between two writings: what a kill can cost the store, though not the table
ASKED_AT_ONCE = 1 << 20  # orders: bounds the memory that asking takes


def of_spec(spec: "Spec") -> dict[str, Any]:
    """All that rows of this sweep depend on, besides their task and the kernel; as JSON has it."""
    chain = {"model": spec.model, "varied": list(spec.varied()), "quantities": list(spec.output.quantities())}
    columns = [list(column) for column in spec.layout().descr]
    return chain | {"columns": columns, "accuracy": spec.accuracy.model_dump(mode="json")}


def _as_text(what: dict[str, Any]) -> str:
    """By which the store tells kinds of rows apart; SCREENED stands for the accuracy of what is no result."""
    return json.dumps(what, sort_keys=True)


def _accuracy(given: Any) -> "Accuracy":
    from sweep.plan.sections import Accuracy  # pydantic, which the workers of a run do without

    return Accuracy.model_validate(given)


def serving(wanted: dict[str, Any], kinds: dict[int, str]) -> dict[int, str]:
    """Which kinds of rows serve one that is `wanted` though they are another, with words for how accurate they are.

    They are of the same chain, columns and bits, and at least as accurate (as for `--reuse`); the nearest first.
    """
    served = list[tuple[float, int, str]]()
    for kind, text in kinds.items():
        what = json.loads(text)
        same = all(what.get(name) == wanted[name] for name in wanted if name != "accuracy")
        if not same or what == wanted or what["accuracy"] == SCREENED:
            continue
        found = _accuracy(what["accuracy"])
        if not lacks(found, _accuracy(wanted["accuracy"])):
            served.append((-found.target, kind, in_words(found)))
    return {kind: words for _, kind, words in sorted(served)}


class Known:
    """The store, as one run of one sweep sees it; on rank 0."""

    def __init__(
        self,
        folder: Path,
        what: dict[str, Any],
        tasks: TaskList,
        layout: np.dtype[Any],
        path: Path,
        slot: int,
        whole: bool,
        screens: float,
    ) -> None:
        """`what`: of `of_spec`, with the kernel's `numerics`; `path`: the table.

        slot: of its list of runs, from which on it is told where rows come from.
        whole: take more accurate rows too. What a search asks for follows from its rows: it takes its own kind alone.
        screens: of sweep.plan.search.Search.
        """
        self.folder, self._shelf, self._tasks, self._layout = folder, Shelf(folder), tasks, layout
        accuracy, no_result = _accuracy(what["accuracy"]), what | {"accuracy": SCREENED}
        self._own = self._shelf.kind(_as_text(what))
        screening = {"chain_until": screens, "shared_speed_ratio": SHARED_SPEED_RATIO}
        self._screened = self._shelf.kind(_as_text(no_result | screening))
        self._tried = self._shelf.kind(_as_text(no_result | {"tried": what["accuracy"]}))
        self._words = {self._own: in_words(accuracy), self._screened: f"{SCREENED}, {SCREENING}"}
        self._words |= {self._tried: f"{SCREENED} and tried, {accuracy.integrator()}"}
        also = serving(what, self._shelf.kinds()) if whole else {}
        self._words |= also
        self._kinds = {COMPUTE: [self._own, *also], SCREEN: [self._screened], TRY: [self._tried]}
        self._slots = dict[tuple[int, int], int]()  # of the table's list of runs, by kind and origin
        self._counts = dict[tuple[int, int], int]()
        self._next_slot = slot
        self._keeper = _Keeper(folder, f"{platform.node()}:{as_text(path.absolute())}")

    @property
    def taken(self) -> int:
        """How many rows were taken."""
        return sum(self._counts.values())

    def find(self, orders: Ids, writer: Writer) -> tuple[Ids, NDArray[np.void]]:
        """The orders of these (sweep.plan.search.Search) that are answered, and their rows.

        The table's list of runs has where they come from before the table has them: a kill may come in between.
        """
        n, found, rows = len(self._tasks), [orders[:0]], [np.empty(0, self._layout)]
        for first in range(0, len(orders), ASKED_AT_ONCE):
            some = orders[first : first + ASKED_AT_ONCE]
            for asked, kinds in self._kinds.items():
                part = some[some // n == asked]
                for kind in kinds:
                    taken = self._told(
                        kind, self._shelf.find(kind, self._tasks.columns(part % n), self._layout), writer
                    )
                    found.append(part[taken.where])
                    rows.append(taken.rows)
                    part = np.delete(part, taken.where)
        return np.concatenate(found), np.concatenate(rows)

    def _told(self, kind: int, taken: Taken, writer: Writer) -> Taken:
        """What of it the list of runs has room for, which now tells it."""
        for origin in np.unique(taken.origins).tolist():
            key, here = (kind, origin), taken.origins == origin
            if key not in self._slots:
                if self._next_slot >= table.RUNS_MAX:  # then they are computed
                    taken = Taken(*(part[~here] for part in taken))
                    continue
                self._slots[key], self._next_slot = self._next_slot, self._next_slot + 1
            self._counts[key] = self._counts.get(key, 0) + int(np.count_nonzero(here))
            place = f"store {as_text(self.folder.absolute())}: {self._shelf.place_of(origin)}"
            writer.log(self._slots[key], entry(self._counts[key], place, self._words[kind], kernel=""))
        return taken

    def keep(self, orders: Ids, rows: NDArray[np.void]) -> None:
        """Put what was computed into the store, soon; failed rows are none."""
        done = rows["status"] == DONE
        for asked, (own, *_) in self._kinds.items():
            if (of := done & (orders // len(self._tasks) == asked)).any():
                self._keeper.take(own, rows[of])

    def close(self) -> None:
        """Write what is not yet in the store."""
        self._keeper.close()
        self._shelf.close()


class _Keeper:
    """A thread that writes rows into the store. A store that cannot be written any more ends no run."""

    def __init__(self, folder: Path, place: str) -> None:
        self._folder, self._place = folder, place
        self._rows = list[tuple[int, NDArray[np.void]]]()
        self._lock, self._closing = threading.Lock(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="keeper", daemon=True)
        self._thread.start()

    def take(self, kind: int, rows: NDArray[np.void]) -> None:
        """Have these written, unless the store cannot be written any more."""
        if self._thread.is_alive():
            with self._lock:
                self._rows.append((kind, rows))

    def _run(self) -> None:
        try:
            shelf = Shelf(self._folder)
            origin = shelf.origin(self._place)
            while not self._closing.wait(KEEP_EVERY):
                self._write(shelf, origin)
            self._write(shelf, origin)
            shelf.close()
        except InputError as error:
            say(f"{error}; the table is not affected, but what follows is not kept for other sweeps")

    def _write(self, shelf: Shelf, origin: int) -> None:
        with self._lock:
            waiting, self._rows = self._rows, []
        for kind in dict.fromkeys(kind for kind, _ in waiting):
            shelf.put(kind, origin, np.concatenate([rows for its, rows in waiting if its == kind]))

    def close(self) -> None:
        """Write the rest."""
        self._closing.set()
        self._thread.join()


def told_of(error: InputError) -> None:
    """Say that a run goes on without the store."""
    say(f"{error}; what it has is computed, and nothing more is kept")


def checked(folder: Path | None) -> Path | None:
    """The folder; none, which is said, where its file is damaged or has no room. InputError where it cannot be used."""
    if folder is not None:
        try:
            shelf = Shelf(folder)
            shelf.kinds()
            shelf.close()
        except UselessStoreError as error:
            told_of(error)
            return None
    return folder


class Alike:
    """The ranks whose rows have the bits of rank 0's, by the `kernel.numerics` of each: a store keeps theirs alone."""

    def __init__(self, numerics: str) -> None:
        self.numerics = numerics
        self._ranks = list[int]()

    def meet(self, first: int, found: Sequence[str]) -> None:
        """Ranks from `first` on, and the numerics of each."""
        same = [rank for rank, each in enumerate(found, first) if each == self.numerics]
        self._ranks += same
        if others := len(found) - len(same):
            who = "1 rank computes" if others == 1 else f"{others} ranks compute"
            say(
                f"{who} other bits than rank 0 ({self.numerics}), as other kinds of processors do: the store keeps no "
                "row of them"
            )

    def are_of(self, rows: NDArray[np.void]) -> NDArray[np.bool_]:
        """Which rows they have computed."""
        return np.isin(rows["rank"], self._ranks)
