"""Scenes of random impacts: how far whole fields are off at an accuracy, and whether `errors` says so.

    python -m tests.scenes [--random 300] [--seed S] [--longest 80] [--accuracies 1e-1 1e-2 1e-3 1e-4 1e-5 1e-6]

Chains are the paper's, bistable or linear, of 2 sites and more; impacts reach a decade beyond its domain. Velocities of
all sites at 90 times, kinetic energies and the total energy are held against Dormand-Prince at an accuracy of 1e-8, as
largest differences over the largest magnitude. Exit status 1 where NEARLY times `errors` covers less than COVERED of
one of these.
"""

import argparse
import time

import numpy as np

import kernel

ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
REFERENCE = 1e-8
ARRAYS = (("profile", "v"), ("ke_field", "ke"), ("energy", "total"))
OBSERVE = {"profile": {"at": np.linspace(0.0, 2.25, 90).tolist()}, "ke_field": {"times": 40}, "energy": {"times": 50}}
STIFF = 3.0  # N zeta_T above which the reference would take minutes
NEARLY, COVERED = 3.0, 0.95


def draw(count: int, seed: int, longest: int) -> list[kernel.Scene]:
    """Random ones, but for those that are STIFF."""
    rng, scenes = np.random.default_rng(seed), list[kernel.Scene]()
    while len(scenes) < count:
        N, zeta_T = int(np.exp(rng.uniform(np.log(2), np.log(longest)))), rng.choice([0.0, 10 ** rng.uniform(-6, 0)])
        impact = kernel.Impact(10 ** rng.uniform(-1.5, 1.5), 10 ** rng.uniform(-1.5, 1.3))
        if N * zeta_T < STIFF:
            scenes.append(kernel.Scene(N, zeta_T, impact, str(rng.choice(["bistable", "linear"])), OBSERVE))
    return scenes


def measured(scene: kernel.Scene, accuracies: tuple[float, ...] = ACCURACIES) -> np.ndarray:
    """Of each accuracy and each of ARRAYS (accuracies, arrays, 2): its error, and what `errors` says of it."""
    true = kernel.simulate(scene, REFERENCE, "rk45")
    found = []
    for accuracy in accuracies:
        seen = kernel.simulate(scene, accuracy, certify=True)
        off = [np.abs(seen[o][key] - true[o][key]).max() / np.abs(true[o][key]).max() for o, key in ARRAYS]
        found.append([(error, seen.errors[o][key]) for error, (o, key) in zip(off, ARRAYS, strict=True)])
    return np.array(found)


def covers(found: np.ndarray, times: float = 1.0) -> np.ndarray:
    """Whether so many times the estimate cover the error, up to the reference's own."""
    return found[..., 0] <= np.maximum(times * found[..., 1], REFERENCE)


def main() -> int:
    """Draw, compare, tell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", type=int, default=300, metavar="COUNT")
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--longest", type=int, default=80, metavar="N")
    parser.add_argument("--accuracies", type=float, nargs="+", default=ACCURACIES)
    args = parser.parse_args()
    scenes = draw(args.random, args.seed, args.longest)
    found = np.array([measured(scene, tuple(args.accuracies)) for scene in scenes])
    print(f"{len(found)} scenes of seed {args.seed}")
    for k, accuracy in enumerate(args.accuracies):
        for j, (observer, key) in enumerate(ARRAYS):
            off, told = found[:, k, j].T
            excess = np.median(told / np.maximum(off, REFERENCE))
            print(
                f"{accuracy:.0e} {observer} {key}: {np.mean(off <= accuracy):.0%} within, worst {off.max():.1e}, "
                f"covered {covers(found[:, k, j]).mean():.1%}, to a factor of {NEARLY:g} "
                f"{covers(found[:, k, j], NEARLY).mean():.1%}, median excess {excess:.1f}"
            )
    return int(covers(found, NEARLY).mean(axis=0).min() < COVERED)


if __name__ == "__main__":
    raise SystemExit(main())
