"""What a user reads when a spec is wrong: every problem at once, each with its key, the rule and the value."""

import json
import os
from pathlib import Path

import pytest

from sweep.errors import PROBLEMS_MAX, InputError, some_of
from sweep.plan.problems import LINE_MAX, cut
from sweep.plan.spec import parse_spec, read_spec

from .conftest import problems_of

QUANTITIES = (
    "peak_ke, ke, wall_force, contact_force, acceleration, impulse, arrival, dissipated, stored, flipped, rebound"
)
GOOD = """name = "good"
[grid]
N = 5
zeta_T = 0.0
M_over_M0 = [1.0, 2]
V_over_V0 = 1
[accuracy]
target = 1e-3
[output]
observe = ["peak_ke"]
"""


def problems(text: str) -> tuple[str, ...]:
    return problems_of(parse_spec, text, "x.toml")


@pytest.mark.parametrize(
    ("line", "instead", "problem"),
    [
        ("N = 5", "N = 1", "grid.N: must be a whole number from 2 to 10000, got 1"),
        ("N = 5", "", "grid.N: is missing"),
        ("N = 5", "N = 5\nn = 5", "grid.n: is not a known key (did you mean 'N'?), got 5"),
        ("N = 5", "N = 0x8" + 15 * "0", "is not TOML: grid.N: a whole number must fit 64 bits, got 0x8"),
        ("M_over_M0 = [1.0, 2]", "M_over_M0 = -1", "grid.M_over_M0: must be a number from 0.01 to 100, got -1"),
        ("M_over_M0 = [1.0, 2]", "M_over_M0 = []", "grid.M_over_M0: must hold at least one value, got []"),
        ("V_over_V0 = 1", "V_over_V0 = nan", "grid.V_over_V0: must be a number from 0.01 to 20, got nan"),
        ("V_over_V0 = 1", "V_over_V0 = '1'", "grid.V_over_V0: must be a number from 0.01 to 20, got '1'"),
        ("zeta_T = 0.0", "zeta_T = -inf", "grid.zeta_T: must be a number from 0 to 10, got -inf"),
        ("target = 1e-3", "target = 0", "accuracy.target: must be a number from 1e-08 to 0.1, got 0"),
        (
            "target = 1e-3",
            "method = 'rk4'",
            "accuracy.method: must be one of auto, rk45, got 'rk4' (did you mean 'rk45'?)",
        ),
        ("target = 1e-3", "accuracy = 1e-3", "accuracy.accuracy: is not a known key, got 0.001"),
        ("N = 5", "N = 5\nmodel = 1", "grid.model: is not a known key (it is a section of its own, [model]), got 1"),
        ("N = 5", "N = 5\nname = 1", "grid.name: is not a known key (it belongs before all sections), got 1"),
        ("N = 5", "N = { log = [5, 6], points = 2.5 }", "grid.N: points must be a whole number from 1 to 1000000"),
        ("target = 1e-3", "max_steps = 1.5", "accuracy.max_steps: must be a whole number from 1 to 10**15, got 1.5"),
        ("target = 1e-3", "method = 4", "accuracy.method: must be one of auto, rk45, got 4"),
        ("target = 1e-3", "rtol = 1e-3", 'accuracy.rtol: stands only with method = "rk45", since "auto" chooses'),
        ("target = 1e-3", "method = 'rk45'\nrtol = 1", "accuracy.rtol: must be a number from 1e-13 to 0.1, got 1"),
        ("target = 1e-3", "method = 'rk45'\natol = 0", "accuracy.atol: must be a finite number above 0, got 0"),
        ("target = 1e-3", "certify = 'yes'", "accuracy.certify: must be a valid boolean, got 'yes'"),
        (
            "['peak_ke']",
            "[]",
            f"output.observe: must be a list of distinct quantities out of: {QUANTITIES}; got []",
        ),
        (
            "['peak_ke']",
            "['heat']",
            f"output.observe: must be a list of distinct quantities out of: {QUANTITIES}; got 'heat'",
        ),
        ("'good'", "''", "name: must have at least 1 character, got ''"),
        ("'good'", "3", "name: must be a valid string, got 3"),
        ("'good'", "'a'\n'k(e)y' = 1", "k(e)y: is not a known key, got 1"),
        ("[grid]", "[[grid]]", "grid: must be a section [grid], got [{"),
    ],
)
def test_one_mistake_is_one_problem_with_key_rule_and_value(line, instead, problem):
    text = GOOD.replace('"', "'")
    assert line in text
    found = problems(text.replace(line, instead))
    assert len(found) == 1
    assert found[0].startswith(f"x.toml: {problem}")


def test_all_problems_are_reported_at_once():
    text = GOOD.replace("N = 5", "N = 1\nM = 3").replace("= 1e-3", "= nan").replace("[1.0, 2]", "[-1, 0]")
    keys = [problem.split(": ")[1] for problem in problems(text + "[more]\n")]
    assert sorted(keys) == ["accuracy.target", "grid.M", "grid.M_over_M0", "grid.N", "more"]


def test_a_problem_with_a_long_value_is_still_one_readable_line():
    (problem,) = problems(GOOD.replace("N = 5", f"N = 5\nmore = {list(range(5000))}"))
    assert problem.startswith("x.toml: grid.more: is not a known key, got [0, 1, ")
    assert len(problem) < 400
    assert cut("x" * LINE_MAX) == "x" * LINE_MAX
    assert cut("x" * (LINE_MAX + 1)) == "x" * LINE_MAX + "..."


def test_a_grid_too_large_for_a_table_is_refused():
    huge = "{ linear = [1, 2], points = 100000 }"
    text = GOOD.replace("zeta_T = 0.0", f"zeta_T = {huge}").replace("V_over_V0 = 1", f"V_over_V0 = {huge}")
    assert problems(text) == ("x.toml: grid has 20000000000 tasks, at most 1000000000 fit one table",)


@pytest.mark.parametrize("text", ["name = ", "name = 'a'\nname = 'b'", "= 1", "[grid", f"x = {'[' * 5000}", "\0"])
def test_text_that_is_not_toml_is_one_problem(text):
    (problem,) = problems(text)
    assert problem.startswith(("x.toml: is not TOML: ", "x.toml: is nested too deeply"))


def test_a_whole_number_may_be_written_as_a_power_of_ten():
    text = GOOD.replace("N = 5", "N = { linear = [10, 100], points = 10 }").replace("target = 1e-3", "max_steps = 1e6")
    search = '[search]\nfind = "level"\nalong = "N"\nlevel = 1\nmost = 1e2\n'
    spec = parse_spec(text + search, "x")
    assert (len(spec.grid.N), spec.accuracy.max_steps, spec.search.most) == (10, 10**6, 100)
    assert isinstance(spec.accuracy.max_steps, int)


def test_a_line_that_is_not_toml_is_shown():
    (problem,) = problems(GOOD.replace("N = 5", "N = 12:5:60"))
    assert problem.startswith("x.toml: is not TOML: Expected newline or end of document")
    assert problem.endswith("column 7), got 'N = 12:5:60'")


def test_byte_order_mark_and_windows_line_ends_are_taken(tmp_path):
    (tmp_path / "plain.toml").write_text(GOOD)
    (tmp_path / "windows.toml").write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert read_spec(tmp_path / "windows.toml") == read_spec(tmp_path / "plain.toml")


def test_files_that_cannot_be_read_are_named_with_the_reason(tmp_path):
    (tmp_path / "latin.toml").write_bytes(b"name = '\xe9'")
    reasons = {"missing.toml": "No such file", ".": "Is a directory", "latin.toml": "is not a text file in UTF-8"}
    for name, reason in reasons.items():
        with pytest.raises(InputError, match=reason):
            read_spec(tmp_path / name)


def test_specs_that_ask_for_other_numbers_differ_by_key_and_names_do_not_matter():
    spec = parse_spec(GOOD, "x")
    other = GOOD.replace("good", "renamed").replace("N = 5", "N = [5, 6]").replace("1e-3", "1e-2")
    resolved = json.loads(parse_spec(other, "x").resolved())
    assert spec.differences(resolved) == ["accuracy.target", "grid.N"]


def test_a_wrong_chain_is_told_beside_what_else_is_wrong():
    told = problems(GOOD.replace("N = 5", "N = 1") + '[model]\nwall = "open"\nspring = { law = "todda" }\n')
    assert [line.partition(": must")[0] for line in told] == [
        "x.toml: grid.N",
        "x.toml: model.spring.law",
        "x.toml: model.wall",
    ]


def test_a_range_with_a_wrong_key_tells_its_wrong_ends_too():
    (line,) = problems(GOOD.replace("V_over_V0 = 1", "V_over_V0 = { log = [0.1, 30], ponts = 3 }"))
    assert "ponts (did you mean 'points'?); must be a number from 0.01 to 20, got 30" in line


SEARCH = """[search]
find = "lowest"
over = ["M_over_M0"]
"""


@pytest.mark.parametrize(
    ("changes", "rest", "keys"),
    [
        (
            {},
            SEARCH.replace('["M_over_M0"]', '["N", "foo"]') + 'of = "wall_force"\nrobust = -1\nlevel = 3\n',
            ["search.level", "search.of", "search.over", "search.over", "search.robust"],
        ),
        (
            {},
            SEARCH.replace("M_over_M0", "foo") + 'of = "wall_force"\nalong = "N"\nuntil = 0.1\n',
            ["search.along", "search.of", "search.over", "search.until"],
        ),
        ({}, SEARCH.replace("lowest", "lowset").replace("M_over_M0", "foo"), ["search.find", "search.over"]),
        ({}, SEARCH + 'robust = 9\nby = "best"\n', ["search.by", "search.robust"]),
        (
            {"target = 1e-3": "rtol = 7", "['peak_ke']": "[]"},
            '[search]\nfind = "level"\nalong = "zeta_T"\nuntil = 7\n[adaptive]\n',
            ["accuracy.rtol"] * 2 + ["adaptive", "grid.zeta_T", "output.observe", "search.level", "search.until"],
        ),
        (
            {"N = 5": "N = 1\n'spring.c9' = 1", "target = 1e-3": "target = 9\ncertify = false"},
            SEARCH,
            ["accuracy.certify", "accuracy.target", "grid.N", "grid.spring.c9"],
        ),
        ({"N = 5": "N = 5\n'spring.c9' = 1\n'spring.c2' = 'x'"}, "", ["grid.spring.c2", "grid.spring.c9"]),
        (
            {"N = 5": "N = 5\n'spring.c2' = [4, 2e9]", "target": "tarqet"},
            "[model]\nspring = { c2 = 4.0 }\n",
            ["accuracy.tarqet", "grid"],
        ),
        (
            {"N = 5": "N = { linear = [2, 9999], points = 9999 }", "zeta_T = 0.0": "zeta_T = [0, 9, 9, 11]"},
            "[more]\n",
            ["grid.zeta_T", "more"],
        ),
        (
            {
                "N = 5": "N = { linear = [2, 9999], points = 9998 }",
                "zeta_T = 0.0": "zeta_T = { linear = [0, 1], points = 999999 }",
            },
            "[more]\n",
            ["grid has 19995980004 tasks, at most 1000000000 fit one table", "more"],
        ),
    ],
)
def test_what_depends_on_no_other_mistake_is_told_beside_it(changes, rest, keys):
    text = GOOD.replace('"', "'")
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    assert sorted(line.split(": ")[1] for line in problems(text + rest)) == sorted(keys)


def test_all_that_is_wrong_with_an_axis_is_told_at_once():
    (line,) = problems(GOOD.replace("N = 5", "N = [1, 7, 7]"))
    assert "got 1; must hold distinct values, got 7 more than once" in line
    (line,) = problems(GOOD.replace("N = 5", "N = { log = [1.2, 9.4], points = 0 }"))
    assert "points must be a whole number from 1 to 1000000, got 0; must be a whole number from 2 to" in line


@pytest.mark.parametrize(("wrong", "ends"), [(20, "-19, -20"), (21, "-19, -20, and 1 more"), (99, "-20, and 79 more")])
def test_of_many_values_that_break_a_rule_twenty_are_told_and_the_others_counted(wrong, ends):
    (line,) = problems(GOOD.replace("N = 5", f"N = {[-n for n in range(1, wrong + 1)]}"))
    assert line.endswith(ends)


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        (["20,0,1,2", "-3,x,1,2", "20.5,0,1,2"], ["line 3: must hold 4 numbers with commas between them, got ['-3',",
         "points.N: must be a whole number from 2 to 10000, got -3.0 in p.csv, line 3 and 1 more"]),
        (["20,0,1", "20,0,1,2", "20,0,1,999"], ["line 2: must hold 4 numbers", "got 999.0 in p.csv, line 4"]),
        (["20;0;1;2"], ["line 2: must hold 4 numbers with commas between them, got ['20;0;1;2']"]),
    ],
)  # fmt: skip
def test_a_wrong_point_of_a_file_is_named_by_its_line(rows, told, tmp_path):
    (tmp_path / "p.csv").write_text("\n".join(["N,zeta_T,M_over_M0,V_over_V0", *rows, ""]))
    first, *others = problems_of(parse_spec, 'name = "p"\n[points]\nfile = "p.csv"\nseed = 1', "x", tmp_path)
    assert first == "x: points.seed: is not a known key beside points.file"
    assert len(others) == len(told)
    assert [part for part, line in zip(told, others, strict=True) if part not in line] == []


@pytest.mark.parametrize("sign", [";", "\t", " "])
def test_a_file_of_points_with_other_signs_than_commas_is_one_problem(sign, tmp_path):
    text = "N,zeta_T,M_over_M0,V_over_V0\n20,0,1,2\n30,0,1,2\n"
    (tmp_path / "p.csv").write_text(text.replace(",", sign))
    (line,) = problems_of(parse_spec, 'name = "p"\n[points]\nfile = "p.csv"', "x", tmp_path)
    assert f"p.csv must have commas between columns, got {sign!r} in " in line


@pytest.mark.parametrize(
    ("section", "told"),
    [
        ("[points]", "points.file: p.csv is a device or pipe, not a file of points"),
        ('[grid]\nN = 5\nzeta_T = 0.0\nM_over_M0 = 1\nV_over_V0 = 1\n[search]\nfind = "own"',
         "search.file: p.csv cannot be read: it is a device or pipe"),
    ],
)  # fmt: skip
def test_a_pipe_holds_no_points_and_no_sampler_and_is_not_opened(section, told, tmp_path, monkeypatch):
    def waits(path, *_, **__):
        raise AssertionError("whoever opens a pipe waits for ever")

    os.mkfifo(tmp_path / "p.csv")
    monkeypatch.setattr(Path, "open", waits)
    assert problems_of(parse_spec, f'name = "p"\n{section}\nfile = "p.csv"', "x", tmp_path) == (f"x: {told}",)


@pytest.mark.parametrize("more", [0, 1, 7])
def test_of_many_problems_the_first_are_told_and_exactly_the_others_counted(more):
    every = [f"problem {k}" for k in range(PROBLEMS_MAX + more)]
    assert some_of(every) == every[:PROBLEMS_MAX] + [f"and {more} more"] * (more > 0)
