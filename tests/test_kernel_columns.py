"""Many tasks, from whatever they are kept in: a row each, ready for a data frame, or one message that names all."""

import numpy as np
import pandas as pd
import pytest

import kernel
from kernel.ke import RESULT
from kernel.task import PARAMETERS

TASKS = {"N": [10, 20], "zeta_T": 1e-3, "M_over_M0": [1.0, 2.0], "V_over_V0": [1, 2]}
ROWS = [[10, 1e-3, 1.0, 1.0], [20, 1e-3, 2.0, 2.0]]


def structured():
    rows = np.empty(2, [("note", "U4"), *((name, "i4" if name == "N" else "f4") for name in PARAMETERS)])
    for name, values in zip(PARAMETERS, np.transpose(ROWS), strict=True):
        rows[name] = values
    rows["zeta_T"] = 0.0
    return rows


@pytest.mark.parametrize(
    "tasks",
    [
        TASKS,
        TASKS | {"N": [10.0, 20.0]},
        TASKS | {"N": np.array([10, 20], object), "mine": ["a", "b"]},
        pd.DataFrame(TASKS).assign(note="x"),
        pd.DataFrame(TASKS).astype({"N": "Int64"}),
        np.array(ROWS),
        ROWS,
        [kernel.Task(*row) for row in ROWS],
        [kernel.Task(*ROWS[0]), ROWS[1]],
        (kernel.Task(*row) for row in ROWS),
    ],
)
def test_every_form_of_the_same_tasks_gives_the_same_rows(tasks):
    found = kernel.ke_ratios(tasks, certify=False)
    expected = kernel.ke_ratios(ROWS, certify=False)
    assert found.tobytes() == expected.tobytes()
    assert found["N"].tolist() == [10, 20]
    assert kernel.ke_ratios(structured(), certify=False)["zeta_T"].tolist() == [0, 0]


def test_the_rows_are_a_data_frame_with_its_inputs_and_words():
    df = pd.DataFrame(kernel.ke_ratios(TASKS))
    assert list(df.columns[:4]) == list(PARAMETERS)
    assert (df["status"] == "done").all()
    assert df["status"].value_counts().to_dict() == {"done": 2}
    assert df["checked"].all()
    assert list(df.columns)[list(df.columns).index("chaotic") + 1] == "checked"


def test_one_task_and_many_tell_the_same():
    for certify in (True, False):
        rows = kernel.ke_ratios(TASKS, certify=certify)
        for row, task in zip(rows, ROWS, strict=True):
            alone = kernel.ke_ratio(*task, certify=certify)
            for name in set(RESULT.names) - {*PARAMETERS, "chaotic"}:
                np.testing.assert_array_equal(getattr(alone, name), row[name])
            assert alone.chaotic is (bool(row["chaotic"]) if certify else None)
            assert alone.checked is certify


def test_a_flag_that_nobody_asked_for_is_neither_true_nor_false():
    r = kernel.ke_ratio(50, 0.0, 1 / 0.159, 0.1 / 0.26, certify=False)
    assert (r.checked, r.chaotic) == (False, None)
    assert kernel.ke_ratio(50, 0.0, 1 / 0.159, 0.1 / 0.26).chaotic is True
    unfinished = kernel.ke_ratio(50, 0.0, 1, 1, max_steps=20)
    assert (unfinished.status, unfinished.checked, unfinished.chaotic) == ("step_budget", False, None)


def test_bad_tasks_keep_their_inputs_and_have_no_numbers():
    given = [
        [20, 1e-3, 1, 1],
        [20, -1, 1, 1],
        [2.5, 0, 1, 1],
        [np.nan, 0, 1, 1],
        [20, 1e-3, np.inf, 1],
        [1e30, 0, 1, 1],
        [2.0**63, 0, 1, 1],
    ]
    rows = kernel.ke_ratios(given)
    assert rows["status"].tolist() == ["done", *["bad_input"] * 6]
    assert rows["N"].tolist() == [20, 20, -1, -1, 20, -1, -1], (
        "an N that is no whole number cannot be kept in the column"
    )
    np.testing.assert_array_equal(rows["zeta_T"], np.array(given)[:, 1])
    np.testing.assert_array_equal(rows["M_over_M0"], np.array(given)[:, 2])
    for name in RESULT.names:
        if RESULT[name].kind == "f" and name not in PARAMETERS:
            assert np.isnan(rows[name][1:]).all(), name
    assert set(rows["method"][1:]) == {""}
    assert not rows["checked"][1:].any()


def test_the_parameters_at_the_edge_of_the_box_are_good_and_those_beyond_are_not():
    edges = {"N": (2, 2), "zeta_T": (0, 10), "M_over_M0": (0.01, 100), "V_over_V0": (0.01, 20)}
    middle = {"N": 3, "zeta_T": 1.0, "M_over_M0": 1.0, "V_over_V0": 1.0}
    for name, ends in edges.items():
        for end in ends:
            assert kernel.ke_ratios([list((middle | {name: end}).values())], 1e-1, certify=False)["status"] == "done"
    for name, value in (("N", 1), ("N", 10_001), ("zeta_T", 10.01), ("M_over_M0", 0.0099), ("V_over_V0", 20.01)):
        assert kernel.ke_ratios([list((middle | {name: value}).values())])["status"] == "bad_input"


def test_no_tasks_give_no_rows():
    assert len(kernel.ke_ratios([])) == len(kernel.ke_ratios({name: [] for name in PARAMETERS})) == 0


@pytest.mark.parametrize("N", [200, 200.0, np.float32(200), np.int16(200), np.float64(200)])
def test_two_hundred_is_two_hundred_whatever_its_type(N):
    assert kernel.Task(N, 0, 1, 1) == kernel.Task(200, 0.0, 1.0, 1.0)
    assert type(kernel.Task(N, 0, 1, 1).N) is int
    assert kernel.Scene(N, 0, kernel.Impact(1, 1)).N == 200
    ratio = kernel.ke_ratio(200, 1.0, 1, 1, 1e-1, certify=False).ke_ratio
    assert kernel.ke_ratio(N, 1.0, 1, 1, 1e-1, certify=False).ke_ratio == ratio
    assert kernel.ke_ratios({"N": N, "zeta_T": 1.0, "M_over_M0": 1, "V_over_V0": 1}, 1e-1)["N"] == [200]


def test_a_column_named_as_a_number_that_the_model_lacks_is_no_column_of_the_users():
    """Left alone it would look as if the number had been changed."""
    for name, meant in (("spring.c5", " (did you mean 'spring.c3'?)"), ("spring.C2", " (did you mean 'spring.c2'?)")):
        for work in (kernel.ke_ratios, kernel.measure):
            with pytest.raises(ValueError) as caught:
                work(TASKS | {name: 4.0, "mass.spread": 0.1, "mine": [1, 2]})
            assert f"{name}: the model has no such number{meant}; mass.spread: the model has no" in str(caught.value)
    with pytest.raises(ValueError) as caught:  # where it is not known what a model has, nothing is said of it
        kernel.ke_ratios(TASKS | {"spring.c2": 4.0}, model="x")
    assert str(caught.value) == "model: must be a kernel.Model, got 'x'"
    assert (kernel.ke_ratios(TASKS | {"spring.c2": 4.0, "c2": 5.0}, certify=False)["spring.c2"] == 4.0).all()


def test_a_missing_column_is_not_guessed_to_be_another_input():
    with pytest.raises(ValueError, match=r"lacks the column V_over_V0$"):
        kernel.ke_ratios({name: TASKS[name] for name in PARAMETERS[:3]})
    with pytest.raises(ValueError, match=r"lacks the column V_over_V0 \(did you mean it by 'V_over_VO'\?\)"):
        kernel.ke_ratios({name: TASKS[name] for name in PARAMETERS[:3]} | {"V_over_VO": 1.0})


@pytest.mark.parametrize("work", [kernel.ke_ratios, kernel.measure])
def test_where_every_model_is_bad_every_row_says_so(work):
    rows = work(TASKS | {"spring.c2": -1e9})
    assert rows["status"].tolist() == ["bad_input"] * 2
    assert len(work({name: [] for name in (*PARAMETERS, "spring.c2")})) == 0


@pytest.mark.parametrize("given", [[True, 1e-3], [1e-3, np.bool_(False)], np.ma.array([1e-3, 1e-3], mask=[0, 1])])
def test_what_numpy_would_take_for_a_number_and_is_none_is_refused_with_its_key(given):
    rule = "must hold numbers, none of them True, False or masked, got "
    with pytest.raises(ValueError, match=f"^tasks: zeta_T: {rule}"):
        kernel.ke_ratios(TASKS | {"zeta_T": given})
    with pytest.raises(ValueError, match=f"^tasks: {rule}"):
        kernel.ke_ratios([[10, x, 1, 1] for x in given])
