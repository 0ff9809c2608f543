"""Scenes of random chains that are not uniform, frame by frame against scipy's DOP853.

    python -m tests.listed_scenes [--random 100] [--seed S] [--longest 60] [--accuracies 1e-2 1e-3 1e-4 1e-5 1e-6]

Chains are those of tests/listed.py. They are struck, released with a first site that is free or held, or driven: at
constant speed, by a ramp, a half sine, a sine or samples, through the contact or holding the first site. Errors are of
displacements and velocities at six times, over the largest that were seen. Condition numbers are told by a neighbour
that is disturbed by 1e-6, at first and on the way. Exit status 1 where less than 99.7 % of those below 100 are within
the accuracy, or one is beyond five times it, as is so where a driver pushes through the contact (docs/limits.md).
"""

import argparse
import time
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import kernel
from tests import listed

ACCURACIES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
FRAMES, KICKS = 6, 4
DISTURBANCE, WELL, FAR, MOSTLY = 1e-6, 100.0, 5.0, 0.997
Array = np.ndarray


def told(drive: kernel.Drive, N: int, size: float) -> Any:
    """Place, velocity and acceleration of a driver at time t, `size` times as large as told."""
    x: Any = drive.speed
    if isinstance(x, float):
        return lambda t: (size * x * t, size * x, 0.0)
    if isinstance(x, kernel.HalfSine | kernel.Harmonic):
        half = N * (x.duration if isinstance(x, kernel.HalfSine) else 0.5 * x.period)
        until, w, s = half if isinstance(x, kernel.HalfSine) else np.inf, np.pi / half, size * x.speed

        def sine(t: float) -> tuple[float, float, float]:
            place = s / w * (1.0 - np.cos(w * min(t, until)))
            return (place, s * np.sin(w * t), s * w * np.cos(w * t)) if t < until else (place, 0.0, 0.0)

        return sine
    ramp = isinstance(x, kernel.Ramp)
    at = N * np.array([0.0, x.rise] if ramp else x.times)
    speeds = size * np.array([0.0, x.speed] if ramp else x.speeds)
    places = np.concatenate([[0.0], np.cumsum(np.diff(at) * 0.5 * (speeds[1:] + speeds[:-1]))])

    def straight(t: float) -> tuple[float, float, float]:
        k = int(np.searchsorted(at, t, side="right")) - 1
        a = (speeds[k + 1] - speeds[k]) / (at[k + 1] - at[k]) if k + 1 < len(at) else 0.0
        dt = t - at[k]
        return places[k] + dt * (speeds[k] + 0.5 * a * dt), speeds[k] + a * dt, a

    return straight


def longest_step(event: Any, N: int) -> float:
    """With which scipy overlooks nothing of what a driver does."""
    x = getattr(event, "speed", None)
    known = {"Ramp": "rise", "HalfSine": "duration", "Harmonic": "period"}
    name = type(x).__name__
    if name in known:
        return 0.1 * N * float(getattr(x, known[name]))
    return 0.5 * N * float(np.diff(x.times).min()) if name == "Samples" else np.inf


def exact(scene: kernel.Scene, t: Array, disturbance: float = 0.0) -> tuple[Array, Array]:
    """Displacements and velocities (frames, N) at times t.

    disturbance: relative, of all that begins; and of the velocities of the sites, at random, KICKS times a frame.
    """
    event, N, n, size = scene.event, scene.N, scene.N + 1, 1.0 + disturbance
    impact = isinstance(event, kernel.Impact)
    M = event.M_over_M0 if impact else 1.0
    task = {"N": N, "zeta_T": scene.zeta_T, "M_over_M0": M, "V_over_V0": 1.0}
    chain, y = listed.chain_of(task, scene.model, linear=scene.law == "linear"), np.zeros(2 * n)
    driver, hold = None, bool(getattr(event, "hold", False))
    if impact:
        y[n] = event.V_over_V0 * listed.V0 * size
    elif isinstance(event, kernel.Release):
        y[1:n], y[n + 1 :], y[0] = size * event.u, size * event.v, -1e9
        driver = (lambda _: (size * event.u[0], 0.0, 0.0)) if hold else None
    else:
        driver = told(event, N, size)
        y[0] = -1e9 if hold else 0.0
    moved = 1 if hold else 0
    free = listed.rates_of(chain)

    def rates(t: float, y: Array) -> Array:
        if driver is None:
            return free(t, y)
        y = y.copy()
        y[moved], y[n + moved], a = driver(t)
        f = free(t, y)
        f[n + moved] = a
        return f

    if driver is not None:
        y[moved], y[n + moved], _ = driver(0.0)
    top = max(
        1e-30,
        np.abs(y[n:]).max(),
        np.abs(y[1:n]).max(),
        scene.speed if driver and not isinstance(event, kernel.Release) else 0.0,
    )
    how = {"rtol": listed.RTOL, "atol": listed.ATOL * min(1.0, top)}
    rng, start, frames = np.random.default_rng(N), 0.0, []
    for moment in t:
        how["max_step"] = min(longest_step(event, N), moment - start)
        for end in np.linspace(start, moment, KICKS + 1)[1:]:
            y[n + 1 :] += disturbance * top * rng.uniform(-1.0, 1.0, N)
            run = solve_ivp(rates, (start, end), y, "DOP853", t_eval=[end], **how)
            if run.status != 0:
                return np.full((len(t), N), np.nan), np.full((len(t), N), np.nan)
            start, y = end, run.y[:, -1].copy()
        frames.append(y)
    seen = np.array(frames).T
    u, v = seen[1:n].T.copy(), seen[n + 1 :].T.copy()
    if driver is not None and hold:
        u[:, 0], v[:, 0] = np.array([driver(x)[:2] for x in t]).T
    return u, v


def an_event(rng: Any, N: int) -> Any:
    """One that makes waves of about the paper's speeds, or of a hundredth of these."""
    size = 10 ** rng.uniform(-2.0, 0.3)
    kind, hold = rng.integers(8), bool(rng.random() < 0.5)
    if kind == 0:
        return kernel.Impact(10 ** rng.uniform(-1, 1), 10 ** rng.uniform(-2, 1))
    if kind in (1, 2):
        shape = rng.integers(3)
        x = np.arange(1, N + 1) / N
        u = size * (rng.normal(size=N) * 0.1 if shape == 0 else np.exp(-(((x - rng.random()) * 10) ** 2)))
        v = size * (rng.normal(size=N) * 0.1 if shape == 1 else np.zeros(N))
        v[0] = 0.0 if hold else v[0]
        return kernel.Release(u, v, hold=hold)
    speed, time = size * rng.choice([-1.0, 1.0], p=[0.2, 0.8] if hold else [0.0, 1.0]), 10 ** rng.uniform(-1.0, 0.3)
    if kind == 3:
        return kernel.Drive(abs(speed), strain=abs(speed) * rng.uniform(0.5, 2.5), hold=hold)
    if kind == 4:
        return kernel.Drive(kernel.Ramp(speed, time), hold=hold)
    if kind == 5:
        return kernel.Drive(kernel.HalfSine(speed, time), hold=hold)
    if kind == 6:
        return kernel.Drive(kernel.Harmonic(speed, time), hold=hold)
    at = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 0.5, 6))])
    return kernel.Drive(kernel.Samples(at, speed * rng.uniform(-0.3, 1.0, 7)), hold=hold)


def draw(count: int, seed: int, longest: int) -> list[kernel.Scene]:
    """Scenes of random chains."""
    tasks, models = listed.draw(count, seed, longest)
    rng, scenes = np.random.default_rng([seed, 1]), []
    for task, model in zip(listed.rows(tasks), models, strict=True):
        event = an_event(rng, task["N"])
        plain = {"N": task["N"], "zeta_T": task["zeta_T"], "event": event, "model": model}
        end = kernel.Scene(**plain, observe="profile", law="bistable")
        span = end.t_end / task["N"]
        scenes.append(kernel.Scene(**plain, observe={"profile": {"at": np.linspace(0.1, 1.0, FRAMES) * span}}))
    return scenes


def apart(here: tuple[Array, Array], there: tuple[Array, Array]) -> float:
    """Largest difference of displacements and of velocities, each over the largest of `there`."""
    found = [np.abs(a - b).max() / np.abs(b).max() for a, b in zip(here, there, strict=True)]
    return float(max(found))


def affordable(scene: kernel.Scene) -> bool:
    """As of tests.listed."""
    task = {"N": scene.N, "zeta_T": scene.zeta_T, "M_over_M0": 1.0, "V_over_V0": 1.0}
    return listed.affordable(listed.chain_of(task, scene.model, linear=False))


def main() -> int:
    """Draw, compare, tell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", type=int, default=100, metavar="COUNT")
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--longest", type=int, default=60, metavar="N")
    parser.add_argument("--accuracies", type=float, nargs="+", default=ACCURACIES)
    args = parser.parse_args()
    errors, conditions = [], []
    for i, scene in enumerate(draw(args.random, args.seed, args.longest)):
        if not affordable(scene):
            continue
        t = np.linspace(0.1, 1.0, FRAMES) * scene.t_end
        true = exact(scene, t)
        condition = apart(exact(scene, t, DISTURBANCE), true) / DISTURBANCE
        off = []
        for accuracy in args.accuracies:
            seen = kernel.simulate(scene, accuracy)
            off.append(apart((seen["profile"]["u"], seen["profile"]["v"]), true) / accuracy)
        errors.append(off)
        conditions.append(condition)
        if max(off) > 1.0 or not max(off) >= 0.0:
            told_off = " ".join(f"{x:.2g}" for x in off)
            print(
                f"  {i}: N={scene.N} zeta_T={scene.zeta_T:.3g} {scene.event}, {type(scene.model.spring).__name__}, "
                f"condition {condition:.2g}: {told_off} accuracies",
                flush=True,
            )
    off, condition = np.array(errors), np.array(conditions)
    well, broken = condition < WELL, False
    print(f"{len(off)} scenes of seed {args.seed}, {well.sum()} of them well-conditioned")
    for accuracy, e in zip(args.accuracies, off.T, strict=True):
        within, worst = np.mean(e[well] <= 1.0), e[well].max()
        broken |= bool(within < MOSTLY or worst > FAR)
        print(f"{accuracy:.0e}: {within:.1%} within, median {np.median(e[well]):.2g}, worst {worst:.2g} accuracies")
    return int(broken)


if __name__ == "__main__":
    raise SystemExit(main())
