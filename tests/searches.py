"""A search for the lowest beside its whole grid, both in one run: how much it computes, how long, how good it is.

python -m tests.searches [SPEC | --random SEED] [--ranks K]    SPEC: a grid; default: jobs/paper/quick/fig8.toml
"""

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

import analysis
import sweep
from sweep.plan.toml import as_toml
from sweep.tell import report

QUICK = Path(__file__).parent.parent / "jobs/paper/quick/fig8.toml"
SEARCH = {"find": "lowest", "over": ["M_over_M0", "V_over_V0"]}
REGIONS = ((0.0, 0.01), (0.01, 0.1), (0.1, 0.4), (0.4, np.inf))  # of N zeta_T


def random_grid(seed: int) -> str:
    """60 cells of 9 x 9 candidates each."""
    rng = np.random.default_rng(seed)
    grid = {
        "N": sorted(set(np.exp(rng.uniform(np.log(5), np.log(300), 10)).astype(int).tolist())),
        "zeta_T": [0.0, *sorted(10 ** rng.uniform(-5.5, -0.5, 5))],
        "M_over_M0": sorted(10 ** rng.uniform(-1, 1, 9)),
        "V_over_V0": sorted(10 ** rng.uniform(-1, 1, 9)),
    }
    return as_toml({"name": f"random-{seed}", "grid": grid, "accuracy": {"target": 1e-2}})[0]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("spec", type=Path, nargs="?", default=QUICK)
    parser.add_argument(
        "--random", type=int, metavar="SEED", help="a grid of random values of the paper's domain instead"
    )
    parser.add_argument("--ranks", type=int, default=1)
    args = parser.parse_args()
    text = args.spec.read_text() if args.random is None else random_grid(args.random)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "grid.toml").write_text(text)
        (Path(folder) / "search.toml").write_text(text + "\n" + as_toml({"search": SEARCH})[0])
        seconds, busy, tables = {}, {}, {}
        for kind in ("search", "grid"):
            start = time.perf_counter()
            finished = sweep.run(Path(folder) / f"{kind}.toml", Path(folder) / f"{kind}.h5", args.ranks, progress=False)
            seconds[kind], tables[kind] = time.perf_counter() - start, analysis.load(finished, done_only=False)
            busy[kind] = sum(run["busy"] for run in report.show(finished.table)["runs"])
        tried = report.status(Path(folder) / "search.h5")["tried"]
    found, whole = (analysis.best(tables[kind]).set_index(["N", "zeta_T"]) for kind in ("search", "grid"))
    excess = found["ke_ratio"] / whole["ke_ratio"] - 1.0
    done = tables["search"]["status"] == "done"
    print(
        f"tasks   {done.sum()} of {len(done)} computed, {done.mean():.1%}; {tried / len(done):.1%} tried; all screened"
    )
    share = busy["search"] / busy["grid"]
    print(f"busy    {busy['search']:.0f} s of all cores, grid {busy['grid']:.0f} s: {share:.3f}")
    print(f"wall    {seconds['search']:.0f} s, grid {seconds['grid']:.0f} s: {seconds['search'] / seconds['grid']:.3f}")
    exact, near = (excess == 0).mean(), (excess <= 0.02).mean()
    print(f"cells   {len(excess)}: {exact:.1%} have the grid's lowest, {near:.1%} are within 2 %,")
    print(f"        {(excess > 0.1).sum()} more than 10 % above it; worst {excess.max():.1%}")
    print(f"checked {found['checked'].all()}; chaotic cells {found['chaotic'].sum()}, grid {whole['chaotic'].sum()}")
    damping = tables["search"]["N"] * tables["search"]["zeta_T"]
    for low, high in REGIONS:
        print(f"N zeta_T from {low:g} to {high:g}: {done[(damping >= low) & (damping < high)].mean():.1%} computed")


if __name__ == "__main__":
    main()
