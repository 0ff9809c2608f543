"""A spec is validated as a whole: a good one resolves to itself, a bad one is refused with every problem named."""

import itertools
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep.errors import InputError
from sweep.plan.spec import Spec, parse_spec, read_spec
from sweep.plan.tasks import Tasks

from .test_sweep_model import VARIED

GOOD = {"name": "good", "grid": {"N": 5, "zeta_T": 0.0, "M_over_M0": [1.0, 2], "V_over_V0": 1}}


def toml(value) -> str:
    """A value as TOML text; tables inline."""
    if isinstance(value, dict):
        return (
            "{"
            + ", ".join(f"{json.dumps(key, ensure_ascii=False)} = {toml(item)}" for key, item in value.items())
            + "}"
        )
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"
    return json.dumps(value, ensure_ascii=False)


def document(content: dict) -> str:
    return "\n".join(f"{json.dumps(key, ensure_ascii=False)} = {toml(value)}" for key, value in content.items())


def axes(low: float, high: float):
    number = st.floats(low, high, exclude_min=low == 0) | st.integers(1, int(high))
    ends = st.lists(st.floats(max(low, 1e-3), high), min_size=2, max_size=2).filter(
        lambda e: abs(e[0] / e[1] - 1) > 0.1
    )
    ranges = st.tuples(st.sampled_from(["log", "linear"]), ends, st.integers(1, 9)).map(
        lambda r: {r[0]: r[1], "points": r[2]}
    )
    return number | st.lists(number, min_size=1, max_size=5, unique=True) | ranges


GRIDS = st.fixed_dictionaries(
    {
        "N": st.integers(2, 10**4)
        | st.lists(st.integers(2, 500), min_size=1, max_size=5, unique=True)
        | st.integers(1, 9).map(lambda n: {"log": [5, 200], "points": n}),
        "zeta_T": axes(0, 10),
        "M_over_M0": axes(0.01, 100),
        "V_over_V0": axes(0.01, 20),
    }
)
ACCURACIES = st.fixed_dictionaries(
    {}, optional={"target": st.floats(1e-8, 1e-1), "method": st.just("auto"), "certify": st.booleans()}
) | st.fixed_dictionaries(
    {"method": st.just("rk45")}, optional={"rtol": st.floats(1e-13, 1e-1), "atol": st.floats(1e-15, 1)}
)
SPECS = st.fixed_dictionaries(
    {"name": st.text(st.characters(codec="utf-8", exclude_categories=["C"]), min_size=1, max_size=80), "grid": GRIDS},
    optional={"accuracy": ACCURACIES, "output": st.just({"observe": ["peak_ke"]})},
)
ANYTHING = st.recursive(
    st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats() | st.text('ab"\\\n(é.', max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["log", "linear", "points", "N", "a.b", "("]), inner, max_size=3)
    ),
    max_leaves=6,
)
PLACES = [
    *[("grid", key) for key in GOOD["grid"]],
    *[("accuracy", key) for key in ("target", "method", "rtol", "atol", "certify", "more")],
    *[("output", key) for key in ("observe", "more")],
    *[(key,) for key in ("name", "grid", "accuracy", "output", "more")],
]


@given(SPECS)
def test_a_good_spec_resolves_to_itself(content):
    spec = parse_spec(document(content), "spec")
    assert parse_spec(document(_without_none(json.loads(spec.resolved()))), "again") == spec
    assert spec.differences(json.loads(spec.resolved())) == []


def _without_none(content: dict) -> dict:
    """The resolved spec as a user could write it: TOML has no null."""
    return {
        key: _without_none(value) if isinstance(value, dict) else value
        for key, value in content.items()
        if value is not None
    }


@given(SPECS)
def test_the_tasks_are_the_product_of_the_axes(content):
    spec = parse_spec(document(content), "spec")
    grid = spec.grid.model_dump()
    tasks = Tasks(grid)
    columns = tasks.columns(np.arange(len(tasks)))
    product = list(itertools.product(*grid.values()))
    assert len(tasks) == spec.tasks == len(product)
    assert list(zip(*(column.tolist() for column in columns.values()), strict=True)) == product


@given(st.sampled_from(PLACES), ANYTHING)
def test_any_value_anywhere_is_taken_or_refused_by_its_key(place, value):
    content = json.loads(json.dumps(GOOD))
    section = content if len(place) == 1 else content.setdefault(place[0], {})
    section[place[-1]] = value
    try:
        assert isinstance(parse_spec(document(content), "spec"), Spec)
    except InputError as error:
        assert all(problem.startswith(f"spec: {place[0]}") for problem in error.problems)
        assert all("got " in problem or "is missing" in problem or "only with" in problem for problem in error.problems)


@given(st.text(max_size=60) | st.text("[]{}=.,\"'\n#aN01-", max_size=60))
def test_any_text_is_refused_politely(text):
    with pytest.raises(InputError, match=r"^spec: "):
        parse_spec(text, "spec")


@given(st.binary(max_size=40))
def test_any_file_is_refused_politely(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("spec") / "any.toml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"any\.toml: "):
        read_spec(path)


def test_a_resolved_spec_holds_no_number_of_the_model_that_an_axis_varies():
    text = VARIED.replace(
        '"mass.seed" = [1, 2]', '"stiffness.last" = { log = [0.25, 4], points = 5 }\n"mass.seed" = [5, 6]'
    )
    model = json.loads(parse_spec(text, "s").resolved())["model"]
    assert (model["mass"], model["stiffness"]) == ({"spread": 0.1}, {"first": 1.0})
    listed = (
        VARIED.replace("[6, 9]", "2")
        .replace("{ first = 1.0, last = 2.0 }", "[1.0, 2.0]")
        .replace("mass.seed", "stiffness.1")
    )
    assert json.loads(parse_spec(listed, "s").resolved())["model"]["stiffness"] == [1.0, "varied"]
