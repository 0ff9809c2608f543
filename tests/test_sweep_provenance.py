"""What a run says about where it ran fits its row and misses nothing that fits."""

import json

import h5py
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep.machine import compiled_for
from sweep.site import schedulers
from sweep.store.reuse import entry
from sweep.store.runs import hosts_text, kinds_of, new_run, places_of, places_text
from sweep.tell.text import of_answer, of_show


def test_every_host_is_told_once_with_its_ranks():
    assert hosts_text(["a", "b", "a", "a"], 192) == "a*3 b*1"


@given(st.lists(st.sampled_from([f"node{k:03}" for k in range(200)]), max_size=400), st.integers(0, 192))
def test_too_many_hosts_are_counted_and_the_text_fits(hosts, room):
    told = hosts_text(hosts, room)
    assert len(told) <= room
    if "more" in told:
        shown, _, more = told.partition("+ ")
        assert len(shown.split()) + int(more.split()[0]) == len(set(hosts))


@given(st.lists(st.sampled_from([f"kind{k:03}-1234abcd" for k in range(9)]), min_size=1, max_size=9))
def test_hosts_and_kinds_of_processors_are_told_together_and_parted_again(kinds):
    hosts = [f"node{k % 50:03}" for k in range(200)]
    told = places_text(hosts, kinds, 192)
    assert len(told) <= 192
    there, processors = places_of(told)
    assert there.startswith("node000*4 node001*4 ")
    assert processors == hosts_text(kinds, 64)
    run = new_run(1, "gather", "0", told)
    assert kinds_of(run) == {one for one in kinds if f"{one}*" in processors}
    assert kinds_of(entry(1, told, "", "")) == kinds_of(new_run(1, "gather", "0", "a*2")) == set()


def set_back(path, kind):
    """As if another kind of processor had computed half of the table, and the run had been stopped."""
    with h5py.File(path, "r+") as file:
        rows, runs = file["results"][()], file["runs"][()]
        half = len(rows) // 2
        rows["status"][half:], rows["checksum"][half:] = b"pending", 0
        runs["hosts"][0] = places_text(["old"], [kind], 192)
        file["results"][...], file["runs"][...] = rows, runs


@pytest.mark.parametrize("kind", ["older-1234abcd", compiled_for()])
def test_a_resumed_run_on_another_kind_of_processor_says_so_and_each_run_names_its_own(
    sweep, small_spec, tmp_path, kind
):
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0
    assert "kind of processor" not in sweep("run", small_spec, "-o", "t.h5").stderr
    set_back(tmp_path / "t.h5", kind)
    again = sweep("run", small_spec, "-o", "t.h5")
    assert again.returncode == 0
    told = f"some rows of this table come of another kind of processor ({kind}; here {compiled_for()})"
    assert again.stderr.count(told) == (kind != compiled_for())
    runs = json.loads(sweep("show", "t.h5", "--json").stdout)["runs"]
    assert [runs[0]["hosts"], runs[0]["processors"]] == ["old*1", f"{kind}*1"]
    assert runs[-1]["processors"] == f"{compiled_for()}*1"


@pytest.mark.parametrize("name", ["NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"])
def test_a_kernel_compiled_for_another_kind_of_processor_by_numbas_settings_is_told_apart(monkeypatch, name):
    before = compiled_for()
    monkeypatch.setenv(name, "")
    assert compiled_for() != before


@pytest.mark.parametrize(
    ("environment", "job"),
    [
        ({}, ""),
        ({"SLURM_JOB_ID": "7"}, "7"),
        ({"SLURM_JOB_ID": "7", "SLURM_RESTART_COUNT": "2"}, "7 restart 2"),
        ({"SLURM_JOB_ID": "9", "SLURM_ARRAY_JOB_ID": "7", "SLURM_ARRAY_TASK_ID": "2"}, "7_2"),
        ({"SLURM_RESTART_COUNT": "2"}, ""),
        ({"LSB_JOBID": "7"}, "7"),
        ({"LSB_JOBID": "7", "LSB_JOBINDEX": "0"}, "7"),
        ({"LSB_JOBID": "7", "LSB_JOBINDEX": "3"}, "7[3]"),
        ({"PBS_JOBID": "7[3].server"}, "7[3].server"),
    ],
)
def test_a_job_is_told_as_its_scheduler_names_it(environment, job):
    assert schedulers.job(environment) == job


def test_what_has_keys_of_its_own_is_shown_below_its_key_one_step_further_in():
    told = of_answer(
        {
            "host": "one",
            "resolved": {"grid": {"N": [5, 8], "zeta_T": list(range(40))}, "output": {"flush_every": 30.0}},
            "runs": [{"rows": 3, "ranks": 2}, {"rows": 4, "ranks": 1}],
            "reused": {},
        }
    )
    assert told.splitlines() == [
        "host            one",
        "resolved",
        "    grid",
        "        N               5, 8",
        "        zeta_T          0, 1, 2, .., 39 (40 values)",
        "    output",
        "        flush_every     30",
        "runs",
        "    1 of 2",
        "        rows            3",
        "        ranks           2",
        "    2 of 2",
        "        rows            4",
        "        ranks           1",
        "reused          -",
    ]


def test_a_git_revision_is_told_as_that_of_the_spec_in_merged_tables_too():
    known = {"git": "abc", "kernel": "123", "merged": [{"table": "a.h5", "git": "def"}]}
    told = of_show(known).splitlines()
    assert told[:2] == ["git of the spec abc", "kernel          123"]
    assert "        git of the spec def" in told
    assert of_show({"merged": "damaged"}) == "merged          damaged"


def test_a_resolved_spec_is_shown_with_every_digit_in_merged_tables_too():
    resolved = {"model": {"spring": {"c2": 5.259193619849357}, "t_end": 2.0, "mass": [1.25, 1.0]}, "N": 5}
    told = of_show({"resolved": resolved, "wall_s": 1.23456, "merged": [{"resolved": resolved}]}).split()
    for number in ("5.259193619849357", "2", "1.25,", "5"):
        assert told.count(number) == 2
    assert "1.235" in told
