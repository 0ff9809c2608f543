"""Every bad input, through the real command line: one clear message, exit status 2, nothing written or changed."""

import contextlib
import os
from pathlib import Path

import h5py
import pytest

from sweep import files
from sweep.plan.spec import OF_A_TABLE
from sweep.plan.tasks import Tasks
from sweep.store import table
from sweep.store.merge import merge
from sweep.tell import report
from sweep.tell.audit import audit

from .conftest import SMALL, problems_of


def contents(folder: Path) -> dict[str, tuple]:
    """Every path below the folder with what would tell a change."""
    found = {}
    for path in sorted(folder.rglob("*")):
        stat = path.lstat()
        found[str(path)] = (stat.st_mode, stat.st_mtime_ns, path.read_bytes() if path.is_file() else None)
    return found


@contextlib.contextmanager
def unchanged(folder: Path):
    before = contents(folder)
    yield
    assert contents(folder) == before


def refused(answer, *problems: str) -> None:
    """Exit status 2, exactly these problems, one line each, and nothing else said."""
    assert answer.returncode == 2
    assert answer.stdout == ""
    lines = answer.stderr.splitlines()
    assert len(lines) == len(problems), answer.stderr
    for line, problem in zip(lines, problems, strict=True):
        assert line.startswith("sweep: ")
        assert problem in line


BAD_LINES = {
    "unknown key": ("V_over_V0 = 1\nspeed = 2", "grid.speed: is not a known key, got 2"),
    "mistyped key": ("zeta_t = 0\nV_over_V0 = 1", "grid.zeta_t: is not a known key (did you mean 'zeta_T'?), got 0"),
    "mistyped section": ("V_over_V0 = 1\n[acuracy]", "acuracy: is not a known key (did you mean 'accuracy'?), got {}"),
    "key elsewhere": (
        "V_over_V0 = 1\n[output]\ncertify = true",
        "output.certify: is not a known key (it belongs into ",
    ),
    "unknown quantity": (
        "V_over_V0 = 1\n[output]\nobserve = ['peak_ke', 'peek_ke']",
        "output.observe: must be a list of distinct quantities out of: peak_ke, ke, wall_force",
    ),
    "quantity twice": ("V_over_V0 = 1\n[output]\nobserve = ['peak_ke', 'peak_ke']", "must be a list of distinct"),
    "no quantity": ("V_over_V0 = 1\n[output]\nobserve = []", "must be a list of distinct"),
    "wrong type": ("V_over_V0 = 'fast'", "grid.V_over_V0: must be a number from 0.01 to 20, got 'fast'"),
    "negative speed": ("V_over_V0 = -1", "grid.V_over_V0: must be a number from 0.01 to 20, got -1"),
    "nan": ("V_over_V0 = nan", "grid.V_over_V0: must be a number from 0.01 to 20, got nan"),
    "inf": ("V_over_V0 = inf", "grid.V_over_V0: must be a number from 0.01 to 20, got inf"),
    "zero points": (
        "V_over_V0 = { log = [1, 2], points = 0 }",
        "points must be a whole number from 1 to 1000000, got 0",
    ),
    "empty axis": ("V_over_V0 = []", "grid.V_over_V0: must hold at least one value, got []"),
    "not TOML": ("V_over_V0 = = 1", "is not TOML: "),
}


@pytest.mark.parametrize("command", [["run", "-o", "t.h5"], ["plan"]], ids=["run", "plan"])
@pytest.mark.parametrize("kind", BAD_LINES)
def test_a_bad_spec_is_refused(sweep, tmp_path, kind, command):
    line, problem = BAD_LINES[kind]
    (tmp_path / "bad.toml").write_text(f"name = 'bad'\n[grid]\nN = 5\nzeta_T = 0\nM_over_M0 = 1\n{line}\n")
    with unchanged(tmp_path):
        refused(sweep(command[0], "bad.toml", *command[1:]), f"bad.toml: {problem}" if ":" in problem else problem)


def test_all_problems_of_a_spec_are_told_at_once(sweep, tmp_path):
    (tmp_path / "bad.toml").write_text("[grid]\nN = 1\nzeta_T = -1e-3\nM_over_M0 = -2\n")
    with unchanged(tmp_path):
        missing = ("name: is missing", "grid.V_over_V0: is missing")
        broken = ("grid.N: must", "grid.zeta_T: must", "grid.M_over_M0: must")
        refused(sweep("run", "bad.toml", "-o", "t.h5"), missing[0], *broken, missing[1])


def test_all_problems_of_a_run_are_told_at_once(sweep, small_spec, tmp_path):
    with unchanged(tmp_path):
        options = ["--until=soon", "--writer=mpio", "--reuse=none.h5", "--page=x.txt", "--shard=2/99", "--store=rows"]
        spec = ("--until: must be", "--shard: 2/99 leaves shards without a task", "none.h5: cannot be read")
        names = ("--writer mpio: needs more than", "t.csv: a table is an HDF5 file", "--page: x.txt: a page")
        refused(sweep("run", small_spec, "-o", "t.csv", *options), *spec, *names)


def test_values_that_options_cannot_have_are_told_beside_the_problems_of_spec_and_table(sweep, tmp_path):
    (tmp_path / "bad.toml").write_text("name = ''\n[grid]\nN = 1\nzeta_T = 0\nM_over_M0 = 1\nV_over_V0 = 1\n")
    with unchanged(tmp_path):
        spec = ("--until: must be", "bad.toml: name: must", "bad.toml: grid.N: must")
        names = ("none/t.h5: there is no directory", "--shard: must be", "--max-fails: must", "--writer: invalid")
        options = ["--shard=5/2", "--until=xyz", "--max-fails=-1", "--writer=gathr"]
        refused(sweep("run", "bad.toml", "-o", "none/t.h5", *options), *spec, *names)


def test_an_empty_grid_is_refused(sweep, tmp_path):
    (tmp_path / "bad.toml").write_text("name = 'bad'\n[grid]\n")
    with unchanged(tmp_path):
        axes = ("N", "zeta_T", "M_over_M0", "V_over_V0")
        refused(sweep("run", "bad.toml", "-o", "t.h5"), *(f"bad.toml: grid.{axis}: is missing" for axis in axes))


def test_a_spec_that_cannot_be_read_is_refused(sweep, tmp_path):
    (tmp_path / "latin.toml").write_bytes(b"name = '\xe9'")
    (tmp_path / "folder.toml").mkdir()
    with unchanged(tmp_path):
        refused(sweep("run", "missing.toml", "-o", "t.h5"), "missing.toml: cannot be read: No such file or directory")
        refused(sweep("run", "folder.toml", "-o", "t.h5"), "folder.toml: cannot be read: Is a directory")
        refused(sweep("run", "latin.toml", "-o", "t.h5"), "latin.toml: is not a text file in UTF-8")


@pytest.mark.mpi
def test_under_mpirun_the_message_comes_once(sweep, tmp_path):
    (tmp_path / "bad.toml").write_text("name = 'bad'\ngrid = 1\n")
    with unchanged(tmp_path):
        refused(sweep("run", "bad.toml", "-o", "t.h5", ranks=2), "bad.toml: grid: must be a section [grid], got 1")
        usage = sweep("run", "bad.toml", ranks=2)
    assert usage.returncode == 2
    assert usage.stderr.count("the following arguments are required: -o/--output") == 1


def test_an_output_that_cannot_be_written_is_refused(sweep, small_spec, tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("no folder")
    os.mkfifo(tmp_path / "pipe")
    with unchanged(tmp_path):
        refused(sweep("run", small_spec, "-o", "folder"), "folder: is a directory; -o must name a file")
        refused(sweep("run", small_spec, "-o", ""), ".: is a directory; -o must name a file")
        refused(sweep("run", small_spec, "-o", "missing/t.h5"), "missing/t.h5: there is no directory 'missing'")
        refused(sweep("run", small_spec, "-o", "file/t.h5"), "file/t.h5: ")
        refused(sweep("run", small_spec, "-o", "pipe"), "pipe: is a device or pipe, not a table")
        refused(sweep("run", small_spec, "-o", "t" * 300), "File name too long")
        refused(sweep("run", small_spec, "-o", "new\nline/t.h5"), "new\\nline/t.h5: there is no directory")


def test_an_output_without_permission_is_refused(sweep, small_spec, tmp_path, unprivileged):
    (tmp_path / "closed").mkdir()
    (tmp_path / "readable").mkdir()
    assert sweep("run", small_spec, "-o", "readable/t.h5").returncode == 0
    (tmp_path / "readable" / "t.h5").chmod(0o444)
    (tmp_path / "readable").chmod(0o555)
    (tmp_path / "closed").chmod(0o000)
    run = ("run", small_spec.name, "-o")
    refused(unprivileged(*run, "readable/new.h5"), "readable/new.h5: the directory 'readable' is not writable")
    refused(unprivileged(*run, "readable/t.h5"), "readable/t.h5: the directory 'readable' is not writable")
    (tmp_path / "readable").chmod(0o777)
    refused(unprivileged(*run, "readable/t.h5"), "readable/t.h5: cannot be written: no write permission")
    refused(unprivileged(*run, "closed/t.h5"), "closed/t.h5: cannot be written: Permission denied")
    refused(unprivileged("status", "closed/t.h5"), "closed/t.h5: cannot be read: Permission denied")
    (tmp_path / "closed").chmod(0o755)
    assert [path.name for path in (tmp_path / "readable").iterdir()] == ["t.h5"]
    assert not list((tmp_path / "closed").iterdir())


def test_a_table_of_another_sweep_is_refused(sweep, small_spec, tmp_path):
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0
    other = tmp_path / "other.toml"
    other.write_text(small_spec.read_text().replace("[0.5, 2]", "[0.5, 3]").replace("1e-2", "2e-2"))
    with unchanged(tmp_path):
        problem = "t.h5: holds another sweep (it differs in accuracy.target, grid.M_over_M0); give another -o"
        answer = sweep("run", other, "-o", "t.h5")
        refused(answer, problem)
        assert "and --reuse t.h5 to take over the rows that both have" in answer.stderr
    other.write_text(other.read_text() + "\n[model]\nsite = 0.4\n")  # of which no row could be taken over
    answer = sweep("run", other, "-o", "t.h5")
    refused(answer, "t.h5: holds another sweep (it differs in accuracy.target, grid.M_over_M0, model.")
    assert answer.stderr.endswith("); give another -o\n")


def test_a_table_that_is_not_ours_is_refused(sweep, small_spec, tmp_path):
    (tmp_path / "text.h5").write_text("N,zeta_T\n")
    (tmp_path / "empty.h5").write_bytes(b"")
    with h5py.File(tmp_path / "foreign.h5", "w") as file:
        file["results"] = [1.0]
    for name, problem in (
        ("text", "text.h5: is a CSV file, not a table"),
        ("empty", "empty.h5: is an empty file, not a table"),
        ("foreign", "not a table"),
    ):
        with unchanged(tmp_path):
            for command in (("run", small_spec, "-o"), ("status",), ("show",)):
                refused(sweep(*command, f"{name}.h5"), problem)


OTHERS = {
    "a spec (TOML)": SMALL.encode(),
    "a CSV file": "task,N,zeta_T\n0,5,0.1\n".encode("utf-8-sig"),
    "a text file": "größe\n".encode(),
    "an SVG, XML or HTML file": b"<?xml version='1.0'?>\n<svg/>",
    "a PNG picture": b"\x89PNG\r\n\x1a\n\0\0",
    "a Parquet file": b"PAR1\x15\x04\0",
}


@pytest.mark.parametrize("section", ["[grid]", "[grid]  # the impacts", "[points]"])
def test_a_spec_is_known_by_its_section_of_tasks(section):
    assert files.kind_of_data(f'name = "a"\n{section}\n'.encode()) == files.SPEC


@pytest.mark.parametrize("kind", OTHERS)
def test_what_never_was_a_table_is_told_what_it_is_and_never_to_be_repaired(small_spec, tmp_path, kind):
    (tmp_path / "t.h5").write_bytes(OTHERS[kind])
    for read in (report.status, report.show, audit, lambda path: merge([path], tmp_path / "m.h5")):
        (problem,) = problems_of(read, tmp_path / "t.h5")
        assert f"t.h5: is {kind}, not a table; " in problem
        assert "--repair" not in problem


def test_a_table_in_place_of_a_spec_is_told_apart(sweep, small_spec, tmp_path):
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0
    with unchanged(tmp_path):
        refused(sweep("plan", "t.h5"), f"t.h5: is an HDF5 file, not a spec{OF_A_TABLE}")
    assert sweep("export", "t.h5", "-o", "there", "--crate").returncode == 0
    assert sweep("run", "there/spec.toml", "-o", "t.h5").returncode == 0


@pytest.mark.parametrize("name", ["quick.csv", "Quick.PNG", "a.b.toml", "x.nc", "x.lsf"])
def test_a_table_is_not_given_the_name_of_another_format(sweep, small_spec, tmp_path, name):
    rule = (
        f"{name}: a table is an HDF5 file, its name may not end with {Path(name).suffix} as those of other formats do"
    )
    with unchanged(tmp_path):
        for command in (("run", small_spec), ("submit", small_spec), ("merge", "a.h5", "b.h5")):
            refused(sweep(*command, "-o", name), rule)


def test_a_table_of_another_kernel_is_refused_unless_its_rows_are_wanted(sweep, small_spec, tmp_path):
    assert sweep("run", small_spec, "-o", "made.h5").returncode == 0
    with table.reading(tmp_path / "made.h5") as file:
        known, rows = table.attributes(file), file["results"][()]
    axes = {name: list(dict.fromkeys(rows[name].tolist())) for name in ("N", "zeta_T", "M_over_M0", "V_over_V0")}
    table.create(tmp_path / "t.h5", Tasks(axes), known | {"kernel": "0123456789abcdef"})
    with unchanged(tmp_path):
        refused(sweep("run", small_spec, "-o", "t.h5"), "t.h5: was computed by another version of the kernel")
    assert sweep("run", small_spec, "-o", "t.h5", "--keep-rows").returncode == 0


def test_a_program_is_not_taken_for_a_csv_by_the_comma_in_its_first_line_and_none_is_hidden_by_a_comment():
    assert files.kind_of_data(b"import os, sys\n\nfor k in range(3):\n    print(k)\n") == "a text file"
    assert files.kind_of_data(b"# made, by hand\n\nN,zeta_T\n5,0.1\n8,0.1\n13,0.") == "a CSV file"
