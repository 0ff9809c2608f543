"""Random chains that are not uniform, and what is true of them: scipy's DOP853 from the equations of docs/model.md.

Mass, stiffness and damping are graded, random or listed (one site heavy, one link soft), the end free or fixed, the
law any; nothing of kernel/ is used to integrate them. Their condition numbers are those of tests/truth.py.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import DOP853

from kernel.along import Disordered, Graded
from kernel.ke import PARAMETERS
from kernel.lattice import Model
from kernel.laws import Bistable, Hertz, PiecewiseLinear, Polynomial, PowerLaw, Toda
from tests import truth

RTOL, ATOL = 1e-11, 1e-14
M0, V0, CELLS = 0.159, 0.26, 2.25  # as in docs/model.md
AFFORDED = 40_000  # steps of scipy's, of about 0.3 ms each, that are bounded by dampers
SAMPLES = 9  # of a step in which the site's speed may be the largest so far
Array = np.ndarray


class Chain(NamedTuple):
    """The numbers of one chain in the units of docs/model.md."""

    mass: Array
    stiffness: Array
    damping: Array  # 2 N zeta_T d_i
    tension: Callable[[Array], Array]
    K: float  # of the contact, over overlaps in unit cells
    exponent: float
    impactor: float  # its mass over a site's
    t_end: float
    site: int  # from 1


def tension_of(law: Any) -> Callable[[Array], Array]:
    """f(e) as the table of laws in docs/model.md has it."""
    if isinstance(law, Bistable):
        return lambda e: e + law.c2 * np.minimum(e, 0.0) ** 2 + law.c3 * np.minimum(e, 0.0) ** 3
    if isinstance(law, Polynomial):
        return lambda e: e + law.c2 * e**2 + law.c3 * e**3
    if isinstance(law, PowerLaw):
        n, d = law.exponent, law.precompression
        return lambda e: d / n * (1.0 - np.maximum(1.0 - e / d, 0.0) ** n)
    if isinstance(law, Toda):
        return lambda e: -np.expm1(-law.b * e) / law.b
    bends = [
        (at, after - before) for at, before, after in zip(law.strains, (1.0, *law.slopes), law.slopes, strict=False)
    ]
    return lambda e: e + sum(bend * np.minimum(e + at, 0.0) for at, bend in bends)


def chain_of(task: Mapping[str, Any], model: Model, linear: bool) -> Chain:
    """Of a task's four numbers and a model."""
    N, given = int(task["N"]), {}
    for kind in ("mass", "stiffness", "damping"):
        given[kind] = along(getattr(model, kind), N, kind)
    if model.wall == "free":
        given["stiffness"][-1] = given["damping"][-1] = 0.0
    tension = (lambda e: e) if linear else tension_of(model.spring)
    contact = model.contact
    return Chain(
        given["mass"],
        given["stiffness"],
        2.0 * N * task["zeta_T"] * given["damping"],
        tension,
        contact.stiffness / N**contact.exponent,
        contact.exponent,
        N * task["M_over_M0"] * M0,
        model.t_end * N,
        max(1, int(np.ceil(model.site * N - 1e-9))),
    )


def along(given: Any, N: int, kind: str) -> Array:
    """(N,) numbers of sites or links."""
    if hasattr(given, "last"):
        return np.linspace(given.first, given.last, N)
    if hasattr(given, "spread"):  # the numbers themselves are promised by tests/test_kernel_lattice.py
        return np.array(given.values(N, kind))
    return np.array(given) if isinstance(given, tuple) else np.full(N, float(given))


def rates_of(chain: Chain) -> Callable[[float, Array], Array]:
    """Right-hand side of y = (u_0 .. u_N, v_0 .. v_N)."""
    n = len(chain.mass) + 1
    lightness = 1.0 / np.concatenate([[chain.impactor], chain.mass])
    slack, pull = np.zeros(n + 1), np.zeros(n + 1)  # the wall behind; nothing before the impactor

    def rates(_: float, y: Array) -> Array:
        u, v = y[:n], y[n:]
        slack[:n] = u
        e = slack[2:] - slack[1:-1]
        slack[:n] = v
        pull[2:] = chain.stiffness * chain.tension(e) + chain.damping * (slack[2:] - slack[1:-1])
        pull[1] = -chain.K * max(u[0] - u[1], 0.0) ** chain.exponent
        return np.concatenate([v, (pull[1:] - pull[:-1]) * lightness])

    return rates


def affordable(chain: Chain) -> bool:
    """Whether scipy's steps, which dampers bound, are not too many."""
    return bool(chain.t_end * 4.0 * (chain.damping / chain.mass).max() / 6.0 < AFFORDED)


def peak_speed(chain: Chain, V: float) -> float:
    """Largest speed of the watched site over continuous time; nan where scipy gives up."""
    n = len(chain.mass) + 1
    y, at, best = np.zeros(2 * n), n + chain.site, 0.0
    y[n] = V
    run = DOP853(rates_of(chain), 0.0, y, chain.t_end, rtol=RTOL, atol=ATOL * min(1.0, V))
    v, a = 0.0, 0.0
    while run.status == "running":
        run.step()
        v_next, a_next = float(run.y[at]), float(run.f[at])
        if max(abs(v), abs(v_next)) + run.step_size * max(abs(a), abs(a_next)) > best:
            best = max(best, crest(run.dense_output(), run.t_old, run.t, at))
        v, a = v_next, a_next
    return best if run.status == "finished" else np.nan


def crest(seen: Any, start: float, end: float, at: int) -> float:
    """Largest magnitude of one number of the state from `start` to `end`, by samples that close in on it."""
    for _ in range(4):
        t = np.linspace(start, end, SAMPLES)
        values = np.abs(seen(t)[at])
        top = int(values.argmax())
        start, end = t[max(top - 1, 0)], t[min(top + 1, SAMPLES - 1)]
    return float(values.max())


def exact_KE(task: Mapping[str, Any], model: Model) -> tuple[float, float]:
    """Largest kinetic energy of the watched site over TE, of both chains; nan where scipy cannot afford it."""
    V, found = task["V_over_V0"] * V0, []
    for linear in (False, True):
        chain = chain_of(task, model, linear)
        speed = peak_speed(chain, V) if affordable(chain) else np.nan
        found.append(chain.mass[chain.site - 1] * speed**2 / (chain.impactor * V * V))
    return found[0], found[1]


def is_stiff(task: Mapping[str, Any], model: Model) -> bool:
    """Whether dampers bound the steps of Dormand-Prince, too, to more than a reference can afford."""
    chain = chain_of(task, model, linear=True)
    return bool(task["N"] * (chain.damping / chain.mass).max() > truth.STIFF)


def draw(count: int, seed: int, longest: int, law: str = "all") -> tuple[dict[str, Array], list[Model]]:
    """Tasks in columns, and the model of each; one in eight undamped, one in four of a wider box of impacts."""
    rng = np.random.default_rng(seed)
    tasks: dict[str, list[float]] = {name: [] for name in PARAMETERS}
    models = []
    for i in range(count):
        wide = rng.random() < 0.25
        N = int(np.rint(np.exp(rng.uniform(np.log(2), np.log(longest)))))
        reach = 2.0 if wide else 1.0
        zeta_T = 0.0 if rng.random() < 0.125 else 10 ** rng.uniform(-6, 0)
        M, V = 10 ** rng.uniform(-reach, reach), min(20.0, 10 ** rng.uniform(-reach, reach))
        for name, value in zip(PARAMETERS, (N, zeta_T, M, V), strict=True):
            tasks[name].append(value)
        name = list(LAWS)[i % len(LAWS)] if law == "all" else law
        models.append(a_model(rng, N, name))
    return {k: np.array(x, np.int64 if k == "N" else np.float64) for k, x in tasks.items()}, models


def _straight(rng: Any) -> PiecewiseLinear:
    first = 10 ** rng.uniform(-1.5, -0.3)
    return PiecewiseLinear((first, first * rng.uniform(1.5, 4.0)), (rng.uniform(-0.8, 1.5), rng.uniform(0.5, 3.0)))


def _bistable(rng: Any) -> Bistable:
    c3 = rng.uniform(1.0, 8.0)
    return Bistable() if rng.random() < 0.5 else Bistable(rng.uniform(1.0, 2.3) * c3**0.5, c3)


LAWS: dict[str, Callable[[Any], Any]] = {
    "bistable": _bistable,
    "polynomial": lambda rng: Polynomial(rng.uniform(-2.0, 2.0), rng.uniform(0.5, 5.0)),
    "piecewise_linear": _straight,
    "power": lambda rng: PowerLaw(rng.uniform(1.2, 3.0), 10 ** rng.uniform(-2, 0)),
    "toda": lambda rng: Toda(10 ** rng.uniform(-1, 1)),
}


def a_model(rng: Any, N: int, law: str) -> Model:
    """One of this law that is not uniform."""
    numbers = {kind: _along(rng, N, kind) for kind in ("mass", "stiffness", "damping")}
    wall = "free" if rng.random() < 0.3 else "fixed"
    if wall == "fixed" and all(isinstance(x, float) for x in numbers.values()):
        numbers["mass"] = with_one(rng, N)
    return Model(
        spring=LAWS[law](rng),
        contact=Hertz(10 ** rng.uniform(4, 8)) if rng.random() < 0.3 else Hertz(),
        t_end=rng.choice([2.25, 2.25, rng.uniform(0.5, 4.0)]),
        site=rng.choice([0.5, 0.5, rng.uniform(0.0, 0.2) + 1e-4, rng.uniform(0.8, 1.0)]),
        wall=wall,
        **numbers,
    )


def with_one(rng: Any, N: int) -> list[float]:
    """Ones, and somewhere a heavy or a soft one."""
    found = np.ones(N)
    found[rng.integers(N)] = 10 ** rng.uniform(-1.3, 1.7)
    return found.tolist()


def _along(rng: Any, N: int, kind: str) -> Any:
    form = rng.integers(4)
    if form == 0:
        return 10 ** rng.uniform(-0.5, 0.5) if kind == "damping" else 1.0
    if form == 1:
        ends = (1.0, 10 ** rng.uniform(0.0, np.log10(30.0)))
        return Graded(*(ends if rng.random() < 0.5 else ends[::-1]))
    if form == 2:
        return Disordered(rng.uniform(0.05, 0.5), int(rng.integers(2**32)))
    return with_one(rng, N)


def rows(tasks: Mapping[str, Array]) -> Iterator[dict[str, Any]]:
    """Every task by itself."""
    for i in range(len(tasks["N"])):
        yield {name: values[i].item() for name, values in tasks.items()}
