"""What the kernel costs and reaches, without any peer: the domain, its extremes, each saving on and off.

    python -m tests.measure [--tasks 4096] [--keep]

Times are processor times of one core; only their ratios mean much on a shared machine.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from kernel import Impact, Scene, ke_ratios, rk45, simulate
from kernel.integrate import run_by
from kernel.ke import PARAMETERS, results_of
from kernel.method import EXPLICIT, SWITCH, choose
from kernel.model import make_chain
from kernel.quantities import QUANTITIES
from kernel.simd import SINGLE
from kernel.splitting.explicit import run_explicit
from kernel.splitting.rules import explicit_rule
from kernel.task import V0
from kernel.watch import new_watch
from tests.measured import keep

REFERENCES = Path(__file__).parent / "data" / "references.csv"
TARGETS = (1e-1, 1e-2, 1e-3, 1e-4)
Figures = Iterator[tuple[str, str]]  # what, and how much
WELL_CONDITIONED = 100  # |d ln ke_ratio / d ln V|


def seconds(work: Callable[[], object], repeats: int = 5) -> float:
    """Least processor time of some repeats; the first may compile."""
    best = np.inf
    for _ in range(repeats):
        start = time.process_time()
        work()
        best = min(best, time.process_time() - start)
    return best


def drawn(count: int) -> np.ndarray:
    """Random tasks of the paper's domain, one a row."""
    rng = np.random.default_rng(4096)
    low, high = np.log([5, 1e-5, 0.1, 0.1]), np.log([500, 1.0, 10.0, 10.0])
    table = np.exp(rng.uniform(low, high, (count, 4)))
    table[:, 0] = np.rint(table[:, 0])
    return table


def price(count: int) -> Iterator[dict[str, str]]:
    """What a target costs over the paper's domain, certified and not."""
    table = drawn(count)
    each = {
        certify: {a: seconds(lambda a=a, c=certify: ke_ratios(table, a, certify=c), 2) / count for a in TARGETS}
        for certify in (False, True)
    }
    for accuracy, cost in each[False].items():
        yield {
            "target": f"{accuracy:g}",
            "ms a task, not certified": f"{1e3 * cost:.2f}",
            "over that at 1e-3": f"{cost / each[False][1e-3]:.2f}",
            "certified over not certified": f"{each[True][accuracy] / cost:.1f}",
        }


def of_quantities(count: int) -> Figures:
    """What one quantity, and all together, cost, certified at 1e-3, where dampers are weak, strong, and in all."""
    table, integrator, totals = drawn(count), choose(accuracy=1e-3), np.zeros(3)
    strong, one = table[:, 0] * table[:, 1] >= SWITCH, {"wall_force": QUANTITIES["wall_force"]}
    for where, which in (("weak", ~strong), ("strong", strong)):
        columns, each = dict(zip(PARAMETERS, table[which].T, strict=True)), np.full(3, np.inf)
        for _ in range(7):  # in turn, so that a busy moment of the machine strikes all
            for k, asked in enumerate(({}, one, QUANTITIES)):
                took = seconds(lambda q=asked, c=columns: results_of(c, integrator, True, quantities=q), 1)
                each[k] = min(each[k], took)
        totals += each
        yield f"those of {count} tasks with {where} dampers: one quantity, all over none", _over_none(each)
    yield f"{count} tasks: one quantity, all over none", _over_none(totals)


def _over_none(each: np.ndarray) -> str:
    return ", ".join(f"{x / each[0]:.2f}" for x in each[1:])


def references() -> Figures:
    """The error reached on the stored references."""
    data = np.genfromtxt(REFERENCES, delimiter=",", names=True)
    tasks = {name: data[name] for name in PARAMETERS}
    well = data["condition"] < WELL_CONDITIONED
    for accuracy in (1e-2, 1e-3, 1e-4):
        plain = ke_ratios(tasks, accuracy, certify=False)
        error = np.abs(plain["ke_ratio"] / data["ke_ratio"] - 1)[well]
        told = " / ".join(f"{q:.1e}" for q in np.quantile(error, [0.5, 0.9, 0.95]))
        yield f"error of {well.sum()} references at {accuracy:g}, not certified: median / 90 % / 95 %", told


def cost_of(N: int, zeta_T: float) -> float:
    """Seconds of one task at (M/M0, V/V0) = (2, 2), accuracy 1e-3, without error estimate."""
    return seconds(lambda: ke_ratios([[N, zeta_T, 2.0, 2.0]], 1e-3, certify=False))


def extremes() -> Figures:
    """No cost cliff in damping, and how cost grows with N."""
    costs = {zeta_T: cost_of(200, zeta_T) for zeta_T in (0.0, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0)}
    told = ", ".join(f"{cost / costs[1e-4]:.2f} at {zeta_T:g}" for zeta_T, cost in costs.items())
    yield "N = 200: cost over that at zeta_T = 1e-4", told
    for zeta_T in (0.0, 4e-4, 0.1):
        yield (
            f"zeta_T = {zeta_T:g}: cost at N = 1000 over N = 100",
            f"{cost_of(1000, zeta_T) / cost_of(100, zeta_T):.1f}",
        )


def of_the_chain(N: int) -> Figures:
    """The window of sites that the wave has reached, and what the linear chain costs."""
    V, a, most = 2.0 * V0, 3e-4, 10**9
    chain, linear = (make_chain(N, 1e-4, 2.0, bistable=bistable) for bistable in (True, False))
    rule, crests = explicit_rule(chain, a), new_watch(())
    on, off = (  # any noise, however small, moves all sites at once
        seconds(lambda x=x: run_explicit(chain, V, rule, rule, most, x, crests, SINGLE)) for x in (0.0, 1e-100)
    )
    yield f"N = {N}: all sites from the start over sites that the wave has reached", f"{off / on:.2f}"
    fine = seconds(lambda: run_explicit(linear, V, rule, rule, most, 0.0, crests, SINGLE))
    hasty = seconds(lambda: run_by(EXPLICIT, linear, V, 0.0, a, most, crests))
    told = f"{fine / on:.2f}, {hasty / on:.2f}"
    yield f"N = {N}: linear chain over bistable chain, with fine steps throughout and until the first arrival", told


def savings() -> Figures:
    """Each saving on and off."""
    yield from of_the_chain(100)
    yield from of_the_chain(500)
    free, damped = (
        seconds(
            lambda z=z: rk45.integrate(
                make_chain(200, z, 2.0, bistable=True), 0.5, 1e-6, 1e-9, 10**9, 450.0, new_watch(())
            )
        )
        for z in (0.0, 1e-12)
    )
    yield "rk45: undamped chain with stage velocities over without", f"{damped / free:.2f}"
    yield from scenes()


def scenes() -> Figures:
    """What observers cost, and what the fast methods save."""
    for N, zeta_T in ((20, 4e-5), (200, 4e-5), (200, 0.1), (1000, 4e-5)):

        def scene(*observe: str, N: int = N, zeta_T: float = zeta_T) -> Scene:
            return Scene(N, zeta_T, Impact(2.0, 2.0), observe=observe)

        alone = seconds(lambda: simulate(scene("peak_ke")))
        slow = seconds(lambda: simulate(scene("peak_ke"), method="rk45"))
        where = f"scene of N = {N}, zeta_T = {zeta_T:g}"
        yield f"{where}: rk45 over auto", f"{slow / alone:.1f}"
        for name in ("ke_field", "energy", "viscous_force", "profile"):
            more = seconds(lambda name=name: simulate(scene("peak_ke", name)))
            yield f"{where}: with {name} over peak_ke alone", f"{more / alone:.2f}"


def start_up() -> Figures:
    """Time to the first task, with a cold and a warm cache and of another law, and the memory of a worker."""
    program = "import kernel; kernel.ke_ratio(20, 1e-3, 1.0, 1.0); kernel.ke_ratio(20, 0.1, 1.0, 1.0)"
    another = "import kernel; kernel.ke_ratio(20, 1e-3, 1.0, 1.0, model=kernel.Model(spring=kernel.Toda(2.0)))"
    steps = {
        "import and two tasks, cold cache": program,
        "import and two tasks, warm cache": program,
        "import and the first task of Toda's lattice, once the paper's chain is compiled": another,
    }
    with tempfile.TemporaryDirectory() as cache:
        for what, lines in steps.items():
            start = time.perf_counter()
            subprocess.run([sys.executable, "-c", lines], env={"NUMBA_CACHE_DIR": cache}, check=True, timeout=600)
            yield what, f"{time.perf_counter() - start:.1f} s"
    # Not ru_maxrss: a child inherits what its parent held.
    program = f"import h5py, mpi4py.MPI; {program}; print(open('/proc/self/status').read())"
    told = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=600)
    most = next(line for line in told.stdout.splitlines() if line.startswith("VmHWM"))
    yield "memory of a worker with a warm cache, at most", f"{1024 * int(most.split()[1]) / 1e6:.0f} MB"


def main() -> None:
    """Print everything."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", type=int, default=4096)
    parser.add_argument("--keep", action="store_true", help="for the documentation (tests.measured)")
    args = parser.parse_args()
    prices, figures = list[dict[str, str]](), list[dict[str, str]]()
    for row in price(args.tasks):
        prices.append(row)
        print(", ".join(f"{name}: {value}" for name, value in row.items()), flush=True)
    parts = (lambda: of_quantities(args.tasks), references, extremes, savings, start_up)
    for what, figure in (pair for part in parts for pair in part()):
        figures.append({"what": what, "figure": figure})
        print(f"{what}: {figure}", flush=True)
    if args.keep:
        keep("price", prices, f"{args.tasks} random tasks of the paper's domain")
        keep("measure", figures, "times on one core")


if __name__ == "__main__":
    main()
