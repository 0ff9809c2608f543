"""`sweep doctor` tries out what a machine can do and leaves nothing behind."""

import errno
import json
import os

import h5py
import pytest

pytestmark = pytest.mark.mpi


def test_here_a_sweep_can_run(sweep, tmp_path):
    answer = sweep("doctor", "--json", tmp_path)
    assert answer.returncode == 0, answer.stderr
    told = json.loads(answer.stdout)
    assert told["can_run"]
    verdicts = {each["what"]: each["verdict"] for each in told["findings"]}
    assert verdicts["one process"] == verdicts["locks"] == "good"
    if h5py.get_config().mpi:
        assert verdicts["HDF5"] == verdicts["MPI"] == "good"
    assert list(tmp_path.iterdir()) == []


def test_no_file_of_the_current_folder_takes_a_librarys_place(tmp_path, monkeypatch):
    from sweep.site import doctor

    (tmp_path / "h5py.py").write_text("raise SystemExit('mine')")
    monkeypatch.chdir(tmp_path)
    verdict, told = doctor._written(tmp_path, 1)
    assert verdict == doctor.GOOD, told


def test_under_a_launcher_one_process_is_still_one_process(tmp_path, monkeypatch):
    from sweep.site import doctor

    for name, value in {"PMI_RANK": "0", "PMI_SIZE": "1", "PMI_FD": "99"}.items():
        monkeypatch.setenv(name, value)
    verdict, told = doctor._written(tmp_path, 1)
    assert verdict == doctor.GOOD, told


def test_it_speaks_plainly(sweep, tmp_path):
    answer = sweep("doctor", tmp_path)
    assert answer.stdout.endswith("a sweep can run here\n")
    assert "killed in the middle" in answer.stdout


def test_a_folder_that_cannot_be_written_is_refused(sweep, unprivileged, tmp_path):
    missing = sweep("doctor", tmp_path / "missing")
    assert missing.returncode == 2
    assert missing.stderr.startswith("sweep: ")
    (tmp_path / "closed").mkdir(mode=0o500)
    closed = unprivileged("doctor", "closed")
    assert closed.returncode == 2
    assert "closed: cannot be written: Permission denied" in closed.stderr


def test_a_disk_without_room_for_a_table_is_bad(tmp_path, monkeypatch, capsys):
    from collections import namedtuple

    from sweep import cli

    usage = namedtuple("usage", "free")
    monkeypatch.setattr("shutil.disk_usage", lambda _: usage(1000))
    assert cli.main(["doctor", str(tmp_path)]) == 2
    out, err = capsys.readouterr()
    assert err == ""
    assert "\nbad   one process  the disk has no room for a small table\n" in out
    assert out.endswith("a sweep cannot run here: see the lines that begin with bad\n")
    assert not list(tmp_path.iterdir())


def test_without_mpirun_one_process_is_what_there_is(sweep, environment, tmp_path, monkeypatch):
    from sweep.site import doctor

    monkeypatch.setattr(doctor.launch, "mpirun", lambda: None)
    monkeypatch.setattr(doctor.shutil, "which", lambda *_, **__: None)
    findings = {each.what: each for each in doctor.examine(tmp_path)}
    assert findings["MPI"].verdict == doctor.LIMIT
    assert "one process only" in findings["MPI"].told
    assert doctor.can_run(list(findings.values()))


def test_a_launcher_of_another_mpi_is_found_out(monkeypatch, tmp_path):
    from sweep.site import doctor

    foreign = tmp_path / "mpirun"
    foreign.write_text('#!/bin/sh\nshift 2\nexec "$@"\n')
    foreign.chmod(0o755)
    monkeypatch.setattr(doctor.launch, "mpirun", lambda: str(foreign))
    finding = next(each for each in doctor.examine(tmp_path) if each.what == "MPI")
    assert finding.verdict == doctor.LIMIT


@pytest.mark.parametrize(("ranks", "verdict", "who"), [(1, "bad", "1 rank started"), (2, "limit", "2 ranks started")])
def test_what_dies_before_it_writes_is_told_and_bad_where_it_is_one_process(monkeypatch, tmp_path, ranks, verdict, who):
    from sweep.site import doctor

    broken = tmp_path / "broken"
    broken.write_text("#!/bin/sh\necho 'first words' >&2\necho 'no libmpi' >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setattr(doctor.sys, "executable", str(broken))
    monkeypatch.setattr(doctor.launch, "mpirun", lambda: str(broken))
    assert doctor._written(tmp_path, ranks) == (verdict, f"{who}, and wrote nothing: no libmpi")


SINFO = {
    "up": ("echo 'day up'; echo 'night down'; echo 'day up'", "good", "to day"),
    "no controller": (
        "echo 'slurm_load_partitions: Unable to contact slurm controller (connect failure)' >&2; exit 1",
        "limit",
        "Unable to contact slurm controller (connect failure)",
    ),
    "no partition": ("echo 'day down'", "limit", "no partition is up"),
    "no answer": ("exec sleep 60", "limit", "does not answer within 1 s"),
}


@pytest.mark.parametrize("case", SINFO)
def test_slurm_is_good_only_by_its_controllers_word(case, monkeypatch, tmp_path):
    from sweep.site import asking, doctor, slurm

    script, verdict, told = SINFO[case]
    for name in ("sbatch", "squeue", "scontrol", "scancel", "sinfo"):
        (tmp_path / name).write_text(f"#!/bin/sh\n{script}\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    monkeypatch.setattr(asking, "ANSWER_WITHIN", 1.0)
    answer = doctor.scheduler(slurm.Slurm())
    assert answer.verdict == verdict
    assert told in answer.told


@pytest.mark.parametrize("compiled", [True, False])
def test_a_folder_without_room_for_the_compiled_kernel_is_told(monkeypatch, tmp_path, compiled):
    from sweep.site import doctor

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    if compiled:
        (tmp_path / "function.nbc").touch()
        assert doctor._cache() == (doctor.GOOD, f"compiled code in {tmp_path}")
    monkeypatch.setattr(os, "posix_fallocate", full)
    verdict, told = doctor._cache()
    assert verdict == doctor.LIMIT
    assert "kept" in told
    assert str(tmp_path) in told
    assert "(No space left on device)" in told


def test_a_folder_for_the_compiled_kernel_that_cannot_be_made_is_told(monkeypatch):
    from sweep.site import doctor

    monkeypatch.setenv("NUMBA_CACHE_DIR", "/proc/nowhere")  # which root, too, cannot make
    verdict, told = doctor._cache()
    assert verdict == doctor.LIMIT
    assert told.startswith("the compiled kernel cannot be kept in /proc/nowhere (")


def test_the_disk_is_counted_in_rows_of_the_table(tmp_path, monkeypatch):
    from collections import namedtuple

    from sweep.schema import ROW
    from sweep.site import doctor

    usage = namedtuple("usage", "free")
    monkeypatch.setattr(doctor.shutil, "disk_usage", lambda _: usage(3e6 * ROW.itemsize))
    assert ", 3 million rows" in doctor.disk(tmp_path)[1]
