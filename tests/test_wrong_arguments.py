"""Whatever is wrong with an argument of a public function or class is said in our words, all of it at once."""

import inspect
import re

import numpy as np
import pandas as pd
import pytest

import analysis
import kernel
from analysis.at import pairs
from kernel.problems import ProblemsError
from kernel.task import PARAMETERS

from .test_analysis_unknown import table as unknown_table

TASK = {"N": 20, "zeta_T": 1e-3, "M_over_M0": 1.0, "V_over_V0": 1.0}
IMPACT = kernel.Impact(1, 1)
# Of every parameter values of a wrong type, name, range or shape; None stands for what has no default.
NO_NUMBER = ["20", None, True, [1, 2], np.array([1, 2]), {}, float("nan"), float("inf"), 10**400, 1j, object()]
NO_TASKS = [
    3,
    None,
    "abc",
    object(),
    [1, 2, 3, 4],
    [[1, 2, 3]],
    [[20, 1e-3, 1, 1], [20, 1e-3, 1]],
    [["20", 1e-3, 1, 1]],
    [kernel.Impact(1, 1)],
    np.zeros((2, 2, 4)),
    {},
    TASK | {"N": [[20, 30]]},
    TASK | {"N": [20, 30], "zeta_T": [0, 0, 0]},
    TASK | {"zeta_T": "low"},
    TASK | {"V_over_V0": None},
    TASK | {"M_over_M0": [1, [2, 3]]},
    TASK | {"N": True},
    TASK | {"zeta_T": [True, 1e-3]},
    TASK | {"zeta_T": [1e-3, np.bool_(False)]},
    TASK | {"zeta_T": np.array([True, 1e-3], object)},
    [[20, False, True, 1]],
    [[20, 1e-3, np.array(True), 1]],
    TASK | {"N": np.ma.array([10, 12], mask=[0, 1])},
    TASK | {"N": [np.ma.masked, 12]},
    np.ma.array([[20, 1e-3, 1, 1]], mask=[[0, 0, 0, 1]]),
    [np.ma.array([20, 1e-3, 1, 1], mask=[0, 0, 0, 1])],
    TASK | {"N": [10, 10**400]},
    {("n" if name == "N" else name): value for name, value in TASK.items()},
    pd.DataFrame({"N": [1]}),
    pd.concat([pd.DataFrame([TASK]), pd.DataFrame([{"N": 30}])], axis=1),
]
KNOBS = {
    "accuracy": [*NO_NUMBER, 1.0, 0],
    "method": ["rk54", None, 3, ["auto"], np.array(["auto", "rk45"])],
    "certify": ["no", None, 1, [True]],
    "max_steps": ["9", None, 0, 1.5, [1]],
    "rtol": ["1e-3", [1e-3], 0, True],
    "atol": ["1e-3", [1e-3], -1, True],
    "model": [None, 3, "paper", kernel.Bistable(), kernel.Model(kernel.PowerLaw(1.5, 0.0))],
}
NO_STATE = [None, "0", [], [[0.1, 0.2]], [float("nan"), 0], ["a", "b"], [1, 2, 3], object()]
NO_STATE += [["0.1", "0.2"], [True, 0], np.array([True, False]), np.array(["1", "2"]), [1e200, 0], {0.1: 1}]
NO_STATE += [[10**400, 0], np.ma.array([0.1, 0.2], mask=[0, 1]), [0.1, np.ma.masked]]
NO_TIMES = ["0.5", ["0.5"], [True], True, [0.1, None], [0.5, 0.1], [[0.5]], 9, {}]
NO_OPTIONS = [{"energy": {"time": 3}}, *({"profile": {"at": at}} for at in NO_TIMES)]
NO_WORKERS = ["2", None, 0, -1, 1.5, True, [2], 10**6]
NO_PARAMETER = [*NO_NUMBER, -1]
NO_EVENT = [*NO_NUMBER, 0]
NO_STRAIN = [x for x in NO_EVENT if x is not None]
NO_LAWS = [kernel.Toda(0), *(kernel.PowerLaw(*given) for given in [([1], "a"), (1.5, False), (1.5, np.bool_(False))])]
NO_PLACES = [x for x in NO_NUMBER if not isinstance(x, list | np.ndarray)] + [[1, "a"], [], [1, -2], [[1, 2]]]
NO_HISTORY = [kernel.Ramp(0, 1), kernel.HalfSine(1, 0), kernel.Harmonic("a", None), kernel.Samples([0, 1], [0, 0])]
NO_HISTORY += [kernel.Samples(np.float64(0), np.float64(1)), kernel.Samples(np.array(0), np.array(1))]
CALLS = {
    kernel.Task: (TASK, dict.fromkeys(PARAMETERS, NO_PARAMETER)),
    kernel.ke_ratio: (TASK, dict.fromkeys(PARAMETERS, NO_PARAMETER) | KNOBS),
    kernel.ke_ratios: ({"tasks": TASK}, {"tasks": NO_TASKS, "workers": NO_WORKERS} | KNOBS),
    kernel.measure: (
        {"tasks": TASK},
        {"tasks": NO_TASKS, "workers": NO_WORKERS, "observe": [None, 3, [], "kee", ["ke", "ke"], [3], [["ke"]], [{}]]}
        | KNOBS,
    ),
    kernel.Impact: ({"M_over_M0": 1, "V_over_V0": 1}, {"M_over_M0": NO_EVENT, "V_over_V0": NO_EVENT}),
    kernel.Drive: (
        {"speed": 1e-3},
        {"speed": [*NO_EVENT, *NO_HISTORY], "strain": NO_STRAIN, "hold": ["no", None, 1, [True]]},
    ),
    kernel.Release: (
        {"u": [0.0, 0.1], "v": [0.0, 0.0]},
        {"u": NO_STATE, "v": NO_STATE, "hold": ["no", None, 1, [True]]},
    ),
    kernel.Model: (
        {},
        {
            "spring": [None, 3, "bistable", (1.0, 2.0), kernel.Hertz(), *NO_LAWS],
            "contact": [None, 3, "hertz", (1.0, 2.0), kernel.Toda(), kernel.Hertz(0), kernel.Hertz(1e6, None)],
            "t_end": [*NO_NUMBER, 0],
            "site": [*NO_NUMBER, 0, 1.1, -1],
            "mass": [*NO_PLACES, 0, kernel.Graded(0, 1), kernel.Disordered(0.1, -1)],
            "stiffness": [*NO_PLACES, 0, kernel.Graded("a", 1), kernel.Disordered(1)],
            "damping": [*NO_PLACES, -1, kernel.Graded(-1, 1), kernel.Disordered([1], None)],
            "wall": [None, 3, "soft", ["fixed"]],
        },
    ),
    kernel.Scene: (
        {"N": 20, "zeta_T": 1e-3, "event": IMPACT},
        {
            "N": NO_NUMBER,
            "zeta_T": NO_NUMBER,
            "event": [(1, 1), None, "impact", kernel.Impact],
            "law": ["Linear", None, 3, ["linear"]],
            "observe": [None, 3, [], {}, "ke_feild", [3], [["energy"]], {"energy": 3}, *NO_OPTIONS],
            "model": [None, 3, "paper", kernel.Bistable()],
        },
    ),
    kernel.simulate: (
        {"scene": kernel.Scene(5, 0.1, IMPACT)},
        {
            "scene": [None, 3, IMPACT],
            "accuracy": NO_NUMBER,
            "method": [None, 3, "rk54", ["auto"]],
            "max_steps": KNOBS["max_steps"],
            "certify": KNOBS["certify"],
        },
    ),
}
RESULTS = {kernel.KeRatio, kernel.Simulation}  # what is given back: nobody makes one
# Plain numbers, which the Model that they are given to checks (above, and in test_kernel_laws).
LAWS = {kernel.Bistable, kernel.Hertz, kernel.PiecewiseLinear, kernel.Polynomial, kernel.PowerLaw, kernel.Toda}
LAWS |= {kernel.Disordered, kernel.Graded}
HISTORIES = {kernel.HalfSine, kernel.Harmonic, kernel.Ramp, kernel.Samples}  # which kernel.Drive checks


def frame(**columns):
    grid = pd.MultiIndex.from_product([[5, 20, 80], [1e-5, 1e-3], [0.5, 2], [1, 3, 9]], names=PARAMETERS).to_frame(
        False
    )
    numbers = {"ke_ratio": 2.0 / grid["N"] ** 0.5, "error": 1e-4, "chaotic": False, "status": "done"}
    return grid.assign(**numbers | columns)


FOUND = analysis.transition(frame(ke_ratio=lambda df: 1e3 / df["N"] ** 3))
AT = {"M_over_M0": 2, "V_over_V0": 1}
NO_FRAME = [
    None,
    3,
    "quick.h5",
    [],
    frame().to_dict("list"),
    frame().to_numpy(),
    pd.DataFrame(),
    frame()["N"],
    frame().drop(columns="ke_ratio"),
    frame().rename(columns={"zeta_T": "zeta_t"}),
    frame(ke_ratio="low"),
    frame(chaotic="no"),
    frame(status=b"done"),
    frame(status=3),
    frame(N=[[1, 2]] * 36),
    frame(M_over_M0=None),
    pd.concat([frame(), frame()[["N"]]], axis=1),
]
NO_FLAG = ["no", None, 1, [True]]
NO_OVER = ["N", None, 3, ("N",), ("N", "zeta"), ("N", "N"), [["N"], "zeta_T"], [1, 2]]
NO_AT = [3, "N=3", [("N", 3)], {"M_over_M0": "2"}, {"M_over_M0": [2]}, {"m": 2}, {"M_over_M0": True}, {3: 3}]
NO_RATIO = ["ke", None, 3, ["ke_ratio"], "status", "_ratio", "wal_force_ratio"]
NO_NAMES = [None, 3, "N", [3], ["spring.c2"]]
CALLS |= {
    analysis.load: ({"path": "none.h5"}, {"path": [None, 3, b"x", ["a"], "none.h5", "."], "done_only": NO_FLAG}),
    analysis.best: (
        {"df": frame()},
        {"df": NO_FRAME, "chaotic_too": NO_FLAG, "over": NO_OVER, "of": NO_RATIO, "among": NO_NAMES},
    ),
    analysis.crossings: (
        {"df": frame(), "level": 1.0},
        {
            "df": NO_FRAME,
            "level": NO_NUMBER,
            "along": ["n", None, 3, ["N"], "ke_ratio"],
            "of": ["ke", None, 3, ["ke_ratio"], "status"],
            "which": ["second", None, 1, ["first"]],
        },
    ),
    analysis.optimum: (
        {"df": frame()},
        {"df": NO_FRAME, "chaotic_too": NO_FLAG, "over": NO_OVER, "of": NO_RATIO, "among": NO_NAMES},
    ),
    analysis.plane: ({"df": frame(), "at": AT}, {"df": NO_FRAME, "over": NO_OVER, "at": NO_AT}),
    analysis.map_over: ({"df": frame(), "at": AT}, {"df": NO_FRAME, "over": NO_OVER, "at": NO_AT}),
    analysis.collapse: (
        {"df": frame()},
        {"df": NO_FRAME, "against": ["Re", None, 3, ["Pi_IE"], "pi_ie"], "of": NO_RATIO},
    ),
    analysis.to_xarray: ({"df": frame()}, {"df": NO_FRAME}),
    analysis.transition: ({"df": frame()}, {"df": NO_FRAME, "of": NO_RATIO}),
    analysis.findings: ({"df": frame()}, {"df": NO_FRAME, "of": NO_RATIO}),
    analysis.power_law: ({"found": FOUND}, {"found": NO_FRAME, "definition": ["levle", None, 3, ["level"]]}),
    analysis.power_laws: ({"found": FOUND}, {"found": NO_FRAME}),
}


def public(module):
    return {getattr(module, name) for name in module.__all__ if not name.startswith("__")}


def test_every_public_name_is_called_here():
    assert set(CALLS) == (public(kernel) - RESULTS - LAWS - HISTORIES) | (public(analysis) - {analysis.InputError})
    for call, (_, wrong) in CALLS.items():
        assert set(wrong) == set(inspect.signature(call).parameters), call


def cases():
    for call, (good, wrong) in CALLS.items():
        for name, values in wrong.items():
            for k, value in enumerate(values):
                if not (name in ("rtol", "atol") and value is None):
                    yield pytest.param(call, good | {name: value}, id=f"{call.__name__}-{name}-{k}")


# A sign of words that are not ours: of Python, numpy or pandas.
FOREIGN = re.compile(
    r"object is not|has no attribute|unhashable|ambiguous|not supported between|could not convert|Invalid"
)


@pytest.mark.parametrize(("call", "arguments"), list(cases()))
def test_a_wrong_argument_is_answered_in_our_words(call, arguments):
    kind = ValueError if call.__module__.startswith("kernel") else analysis.InputError
    if call in (kernel.ke_ratio, kernel.ke_ratios, kernel.measure) and {"rtol", "atol"} & set(arguments):
        arguments = arguments | {"method": "rk45"}
    with pytest.raises(kind) as caught:
        call(**arguments)
    assert caught.type in (kind, ProblemsError)  # not one of Python's own kinds of it
    told = str(caught.value)
    assert "\n" not in told
    assert not FOREIGN.search(told), told
    assert len(told) < 1000


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: kernel.ke_ratio(1, -1, 1, 1, 7, "rk54", certify="no"), ["N:", "zeta_T:", "accuracy:",
         "method:", "certify:"]),
        (lambda: kernel.ke_ratios(3, 7, certify=0), ["tasks:", "accuracy:", "certify:"]),
        (lambda: kernel.ke_ratios({"n": 3, "zeta_T": "x", "V_over_V0": [[1]]}), [
         "lacks the column N (did you mean it by 'n'?)", "lacks the column M_over_M0",
         "zeta_T: must hold numbers", "V_over_V0: must be a number or one column"]),
        (lambda: kernel.Scene(1, -1, 3, "cubic", "energy_"), ["N:", "zeta_T:", "event:", "law:",
         "did you mean 'energy'"]),
        (lambda: kernel.simulate(None, 7), ["scene:", "accuracy:"]),
        (lambda: analysis.best(frame(ke_ratio="low", chaotic="no").drop(columns="N")), ["lacks the columns N",
         "numbers in the columns ke_ratio", "True, False or nothing in the columns chaotic"]),
        (lambda: analysis.plane(frame(), "N", 3), ["over:", "at:"]),
        (lambda: analysis.plane(frame().rename(columns={"zeta_T": "zeta_t"})), ["zeta_T (did you mean it by 'zeta_"]),
        (lambda: analysis.plane(frame(), ("N", "zetaT"), {"mass": 1}), ["zetaT, mass",
         "zetaT (did you mean 'zeta_T'?)"]),
        (lambda: analysis.collapse(frame(), "Pi_IEE"), ["against:", "did you mean 'Pi_IE'"]),
    ],
)  # fmt: skip
def test_all_problems_are_told_at_once(call, told):
    with pytest.raises(ValueError) as caught:
        call()
    assert [part for part in told if part not in str(caught.value)] == []


RULES = [analysis.best, analysis.optimum, analysis.transition, analysis.collapse, analysis.findings]


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.__name__)
def test_rows_of_several_chains_do_not_compete_as_those_of_one(rule):
    rows = unknown_table()
    rule(rows.assign(**{"spring.c2": 4.0}))
    mixed = rows.assign(**{"spring.c2": np.where(rows.index % 2, 4.0, 3.5)})
    with pytest.raises(analysis.InputError, match=r"varies spring\.c2: choose the rows of one chain"):
        rule(mixed)


@pytest.mark.parametrize("N", NO_NUMBER)
def test_a_length_that_is_no_number_is_held_against_no_list(N):
    released, listed = kernel.Release([0.0, 0.1], [0.0, 0.0]), kernel.Model(mass=[1.0, 2.0])
    calls = (
        lambda: kernel.Scene(N, 1e-3, released, observe="energy"),
        lambda: kernel.Scene(N, 1e-3, IMPACT, model=listed),
        lambda: kernel.ke_ratio(N, 1e-3, 1, 1, model=listed),
    )
    for call in calls:
        with pytest.raises(ValueError, match=r"^N: must be a whole number from 2 to 10000, got ") as caught:
            call()
        assert not re.search("model|event|ambiguous", str(caught.value))


RELEASED = kernel.Release([0.0, 0.1], [0.0, 0.0])


@pytest.mark.parametrize(
    "wrong",
    [
        {"zeta_T": -1},
        {"N": 1},
        {"N": 10_001, "event": RELEASED},
        {"event": "drive"},
        {"event": RELEASED},
        {"law": "cubic"},
        {"N": "x", "zeta_T": None, "event": None, "law": 3},
    ],
    ids=str,
)
def test_a_scenes_options_are_judged_beside_what_else_is_wrong(wrong):
    """Of a profile's last time only the event can tell whether it is too late."""
    observe = {"ke_field": {"times": 0, "sites": 0, "foo": 1}, "profile": {"at": [0.5, 100.0]}}
    with pytest.raises(ProblemsError) as caught:
        kernel.Scene(**{"N": 10, "zeta_T": 0.0, "event": IMPACT, "observe": observe} | wrong)
    told = [line.partition(":")[0] for line in caught.value.lines if not line.startswith("observe")]
    assert set(told) == set(wrong)
    (field, *late) = [line for line in caught.value.lines if line.startswith("observe")]
    assert field.startswith("observe: ke_field: has no option 'foo' (there is times, sites); times must be")
    assert "; sites must be" in field
    assert [line.startswith("observe: profile: at must hold") for line in late] == [True] * ("event" not in wrong)


def test_crossings_and_a_command_tell_every_wrong_argument():
    """Before, the level alone; and of --at the number alone, not the name."""
    with pytest.raises(analysis.InputError) as caught:
        analysis.crossings(unknown_table(), "a", along="q", of="zz", which="mid")
    keys = ["level: must", "which: must", "unknown parameters q", "the table lacks the columns zz"]
    assert [line.startswith(key) for line, key in zip(caught.value.problems, keys, strict=True)] == [True] * 4
    with pytest.raises(analysis.InputError) as caught:
        pairs(["M_over_M0=x", "foo=1", "spring.c2=y"])
    keys = ["--at M_over_M0=x: ", "--at spring.c2=y: ", "unknown parameters foo; "]
    assert [line.startswith(key) for line, key in zip(caught.value.problems, keys, strict=True)] == [True] * 3
