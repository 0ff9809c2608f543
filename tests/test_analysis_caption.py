"""Below a picture there is room for all that its legend and its small print say."""

import json

import h5py
import numpy as np
import pandas as pd
import pytest

import kernel
from analysis import load, power_laws, transition
from analysis.caption import MEANINGS, below
from analysis.chain import alike_in, chain_of, is_papers, made_of
from analysis.cli import main
from analysis.commands.transition import law_lines
from analysis.look import settings
from analysis.quantity import KE, quantity
from analysis.style import canvas
from sweep.schema import seal
from sweep.store.meanings import meaning
from sweep.store.table import PROVENANCE

from .test_analysis_cli import rows, write

NONE = pd.DataFrame()
FROM_FIRST = "from mass.first to mass.last times the paper's"
LONG = "what takes several lines of a narrow column, as an impact with its exponent and the interval of that does"


@pytest.mark.parametrize("long", [(0, 1, 2), (0,), (3, 4), (1, 3), ()])
@pytest.mark.parametrize("columns", [1, 2, 3])
def test_a_legend_of_wrapped_labels_stays_between_the_axes_and_the_print(long, columns):
    """The columns of a legend are filled one after the other."""
    from matplotlib.lines import Line2D

    with settings():
        figure, axes = canvas(1, 1, 6.0, 6.0)
        axes[0, 0].set_xlabel("x")
        handles = [Line2D([], [], label=LONG if k in long else "short") for k in range(5)]
        below(figure, handles, ("ke_ratio",), columns=columns)
        figure.draw_without_rendering()
        legend = figure.legends[0].get_window_extent()
        assert figure.texts[0].get_window_extent().y1 <= legend.y0 + 1
        assert legend.y1 <= axes[0, 0].get_tightbbox().y0 + 1


def test_no_words_of_a_picture_or_a_column_call_a_chain_bistable_that_need_not_be():
    words = [*MEANINGS.values(), quantity("wall_force_ratio").meaning]
    words += [meaning(name).replace("ke_bistable", "") for name in (*rows().dtype.names, "wall_force_ratio")]
    assert not [text for text in words if "bistable" in text]


def test_a_picture_names_the_springs_that_are_not_the_papers_without_the_numbers_that_it_varies(tmp_path):
    path = write(tmp_path / "t.h5", rows())
    assert chain_of(path, NONE) == ""
    spring = {"law": "piecewise_linear", "knee": -0.25, "after": 0.5}
    spec = {"grid": {"N": [5], "spring.knee": [-0.25, -0.5]}, "model": {"spring": spring}}
    table = pd.DataFrame({"N": 5, "spring.knee": [-0.25, -0.5]})
    with h5py.File(path, "a") as file:
        file[f"{PROVENANCE}/resolved"] = np.bytes_(json.dumps(spec))
    assert chain_of(path, table) == "Springs: piecewise linear, after = 0.5."


def test_a_picture_tells_the_numbers_in_a_springs_lists_but_for_those_that_it_varies(tmp_path):
    path = write(tmp_path / "t.h5", rows())
    spring = {"law": "piecewise_linear", "strains": [0.1, 0.3], "slopes": [0.3, 2]}
    with h5py.File(path, "a") as file:
        file[f"{PROVENANCE}/resolved"] = np.bytes_(json.dumps({"grid": {"N": [5]}, "model": {"spring": spring}}))
    springs = "Springs: piecewise linear, strains.0 = 0.1, strains.1 = 0.3"
    assert chain_of(path, NONE) == f"{springs}, slopes.0 = 0.3, slopes.1 = 2."
    assert chain_of(path, pd.DataFrame({"N": 5, "spring.slopes.0": [0.2, 0.3]})) == f"{springs}, slopes.1 = 2."


def test_a_picture_names_whatever_else_of_the_chain_is_not_the_papers(tmp_path):
    path = write(tmp_path / "t.h5", rows())
    contact, mass = kernel.Hertz(3e5, 1.2), kernel.Disordered(0.1, 3)
    others = {"mass": mass, "stiffness": kernel.Graded(1, 2), "damping": [1.0, 0.5], "site": 0.3, "t_end": 4.0}
    settings = kernel.Model(contact=contact, wall="free", **others).settings()
    with h5py.File(path, "a") as file:
        file[f"{PROVENANCE}/resolved"] = np.bytes_(json.dumps({"model": settings}))
    assert chain_of(path, pd.DataFrame({"contact.stiffness": [3e5], "site": [0.3]})) == (
        "Springs: bistable, c2 = 5.259, c3 = 6.752. Contact: F = K w^p, exponent = 1.2. Runs end at t = 4 N. "
        "Mass random, within 0.1 of the mean. Stiffness from 1 to 2 times the paper's along the chain. "
        "Damping from a list of 2 numbers. The far end is free."
    )


@pytest.mark.parametrize(
    ("how", "axes", "said"),
    [
        (kernel.Disordered(0.1, 3), ["mass.seed"], "Mass random, within 0.1 of the mean."),
        (kernel.Disordered(0.1, 3), ["mass.spread"], "Mass random, within mass.spread of the mean."),
        (kernel.Disordered(0.1, 3), ["mass.spread", "mass.seed"], "Mass random, within mass.spread of the mean."),
        (kernel.Graded(1.0, 2.0), ["mass.last"], "Mass from 1 to mass.last times the paper's along the chain."),
        (kernel.Graded(1.0, 2.0), ["mass.first"], "Mass from mass.first to 2 times the paper's along the chain."),
        (kernel.Graded(1.0, 2.0), ["mass.first", "mass.last"], f"Mass {FROM_FIRST} along the chain."),
        (3.0, [], "Mass 3 times the paper's."),
        (3.0, ["mass"], ""),
    ],
)
def test_what_a_table_varies_along_the_chain_is_not_said_to_be_fixed(how, axes, said, tmp_path):
    path, model = write(tmp_path / "t.h5", rows()), kernel.Model(mass=how).settings()
    if isinstance(model["mass"], dict):  # a sweep leaves out what its axes replace
        model["mass"] = {key: x for key, x in model["mass"].items() if f"mass.{key}" not in axes}
    with h5py.File(path, "a") as file:
        file[f"{PROVENANCE}/resolved"] = np.bytes_(json.dumps({"model": model}))
    table = pd.DataFrame({"N": [2]} | {name: [1.0] for name in axes})
    assert chain_of(path, table) == f"Springs: bistable, c2 = 5.259, c3 = 6.752. {said}".rstrip()


def test_numbers_of_the_model_that_are_alike_in_all_rows_are_told():
    some = pd.DataFrame({"N": 5, "mass.seed": [3.0, 3.0], "spring.c2": [4.0, 5.0]})
    assert alike_in(some) == "All at mass.seed = 3."
    assert alike_in(some[["N", "spring.c2"]]) == ""


@pytest.mark.parametrize("command", ["transition", "collapse", "best", "map", "points"])
def test_every_picture_of_a_table_says_what_its_chain_is(command, tmp_path, monkeypatch):
    from analysis.cli import main

    path, seen = write(tmp_path / "t.h5", rows()), []
    with h5py.File(path, "a") as file:
        file[f"{PROVENANCE}/resolved"] = np.bytes_(json.dumps({"model": kernel.Model(kernel.Toda(3.0)).settings()}))
    monkeypatch.setattr(f"analysis.commands.{command}.write", lambda _, figure, *rest: seen.append(figure))
    at = ["--at", "M_over_M0=1", "V_over_V0=1"] if command == "map" else []
    assert main([command, str(path), "-o", str(tmp_path / "t.png"), *at]) == 0
    print_of = " ".join(text.get_text() for text in seen[0].texts).replace("\n", " ")
    assert "Springs: toda, b = 3." in print_of


def test_the_papers_exponent_stands_only_beside_those_of_its_own_chain(tmp_path):
    path, N = tmp_path / "t.h5", np.geomspace(5, 300, 20).round()
    data = rows((tuple(N), (1e-4, 2e-4, 4e-4, 8e-4), (2.0,), (2.0,)))
    data["ke_ratio"] = 1.5 / (1 + (data["N"] * data["zeta_T"] ** 0.45) ** 4)
    seal(data)
    for model, papers in ((None, True), ({"spring": {"law": "bistable", "c2": 5.0}}, False)):
        write(path, data)
        with h5py.File(path, "a") as file:
            file[f"{PROVENANCE}/resolved"] = np.bytes_(json.dumps({"grid": {"N": [5]}, "model": model}))
        table = load(path)
        assert is_papers(path, table) == papers
        lines = law_lines(power_laws(transition(table)), KE, beside=is_papers(path, table))
        assert [line.endswith("; the paper 0.3627") for line in lines] == [papers, False, False]


def test_a_page_says_which_chain_it_shows_and_how_accurately_it_was_computed(tmp_path):
    path, accuracy = write(tmp_path / "t.h5", rows()), {"target": 1e-4}
    assert made_of(path, load(path)) == ""
    with h5py.File(path, "a") as file:
        file[f"{PROVENANCE}/resolved"] = np.bytes_(json.dumps({"grid": {"N": [5]}, "accuracy": accuracy}))
    assert made_of(path, load(path)) == "The paper's chain. Computed by auto at target 0.0001, certified."
    assert main(["page", str(path), "-o", str(tmp_path / "t.html")]) == 0
    assert "at target 0.0001, certified.</p>" in (tmp_path / "t.html").read_text()
    with h5py.File(path, "a") as file:
        del file[f"{PROVENANCE}/resolved"]
        spring = {"law": "bistable", "c2": 5.0, "c3": 6.0}
        file[f"{PROVENANCE}/resolved"] = np.bytes_(json.dumps({"grid": {"N": [5]}, "model": {"spring": spring}}))
    assert made_of(path, load(path)) == "Springs: bistable, c2 = 5, c3 = 6."
