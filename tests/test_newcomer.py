"""The wheel, as somebody gets it who has no root, compiler or MPI: installed from the package index, to a map."""

import pandas as pd
import pytest

import analysis
from sweep.schema import RUN_COLUMNS

from .newcomer import home, index_problem, work

pytestmark = [pytest.mark.slow, pytest.mark.mpi]


def test_the_wheel_with_the_indexs_mpi_gives_a_map_and_the_same_table_twice_without_root():
    if problem := index_problem():
        pytest.skip(problem)
    with home() as folder:
        work(folder, pinned=True)
        assert (folder / "quick.png").stat().st_size > 10_000
        assert len(pd.read_csv(folder / "quick.best.csv")) == 64
        first, again = (analysis.load(folder / name).drop(columns=[*RUN_COLUMNS], errors="ignore") for name in TABLES)
    assert len(first) == 960
    pd.testing.assert_frame_equal(first, again, check_exact=True)


TABLES = ("quick.h5", "again.h5")
