"""A column or a status has one home, the kernel; the table follows, and tables without a new column stay readable."""

import numpy as np
import pytest

from kernel import status
from kernel.columns import RESULT
from kernel.version import source_hash
from sweep import schema
from sweep.schema import (
    COLUMNS,
    PARAMETERS,
    ROW,
    as_rows,
    blank_of,
    is_ended,
    is_layout,
    layout_of,
    quantities_of,
    seal,
)

NOT_KEPT = ("evaluations", "site_evaluations")  # measures of work that the table does without: it has `steps`


def test_the_table_keeps_every_column_of_the_kernel_under_its_name():
    assert set(RESULT.names) - set(COLUMNS) == set(NOT_KEPT)
    for name in set(RESULT.names) - set(NOT_KEPT):
        assert ROW[name].kind == RESULT[name].kind.replace("U", "S"), name  # HDF5 has no text of fixed width


def test_the_table_has_room_for_every_word_of_the_kernel():
    longest = max(map(len, status.WORDS))
    assert longest <= ROW["status"].itemsize
    assert {schema.DONE.decode(), schema.RAISED.decode()} <= set(status.WORDS)
    assert not {schema.PENDING.decode(), schema.TORN.decode(), schema.UNASKED.decode()} & set(status.WORDS)


def test_the_list_of_runs_has_room_for_the_hash_of_the_kernel():
    assert len(source_hash()) == schema.RUN["kernel"].itemsize


def without(*names):
    return np.dtype([(name, ROW[name]) for name in COLUMNS if name not in names])


@pytest.mark.parametrize("new", ["spread_high", "condition", "steps"])
def test_rows_from_before_a_column_was_added_are_read_with_all_that_they_have(new):
    full = blank_of({"N": np.array([5, 8]), "zeta_T": np.zeros(2), "M_over_M0": np.ones(2), "V_over_V0": np.ones(2)})
    full["ke_ratio"], full["status"], full["checked"] = (0.5, 0.25), (schema.DONE, schema.PENDING), True
    old = np.empty(2, without(new))
    for name in old.dtype.names:
        old[name] = full[name]
    seal(old)
    assert is_layout(old.dtype)
    rows = as_rows(old)
    assert is_ended(rows).tolist() == [True, False]
    assert (rows["ke_ratio"][0], rows["checked"][0]) == (0.5, True)
    assert rows[new][0].tobytes() == blank_of({name: full[name][:1] for name in PARAMETERS})[new][0].tobytes()


def test_rows_with_whole_quantities_can_be_read_and_with_parts_of_them_not():
    whole = layout_of(("wall_force", "momentum"))
    assert is_layout(whole)
    assert quantities_of(whole) == ("wall_force", "momentum")
    assert not is_layout(np.dtype([(name, whole[name]) for name in whole.names if name != "momentum_error"]))
    assert quantities_of(ROW) == ()


@pytest.mark.parametrize(
    "layout",
    [
        without("status"),
        without("checksum"),
        without("N"),
        np.dtype([*ROW.descr, ("newer", "<f8")]),
        np.dtype("f8"),
        np.dtype([(name, ROW[name]) for name in reversed(COLUMNS)]),
    ],
)
def test_rows_that_could_be_misread_are_refused(layout):
    assert not is_layout(layout)
