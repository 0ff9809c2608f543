"""A page of a million rows: how large, how soon it can be used, how long a slider's step takes, in a real Chromium.

    python -m tests.million [--rows 1000000] [--openings 3] [--keep]

Times are of the clock, as the page itself takes them: of openings the quickest, as others may want the machine too; of
the steps of that opening the middle one and the slowest.
"""

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from analysis.cli import main as analysis
from sweep.schema import seal
from tests import browser
from tests.measured import keep
from tests.test_analysis_cli import rows, write

IMPACTS = (14, 15)  # values of mass and speed, which have the sliders: figure 8 of the paper has as many


def table(path: Path, many: int) -> int:
    """Write a table of about so many rows, whose results have all their digits; how many they are."""
    cells = max(2, round((many / (IMPACTS[0] * IMPACTS[1])) ** 0.5))
    N = np.unique(np.linspace(5, 5 + 10 * cells, cells).astype(int))
    axes = (N, np.geomspace(1e-5, 1e-2, cells), *(np.geomspace(0.1, 10, n) for n in IMPACTS))
    made, random = rows(axes), np.random.default_rng(22)
    for name in ("ke_bistable", "ke_linear", "t_peak_bistable", "t_peak_linear", "condition", "seconds", "error"):
        made[name] = 10 ** random.uniform(-4, 0, len(made))
    made["ke_ratio"] *= 1 + 0.1 * random.random(len(made))
    made["chaotic"] = random.random(len(made)) < 0.1
    seal(made)
    write(path, made)
    return len(made)


def opened(address: str) -> tuple[float, list[float]]:
    """Seconds until the page can be used, and of each of its sliders' steps."""
    with browser.browser() as running:
        tab = browser.Tab(running, address)
        ready = float(tab.page.evaluate("Number(document.documentElement.dataset.ready)"))
        steps = []
        for k, values in enumerate(IMPACTS):
            slider = tab.page.locator("label.slice input").nth(k)
            for place in range(1, values + 1):
                tab.redrawn(lambda slider=slider, place=place: slider.fill(str(place)))
                steps.append(float(tab.page.evaluate("Number(document.documentElement.dataset.drawn)")))
        if tab.errors:
            sys.exit("\n".join(tab.errors))
    return ready / 1e3, [step / 1e3 for step in steps]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=1_000_000)
    parser.add_argument("--openings", type=int, default=3)
    parser.add_argument("--keep", action="store_true", help="for the documentation (tests.measured)")
    args = parser.parse_args()
    if browser.WHY_NOT:
        sys.exit(browser.WHY_NOT)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "million.h5"
        many = table(path, args.rows)
        page = path.with_suffix(".html")
        start = time.process_time()
        if analysis(["page", str(path), "-o", str(page)]):
            sys.exit("there is no page")
        made = time.process_time() - start
        ready, steps = min(opened(page.as_uri()) for _ in range(args.openings))
        size = page.stat().st_size
    told = {
        "rows": f"{many}",
        "size of the page": f"{size / 1e6:.0f} MB",
        "`analysis page`, processor time": f"{made:.1f} s",
        "until the page can be used": f"{ready:.2f} s",
        "a slider's step, the middle one": f"{np.median(steps):.3f} s",
        "the slowest": f"{max(steps):.3f} s",
    }
    for what, much in told.items():
        print(f"{what:34} {much}")
    if args.keep:
        load = f"{os.getloadavg()[0]:.1f} processes wanted one of {os.cpu_count()} cores meanwhile"
        keep("million", [{"a page of a million rows": what, "": much} for what, much in told.items()], load)


if __name__ == "__main__":
    main()
