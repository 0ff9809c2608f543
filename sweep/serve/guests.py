"""Rank 0's end of `sweep join`: gives processes that joined the run their work, and takes in what they computed."""

import contextlib
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sweep.log import say
from sweep.machine import compiled_for
from sweep.plan.batches import Batches
from sweep.plan.tasks import Ids
from sweep.schema import is_ended
from sweep.serve.grace import grace
from sweep.serve.worker import Job
from sweep.store import lease, mailbox
from sweep.store.known import Alike
from sweep.store.mailbox import BITS, GUEST, KIND, ORDER, ROWS, DamagedError, Sign, Watched
from sweep.store.writers import Waiting

LOOK_EVERY = 0.2  # seconds between looks into the folder
LIFE_EVERY = 2.0  # seconds between looks whether guests live: a file to open for each of them (python -m tests.crowds)
AHEAD = 2  # orders that a guest has at a time: it computes one while rank 0 finds what came of the one before
ORDER_SECONDS = 10.0  # predicted, of an order: fifty looks, so that a guest that has the next one never waits
ORDER_MAX = 1 << 14  # tasks of an order: some MB of rows
Met = Callable[[Sequence[str], Sequence[str]], None]


class Given(NamedTuple):
    """An order that is not answered."""

    ids: Ids
    predicted: float  # seconds

    def parted(self, count: int) -> "tuple[Given, Given]":
        """The first so many tasks, and the others."""
        share = self.predicted * count / len(self.ids)
        return Given(self.ids[:count], share), Given(self.ids[count:], self.predicted - share)


@dataclass
class Guest:
    """One process that has joined."""

    name: str
    rank: int
    watched: Watched
    orders: dict[int, Given] = field(default_factory=dict)
    given: int = 0  # orders so far
    heard: float = 0.0  # when its first order was begun, as far as is known here
    wrong: str = ""  # why it gets no more work

    def is_late(self, ratio: float) -> bool:
        """Whether its first order should have come back long ago; `ratio`: real over predicted time of this run."""
        first = next(iter(self.orders.values()), None)
        return first is not None and time.monotonic() - self.heard > grace(ratio * first.predicted)


class Taken(NamedTuple):
    """What a guest has computed."""

    ids: Ids
    rows: NDArray[np.void]
    predicted: float


class Guests:
    """All that have joined."""

    def __init__(
        self,
        table: Path,
        job: Job,
        batches: Batches,
        ranks: int,
        waiting: Waiting | None = None,
        alike: Alike | None = None,
        met: Met = lambda _hosts, _kinds: None,
    ) -> None:
        """`ranks`: of the run itself; guests count on. `waiting`: told of the folder's disk. `alike`: those met.

        `met`: told of those that come, their hosts and their kinds of processors.
        """
        self._tell = met
        self._alike = alike
        self._folder, self._job, self._batches, self._ranks = mailbox.folder_of(table), job, batches, ranks
        self._guests, self._met, self._looked, self._felt = dict[str, Guest](), set[str](), -np.inf, -np.inf
        self._sign: Sign | None = None
        self.waiting = waiting or Waiting()
        try:
            mailbox.empty(self._folder)
            if alike is not None:
                (self._folder / BITS).touch()
            self._sign = Sign(self._folder / mailbox.RUN)
        except OSError as error:
            say(f"nobody can join this run: {self._folder} cannot be written ({error.strerror})")

    @property
    def busy(self) -> bool:
        """Whether anything that they were given is not answered."""
        return any(guest.orders for guest in self._guests.values())

    def is_time(self) -> bool:
        """Whether to look into the folder again."""
        if self._sign is None or time.monotonic() - self._looked < LOOK_EVERY:
            return False
        self._looked = time.monotonic()
        return True

    def taken(self) -> Iterator[Taken]:
        """What they have finished since the last look."""
        for name in mailbox.names(self._folder, ROWS):
            who, _, number = name.partition(".")
            guest = self._guests.get(who)
            try:
                rows = mailbox.get(self._folder / f"{name}{ROWS}")
            except OSError:  # looked at again
                continue
            except DamagedError:
                rows = None
            if guest is None or not number.isdecimal() or (given := guest.orders.get(int(number))) is None:
                continue  # of one that was taken for dead
            if rows is None or not self._fits(given.ids[: len(rows)], rows):
                guest.wrong = "sent damaged rows"
                continue
            done, rest = given.parted(len(rows))
            if len(rest.ids):  # they come later, or never where it was to stop
                guest.orders[int(number)] = rest
            else:
                del guest.orders[int(number)]
            guest.heard = time.monotonic()
            yield Taken(done.ids, rows, done.predicted)

    def _fits(self, ids: Ids, rows: NDArray[np.void]) -> bool:
        """Whether these are finished rows of those tasks, one at least."""
        whole = rows.dtype == self._job.layout and rows.shape == ids.shape and len(rows) > 0
        if not whole or not is_ended(rows).all():
            return False
        return all(np.array_equal(rows[name], values) for name, values in self._job.tasks.columns(ids).items())

    def lost(self, ratio: float) -> Iterator[Given]:
        """What was given to those that have died, or are not wanted any more; `ratio` as of `Guest.is_late`."""
        is_time = time.monotonic() - self._felt >= LIFE_EVERY
        if is_time:
            self._felt = time.monotonic()
        for name, guest in [*self._guests.items()]:
            if not guest.wrong and guest.is_late(ratio):  # a disk may have lost an order, or its rows
                guest.wrong = "has not answered in time"
            if guest.wrong or (is_time and guest.watched.is_gone()):
                yield from self._dismissed(name)

    def withdrawn(self) -> Iterator[Given]:
        """Whatever is not answered; nobody is given anything after that."""
        for name in [*self._guests]:
            yield from self._dismissed(name)

    def _dismissed(self, name: str) -> Iterator[Given]:
        guest = self._guests.pop(name)
        self._batches.ranks -= 1
        for ending in (GUEST, *(f".{number}{ORDER}" for number in guest.orders)):  # it notices, should it live
            with contextlib.suppress(OSError):
                (self._folder / f"{name}{ending}").unlink(missing_ok=True)
        if guest.orders:
            tasks = sum(len(one.ids) for one in guest.orders.values())
            why = guest.wrong or "has ended or died"
            say(f"the guest with rank {guest.rank} {why}; the {tasks} tasks that it had are given to others")
        yield from guest.orders.values()

    def wanting(self) -> Iterator[Guest]:
        """Those that can be given more, new ones among them."""
        self._welcome([name for name in mailbox.names(self._folder, GUEST) if name not in self._met])
        for guest in self._guests.values():
            while len(guest.orders) < AHEAD and not guest.wrong:
                before = guest.given
                yield guest
                if guest.given == before:  # there is nothing left
                    break

    def _welcome(self, new: list[str]) -> None:
        if not new:
            return
        first, signs = self._ranks + len(self._met), []
        for rank, name in enumerate(new, first):
            path = self._folder / f"{name}{GUEST}"
            signs.append(lease.read(path))
            self._guests[name] = Guest(name, rank, Watched(path))
        self._met.update(new)
        self._batches.ranks += len(new)
        if self._alike is not None:
            self._alike.meet(first, [mailbox.said(self._folder / f"{name}.{BITS}") for name in new])
        kinds = [kind for name in new if (kind := mailbox.said(self._folder / f"{name}.{KIND}"))]
        self._tell([sign.host for sign in signs if sign is not None], kinds)
        if len(new) == 1 and signs[0] is not None:
            say(f"process {signs[0].process} on {signs[0].host} has joined as rank {first}")
        elif len(new) > 1:
            hosts = ", ".join(sorted({sign.host for sign in signs if sign is not None}))
            say(f"{len(new)} processes on {hosts} have joined as ranks {first} to {first + len(new) - 1}")
        here = compiled_for()
        if others := [kind for kind in kinds if kind != here]:
            whose = "its rows" if len(new) == 1 else f"the rows of {len(others)} of them"
            say(other_kinds(whose, others))

    def give(self, guest: Guest, ids: Ids, predicted: float) -> None:
        """Give it these tasks."""
        columns = self._job.tasks.columns(ids)
        order = np.empty(len(ids), [*((name, values.dtype) for name, values in columns.items()), ("rank", "<i4")])
        for name, values in columns.items():
            order[name] = values
        order["rank"] = guest.rank
        if not guest.orders:
            guest.heard = time.monotonic()
        guest.orders[guest.given] = Given(ids, predicted)
        try:
            mailbox.put(self._folder / f"{guest.name}.{guest.given}{ORDER}", order)
        except OSError as error:
            guest.wrong = f"could not be given work ({error.strerror})"
        guest.given += 1

    def close(self) -> None:
        """The run ends, and its guests with it."""
        if self._sign is not None:
            self._sign.close()
            mailbox.remove(self._folder)


def other_kinds(whose: str, others: Iterable[str]) -> str:
    """For the log: whose rows come of other kinds of processors than rank 0's."""
    named = ", ".join(sorted(set(others)))
    return (
        f"{whose} come of another kind of processor ({named}; here {compiled_for()}), so that their last digits may "
        "differ from what is computed here, and more where a task is chaotic"
    )


def next_order(batches: Batches, fits: float) -> Given:
    """Some batches as one order; no task where nothing is left that fits."""
    ids, predicted = [batches.take(fits)], batches.taken
    while len(ids[-1]) and predicted < min(ORDER_SECONDS, fits) and sum(map(len, ids)) < ORDER_MAX:
        # What is too long for the rest of this order still fits another rank: to take it would skip it for good.
        if predicted >= batches.share or batches.ahead > fits - predicted:
            break
        ids.append(batches.take(fits - predicted))
        predicted += batches.taken
    return Given(np.concatenate(ids), predicted)
