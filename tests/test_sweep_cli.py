"""What the commands print, for people and as JSON; what a worker does not load."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from sweep import cli
from sweep.schema import ROW

WORKERS_DO_WITHOUT = {"pandas", "matplotlib", "pydantic"}


@pytest.fixture
def done(sweep, small_spec):
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0
    return sweep


def told(answer) -> dict:
    assert (answer.returncode, answer.stderr) == (0, "")
    return json.loads(answer.stdout)


def test_plan_tells_tasks_cost_and_size_and_writes_nothing(sweep, small_spec, tmp_path):
    plan = told(sweep("plan", small_spec, "--json"))
    assert list(tmp_path.iterdir()) == [small_spec]
    assert (plan["name"], plan["tasks"], plan["looked_at"]) == ("small", 24, 24)
    assert plan["core_hours"] > 0
    walls = [plan["wall_s"][str(k)] for k in (1, 2, 16, 128, 1024)]
    assert walls == sorted(walls, reverse=True)
    assert walls[0] == pytest.approx(3600 * plan["core_hours"])
    assert walls[-1] >= plan["longest_task_s"]
    assert plan["memory_rank_0"] > plan["table_bytes"] > 24 * ROW.itemsize


def test_status_counts_every_task(done):
    status = told(done("status", "t.h5", "--json"))
    assert {key: status[key] for key in ("tasks", "done", "failed", "left")} == {
        "tasks": 24,
        "done": 24,
        "failed": 0,
        "left": 0,
    }
    assert status["running"] is False
    assert status["eta_s"] is None
    assert status["rate_per_s"] > 0


def test_show_tells_where_the_table_comes_from(done, small_spec):
    known = told(done("show", "t.h5", "--json"))
    assert known["spec"] == small_spec.read_text()
    assert known["resolved"]["grid"]["N"] == [5, 8, 13]
    assert known["resolved"]["accuracy"] == {
        "target": 0.01,
        "method": "auto",
        "rtol": None,
        "atol": None,
        "max_steps": 200_000_000,
        "certify": True,
    }
    assert {"bistable-sweep", "numpy", "numba", "h5py", "mpi4py", "python", "HDF5", "MPI"} == set(known["versions"])
    assert all(isinstance(known[key], str) and known[key] for key in ("kernel", "host", "processor", "git"))
    (run,) = known["runs"]
    assert (run["rows"], run["ranks"], run["writer"], run["kernel"]) == (24, 1, "gather", known["kernel"])
    assert run["wall_s"] == known["wall_s"] > 0


def test_every_run_of_a_table_is_remembered(done, small_spec):
    assert done("run", small_spec, "-o", "t.h5").returncode == 0
    runs = told(done("show", "t.h5", "--json"))["runs"]
    assert [run["rows"] for run in runs] == [24, 0]


def test_the_text_for_people_names_what_the_json_names(done):
    for arguments in (("status", "t.h5"), ("show", "t.h5")):
        text = done(*arguments)
        assert (text.returncode, text.stderr) == (0, "")
        first_words = {line.split()[0] for line in text.stdout.splitlines() if line[:1].strip()}
        assert set(told(done(*arguments, "--json"))) <= first_words


def test_the_module_is_the_script(done, environment, tmp_path):
    module = subprocess.run(
        [sys.executable, "-m", "sweep", "status", "t.h5"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert (module.returncode, module.stdout) == (0, done("status", "t.h5").stdout)


def test_paths_with_spaces_and_letters_of_any_language_work(sweep, small_spec, tmp_path):
    folder = tmp_path / "größe 1 · 測試"
    folder.mkdir()
    spec = small_spec.rename(folder / "my spec.toml")
    assert sweep("run", spec, "-o", folder / "my table.h5").returncode == 0
    assert told(sweep("status", folder / "my table.h5", "--json"))["done"] == 24


@pytest.mark.parametrize("argv", [[], ["run", "x.toml"], ["fly"], ["status"], ["merge", "x", "-o", "y", "--z"]])
def test_a_usage_error_exits_2(argv, capsys):
    with pytest.raises(SystemExit) as caught:
        cli.main(argv)
    assert caught.value.code == 2
    assert "usage: sweep" in capsys.readouterr().err


def test_importing_the_package_loads_neither_mpi_nor_what_only_rank_0_needs():
    code = "import sys, sweep.cli, sweep.conduct, sweep.serve.worker; print(*sys.modules)"
    command = [sys.executable, "-P", "-c", code]
    answer = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert not (WORKERS_DO_WITHOUT | {"mpi4py.MPI"}) & set(answer.stdout.split())


@pytest.mark.mpi
def test_a_worker_never_loads_what_only_rank_0_needs(small_spec, tmp_path, environment):
    """The whole run, seen from inside each rank."""
    spy = tmp_path / "spy.py"
    spy.write_text(
        "import sys\nfrom mpi4py import MPI\nfrom sweep.cli import main\n"
        "rank = MPI.COMM_WORLD.rank\n"  # main ends MPI
        f"status = main(['run', {str(small_spec)!r}, '-o', 't.h5'])\n"
        f"open(f'loaded{{rank}}', 'w').write(' '.join(sys.modules))\nsys.exit(status)\n"
    )
    command = [str(Path(sys.executable).parent / "mpirun"), "-n", "2", sys.executable, str(spy)]
    subprocess.run(command, cwd=tmp_path, env=environment, check=True, capture_output=True, timeout=120)
    loaded = [set((tmp_path / f"loaded{rank}").read_text().split()) for rank in (0, 1)]
    assert "pydantic" in loaded[0]
    assert "kernel.ke" in loaded[1]
    assert not WORKERS_DO_WITHOUT & loaded[1]


def test_what_was_not_checked_for_chaos_is_said_to_be_so_and_never_counted_as_calm(sweep, small_spec):
    small_spec.write_text(small_spec.read_text() + "certify = false\n")
    said = [sweep("run", small_spec, "-o", "t.h5"), sweep("status", "t.h5"), sweep("audit", "t.h5")]
    assert said[0].stdout.endswith("; not checked for chaos\n")
    assert "certified       no: not checked for chaos" in said[1].stdout
    assert "24 of them were not checked for chaos" in said[2].stdout
    assert not any("0 chaotic" in answer.stdout + answer.stderr for answer in said)


def test_a_certified_sweep_does_not_say_that_it_was_not_checked(done):
    assert not any("not checked" in done(command, "t.h5").stdout for command in ("status", "audit", "show"))


@pytest.mark.parametrize("certify", ["true", "false"])
def test_plan_and_status_call_certification_by_one_name(sweep, small_spec, certify):
    small_spec.write_text(small_spec.read_text() + f"certify = {certify}\n")
    sweep("run", small_spec, "-o", "t.h5")
    told = [json.loads(sweep(*command, "--json").stdout) for command in (("plan", small_spec), ("status", "t.h5"))]
    assert [answer["certified"] for answer in told] == [certify == "true"] * 2
