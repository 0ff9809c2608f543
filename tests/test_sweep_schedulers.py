"""PBS, LSF and plain hosts by stand-ins for their commands, made from their documentation: no real one was tried."""

import os
import shlex
import shutil
import subprocess
import time
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import pytest

from sweep import cli
from sweep.site import pbs, schedulers, slurm
from sweep.site.hosts import Hosts
from sweep.site.lsf import Lsf
from sweep.site.pbs import Pbs
from sweep.site.scheduler import Request
from sweep.site.slurm import Slurm

HOUR = 3600.0
SCRIPTS = Path(slurm.__file__).parent / "scripts"
QSTAT = """Job Id: 7.server
    Job_Name = small
    job_state = R
    resources_used.walltime = 01:00:00
    Resource_List.walltime = 02:00:00
    stime = {stime}
    Variable_List = PBS_O_HOME=/home/u,PBS_O_LANG=C,
\tPBS_O_WORKDIR=/home/u/sweeps
"""


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    """stand_in(name, shell): a command that notes how it was called in the file `called`, then does that."""
    folder = tmp_path / "commands"
    folder.mkdir()
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    monkeypatch.chdir(tmp_path)

    def make(name: str, shell: str) -> None:
        path = folder / name
        note = f'printf "%s\\n" "{name} $*" >>{tmp_path}/called'  # one write: two may be called at once
        path.write_text(f"#!/bin/bash\n{note}\n{shell}\n")
        path.chmod(0o755)

    return make


def called(folder: Path) -> list[str]:
    return [line.strip() for line in (folder / "called").read_text().splitlines()]


@pytest.mark.parametrize("script", sorted(SCRIPTS.iterdir()), ids=lambda path: path.name)
def test_every_script_is_correct_shell(script):
    subprocess.run(["bash", "-n", script], check=True, timeout=60)
    if checker := shutil.which("shellcheck"):
        subprocess.run([checker, "-s", "bash", script], check=True, timeout=60)


@pytest.mark.parametrize("name", ["PBS", "LSF", "ssh"])
def test_what_submit_writes_is_correct_shell_and_has_the_sweeps_names(name, small_spec, capsys):
    options = {"ssh": ["--ssh=node1:2", "--ssh=node2:2"]}.get(name, ["--partition", "day", "--account", "us"])
    command = ["submit", str(small_spec), "--scheduler", name, "--ranks", "4", "--writer", "gather", "--dry-run"]
    assert cli.main([*command, *options]) == 0
    script = capsys.readouterr().out
    subprocess.run(["bash", "-n"], input=script, text=True, check=True, timeout=60)
    assert {"ranks=4", "writer=gather", "shards=''", f"spec={small_spec}"} <= set(script.splitlines())
    expected = {
        "PBS": ["#PBS -l select=4:ncpus=1:mpiprocs=1", "#PBS -l walltime=0:11:00", "#PBS -q day", "#PBS -A us"],
        "LSF": ["#BSUB -n 4", "#BSUB -W 0:11", '#BSUB -Q "75"', "#BSUB -q day", "#BSUB -P us"],
        "ssh": ["hosts=node1:2,node2:2"],
    }
    assert set(expected[name]) <= set(script.splitlines())


def test_pbs_gets_an_array_and_what_follows_it(stand_in, small_spec, tmp_path, capsys):
    stand_in("qsub", "echo '12[].server'")
    assert cli.main(["submit", str(small_spec), "--scheduler", "PBS", "--array", "2"]) == 0
    assert "submitted as job 12[].server" in capsys.readouterr().out
    first, second = called(tmp_path)
    assert first == f"qsub -J 1-2 {tmp_path}/small.pbs"
    assert second.startswith("qsub -W depend=afterany:12[].server -N small-merge ")
    assert " merge " in second


@pytest.mark.parametrize(("name", "plain"), [("[new] #5.", "new-5"), ("#", "sweep")])
def test_no_name_is_taken_for_an_option(stand_in, small_spec, tmp_path, capsys, name, plain):
    small_spec.write_text(small_spec.read_text().replace('"small"', f'"{name}"'))
    stand_in("sbatch", "echo 7")
    assert cli.main(["submit", str(small_spec), "--scheduler", "SLURM"]) == 0
    assert cli.main(["submit", str(small_spec), "--scheduler", "SLURM", "-o", "./-t.h5"]) == 0
    assert called(tmp_path) == [f"sbatch --parsable {tmp_path}/{script}.sbatch" for script in (plain, "-t")]
    assert f"#SBATCH --job-name={plain}" in (tmp_path / "-t.sbatch").read_text().splitlines()


def test_what_another_scheduler_would_understand_is_refused(small_spec, capsys):
    others = ["--sbatch=--mem=4G", "--qsub=-l a", "--account", "us", "--ranks", "0"]
    assert cli.main(["submit", str(small_spec), "--scheduler", "ssh", *others]) == 2
    told = capsys.readouterr().err.splitlines()
    assert [line.partition(",")[0] for line in told] == [
        "sweep: --ranks: must be at least 1",
        "sweep: --account: ssh knows none",
        "sweep: --sbatch: is an option of SLURM",
        "sweep: --qsub: is an option of PBS",
    ]


def test_a_job_that_is_refused_leaves_no_script_and_an_array_whose_merge_is_refused_is_told(
    stand_in, small_spec, tmp_path, capsys
):
    command = ["submit", str(small_spec), "--scheduler", "PBS", "--array", "2", "--time", "1:00:00"]
    stand_in("qsub", "echo no such queue >&2; exit 1")
    assert cli.main(command) == 2
    assert capsys.readouterr().err == "sweep: qsub refuses: no such queue\n"
    assert not (tmp_path / "small.pbs").exists()
    stand_in("qsub", "[ $1 = -J ] && echo '12[].server' || { echo full >&2; exit 1; }")
    assert cli.main(command) == 2
    refused, told = capsys.readouterr().err.splitlines()
    assert refused == "sweep: qsub refuses: full"
    assert told.startswith("sweep: wrote small.pbs; submitted as job 12[].server; when all of it is done, ")
    assert (tmp_path / "small.pbs").exists()


def test_lsf_reads_its_directives_and_what_follows_waits_for_the_array(stand_in, small_spec, tmp_path, capsys):
    stand_in("bsub", "[ $# -gt 0 ] || cat >read\necho 'Job <12> is submitted to queue <normal>.'")
    assert cli.main(["submit", str(small_spec), "--scheduler", "LSF", "--array", "2"]) == 0
    assert "submitted as job 12;" in capsys.readouterr().out
    assert '#BSUB -J "small[1-2]"' in (tmp_path / "read").read_text().splitlines()
    first, second = called(tmp_path)
    assert first == "bsub"
    assert second.startswith("bsub -w ended(12) -J small-merge ")


def test_hosts_get_a_shard_each_and_then_the_merge(stand_in, small_spec, tmp_path, sweep, physics):
    """`ssh HOST COMMAND` is a shell here: the shards really run."""
    stand_in("ssh", 'shift; exec bash -c "$*"')
    options = ["--ssh=one:1", "--ssh=two:1", "--scheduler", "ssh"]
    assert cli.main(["submit", str(small_spec), "--array", "2", "-o", "t.h5", *options]) == 0
    until = time.monotonic() + 200
    while not (tmp_path / "t.h5").exists():
        assert time.monotonic() < until, (tmp_path / "t.log").read_text()
        time.sleep(0.2)
    assert sorted(line.split()[1] for line in called(tmp_path)) == ["one", "two"]
    sweep("run", small_spec, "-o", "alone.h5")
    assert physics(tmp_path / "t.h5") == physics(tmp_path / "alone.h5")


@pytest.mark.parametrize("ended", [75, 255])  # 255: ssh's own, of a connection that was lost
def test_a_host_computes_its_shard_with_the_ranks_asked_for_and_is_tried_again(
    stand_in, small_spec, tmp_path, capsys, ended
):
    stand_in("ssh", f"[ $(grep -c ^ssh {tmp_path}/called) -gt 2 ] || exit {ended}")
    stand_in("sleep", "")
    options = ["--scheduler", "ssh", "--ssh=one:4", "--array", "1", "--ranks", "4", "--time", "none", "--dry-run"]
    assert cli.main(["submit", str(small_spec), *options]) == 0
    subprocess.run(["bash"], input=capsys.readouterr().out, text=True, timeout=60, check=True)
    tries = [line for line in called(tmp_path) if line.startswith("ssh")]
    commands = Path(shutil.sys.executable).parent
    assert len(tries) == 3
    assert tries[0].startswith(f"ssh one {commands}/mpirun -n 4 {commands}/sweep run ")


@pytest.mark.parametrize(("status", "again"), [(75, True), (0, False), (2, False)])
def test_a_pbs_job_that_stopped_early_submits_itself_again(stand_in, small_spec, tmp_path, status, again, capsys):
    stand_in("qsub", "echo 13.server")
    stand_in("sweep", f"exit {status}")
    assert cli.main(["submit", str(small_spec), "--scheduler", "PBS", "--ranks", "1", "--dry-run"]) == 0
    script = capsys.readouterr().out.replace(f"bin={Path(shutil.sys.executable).parent}", f"bin={tmp_path}/commands")
    answer = subprocess.run(["bash"], input=script, text=True, timeout=60, check=False, capture_output=True)
    assert answer.returncode == status
    asked = [line for line in called(tmp_path) if line.startswith("qsub")]
    assert asked == ([f"qsub -v SWEEP_TRIES=1,SWEEP_INDEX=1 {tmp_path}/small.pbs"] if again else [])


GIVEN = {
    "SLURM": ["--qos=low", "--mem=4G", "--requeue", "--nodes=2", "--gres=gpu:1", "--output=x.log", "--time-min=5"],
    "PBS": ["-P us", "-l mem=4gb", "-W group_list=us", "-l select=2:ncpus=1", "-J 1-9", "-W depend=afterok:3"],
    "LSF": ["-G us", "-M 4GB", "-R 'rusage[mem=4GB]'", "-R 'span[ptile=16]'", "-x", "-n 3", "-o x.log"],
}
HANDED_ON = {
    "SLURM": ["--qos=low", "--mem=4G", "--requeue"],
    "PBS": ["-P", "us", "-l", "mem=4gb", "-W", "group_list=us"],
    "LSF": ["-G", "us", "-M", "4GB", "-R", "rusage[mem=4GB]"],
}


@pytest.mark.parametrize("scheduler", [Slurm(), Pbs(), Lsf()], ids=lambda each: each.name)
def test_the_job_that_merges_gets_the_options_that_a_site_asks_of_every_job(scheduler):
    plain = Request(Path("s.toml"), name="s", account="us")
    full = replace(plain, others=tuple(GIVEN[scheduler.name]))
    assert not any(map(scheduler.option_problem, full.others))
    without, with_others = (scheduler.follow(each, "7", "merge them") for each in (plain, full))
    assert sorted(with_others) == sorted([*without, *HANDED_ON[scheduler.name]])
    assert with_others[-1] == without[-1]


@pytest.mark.parametrize("tries", [0, 1])
def test_a_shard_that_pbs_ran_again_merges_as_nothing_else_waits_for_it(stand_in, small_spec, tmp_path, tries, capsys):
    stand_in("sweep", f"[ $1 != merge ] || [ $(grep -c ' merge ' {tmp_path}/called) -gt 1 ] || exit 2")
    stand_in("sleep", "")
    assert cli.main(["submit", str(small_spec), "--scheduler", "PBS", "--array", "2", "--dry-run"]) == 0
    script = capsys.readouterr().out.replace(f"bin={Path(shutil.sys.executable).parent}", f"bin={tmp_path}/commands")
    again = {"SWEEP_TRIES": "1", "SWEEP_INDEX": "2"} if tries else {"PBS_ARRAY_INDEX": "2"}
    subprocess.run(["bash"], input=script, text=True, timeout=60, check=True, env=os.environ | again)
    run, *more = [line for line in called(tmp_path) if line.startswith("sweep ")]
    assert run.endswith(f" -o {tmp_path}/small-2-of-2.h5 --writer auto --shard 2/2")
    merge = f"sweep merge {tmp_path}/small-1-of-2.h5 {tmp_path}/small-2-of-2.h5 -o {tmp_path}/small.h5"
    assert more == [merge] * 2 * tries  # again, as another was merging


@pytest.mark.parametrize("ahead", [0.0, HOUR, -HOUR])
def test_pbs_ends_a_job_by_its_own_clock_and_ours_may_differ(stand_in, tmp_path, ahead):
    began = datetime.fromtimestamp(time.time() - HOUR - ahead).strftime("%a %b %d %H:%M:%S %Y")
    (tmp_path / "told").write_text(QSTAT.format(stime=began))
    stand_in("qstat", f"cat {tmp_path}/told")
    end = Pbs().end({"PBS_JOBID": "7.server"})
    stale = pbs.USE_LAGS if ahead else 0.0  # by which the time that the job has used may be out of date
    assert end == pytest.approx(time.time() + HOUR - stale, abs=10)
    assert called(tmp_path) == ["qstat -f 7.server"]


@pytest.mark.parametrize(
    ("limit", "lsf", "pbs"),
    [
        ("90", 90 * 60, 90),
        ("210", 210 * 60, 210),
        ("0:05", 5 * 60, 5),
        ("1:30", 90 * 60, 90),
        ("12:00", 12 * HOUR, 12 * 60),
        ("12:00:00", None, 12 * HOUR),
        ("1-02", None, None),
        ("90m", None, None),
    ],
)
def test_a_limit_is_what_its_scheduler_reads_from_it(small_spec, capsys, limit, lsf, pbs):
    for each, seconds, line in ((Lsf(), lsf, f"#BSUB -W {limit}"), (Pbs(), pbs, f"#PBS -l walltime={limit}")):
        command = ["submit", str(small_spec), "--scheduler", each.name, "--time", limit, "--dry-run"]
        status, (out, err) = cli.main(command), capsys.readouterr()
        if seconds is None:
            assert (status, out) == (2, "")
            assert err.startswith(f"sweep: --time: must be a time as {each.name} writes it, [")
            assert err.endswith(f", got {limit!r}\n")
        else:
            assert (status, each.seconds_of(limit)) == (0, seconds)
            assert line in out.splitlines()


@pytest.mark.parametrize("scheduler", [Slurm(), Pbs(), Lsf()], ids=lambda each: each.name)
def test_every_scheduler_reads_the_limits_that_it_writes(scheduler):
    assert [scheduler.seconds_of(scheduler.time_of(t)) for t in (60.0, 3601.0, 100 * HOUR)] == [60, 3660, 100 * HOUR]


def test_lsf_tells_what_is_left(stand_in, tmp_path):
    stand_in("bjobs", "echo '1:30 L'")
    assert Lsf().end({"LSB_JOBID": "7", "LSB_JOBINDEX": "3"}) == pytest.approx(time.time() + 1.5 * HOUR, abs=60)
    assert called(tmp_path) == ["bjobs -noheader -o time_left 7[3]"]
    stand_in("bjobs", "echo '-'")
    assert Lsf().end({"LSB_JOBID": "7"}) is None


def test_what_a_scheduler_says_in_another_encoding_is_read_all_the_same(stand_in, small_spec, tmp_path, capsys):
    began = datetime.fromtimestamp(time.time() - HOUR).strftime("%a %b %d %H:%M:%S %Y")
    told = QSTAT.format(stime=began).replace("small", "größe")
    (tmp_path / "told").write_text(told, encoding="latin-1")
    stand_in("qstat", f"cat {tmp_path}/told")
    assert Pbs().end({"PBS_JOBID": "7.server"}) == pytest.approx(time.time() + HOUR, abs=130)
    for name in slurm.COMMANDS:
        stand_in(name, r"printf 'welcome to gr\xf6\xdfe: be kind\nday up\nn\xe4chtlich up\nold down\n'")
    assert Slurm().examine() == (True, "jobs can be submitted from here (sweep submit), to day, n\ufffdchtlich")
    stand_in("sbatch", r"printf 'account gr\xf6\xdfe is locked\n' >&2; exit 1")
    assert cli.main(["submit", str(small_spec), "--scheduler", "SLURM"]) == 2
    assert capsys.readouterr().err == "sweep: sbatch refuses: account gr\ufffd\ufffde is locked\n"


@pytest.mark.parametrize("ahead", [0.0, HOUR, -HOUR])
def test_slurms_end_is_told_by_this_nodes_clock(stand_in, ahead):
    controller = time.time() - ahead
    stand_in("sdiag", f"echo 'sdiag output at Mon Nov 22 13:16:01 2026 ({controller:.0f})'")
    inside = {"SLURM_JOB_ID": "7", "SLURM_JOB_END_TIME": f"{controller + HOUR:.0f}"}
    assert Slurm().end(inside) == pytest.approx(time.time() + HOUR, abs=5)


@pytest.mark.parametrize("sdiag", ["echo sdiag output at Mon Nov 22 13:16:01 2026 '('$(date +%s)')'", "true", "exit 1"])
def test_slurms_end_is_as_told_where_clocks_agree_or_the_controllers_is_not_known(stand_in, sdiag):
    stand_in("sdiag", sdiag)
    assert Slurm().end({"SLURM_JOB_ID": "7", "SLURM_JOB_END_TIME": "2000000000"}) == 2e9


def test_of_an_array_slurm_is_asked_for_the_task_and_not_for_the_array(stand_in, tmp_path):
    stand_in("squeue", "date -d '1 hour' +%Y-%m-%dT%H:%M:%S")
    stand_in("sdiag", "exit 1")
    inside = {"SLURM_JOB_ID": "7", "SLURM_ARRAY_JOB_ID": "7", "SLURM_ARRAY_TASK_ID": "3", "SLURM_RESTART_COUNT": "2"}
    assert Slurm().end(inside) == pytest.approx(time.time() + HOUR, abs=5)
    assert called(tmp_path)[0] == "squeue -h -j 7_3 -o %e"


def test_a_command_is_a_sign_that_a_scheduler_is_in_use_and_ssh_none_that_hosts_wait_for_work(
    stand_in, tmp_path, monkeypatch
):
    stand_in("ssh", "exit 1")
    monkeypatch.setenv("PATH", f"{tmp_path}/commands")  # where other schedulers may be installed
    assert schedulers.chosen().name == "SLURM"
    stand_in("bsub", "exit 1")
    assert schedulers.chosen().name == "LSF"
    assert schedulers.chosen("ssh").name == "ssh"


def test_hosts_can_be_used_where_there_is_an_ssh(stand_in, monkeypatch):
    stand_in("ssh", "exit 1")
    assert Hosts().examine()[0]
    monkeypatch.setenv("PATH", "")
    assert Hosts().examine() == (False, "no ssh")


@pytest.mark.parametrize(
    ("scheduler", "option"),
    [
        (Pbs(), "place=scatter"),
        (Lsf(), "--mem"),
        (Hosts(), "node1;rm"),
        (Hosts(), "h:0"),
        (Pbs(), "-l a\n#PBS x"),
        (Lsf(), "-P it's"),
    ],
)
def test_an_option_that_would_break_the_script_is_refused(scheduler, option):
    assert scheduler.option_problem(option)
    assert not scheduler.option_problem(shlex.split(scheduler.option_example)[0] if scheduler.name == "ssh" else "-x y")
