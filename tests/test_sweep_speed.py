"""How fast this machine is is measured once and remembered; a plan then needs no compiled code."""

import json
import subprocess
import sys
from pathlib import Path

import numba
import pytest
from numba.misc.appdirs import user_cache_dir

import kernel.ke
from sweep import machine
from sweep.plan import cost, speed

# Whether this process has loaded the compiler, without which there is no compiled code.
PLAN = """
import sys
from sweep import cli
assert cli.main(["plan", sys.argv[1]]) == 0
print("loaded", *({"numba", "pandas", "scipy"} & set(sys.modules)))
"""


@pytest.fixture
def remembered(tmp_path, monkeypatch):
    """The file of a fresh folder."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "new" / "cache"))
    return tmp_path / "new" / "cache" / speed.FILE


@pytest.fixture
def batches(monkeypatch):
    """How many tasks the kernel was asked for, call by call; it gives nothing."""
    asked = []
    monkeypatch.setattr(kernel.ke, "results_of", lambda columns, *_, **__: asked.append(len(columns["N"])))
    return asked


def test_what_was_measured_is_remembered(remembered, batches):
    first = speed.seconds_per_work()
    assert batches == [1] + [12] * speed.REPEATS
    assert speed.seconds_per_work() == first
    assert len(batches) == 1 + speed.REPEATS
    assert [path.name for path in remembered.parent.iterdir()] == [speed.FILE]


def test_measure_measures_whatever_is_remembered(remembered, batches):
    for count in (1, 2):
        speed.measure()
        assert len(batches) == count * (1 + speed.REPEATS)


def test_a_new_fit_of_the_cost_model_changes_what_follows_from_the_same_seconds(remembered, batches, monkeypatch):
    first, predict = speed.seconds_per_work(), cost.predict_work
    monkeypatch.setattr(speed, "predict_work", lambda *args, **kwargs: 2.0 * predict(*args, **kwargs))
    assert speed.seconds_per_work() == pytest.approx(first / 2)
    assert len(batches) == 1 + speed.REPEATS


@pytest.mark.parametrize("changed", ["processor_name", "source_hash"])
def test_another_processor_or_kernel_is_measured_and_another_processor_forgets_nothing(
    changed, remembered, batches, monkeypatch
):
    first = speed.seconds_per_work()
    with monkeypatch.context() as other:
        other.setattr(speed, changed, lambda: "other")
        speed.seconds_per_work()
        assert len(batches) == 2 * (1 + speed.REPEATS)
    if changed == "processor_name":
        assert speed.seconds_per_work() == first
        assert len(batches) == 2 * (1 + speed.REPEATS)


def entry(seconds):
    return json.dumps({machine.processor_name(): {"of": speed._identity(), "seconds": seconds}})


DAMAGED = [
    b"",
    b"\xff\xfe",
    b"{",
    b"[]",
    b"[" * 100_000,
    *(entry(seconds).encode() for seconds in (None, "1", -1.0, 0.0, float("nan"), float("inf"), True, [1.0])),
    json.dumps({machine.processor_name(): 1.0}).encode(),
]


@pytest.mark.parametrize("content", DAMAGED, ids=range(len(DAMAGED)))
def test_a_damaged_file_is_measured_anew_and_replaced(content, remembered, batches):
    remembered.parent.mkdir(parents=True)
    remembered.write_bytes(content)
    for _ in range(2):
        assert 0 < speed.seconds_per_work() < float("inf")
    assert len(batches) == 1 + speed.REPEATS


def test_where_nothing_can_be_written_every_plan_measures(tmp_path, monkeypatch, batches):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    for count in (1, 2):
        assert speed.seconds_per_work() > 0
        assert len(batches) == count * (1 + speed.REPEATS)


def test_of_a_read_only_installation_the_cache_is_the_users_as_numba_has_it(tmp_path, monkeypatch):
    for name in ("HOME", "XDG_CACHE_HOME"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    assert machine.cache_folder() == Path(kernel.__file__).parent / "__pycache__"
    monkeypatch.setattr("os.access", lambda path, mode: False)
    assert machine.cache_folder() == Path(user_cache_dir("numba", appauthor=False)) == tmp_path / "numba"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert machine.cache_folder() == Path(user_cache_dir("numba", appauthor=False)) == tmp_path / ".cache" / "numba"


def test_the_command_run_measures_anew(small_spec, tmp_path, remembered):
    from sweep import cli

    remembered.parent.mkdir(parents=True)
    remembered.write_text(entry(1.0))
    assert cli.main(["run", str(small_spec), "-o", str(tmp_path / "t.h5")]) == 0
    (told,) = json.loads(remembered.read_text()).values()
    assert 0 < told["seconds"] < 1.0


@pytest.mark.parametrize("accuracy", ["target = 1e-3", 'method = "rk45"\nrtol = 1e-4', "certify = false"])
def test_a_plan_of_a_machine_whose_speed_is_remembered_loads_no_compiled_function(accuracy, small_spec, environment):
    speed.seconds_per_work()
    small_spec.write_text(small_spec.read_text().replace("target = 1e-2", accuracy))
    told = subprocess.run(
        [sys.executable, "-P", "-c", PLAN, str(small_spec)],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        timeout=240,
    )
    assert told.stdout.splitlines()[-1] == "loaded"


def test_a_plan_that_has_to_compile_says_so(remembered, monkeypatch, capsys):
    monkeypatch.setattr(kernel.ke, "results_of", lambda *_, **__: numba.njit(lambda x: x + 1)(1))
    speed.seconds_per_work()
    assert capsys.readouterr().err.startswith("sweep: compiling the kernel, once")
