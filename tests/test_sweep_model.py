"""Specs with a model, axes of it, and points; small chains, in this process."""

import h5py
import numpy as np
import pandas as pd
import pytest

import analysis
import kernel
from analysis.cli import main as analysis_command
from kernel.task import PARAMETERS
from sweep.cli import main as sweep_command
from sweep.errors import InputError
from sweep.plan.spec import parse_spec

AXES = """
name = "laws"
[model]
site = 0.25
spring = { law = "bistable", c3 = 6.0 }
[grid]
N = [6, 9]
zeta_T = [1e-3, 0.1]
M_over_M0 = 1
V_over_V0 = [1]
"spring.c2" = { linear = [4, 5], points = 3 }
[accuracy]
target = 1e-2
"""
POINTS = """
name = "points"
[points]
sample = "sobol"
n = 20
seed = 3
N = { log = [5, 12] }
zeta_T = { log = [1e-4, 1e-2] }
M_over_M0 = 1
V_over_V0 = { linear = [0.5, 2] }
"spring.c2" = { linear = [4, 5.2] }
[accuracy]
target = 1e-2
"""


def problems(text, folder=None):
    with pytest.raises(InputError) as error:
        parse_spec(text, "s", *([folder] if folder else []))
    return [line.removeprefix("s: ") for line in error.value.problems]


def test_an_axis_of_the_model_is_an_axis_of_the_grid():
    spec = parse_spec(AXES, "s")
    assert spec.tasks == spec.extent().first == spec.extent().at_most == 12
    columns = spec.task_list().columns(np.arange(12))
    assert list(columns) == [*PARAMETERS, "spring.c2"]
    assert columns["spring.c2"].tolist() == [4.0, 4.5, 5.0] * 4
    assert spec.layout().names[-2:] == ("spring.c2", "checksum")
    assert spec.model["spring"] == {"law": "bistable", "c3": 6.0}, "what varies is said by the rows"


def test_a_spec_of_the_papers_chain_is_resolved_as_it_always_was():
    text = AXES.replace("[model]", "").replace("site = 0.25", "").replace('spring = { law = "bistable", c3 = 6.0 }', "")
    spec = parse_spec("\n".join(line for line in text.splitlines() if "spring" not in line), "s")
    assert set(spec._given()) == {"name", "grid", "accuracy", "output"}
    assert spec.kernel_model() is None


def test_a_model_that_is_the_papers_counts_as_none():
    text = AXES.replace("site = 0.25", "").replace('spring = { law = "bistable", c3 = 6.0 }', "")
    empty = "\n".join(line for line in text.splitlines() if "spring" not in line)
    absent, spelled = empty.replace("[model]", ""), empty.replace("[model]", '[model]\nspring = { law = "bistable" }')
    assert len({parse_spec(one, "s").resolved() for one in (absent, empty, spelled)}) == 1
    named = 'spring = { law = "polynomial", c2 = 5.259, c3 = 6.752 }'  # the same numbers, another force in tension
    assert parse_spec(empty.replace("[model]", f"[model]\n{named}"), "s").kernel_model() is not None


def test_every_problem_of_a_model_is_a_line_with_its_key():
    text = AXES.replace("site = 0.25", "site = 2.0\ncolour = 3").replace("c3 = 6.0", "c4 = 6.0")
    text = text.replace("[6, 9]", "[6, 1]").replace('"spring.c2" =', '"zeta" =')
    keys = {line.partition(":")[0] for line in problems(text)}
    assert keys == {"grid.N", "grid.zeta", "model.spring.c4", "model.colour", "model.site"}


def test_every_problem_of_an_axis_of_the_model_is_named():
    assert problems(AXES.replace("spring.c2", "spring.c9")) == [
        "grid.spring.c9: the model has no such number (did you mean 'spring.c3'?)"
    ]
    form, known = "model.mass must be { first, last }", "there are t_end, "
    for name, way in (("mass.last", form), ("mass.lsat", known), ("contact.seed", known)):
        (line,) = problems(AXES.replace("spring.c2", name))
        assert line.startswith(f"grid.{name}: the model has no such number ({way}")
    (line,) = problems(AXES.replace('"spring.c2"', "spring.c2"))
    assert 'grid.spring: is not a known key (a number of the model is written in quotes, as "spring.c2"), got' in line
    (line,) = problems(AXES.replace('"spring.c2"', "spring.slopes.0"))
    assert 'written in quotes, as "spring.slopes.0"), got' in line
    (line,) = problems(AXES + "spring.c2 = 4.0\n")
    assert line == "accuracy.spring: is not a known key, got {'c2': 4.0}"
    lines = problems(AXES.replace(", c3 = 6.0", "").replace("V_over_V0", '"spring.c3" = [6, 0]\nV_over_V0'))
    assert lines[0].startswith("grid: spring.c3: must be above 0 where c2 is")
    assert lines[0].endswith("got c2 = 4 (at spring.c3 = 0, spring.c2 = 4)")
    line, *_ = problems(AXES.replace("linear = [4, 5]", "linear = [4, 5000]"))
    assert line.startswith("grid: spring.c2: must be a number from -1000 to 1000, got 2502.0 (at spring.c2 = 2502)")
    (line,) = problems(
        AXES.replace('law = "bistable", c3 = 6.0', 'law = "power", precompression = 0').replace(
            '"spring.c2" = { linear = [4, 5], points = 3 }', ""
        )
    )
    assert "no stiffness at rest" in line


def test_a_bad_value_of_an_axis_of_the_model_is_told_once_whatever_stands_beside_it():
    more = '"spring.c3" = [6.0, -1, 7, 8, 9, 10]\nmass = [1, 2, -3]\nt_end = [1, 0]'
    text = AXES.replace(", c3 = 6.0", "").replace('"spring.c2" =', f'{more}\n"spring.c2" =')
    told = [line.partition(" (at")[0] for line in problems(text)]
    assert sorted(told) == [
        "grid: mass: must be a number from 0.001 to 1000, got -3.0",
        "grid: spring.c3: must be a number from 0 to 1000, got -1.0",
        "grid: t_end: must be a number from 0.01 to 1000, got 0.0",
    ]
    many = problems(AXES.replace("linear = [4, 5], points = 3", "linear = [4, 5e4], points = 100"))
    assert len(many) == 21
    assert many[-1] == "grid: and 78 more problems"
    (line,) = problems(AXES.replace("[6, 9]", f"{list(range(-30, 2))}"))
    assert line.endswith("-12, -11, and 12 more")


@pytest.mark.parametrize(("text", "section"), [(AXES, "grid"), (POINTS + "[model]\nspring = { c3 = 6.0 }", "points")])
def test_an_axis_takes_the_place_of_the_number_that_stands_in_the_model(text, section):
    """The contract's own spec has c2 = 4.0 beside an axis spring.c2: the same sweep as without, in every row."""
    both = text.replace("c3 = 6.0", "c2 = 4.6, c3 = 6.0")
    assert parse_spec(both, "s").model_dump() == parse_spec(text, "s").model_dump()
    assert "c2" not in parse_spec(both, "s").model["spring"]


@pytest.mark.filterwarnings("error")
def test_a_range_of_points_is_judged_by_its_ends_whatever_is_drawn():
    assert problems(POINTS.replace("N = { log = [5, 12] }", "N = { log = [0.3, 12] }")) == [
        "points.N: must be a whole number from 2 to 10000, got 0.3"
    ]
    few = POINTS.replace("n = 20", "n = 1").replace("log = [1e-4, 1e-2]", "linear = [-1e-3, 10.1]")
    assert problems(few) == ["points.zeta_T: must be a number from 0 to 10, got -0.001, 10.1"]
    assert parse_spec(POINTS.replace("N = { log = [5, 12] }", "N = { log = [1.6, 12.4] }"), "s").tasks == 20, "rounded"
    (line,) = problems(POINTS.replace("linear = [4, 5.2]", "linear = [4, 1001]").replace("n = 20", "n = 1"))
    assert line.startswith("points: spring.c2: must be a number from -1000 to 1000, got 1001.0 (at")


def test_grid_and_points_are_one_or_the_other():
    assert problems(POINTS + "[grid]\nN = 5")[0].startswith("points: must not stand beside")
    grid = AXES[AXES.index("[grid]") : AXES.index("[accuracy]")]
    assert problems(POINTS + grid) == ["points: must not stand beside a section [grid]"]
    assert "grid: is missing" in problems('name = "x"')
    assert {
        line.partition(":")[0] for line in problems(POINTS.replace("sobol", "sobal").replace("n = 20", "n = 0"))
    } == {"points.sample", "points.n"}
    assert problems(POINTS.replace("log = [1e-4, 1e-2]", "log = [1e-4, 100]"))[0].startswith("points.zeta_T: must be")


@pytest.mark.parametrize("kind", ["sobol", "latin", "random"])
def test_a_sample_lies_in_its_box_and_is_the_same_every_time(kind):
    text = POINTS.replace("sobol", kind)
    spec = parse_spec(text, "s")
    columns = spec.task_list().columns(np.arange(spec.tasks))
    assert spec.tasks == 20
    assert 5 <= columns["N"].min() <= columns["N"].max() <= 12
    assert 4 <= columns["spring.c2"].min() < columns["spring.c2"].max() <= 5.2
    assert parse_spec(text, "s").resolved() == spec.resolved()
    assert parse_spec(text.replace("seed = 3", "seed = 4"), "s").differences(spec._given())
    ids = spec.task_list().find(columns)
    assert ids.tolist() == list(range(20))


@pytest.mark.parametrize("range_of", ['"mass.seed" = { linear = [1, 70] }', '"mass.seed" = { log = [1, 70] }'])
def test_realisations_of_disorder_are_sampled_by_whole_seeds(range_of):
    text = POINTS.replace('"spring.c2" = { linear = [4, 5.2] }', range_of) + "[model]\nmass = { spread = 0.1 }\n"
    seeds = parse_spec(text, "s").task_list().columns(np.arange(20))["mass.seed"]
    assert (seeds == np.rint(seeds)).all()
    assert 1 <= seeds.min() < seeds.max() <= 70
    text = VARIED.replace("[1, 2]", "{ log = [1, 50], points = 5 }")
    assert set(parse_spec(text, "s").task_list().columns(np.arange(10))["mass.seed"]) == {1.0, 3.0, 7.0, 19.0, 50.0}


def test_points_of_a_file_are_tasks_and_every_bad_line_is_named(tmp_path):
    text = 'name = "x"\n[points]\nfile = "p.csv"'
    (tmp_path / "p.csv").write_text("N,zeta_T,M_over_M0,V_over_V0,site\n5,0,1,1,0.5\n7,1e-3,2,0.5,0.25\n5,0,1,1,0.5\n")
    spec = parse_spec(text, "s", tmp_path)
    assert spec.tasks == 2, "each once"
    assert spec.task_list().columns(np.arange(2))["site"].tolist() == [0.5, 0.25]
    (tmp_path / "p.csv").write_text("N,zeta,M_over_M0,V_over_V0\n5,0,1\na,0,1,1\n")
    lines = problems(text, tmp_path)
    assert [line for line in lines if "did you mean 'zeta_T'" in line]
    assert sum("line" in line for line in lines) == 2
    (tmp_path / "p.csv").write_text("N,zeta_T,M_over_M0,V_over_V0\n5.5,0,1,1\n5,0,1000,1\n")
    assert {line.partition(":")[0] for line in problems(text, tmp_path)} == {"points.N", "points.M_over_M0"}
    (tmp_path / "p.csv").write_text("N,zeta_T,M_over_M0,V_over_V0\n5.5,0,1,1\n5,x,1,1\n")
    assert [line.partition(" must")[0] for line in problems(text, tmp_path)] == [
        "points.file: p.csv, line 3:",
        "points.N:",
    ]
    (tmp_path / "p.csv").write_text("N,zeta_T,M_over_M0,V_over_V0\n" + "5,x,1,1\n" * 50)
    assert problems(text, tmp_path)[20:] == ["points.file: and 30 more problems"]
    assert "cannot be read" in problems(text.replace("p.csv", "q.csv"), tmp_path)[0]


def test_a_misspelt_input_of_a_sample_is_one_line_and_no_rule_of_its_value_is_asked_for():
    assert problems(POINTS.replace("seed = 3", "sed = 4")) == ["points: 'sed' is no input of a task"]
    lines = problems(POINTS.replace("zeta_T =", "zetaT ="))
    assert lines == [
        "points: 'zetaT' is no input of a task (did you mean 'zeta_T'?)",
        "points: lacks zeta_T",
    ]


@pytest.mark.parametrize("more", [0, 10_000])
def test_a_wrong_number_of_the_model_is_found_among_any_number_of_points(tmp_path, more):
    text, header = 'name = "x"\n[points]\nfile = "p.csv"', "N,zeta_T,M_over_M0,V_over_V0,site,spring.c2\n"
    good = "".join(f"5,0,1,1,0.5,{4 + 1e-5 * k}\n" for k in range(more + 2))
    (tmp_path / "p.csv").write_text(header + good + "9,0,1,1,0.5,4.5\n")
    parse_spec(text, "s", tmp_path)
    (tmp_path / "p.csv").write_text(header + good + "9,0,1,1,0.5,5000\n")
    (line,) = problems(text, tmp_path)
    rule = "must be a number from -1000 to 1000, got 5000.0"
    assert line == f"points: spring.c2: {rule} (at site = 0.5, spring.c2 = 5000)"
    (tmp_path / "p.csv").write_text(header + good + "9,0,1,1,inf,nan\n")
    assert problems(text, tmp_path) == [
        f"points.site: must be a finite number, got inf in p.csv, line {more + 4}",
        f"points.spring.c2: must be a finite number, got nan in p.csv, line {more + 4}",
    ]


@pytest.fixture
def tables(tmp_path):
    (tmp_path / "a.toml").write_text(AXES)
    assert sweep_command(["run", str(tmp_path / "a.toml"), "-o", str(tmp_path / "a.h5")]) == 0
    return tmp_path


@pytest.mark.slow
def test_a_table_has_the_numbers_of_its_models_and_its_rows_are_the_kernels(tables, capsys):
    df = analysis.load(tables / "a.h5")
    model = kernel.Model(kernel.Bistable(c3=6.0), site=0.25)
    rows = kernel.ke_ratios(df[[*PARAMETERS, "spring.c2"]], 1e-2, model=model)
    assert df["ke_ratio"].to_numpy().tobytes() == rows["ke_ratio"].tobytes()
    assert df["ke_ratio"].nunique() == 12
    assert sweep_command(["audit", str(tables / "a.h5")]) == 0
    assert "kept" in capsys.readouterr().out
    assert sweep_command(["export", str(tables / "a.h5"), "-o", str(tables / "a.csv")]) == 0
    assert pd.read_csv(tables / "a.csv")["spring.c2"].tolist() == df["spring.c2"].tolist()
    at = ["--over", "N,spring.c2", "--at", "zeta_T=0.1"]
    assert analysis_command(["map", str(tables / "a.h5"), "-o", str(tables / "m.png"), *at]) == 0
    assert analysis_command(["map", str(tables / "a.h5"), "-o", str(tables / "n.png")]) == 2
    assert "spring.c2" in capsys.readouterr().err
    assert analysis_command(["best", str(tables / "a.h5"), "-o", str(tables / "b.png")]) == 2
    assert "varies spring.c2" in capsys.readouterr().err


@pytest.mark.slow
def test_another_model_is_refused_when_resuming_reusing_and_merging(tables, capsys):
    spec, path = tables / "b.toml", tables / "a.h5"
    spec.write_text(AXES.replace("site = 0.25", "site = 0.75"))
    assert sweep_command(["run", str(spec), "-o", str(path)]) == 2
    assert "model.site" in capsys.readouterr().err
    assert sweep_command(["run", str(spec), "-o", str(tables / "b.h5"), "--reuse", str(path)]) == 2
    assert "is of another model" in capsys.readouterr().err
    assert sweep_command(["run", str(spec), "-o", str(tables / "b.h5")]) == 0
    assert sweep_command(["merge", str(path), str(tables / "b.h5"), "-o", str(tables / "c.h5")]) == 2
    assert "model site 0.25 and 0.75" in capsys.readouterr().err.replace("model.", "model ")
    spec.write_text(AXES.replace("linear = [4, 5]", "linear = [4.5, 5]"))
    assert sweep_command(["run", str(spec), "-o", str(tables / "d.h5"), "--reuse", str(path)]) == 0
    assert "8 rows taken" in capsys.readouterr().err
    assert sweep_command(["merge", str(path), str(tables / "d.h5"), "-o", str(tables / "e.h5")]) == 0
    assert len(analysis.load(tables / "e.h5")) == 16


@pytest.mark.slow
def test_points_are_resumed_shared_out_and_merged(tmp_path, capsys):
    (tmp_path / "p.toml").write_text(POINTS)
    whole, parts = tmp_path / "t.h5", [tmp_path / f"{k}.h5" for k in (1, 2)]
    for k, part in enumerate(parts, 1):
        assert sweep_command(["run", str(tmp_path / "p.toml"), "-o", str(part), "--shard", f"{k}/2"]) == 0
    assert sweep_command(["merge", *map(str, parts), "-o", str(tmp_path / "m.h5")]) == 0
    assert sweep_command(["run", str(tmp_path / "p.toml"), "-o", str(whole), "--reuse", str(tmp_path / "m.h5")]) == 0
    assert "20 rows taken" in capsys.readouterr().err
    assert sweep_command(["run", str(tmp_path / "p.toml"), "-o", str(whole)]) == 0
    with h5py.File(whole) as a, h5py.File(tmp_path / "m.h5") as b:
        assert a["results"][()].tobytes() == b["results"][()].tobytes()
    assert sweep_command(["plan", str(tmp_path / "p.toml")]) == 0
    assert "tasks          20" in capsys.readouterr().out


VARIED = """
name = "varied"
[model]
mass = { spread = 0.1, seed = 1 }
stiffness = { first = 1.0, last = 2.0 }
wall = "free"
[grid]
N = [6, 9]
zeta_T = 1e-3
M_over_M0 = 1
V_over_V0 = 1
"mass.seed" = [1, 2]
[accuracy]
target = 1e-2
"""


def test_a_spec_says_how_numbers_go_along_the_chain_and_its_axes_vary_them():
    spec = parse_spec(VARIED, "s")
    assert spec.tasks == 4
    assert spec.model["mass"] == {"spread": 0.1}
    assert spec.model["wall"] == "free"
    assert spec.kernel_model().stiffness == kernel.Graded(1.0, 2.0)
    other = parse_spec(VARIED.replace("seed = 1", "seed = 7"), "s")
    assert other.differences(spec._given()) == [], "what the axis says is no part of the model"
    listed = VARIED.replace("{ first = 1.0, last = 2.0 }", "[1.0, 2.0, 3.0]")
    assert problems(listed) == ["model: holds lists of 3 numbers, so that grid.N must be 3, got 6, 9"]


def test_every_problem_of_what_is_not_uniform_has_its_key():
    text = VARIED.replace("spread = 0.1", "spread = 1.5").replace("last = 2.0", "lats = 2.0").replace("free", "soft")
    lines = problems(text.replace('"mass.seed" = [1, 2]', ""))
    assert [line.partition(":")[0] for line in lines] == ["model.stiffness", "model.mass.spread", "model.wall"]
    (line,) = problems(VARIED.replace('"mass.seed" = [1, 2]', '"mass.seed" = [1.5]'))
    assert line == "grid: mass.seed: must be a whole number from 0 to 2**32 - 1, got 1.5 (at mass.seed = 1.5)"
    (line,) = problems(VARIED.replace("mass.seed", "damping.seed"))
    assert line == "grid.damping.seed: the model has no such number (model.damping must be { spread, seed })"


def test_an_entry_of_a_list_can_be_an_axis_and_is_said_by_the_rows():
    law = 'spring = { law = "piecewise_linear", strains = [0.1, 0.3], slopes = [-0.5, 2.0] }'
    text = AXES.replace('spring = { law = "bistable", c3 = 6.0 }', law).replace("spring.c2", "spring.slopes.0")
    text = text.replace("linear = [4, 5]", "linear = [-0.6, -0.2]")
    spec = parse_spec(text, "s")
    other = parse_spec(text.replace("slopes = [-0.5, 2.0]", "slopes = [-0.1, 2.0]"), "s")
    assert other.differences(spec._given()) == []
    assert spec.model["spring"]["slopes"] == ["varied", 2.0]


@pytest.mark.slow
def test_a_sweep_of_chains_that_are_not_uniform_has_the_kernels_bits(tmp_path):
    (tmp_path / "v.toml").write_text(VARIED)
    assert sweep_command(["run", str(tmp_path / "v.toml"), "-o", str(tmp_path / "v.h5")]) == 0
    df = analysis.load(tmp_path / "v.h5")
    assert set(df["method"]) == {"rk45"}
    model = kernel.Model(mass=kernel.Disordered(0.1), stiffness=kernel.Graded(1.0, 2.0), wall="free")
    rows = kernel.ke_ratios(df[[*PARAMETERS, "mass.seed"]], 1e-2, model=model)
    assert df["ke_ratio"].to_numpy().tobytes() == rows["ke_ratio"].tobytes()
    assert df["ke_ratio"].nunique() == 4
    assert sweep_command(["audit", str(tmp_path / "v.h5")]) == 0
