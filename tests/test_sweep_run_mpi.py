"""Two routes to one table: any number of ranks and either writer give the same bits."""

import re

import h5py
import pytest

from sweep import schema

pytestmark = pytest.mark.mpi
WRITERS = ("mpio", "gather") if h5py.get_config().mpi else ("gather",)


@pytest.mark.parametrize("writer", WRITERS)
@pytest.mark.parametrize("ranks", [2, 3, 4])
def test_any_number_of_ranks_gives_the_bits_of_one_process(sweep, small_spec, tmp_path, physics, ranks, writer):
    alone = sweep("run", small_spec, "-o", "one.h5")
    many = sweep("run", small_spec, "-o", "many.h5", "--writer", writer, ranks=ranks)
    assert alone.returncode == many.returncode == 0
    assert many.stdout.startswith("24 done, 0 failed, 0 left; wall time ")
    assert physics(tmp_path / "many.h5") == physics(tmp_path / "one.h5")
    assert f"; {ranks} ranks, rank 0 computes too; writer {writer} (asked for); " in many.stderr


def test_the_columns_that_may_differ_are_the_ones_these_tests_leave_out(sweep, small_spec, tmp_path, physics):
    sweep("run", small_spec, "-o", "t.h5")
    assert set(schema.ROW.names) - set(physics(tmp_path / "t.h5")) == set(schema.RUN_COLUMNS)


def test_the_writer_is_chosen_and_the_log_says_why(sweep, small_spec):
    alone = sweep("run", small_spec, "-o", "one.h5").stderr
    many = sweep("run", small_spec, "-o", "two.h5", ranks=2).stderr
    assert "; writer gather (one process); " in alone
    reason = "mpio (parallel HDF5)" if "mpio" in WRITERS else "gather (this h5py has no parallel HDF5)"
    assert f"; writer {reason}; " in many


def test_every_rank_computes_its_share_and_signs_it(sweep, slow_spec, tmp_path):
    sweep("run", slow_spec, "-o", "t.h5", ranks=3)
    with h5py.File(tmp_path / "t.h5") as file:
        ranks, seconds = file["results"]["rank"], file["results"]["seconds"]
    assert set(ranks.tolist()) == {0, 1, 2}
    assert (seconds > 0).all()


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_finished_table_is_left_as_it_is(sweep, small_spec, tmp_path, ranks):
    def results():
        with h5py.File(tmp_path / "t.h5") as file:
            return file["results"][()].tobytes()

    sweep("run", small_spec, "-o", "t.h5", ranks=ranks)
    before = results()
    again = sweep("run", small_spec, "-o", "t.h5", ranks=ranks)
    assert again.returncode == 0
    assert "24 tasks, 0 left; " in again.stderr
    assert results() == before


def test_a_torn_row_is_computed_again(sweep, small_spec, tmp_path, physics):
    sweep("run", small_spec, "-o", "t.h5")
    before = physics(tmp_path / "t.h5")
    with h5py.File(tmp_path / "t.h5", "r+") as file:
        row = file["results"][17]
        row["ke_ratio"] = 1.0
        file["results"][17] = row
    again = sweep("run", small_spec, "-o", "t.h5", ranks=2)
    assert "24 tasks, 1 left; " in again.stderr
    assert physics(tmp_path / "t.h5") == before


def test_more_ranks_than_tasks_is_no_error(sweep, small_spec, tmp_path):
    text = small_spec.read_text()
    for axis in ("N", "zeta_T", "M_over_M0", "V_over_V0"):
        text = re.sub(rf"^{axis} .*$", f"{axis} = 5", text, flags=re.MULTILINE)
    small_spec.write_text(text)
    answer = sweep("run", small_spec, "-o", "t.h5", ranks=4)
    assert answer.returncode == 0
    assert answer.stdout.startswith("1 done, ")


def test_writing_in_parallel_needs_several_ranks(sweep, small_spec, tmp_path):
    answer = sweep("run", small_spec, "-o", "t.h5", "--writer", "mpio")
    assert answer.returncode == 2
    assert answer.stderr.startswith("sweep: --writer mpio: ")
    assert not (tmp_path / "t.h5").exists()
