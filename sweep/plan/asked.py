"""The sections of a spec that ask for less than the whole grid: [search], and [adaptive], an older case of it."""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from kernel.hints import did_you_mean
from kernel.task import broken_rule
from sweep.plan import fall, lowest
from sweep.plan.axis import takes_whole
from sweep.plan.crossing import FIRST, Crossing
from sweep.plan.crossing import START_MIN as ENDS
from sweep.plan.lines import Lines, extent, with_lattice
from sweep.plan.own import Own, Unsteered
from sweep.plan.problems import SpecError
from sweep.plan.refine import ROUND, Refine
from sweep.plan.search import Extent, Search, screening_ends
from sweep.plan.section import Section, whole
from sweep.plan.spline import first_places
from sweep.plan.tasks import Tasks, inputs
from sweep.schema import inputs_of

Axes = Mapping[str, Sequence[Any]]
Width = Annotated[float, Field(ge=1e-3, le=0.5, allow_inf_nan=False)]
Count = Annotated[int, BeforeValidator(whole), Field(ge=1, le=10_000)]
# The keys of [search] that belong to what is to be found: those that are needed, and the others with their values.
NEEDED: dict[str, tuple[str, ...]] = {"lowest": ("over",), "level": ("level", "along"), "map": ("over", "error")}
NEEDED["own"] = ("file",)
WORST = "worst"  # with robust, unless `by` says otherwise
LEFT_OUT: dict[str, dict[str, Any]] = {
    "lowest": {"robust": None, "by": None},
    "level": {"crossing": FIRST, "until": 0.02, "most": 50},
    "map": {"round": ROUND, "screen": True},
    "own": {"sha256": None},
}
REDUCE: dict[str, Any] = {"worst": np.max, "median": np.median}
NEAR = len(lowest.around([1.0], 0.1))  # values that stand for one of an axis, where neighbours count
MAP_AXES_MAX = 3  # a map of four begins with thousands of places
IMPACT = ("M_over_M0", "V_over_V0")  # the axes around which neighbours count
NO_NUMBER = ("error", "condition", "spread_low", "spread_high", "seconds")  # columns of which nothing is to be found


class Adaptive(Section):
    """Compute only what the search for N_transition asks for, starting from the N of the grid on every line."""

    find: Literal["level", "log_slope"] = "level"  # "level": a fall through 1; "log_slope": the steepest fall
    until: Width = 0.02  # relative width of a bracket
    most: Count = 50  # N added to one line

    def problems(self, grid: Collection[str], axes: Axes, layout: np.dtype[Any], certified: bool) -> list[str]:
        """What is wrong with this search of a grid."""
        if not grid or (len(axes.get("N", ())) < fall.START_MIN and "N" in axes):
            N = list(axes["N"]) if grid else "none"
            return [f"grid.N: an adaptive sweep starts from at least {fall.START_MIN} values, got {N}"]
        return []

    def every(self, axes: Axes) -> Tasks:
        """All tasks that may be asked for."""
        return Tasks(with_lattice(axes, "N", self.until))

    def search(self, axes: Axes, sampler: Path | None = None) -> Search:
        """The search, with nothing learnt."""
        return Lines(axes, "N", self._rule(), above=0.0)

    def extent(self, axes: Axes) -> Extent:
        """How much it computes."""
        return extent(axes, "N", self._rule())

    def _rule(self) -> fall.Rule:
        return fall.Rule(self.find, self.until, self.most)


class Sought(Section):
    """Compute only what is needed of the grid to find a number in it."""

    # "lowest": in every cell of the other axes the lowest number over some of them. "level": where a number crosses a
    # level along one axis, on every line. "map": as much of every plane of some axes as interpolation needs. "own":
    # whatever a sampler of your own asks for.
    find: Literal["lowest", "level", "map", "own"]
    of: str = "ke_ratio"  # the column of the table in which it is looked for
    # With "lowest": the axes over which the lowest is looked for. With "map": the axes of the map, at most three, whose
    # values in the grid are the finest that may be computed.
    over: list[str] | None = None
    # With "lowest": not the number itself counts, but the worst of those of the impacts at this relative distance in
    # mass, speed or both; over must name one of the two, or both.
    robust: Annotated[float, Field(ge=1e-6, le=0.5, allow_inf_nan=False)] | None = None
    by: Literal["worst", "median"] | None = None  # with robust: which of these numbers counts
    level: Annotated[float, Field(allow_inf_nan=False)] | None = None  # with "level": the number that is crossed
    along: str | None = None  # with "level": the axis, whose values in the grid are where each line starts
    crossing: Literal["first", "last"] | None = None  # with "level": which one, as the axis rises
    until: Width | None = None  # with "level": relative width of a bracket
    most: Count | None = None  # with "level": values added to one line
    # With "map": of the logarithm of what is inferred between computed places, kept in most of those that are calm.
    error: Annotated[float, Field(ge=1e-3, le=2.0, allow_inf_nan=False)] | None = None
    # With "map": the share of a plane that is asked for at once; ranks wait at the end of a round.
    round: Annotated[float, Field(ge=1e-3, le=1.0, allow_inf_nan=False)] | None = None
    # With "map": whether every task is run loosely first, so that only how far that is off is interpolated. A tenth of
    # the grid's work; more than it saves where nothing is certified, or the grid is far finer than its cliffs.
    screen: bool | None = None
    file: str | None = None  # with "own": a file of Python with the class Sampler, beside the spec
    sha256: str | None = None  # of this file, 16 digits; filled in by the sweep, and held to where it is given

    @model_validator(mode="after")
    def _belongs_together(self) -> "Sought":
        if lines := [*self._wrong_keys()]:
            raise SpecError(lines)
        if self.robust is not None and self.by is None:
            object.__setattr__(self, "by", WORST)
        for name, value in LEFT_OUT[self.find].items():  # so that the table spells it out
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)
        return self

    def problems(self, grid: Collection[str], axes: Axes, layout: np.dtype[Any], certified: bool) -> list[str]:
        """What is wrong with this search of a grid whose rows have this layout.

        grid: the names of its axes; axes: those of them whose values are sound.
        """
        there = [*self._wrong_axes(grid), *self._wrong_kind(axes, certified)] if grid else []
        needs = [] if grid else ["search: needs a section [grid]"]
        return [*self._wrong_keys(), *self._wrong_column(layout), *there, *needs]

    def _given(self) -> set[str]:
        """The keys that are there, sound or not."""
        return {name for name in self.model_fields_set if getattr(self, name) is not None} | {*self._unsound}

    def _own(self) -> Collection[str]:
        """The keys that what is to be found has; all, where that is not known."""
        return (*NEEDED[self.find], *LEFT_OUT[self.find]) if self.find else Sought.model_fields

    def _wrong_keys(self) -> Iterator[str]:
        """Those that are missing, and those that stand only beside others."""
        given, own = self._given(), self._own()
        for name in NEEDED.get(self.find, ()):
            if name not in given:
                yield f'search.{name}: is missing, which find = "{self.find}" needs'
        for name in sorted(given - {"find", "of", *own}):
            homes = " or ".join(f'"{find}"' for find in NEEDED if name in (*NEEDED[find], *LEFT_OUT[find]))
            yield f'search.{name}: stands only with find = {homes}, got find = "{self.find}"'
        if self.by is not None and "by" in own and "robust" not in given:
            yield f'search.by: needs robust, got by = "{self.by}" alone'

    def _wrong_column(self, layout: np.dtype[Any]) -> Iterator[str]:
        inputs = inputs_of(layout)
        known = [n for n in layout.names or () if layout[n].kind == "f" and n not in (*inputs, *NO_NUMBER)]
        known = [name for name in known if not name.endswith("_error")]
        if self.of not in known:
            from kernel.columns import columns_of_quantity
            from kernel.quantities import QUANTITIES  # and with it numba, which most plans do without

            quantity = next((name for name in QUANTITIES if self.of in columns_of_quantity(name)[:3]), "")
            way = f" (add {quantity!r} to output.observe)" if quantity else did_you_mean(self.of, known)
            yield f"search.of: must be one of {', '.join(known)}, got {self.of!r}{way}"

    def _wrong_axes(self, grid: Collection[str]) -> Iterator[str]:
        for key, names in (("over", self.over), ("along", None if self.along is None else [self.along])):
            if names is None or key not in self._own():
                continue
            if not names or len(set(names)) < len(names):
                yield f"search.{key}: must name distinct axes, at least one, got {names}"
            for name in names:
                if name not in grid:
                    yield f"search.{key}: the grid has no axis {name!r}{did_you_mean(name, grid)}"
                elif self.find in ("level", "map") and takes_whole(name) and name != "N":
                    yield f"search.{key}: must not name a seed, as nothing lies between two of them, got {name!r}"

    def _wrong_kind(self, axes: Axes, certified: bool) -> Iterator[str]:
        if self.find == "lowest" and not certified:
            yield "accuracy.certify: must be true, as the lowest of numbers that nobody has checked is low by luck"
        yield from self._wrong_neighbours(axes) if self.find == "lowest" and "robust" in self._given() else ()
        yield from self._wrong_map(axes) if self.find == "map" else ()
        start = axes.get(self.along or "") if self.find == "level" else None
        if start is not None and len(start) < ENDS:
            got = list(start)
            yield f"grid.{self.along}: a line needs at least {ENDS} values to start from, got {got}"

    def _wrong_map(self, axes: Axes) -> Iterator[str]:
        if len(self.over or ()) > MAP_AXES_MAX:
            yield f"search.over: a map has at most {MAP_AXES_MAX} axes, got {self.over}"
        for name in self.over or ():
            if name in axes and list(axes[name]) != sorted(axes[name]):
                yield f"grid.{name}: the values of a map's axis must ascend, got {list(axes[name])}"

    def _wrong_neighbours(self, axes: Axes) -> Iterator[str]:
        if not set(self.over or ()) <= set(IMPACT):
            yield f"search.over: with robust must name {' or '.join(IMPACT)} or both, and nothing else, got {self.over}"
        for name in [name for name in self.over or () if name in IMPACT and name in axes and self.robust is not None]:
            values = lowest.around(axes[name], self.robust or 0.0)
            if len(set(values)) < len(values):
                yield f"grid.{name}: values must lie further apart than search.robust, got robust = {self.robust:g}"
            yield from (f"search.robust: leads to a {line}" for v in values if (line := broken_rule(name, v)))

    def every(self, axes: Axes) -> Tasks:
        """All tasks that may be asked for."""
        if self.find in ("map", "own"):
            return Tasks(axes)
        if self.find == "lowest":
            near = {name: lowest.around(axes[name], self.robust) for name in self.over or ()} if self.robust else {}
            return Tasks({**axes, **near})
        along, rule = self._crossing()
        return Tasks(with_lattice(axes, along, rule.until))

    def search(self, axes: Axes, sampler: Path | None = None) -> Search:
        """The search, with nothing learnt; `sampler`: the file that steers it, if it is the user's own."""
        if self.find == "own":
            return Unsteered(Tasks(axes), self.of) if sampler is None else Own(Tasks(axes), self.of, sampler)
        if self.find == "lowest":
            return self._lowest(axes)
        if self.find == "map":
            screen = self.screen is not False
            return Refine(Tasks(axes), self.over or [], self.of, self.error or 0.0, self.round or ROUND, screen)
        along, rule = self._crossing()
        return Lines(axes, along, rule, self.of)

    def extent(self, axes: Axes) -> Extent:
        """How much it computes."""
        if self.find == "own":
            return Extent(0, math.prod(map(len, axes.values())))
        if self.find == "lowest":
            tasks = math.prod(map(len, self.every(axes).axes.values()))
            return Extent(0, tasks, screening_ends(self.of), tries=True)
        if self.find == "map":
            shape = [len(axes[name]) for name in inputs(axes) if name in (self.over or ())]
            first = first_places(shape)
            tasks = math.prod(map(len, axes.values()))
            screens = 0.0 if self.screen is False else math.inf
            return Extent(len(first) * (tasks // math.prod(shape)), tasks, screens)
        along, rule = self._crossing()
        return extent(axes, along, rule)

    def _lowest(self, axes: Axes) -> Search:
        tasks, over = self.every(axes), self.over or []
        if self.robust is None:
            return lowest.Lowest(tasks, over, self.of)
        first = 1 if self.by == "worst" else NEAR ** len(over)  # a single number bounds the worst, not the median
        return lowest.Lowest(tasks, over, self.of, NEAR, REDUCE[self.by or ""], first)

    def _crossing(self) -> tuple[str, Crossing]:
        assert self.along and self.level is not None and self.crossing and self.until and self.most
        return self.along, Crossing(self.level, self.crossing, self.until, self.most)


def section_of(resolved: Mapping[str, Any]) -> Adaptive | Sought | None:
    """The section of a table's resolved spec that tells its search; None of a whole grid. ValueError where damaged."""
    if "adaptive" in resolved:
        return Adaptive.model_validate(resolved["adaptive"])
    if "search" not in resolved:
        return None
    earlier = {} if resolved["search"].get("find") != "map" else {"screen": False}  # of versions without this key
    return Sought.model_validate(earlier | resolved["search"])
