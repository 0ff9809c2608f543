"""What `sweep plan` foresees: tasks, work, time, memory and the table's size, at once also for the largest sweep."""

import io
import json
import subprocess

import numpy as np
import pytest

from kernel.method import choose
from sweep import cli, conduct
from sweep.errors import InputError
from sweep.plan import cost, forecast
from sweep.plan.search import COMPUTE, SCREEN, TRY
from sweep.plan.spec import parse_spec
from sweep.plan.tasks import Listed, Tasks, keys_of
from sweep.serve.worker import Job
from sweep.tell import report
from sweep.tell.text import duration, of_counts, of_prediction, size

from . import measured
from .conftest import BIN, SMALL, TIME_LIMIT

AUTO = choose()
THOUSAND_MILLION = """
name = "thousand million"
[grid]
N         = { linear = [5, 504], points = 500 }
zeta_T    = { log = [1e-5, 1], points = 200 }
M_over_M0 = { log = [0.1, 10], points = 100 }
V_over_V0 = { log = [0.1, 10], points = 100 }
"""


def grid(*points: int) -> Tasks:
    """A grid of the paper's domain."""
    N, zeta_T, M, V = points
    return Tasks(
        {
            "N": np.linspace(5, 300, N).astype(int),
            "zeta_T": np.geomspace(1e-5, 1, zeta_T),
            "M_over_M0": np.geomspace(0.1, 10, M),
            "V_over_V0": np.geomspace(0.1, 10, V),
        }
    )


def foreseen(tasks: Tasks, exact_max: int = forecast.EXACT_MAX) -> forecast.Forecast:
    return forecast.forecast(tasks, len(tasks), lambda ids: cost.predict_all(tasks, ids, AUTO, True), exact_max)


@pytest.fixture
def looked_at(monkeypatch):
    """How many tasks the cost model was asked for."""
    counted = []
    predict = cost.predict_work

    def spy(columns, *settings):
        counted.append(len(columns["N"]))
        return predict(columns, *settings)

    monkeypatch.setattr(cost, "predict_work", spy)
    return counted


def test_at_least_two_tasks_are_looked_at_as_one_has_no_spread():
    assert foreseen(grid(3, 3, 3, 3), exact_max=4).looked_at == 2


@pytest.mark.parametrize("adaptive", ["", "[adaptive]\n"])
def test_a_thousand_million_tasks_are_planned_by_looking_at_few(adaptive, looked_at, planned, tmp_path):
    path = tmp_path / "large.toml"
    path.write_text(THOUSAND_MILLION + adaptive)
    plan = planned(path)
    assert plan["tasks"] == 1_000_000_000
    assert sum(looked_at) < forecast.EXACT_MAX
    assert plan["looked_at"] == forecast.EXACT_MAX // 4
    assert 0 < plan["core_hours_standard_error"] < 0.02 * plan["core_hours"]
    told = f"{of_counts(plan)}\n{of_prediction(plan)}"
    assert f"sample of {forecast.EXACT_MAX // 4} tasks: standard error " in told
    assert f"tasks          1000000000{' to begin with' * bool(adaptive)}" in told


def test_a_sample_predicts_the_work_of_all_within_its_standard_error():
    tasks = grid(20, 20, 10, 15)
    exact = foreseen(tasks)
    assert (exact.looked_at, exact.standard_error) == (60_000, 0.0)
    few = foreseen(tasks, 12_000)
    assert few.looked_at == 3000
    assert abs(few.seconds - exact.seconds) < 3 * few.standard_error
    assert few.standard_error < 0.05 * exact.seconds
    assert 0.9 * exact.longest < few.longest <= exact.longest
    assert few.wall(1) == few.seconds
    for ranks in (16, 1024):
        assert few.wall(ranks) == pytest.approx(exact.wall(ranks), rel=0.1)


@pytest.mark.parametrize("kind", [Tasks, Listed])
def test_the_longest_task_is_found_at_either_end_though_a_sample_misses_it(kind):
    every = grid(9, 9, 9, 9)
    tasks = every if kind is Tasks else Listed(keys_of(every.columns(np.arange(len(every)))))
    for end in (0, len(tasks) - 1):
        found = forecast.forecast(tasks, len(tasks), lambda ids, end=end: np.where(ids == end, 9.0, 1.0), 40)
        assert (found.longest, found.work.max()) == (9.0, 1.0)


def test_the_standard_error_is_no_smaller_than_the_scatter_of_other_samples(monkeypatch):
    tasks, generator, sums = grid(12, 12, 9, 9), np.random.default_rng, []
    told = foreseen(tasks, 2000).standard_error
    for seed in range(40):
        monkeypatch.setattr(np.random, "default_rng", lambda _, seed=seed: generator(seed))
        sums.append(foreseen(tasks, 2000).seconds)
    assert 0.7 * np.std(sums) < told < 3 * np.std(sums)


@pytest.mark.parametrize("search", ['find = "lowest"', 'find = "map"\nerror = 0.1'])
@pytest.mark.parametrize("observe", ["", 'observe = ["impulse", "wall_force"]'])
def test_a_plan_foresees_of_a_search_what_its_run_will(search, observe, tmp_path, monkeypatch):
    monkeypatch.setattr(report, "seconds_per_work", lambda: 1.0)
    text = f'{SMALL}[search]\n{search}\nover = ["M_over_M0", "V_over_V0"]\n[output]\n{observe}\n'
    text = text.replace("log = [0.3, 3]", "log = [0.5, 1]")
    spec = parse_spec(text, "s")
    n, screens = spec.tasks, spec.new_search().screens
    how = spec.accuracy.integrator(), spec.accuracy.certify, True, spec.output.quantities()
    job = Job(spec.task_list(), *how, screens=screens)
    asks = (COMPUTE, SCREEN, TRY) if spec.extent().tries else (COMPUTE, SCREEN)
    predicted = [conduct._work(job, asked * n + np.arange(n)).sum() for asked in asks]
    plan = report.plan(spec, text, tmp_path)
    near = 1e-9 if observe else 0.2  # of those that share a linear chain a run looks at one
    assert 3600 * plan["screening_core_hours"] == pytest.approx(predicted[SCREEN], rel=near)
    assert 3600 * plan["core_hours"] == pytest.approx(sum(predicted), rel=near)


def test_of_a_small_sweep_every_task_is_looked_at(looked_at):
    tasks = grid(5, 5, 5, 5)
    told = foreseen(tasks)
    assert looked_at == [625]
    assert told.seconds == cost.predict_all(tasks, np.arange(625), AUTO, True).sum()


@pytest.mark.parametrize("points", [1, 40, 4000])
def test_the_table_is_as_large_as_planned(points, sweep, tmp_path):
    """A list of thousands of values is also in the provenance. Created by a run that may start nothing."""
    text = SMALL.replace("log = [0.3, 3], points = 2", f"log = [0.3, 3], points = {points}")
    (tmp_path / "s.toml").write_text(text)
    plan = json.loads(sweep("plan", "s.toml", "--json").stdout)
    assert plan["tasks"] == 12 * points
    assert sweep("run", "s.toml", "-o", "t.h5", "--max-fails", "0", "--until", "1s").returncode in (0, 75)
    assert plan["table_bytes"] == pytest.approx((tmp_path / "t.h5").stat().st_size, rel=0.02)


def test_every_number_of_the_plan_has_its_unit(small_spec, planned):
    plan = planned(small_spec)
    told = f"{of_counts(plan)}\n{of_prediction(plan)}"
    lines = dict(line.split(maxsplit=1) for line in told.splitlines() if line)
    assert lines["tasks"] == "24"
    assert lines["method"].startswith("auto at target 0.01; certified")
    assert "core hours" in lines["work"]
    assert lines["table"] == size(plan["table_bytes"])
    assert lines["memory"] == f"{size(plan['memory_rank_0'])} on rank 0"
    assert lines["ranks"] == "wall time"
    assert all(lines[ranks] == duration(seconds) for ranks, seconds in plan["wall_s"].items())


@pytest.mark.parametrize(
    ("seconds", "told"),
    [(0.04711, "0.0471 s"), (2.43, "2.43 s"), (119, "119 s"), (120, "2 min"), (7200, "2 h"), (4e6, "46.3 d")],
)
def test_a_duration_has_the_largest_unit_of_which_there_are_two(seconds, told):
    assert duration(seconds) == told


def test_sizes_count_in_thousands():
    assert [size(n) for n in (17, 636_320, 1.49e11)] == ["17 bytes", "636 kB", "149 GB"]


def test_an_adaptive_sweep_counts_the_rows_and_tasks_of_its_search():
    spec = parse_spec(SMALL + "[adaptive]\nmost = 1\n", "s")
    search, extent = spec.new_search(), spec.extent()
    assert (extent.first, spec.tasks) == (len(search.ask()), len(search.tasks))
    assert extent.first < extent.at_most < spec.tasks


def test_the_count_is_told_before_the_kernel_is_asked(small_spec, monkeypatch):
    before, pipe = [], io.BytesIO()

    def stopped(*_):
        before.append(pipe.getvalue().decode())
        raise InputError("far enough")

    monkeypatch.setattr(report, "plan", stopped)
    monkeypatch.setattr("sys.stdout", io.TextIOWrapper(pipe))
    assert cli.main(["plan", str(small_spec)]) == 2
    assert "tasks          24\n" in before[0]


def test_the_memory_of_a_rank_is_that_of_the_benchmarks():
    figures = {row["what"]: row["figure"] for row in measured.kept("measure")["rows"]}
    assert figures["memory of a worker with a warm cache, at most"] == size(report.RANK_BYTES)


@pytest.mark.parametrize("flags", [[], ["--json"]])
def test_a_spec_that_can_be_read_only_once_is_planned(flags, small_spec, environment):
    command, given = [str(BIN / "sweep"), "plan", "/dev/stdin", *flags], small_spec.read_bytes()
    told = subprocess.run(command, input=given, env=environment, capture_output=True, timeout=TIME_LIMIT)
    assert (told.returncode, told.stderr) == (0, b"")
    assert (b'"tasks": 24' if flags else b"tasks          24\n") in told.stdout


def test_what_is_no_text_is_told_from_what_was_read_the_first_time(environment):
    command = [str(BIN / "sweep"), "plan", "/dev/stdin"]
    told = subprocess.run(command, input=b"\x89PNG\xff", env=environment, capture_output=True, timeout=TIME_LIMIT)
    assert told.stderr == b"sweep: /dev/stdin: is a PNG picture, not a spec\n"
