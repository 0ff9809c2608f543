"""Our searches beside other samplers, all in one run: tasks and seconds to the same quality.

    python -m tests.beside [--lowest jobs/paper/quick/fig8.toml] [--map jobs/paper/fig4.toml] [--cells 100] [--ranks 2]

Computes the whole grid and our search of both specs, then lets the others look tasks up in the grids: a line for each
sampler and share of the tasks, of cells whose lowest is looked for (tests.samplers), then of the map (tests.maps).
Optuna's TPE and python-adaptive's learner are tried where they are installed (pip install optuna adaptive).
"""

import argparse
import tempfile
from pathlib import Path

import sweep
from sweep.plan.toml import as_toml
from tests import maps, samplers
from tests.searches import QUICK, SEARCH

FIGURE_4 = Path(__file__).parent.parent / "jobs/paper/fig4.toml"
MAP = {"find": "map", "over": maps.AXES, "error": maps.WITHIN}
MAPS = {"map": MAP, "map, not screened": MAP | {"screen": False}}


def computed(spec: Path, search: dict[str, object] | None, name: str, folder: Path, ranks: int) -> Path:
    """The table of a grid, or of this search of it."""
    text = spec.read_text() + ("\n" + as_toml({"search": search})[0] if search else "")
    (folder / f"{name}.toml").write_text(text)
    return sweep.run(folder / f"{name}.toml", folder / f"{name}.h5", ranks, progress=False).table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lowest", type=Path, default=QUICK)
    parser.add_argument("--map", type=Path, default=FIGURE_4)
    parser.add_argument("--cells", type=int, default=100, help="whose lowest is looked for; 0: the map alone")
    parser.add_argument("--ranks", type=int, default=2)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if args.cells:
            grid = computed(args.lowest, None, "cells", folder, args.ranks)
            samplers.tell(grid, computed(args.lowest, SEARCH, "lowest", folder, args.ranks), args.cells)
        plane = computed(args.map, None, "plane", folder, args.ranks)
        maps.tell(plane, [computed(args.map, asked, kind, folder, args.ranks) for kind, asked in MAPS.items()])


if __name__ == "__main__":
    main()
