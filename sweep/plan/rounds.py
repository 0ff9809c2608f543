"""A search whose tasks fall into groups: cells or planes, each of which goes in rounds and waits for no other.

What a round asks for follows from the numbers of the rounds of its group before it alone, in whatever order they came
and whatever else is known.
"""

from collections.abc import Iterator

import numpy as np

from sweep.plan.search import KINDS, Search
from sweep.plan.tasks import Ids, Tasks


class Rounds(Search):
    """Which orders were given, and which groups can go on."""

    def __init__(self, tasks: Tasks, groups: Ids) -> None:
        """`groups`: the numbers of the tasks, as (groups, ..)."""
        self.tasks = tasks
        self._group = np.empty(len(tasks), np.int64)  # of every task
        self._group[groups] = np.arange(len(groups)).reshape(-1, *[1] * (groups.ndim - 1))
        self._known, self._out = np.zeros((2, KINDS * len(tasks)), np.bool_)  # of every order
        self._waits = np.zeros(len(groups), np.int64)  # orders given out for a group whose results are not known
        self._over = np.zeros(len(groups), np.bool_)
        self._changed = np.arange(len(groups))

    def learn(self, orders: Ids) -> None:
        """The results of these orders are known."""
        groups = self._group[orders % len(self.tasks)]
        np.subtract.at(self._waits, groups, self._out[orders] & ~self._known[orders])
        self._known[orders] = True
        self._changed = np.append(self._changed, groups)

    def ask(self) -> Ids:
        """The next round of every group that has all results of its last one."""
        changed, self._changed = np.unique(self._changed), self._changed[:0]
        ready = changed[(self._waits[changed] == 0) & ~self._over[changed]].tolist()
        return np.sort(np.concatenate([np.empty(0, np.int64), *self._next(ready)]))

    def _next(self, groups: list[int]) -> Iterator[Ids]:
        for group in groups:
            orders = self.orders(group)
            while not len(missing := orders[~self._known[orders]]):
                if not self.step(group):
                    self._over[group] = True
                    break
                orders = self.orders(group)
            self._out[missing] = True
            self._waits[group] = len(missing)
            yield missing

    def orders(self, group: int) -> Ids:
        """Everything that the group has asked for so far."""
        raise NotImplementedError

    def step(self, group: int) -> bool:
        """Choose what the next round asks for besides, by what was asked for alone; whether there is anything."""
        raise NotImplementedError
