"""What a run says about where it ran fits its row and misses nothing that fits."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep.site import schedulers
from sweep.store.runs import hosts_text
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
