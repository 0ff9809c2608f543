"""Claims about `sweep audit`: what it recomputes, when a promise counts as broken, what it refuses."""

import json
import math

import h5py
import numpy as np
import pytest

from kernel.lattice import Model
from kernel.laws import PiecewiseLinear, Toda
from kernel.method import AUTO, RK45, choose
from sweep import cli
from sweep.errors import InputError
from sweep.schema import PARAMETERS, RESULTS, layout_of, seal
from sweep.tell import audit as audits
from sweep.tell.audit import SAMPLE_MIN, audit, reference_of
from sweep.tell.promise import PROMISED, SIGNIFICANCE, Audited, chance_of_misses, regions

from .conftest import changed

SPEC = """
name = "audited"
[grid]
N         = [5, 8, 13]
zeta_T    = [0.0, 1e-3, 0.2]
M_over_M0 = [0.5, 2]
V_over_V0 = {{ log = [0.3, 3], points = 2 }}
[accuracy]
{accuracy}
"""


@pytest.fixture
def table(tmp_path):
    """table(accuracy): a finished table of 36 small tasks, computed in this process."""

    def make(accuracy="target = 1e-2"):
        spec, path = tmp_path / "a.toml", tmp_path / "a.h5"
        spec.write_text(SPEC.format(accuracy=accuracy))
        assert cli.main(["run", str(spec), "-o", str(path)]) in (0, 1)
        return path

    return make


def spoil(path, wrong, stated=None):
    """Multiply ke_ratio of the first rows that are done and not chaotic; state an error for them."""
    with changed(path) as rows:
        some = np.flatnonzero((rows["status"] == b"done") & ~rows["chaotic"])[:wrong]
        rows["ke_ratio"][some] *= 1.5
        if stated is not None:
            rows["error"][some] = stated
        seal(rows)


def test_a_sound_table_keeps_its_promise(table, capsys):
    assert cli.main(["audit", str(table())]) == 0
    told = capsys.readouterr().out
    assert "within target     kept" in told
    assert "covered by error  kept" in told
    assert "stiffly damped" in told


def test_rows_that_miss_their_target_break_the_promise(table, capsys):
    path = table()
    spoil(path, 12, stated=1.0)
    assert cli.main(["audit", str(path), "--fraction", "1"]) == 1
    told = capsys.readouterr().out
    assert "within target     BROKEN" in told
    assert "covered by error  kept" in told


def test_errors_that_are_stated_too_small_break_the_promise(table, capsys):
    path = table()
    spoil(path, 12)
    assert cli.main(["audit", str(path), "--fraction", "1"]) == 1
    assert "covered by error  BROKEN" in capsys.readouterr().out


def test_one_bad_row_in_thirty_is_chance(table):
    path = table()
    spoil(path, 1)
    assert audit(path, 1.0)["kept"]


def test_chaotic_rows_are_told_and_not_judged(table):
    path = table()
    spoil(path, 12)
    with changed(path) as rows:
        rows["chaotic"] |= np.arange(len(rows)) < np.flatnonzero(rows["status"] == b"done")[15]
        seal(rows)
    report = audit(path, 1.0)
    assert report["kept"]
    chaotic = [region for region in report["regions"] if region["chaotic"]]
    assert max(region["true_error"]["100%"] for region in chaotic) > 0.4


def test_the_sample_follows_from_the_table_and_is_never_below_thirty_rows(table):
    path = table()
    first, again = audit(path, 0.01), audit(path, 0.01)
    assert first == again
    assert first["sampled"] == SAMPLE_MIN
    assert audit(path, 1.0)["sampled"] == first["done"] > SAMPLE_MIN
    assert sum(region["rows"] for region in first["regions"]) == SAMPLE_MIN


def test_the_sample_does_not_depend_on_who_computed_a_row_and_how_long_it_took(table):
    path, drawn = table(), []
    for seconds in (1.0, 2.0, 3.0):
        with h5py.File(path, "r+") as file:
            rows = file["results"][()]
            rows["seconds"], rows["rank"] = seconds, int(seconds)
            seal(rows)
            file["results"][...] = rows
            drawn.append(audits._sample(file, 0.01)[1][list(PARAMETERS)].tolist())
    assert drawn[0] == drawn[1] == drawn[2]


def test_a_table_without_estimates_is_judged_by_its_target_alone(table):
    report = audit(table("target = 1e-2\ncertify = false"))
    assert [promise["promise"] for promise in report["promises"]] == ["within target"]
    assert {region["covered"] for region in report["regions"]} == {None}


def test_tolerances_of_the_users_own_promise_no_target(table):
    report = audit(table('method = "rk45"\nrtol = 1e-4'))
    assert [promise["promise"] for promise in report["promises"]] == ["covered by error"]
    assert report["target"] is None


def test_own_tolerances_without_estimates_promise_nothing(table, capsys):
    assert cli.main(["audit", str(table('method = "rk45"\nrtol = 1e-3\ncertify = false'))]) == 0
    assert "nothing is promised" in capsys.readouterr().out


@pytest.mark.parametrize("target", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8])
def test_the_reference_is_much_tighter_and_always_dormand_prince(target):
    own = choose("auto", target)
    reference = reference_of(own)
    assert reference.kind == RK45
    assert reference.rtol <= (1e-5 * target if own.kind == AUTO else 0.02 * own.rtol)
    assert reference.atol <= 1e-3 * reference.rtol


@pytest.mark.parametrize("rtol", [1e-3, 1e-8])
@pytest.mark.parametrize("atol", [1e-3, 1e-14])
def test_the_reference_is_much_tighter_than_both_tolerances_of_the_users_own(rtol, atol):
    reference = reference_of(choose("rk45", rtol=rtol, atol=atol))
    assert reference.rtol <= 0.01 * rtol
    assert reference.atol <= min(0.01 * atol, 1e-3 * reference.rtol)


def test_rows_whose_reference_costs_too_much_are_skipped_and_counted(table, monkeypatch):
    path = table()
    monkeypatch.setattr("sweep.tell.audit.SECONDS_MAX", 5e-4)
    report = audit(path, 1.0)
    assert 0 < report["skipped"] < report["sampled"]
    assert sum(region["rows"] for region in report["regions"]) == report["sampled"] - report["skipped"]
    monkeypatch.setattr("sweep.tell.audit.SECONDS_MAX", 0.0)
    with pytest.raises(InputError, match="every sampled row is predicted"):
        audit(path, 1.0)


def test_a_row_whose_disturbed_reference_alone_fails_is_not_recomputed_and_not_called_chaotic(table, monkeypatch):
    path, results_of = table("target = 1e-2\ncertify = false"), audits.results_of

    def failing(columns, integrator, certify, disturbance, model):
        result = results_of(columns, integrator, certify, disturbance, model=model)
        if disturbance and columns["N"][0] == 5:
            result["status"] = "step_budget"
        return result

    before = audit(path, 1.0)
    monkeypatch.setattr(audits, "results_of", failing)
    report = audit(path, 1.0)
    assert (before["not_recomputed"], report["not_recomputed"]) == (0, 12)
    told = {region["region"]: region["rows"] for region in report["regions"] if region["chaotic"]}
    assert told == {region["region"]: region["rows"] for region in before["regions"] if region["chaotic"]}
    assert sum(region["rows"] for region in report["regions"]) == report["sampled"] - 12


@pytest.mark.parametrize(
    ("accuracy", "told"),
    [
        ("target = 1e-2", "auto at target 0.01"),
        ('target = 1e-2\nmethod = "rk45"', "rk45 at rtol 1e-05, atol 1e-08; target 0.01"),
        ('method = "rk45"\nrtol = 1e-3', "rk45 at rtol 0.001, atol 1e-06; tolerances of the user's own"),
    ],
)
def test_it_says_once_what_was_asked_for(table, capsys, accuracy, told):
    path = table(accuracy)
    assert cli.main(["audit", str(path)]) in (0, 1)
    assert f" done rows by {told}\n" in capsys.readouterr().out


def test_json_is_the_report(table, capsys):
    path = table()
    capsys.readouterr()
    assert cli.main(["audit", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == audit(path)


@pytest.mark.parametrize(("misses", "rows"), [(0, 30), (6, 30), (5, 30), (2, 7), (1, 1)])
def test_the_chance_of_misses_is_the_binomial_tail(misses, rows):
    miss = 1 - PROMISED
    tail = (math.comb(rows, k) * miss**k * PROMISED ** (rows - k) for k in range(misses, rows + 1))
    assert chance_of_misses(misses, rows) == pytest.approx(math.fsum(tail), rel=1e-9)


def test_of_a_region_is_told_what_half_nine_in_ten_and_all_of_its_errors_stay_within():
    true = np.arange(10.0, 0.0, -1.0)
    rows = Audited(true=true, stated=np.full(10, 8.0), zeta=np.full(10, 1e-6), chaotic=np.zeros(10, bool))
    (region,) = regions(rows, 5.0, certified=True)
    assert region["true_error"] == {"50%": 5.0, "90%": 9.0, "100%": 10.0}
    assert region["stated_over_true"] == {"50%": 8 / 6, "90%": 4.0, "100%": 8.0}
    assert (region["rows"], region["within_target"], region["covered"]) == (10, 0.5, 0.8)


def test_six_misses_of_thirty_break_a_promise_and_five_do_not():
    assert chance_of_misses(6, 30) < SIGNIFICANCE < chance_of_misses(5, 30)


def test_the_help_tells_how_many_rows_are_taken_at_least(capsys):
    with pytest.raises(SystemExit):
        cli.main(["audit", "--help"])
    assert f"of the done rows, {SAMPLE_MIN} at least" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("fraction", ["0", "-1", "1.5", "nan", "inf"])
def test_a_fraction_outside_0_to_1_exits_2_with_one_line(table, capsys, fraction):
    path = table()
    capsys.readouterr()
    assert cli.main(["audit", str(path), "--fraction", fraction]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert "--fraction: must be a number above 0" in err


def test_what_is_no_table_exits_2_with_one_line(tmp_path, capsys):
    (tmp_path / "text").write_text("no table")
    for path in (tmp_path / "none.h5", tmp_path, tmp_path / "text"):
        assert cli.main(["audit", str(path)]) == 2
        out, err = capsys.readouterr()
        assert (out, err.count("\n")) == ("", 1)


def test_a_table_without_done_rows_exits_2(table, capsys):
    path = table()
    with changed(path) as rows:
        rows["status"] = b"pending"
        seal(rows)
    capsys.readouterr()
    assert cli.main(["audit", str(path)]) == 2
    assert "has no done row to audit" in capsys.readouterr().err


def test_numbers_of_the_model_that_vary_are_found_in_lists_too(monkeypatch):
    rows = np.zeros(1, layout_of(axes=("mass", "spring.b", "spring.slopes.0")))
    rows["mass"], rows["spring.b"], rows["spring.slopes.0"] = 2.0, 3.0, -0.5
    pieces = {"law": "piecewise_linear", "strains": [0.1, 0.3], "slopes": ["varied", 2.0]}
    for spring, found in ((pieces, PiecewiseLinear((0.1, 0.3), (-0.5, 2.0))), ({"law": "toda"}, Toda(3.0))):
        names = ["mass", "spring.slopes.0"] if spring is pieces else ["mass", "spring.b"]
        monkeypatch.setattr(audits.table, "resolved", lambda file, spring=spring: {"model": {"spring": dict(spring)}})
        assert audits.its_model({RESULTS: rows[names]}) == Model(spring=found, mass=2.0)
