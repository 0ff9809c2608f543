"""The kernel's numbers bit by bit: what a change that should change none of them is held against.

    python -m tests.bits -o OLD.npz [--tasks 4096] [--seed 1] [--accuracies 1e-1 1e-2 1e-3 1e-4 1e-5 1e-6]
    python -m tests.bits --against OLD.npz
    python -m tests.bits --digest

The first computes the stored reference tasks up to 300 sites and random ones of the domain, certified, at every
accuracy, and keeps what a row says. The second computes the same tasks again and names the rows that differ. Exit
status 1 where one does. Both must run on one processor. The third keeps a digest of fewer rows for this kind of
processor beside those of others (tests/data/numerics.json), after a change that was to change bits: raise
kernel.numerics.NUMERICS before.
"""

import argparse
import hashlib
import json
from pathlib import Path

import numpy as np

from kernel import Bistable, Hertz, Polynomial, ke_ratios, numerics
from kernel.ke import ACCURACY, PARAMETERS
from kernel.lattice import PAPER_MODEL, Model
from tests import promises, truth

DIGESTS = Path(__file__).parent / "data/numerics.json"  # by NUMERICS and kind of processor
LONGEST = 300  # sites
ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
TIGHTEST = 1e-8  # of the accuracies that may be asked for
SHOWN = 10  # rows of an accuracy that differ


def computed(tasks: dict[str, np.ndarray], accuracy: float, model: Model = PAPER_MODEL) -> np.ndarray:
    """The rows, text as bytes."""
    rows = ke_ratios(tasks, accuracy=accuracy, model=model)
    kinds = [(name, rows.dtype[name].str.replace("U", "S")) for name in rows.dtype.names]
    return rows.astype(kinds)


def drawn(count: int, seed: int) -> dict[str, np.ndarray]:
    """The stored tasks, then random ones."""
    stored, random = promises.references(LONGEST), truth.draw(count, seed, LONGEST)
    return {name: np.concatenate([stored[name], random[name]]) for name in PARAMETERS}


def compare(old: Path) -> bool:
    """Whether every row has the bits that it had."""
    with np.load(old) as kept:
        tasks, same = {name: kept[name] for name in PARAMETERS}, True
        for key in kept.files:
            if key in PARAMETERS:
                continue
            before, now = kept[key], computed(tasks, float(key))
            names = before.dtype.names
            assert set(names) == set(now.dtype.names), "other columns"
            differ = np.array([before[name].tobytes() != now[name].tobytes() for name in names])
            rows = [i for i in range(len(before)) if any(before[n][i].tobytes() != now[n][i].tobytes() for n in names)]
            print(f"{key:>6}: {len(rows)} of {len(before)} rows differ", *np.array(names)[differ], flush=True)
            for i in rows[:SHOWN]:
                print("   was", before[i].item(), "\n    is", now[i].item())
            same = same and not rows
    return same


def digest() -> str:
    """Of the rows of stored and random tasks at three targets, of fewer and shorter ones at the tightest, of these
    where the last site is watched and sound does not come to it, of these where links fall into wells far below rest,
    in compression and far out in tension, and of these where the stiffness of the contact jumps.
    """
    tasks, known = drawn(100, 1), hashlib.sha256()
    for accuracy in (1e-2, 1e-3, 1e-4):
        known.update(computed(tasks, accuracy).tobytes())
    known.update(computed(numerics.samples(), TIGHTEST).tobytes())
    known.update(computed(numerics.samples(), ACCURACY, Model(t_end=0.7, site=1.0)).tobytes())
    known.update(computed(numerics.samples(), ACCURACY, Model(spring=Bistable(c2=7.0, c3=4.9))).tobytes())
    known.update(computed(numerics.samples(), ACCURACY, Model(spring=Polynomial(c2=-2.4, c3=0.53))).tobytes())
    known.update(computed(numerics.samples(), 1e-4, Model(contact=Hertz(1e4, 1.0))).tobytes())
    return known.hexdigest()[:16]


def keep_digest() -> None:
    """Write this machine's among those of this version of the bits."""
    known = json.loads(DIGESTS.read_text())
    known.setdefault(str(numerics.NUMERICS), {})[numerics.processor_kind()] = digest()
    DIGESTS.write_text(json.dumps(known, indent=1) + "\n")


def main() -> int:
    """Keep, or compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--against", type=Path)
    parser.add_argument("--tasks", type=int, default=4096)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--accuracies", type=float, nargs="+", default=ACCURACIES)
    parser.add_argument("--digest", action="store_true")
    args = parser.parse_args()
    if args.digest:
        keep_digest()
        return 0
    if args.against:
        return 0 if compare(args.against) else 1
    tasks = drawn(args.tasks, args.seed)
    np.savez(args.output, **tasks, **{f"{a:g}": computed(tasks, a) for a in args.accuracies})
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
