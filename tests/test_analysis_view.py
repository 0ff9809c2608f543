"""Claims about the served page: for this machine's user alone, growing with the table, each impact to look into."""

import http.client
import json
import re
import signal
import subprocess
import threading

import numpy as np
import pytest

import kernel
from analysis.cli import main
from analysis.table import load
from analysis.view import Server, server
from analysis.view import rows as growing
from analysis.view.scene import scene_of
from sweep.errors import InputError
from sweep.schema import seal

from . import browser
from .conftest import BIN, clean_environment
from .test_analysis_cli import rows, write

pytestmark = pytest.mark.slow

SIX, EIGHT = "table 1: 6 done, 6 pending.", "table 1: 4 pending, 8 done."
GRID = ((5, 10, 20), (1e-3, 1e-2), (1.0,), (0.5, 2.0))


def data(done=12):
    made = rows(GRID)
    made["status"][done:] = b"pending"
    seal(made)
    return made


@pytest.fixture
def served(tmp_path, monkeypatch):
    monkeypatch.setattr(growing, "REST", 0.0)  # of the first reading too, which is slow on a busy machine
    with Server(write(tmp_path / "t.h5", data(6))) as server:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield server
        server.shutdown()
        thread.join(30)


def ask(server, path, host=None):
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=60)
    connection.request("GET", path, headers={"Host": host} if host else {})
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, body


@pytest.mark.parametrize("path", ["/", "/rows", "/version", "/scene?task=0", "/?token=wrong", "/rows?token="])
def test_nobody_without_the_token_is_told_anything(served, path):
    status, body = ask(served, path)
    assert status == 403
    assert b"ke_ratio" not in body


def test_a_foreign_name_for_this_machine_is_refused(served):
    good = f"/version?token={served.token}"
    assert ask(served, good)[0] == 200
    assert ask(served, good, host="example.org")[0] == 403


@pytest.mark.parametrize(("port", "status"), [(80, 200), (8080, 403)])
def test_the_port_that_browsers_leave_out_of_a_name_need_not_be_in_it(served, port, status):
    asked, connected = f"/version?token={served.token}", served.server_port
    served.server_port = port  # the one that the server goes by: only root may have 80
    for host in ("127.0.0.1", "localhost"):
        connection = http.client.HTTPConnection("127.0.0.1", connected, timeout=60)
        connection.request("GET", asked, headers={"Host": host})
        assert connection.getresponse().status == status
        connection.close()


@browser.needed
def test_a_browser_opens_the_address_of_the_port_that_it_leaves_out(tmp_path):
    try:
        server = Server(write(tmp_path / "t.h5", data(6)), 80)
    except InputError as error:
        pytest.skip(str(error))
    with server, browser.browser() as running:
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        tab = browser.Tab(running, server.address)
        assert tab.text("#status") == "6 of 12 rows done (6 pending)."
        tab.page.close()
        server.shutdown()
        thread.join(30)


def test_only_this_machine_can_reach_it(served):
    assert served.server_address[0] == "127.0.0.1"
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=[\w-]{32}", served.address)


@pytest.mark.parametrize(
    ("path", "status", "said"),
    [
        ("/none", 404, "there is no /none"),
        ("/scene?task=99", 422, "there is no task 99"),
        ("/scene?task=x", 422, "task must be a whole number, got 'x'"),
        ("/scene?task=%D9%A1", 422, "task must be a whole number, got '\u0661'"),  # a digit of another script
    ],
)
def test_what_there_is_not_is_answered_in_one_sentence(served, path, status, said):
    found, body = ask(served, f"{path}{'&' if '?' in path else '?'}token={served.token}")
    assert found == status
    assert json.loads(body) == {"problem": said}


def test_an_impact_is_that_of_its_row(tmp_path):
    path = write(tmp_path / "t.h5", data())
    table = load(path)
    found = scene_of(table, 5, path)
    N, zeta_T, M, V = (table[name][5] for name in ("N", "zeta_T", "M_over_M0", "V_over_V0"))
    exact = kernel.ke_ratio(N, zeta_T, M, V)
    ke = np.array(found["bistable"]["ke"]["values"]).reshape(found["bistable"]["ke"]["shape"])
    middle = ke[:, (N + 1) // 2 - 1]
    assert middle.max() == pytest.approx(exact.ke_bistable, rel=2e-2)  # seen at 300 times only
    total = np.array(found["linear"]["total"]) + np.array(found["linear"]["dissipated"])
    assert total == pytest.approx(1.0, abs=1e-3)
    assert len(found["bistable"]["v"]) == N


@pytest.mark.parametrize("zeta_T", [1e-3, 0.1])
def test_an_impact_names_the_method_that_each_chain_took(tmp_path, zeta_T):
    path = write(tmp_path / "t.h5", data())
    table = load(path).assign(zeta_T=zeta_T)
    N, _, M, V = (table[name][11] for name in ("N", "zeta_T", "M_over_M0", "V_over_V0"))
    words = scene_of(table, 11, path)["words"]
    for law in ("bistable", "linear"):
        seen = kernel.simulate(kernel.Scene(N, zeta_T, kernel.Impact(M, V), law, "energy"))
        assert f"{law} chain by {seen.method}, off by some" in words


@pytest.mark.parametrize("name", ["spring.c2", "site", "damping"])
def test_a_chain_that_is_not_the_papers_is_not_drawn_as_if_it_were(tmp_path, name):
    path = write(tmp_path / "t.h5", data())
    with pytest.raises(InputError, match=rf"the paper's chain only, this table has {re.escape(name)}"):
        scene_of(load(path).assign(**{name: 0.5}), 5, path)


def test_the_impact_of_a_csv_says_which_chain_it_is_of(tmp_path):
    table = load(write(tmp_path / "t.h5", data()))
    assert "names no model: this is the paper's chain" in scene_of(table, 5, tmp_path / "t.csv")["words"]
    assert "names no model" not in scene_of(table, 5, tmp_path / "t.h5")["words"]


def test_rows_that_came_before_the_page_first_asks_are_not_missed(served):
    page = ask(served, f"/?token={served.token}")[1].decode()
    write(served.table.path, data())
    found = {path: json.loads(ask(served, f"/{path}?token={served.token}")[1]) for path in ("version", "rows")}
    facts = json.loads(re.search(r'id="facts"[^>]*>(.*?)</script>', page, re.DOTALL)[1])
    assert facts["live"]["version"] == SIX
    assert found["version"]["version"] == found["rows"]["version"] == "table 1: 12 done."


def test_a_table_is_read_again_only_when_its_file_has_changed(tmp_path, monkeypatch):
    path, read = write(tmp_path / "t.h5", data(6)), []
    monkeypatch.setattr(growing, "rows_of", lambda path: read.append(path) or load(path, done_only=False))
    monkeypatch.setattr(growing, "REST", 0.0)
    table = growing.Growing(path)
    assert [table.now().version for _ in range(3)] == [SIX] * 3
    write(path, data(8))
    assert [table.now().version for _ in range(3)] == [EIGHT] * 3
    assert len(read) == 2


def test_a_table_that_grows_all_the_while_is_read_a_sixth_of_the_time(tmp_path, monkeypatch):
    path, now, read = write(tmp_path / "t.h5", data(6)), [0.0], []
    held = load(path, done_only=False)
    monkeypatch.setattr(growing.time, "monotonic", lambda: now[0])

    def two_seconds(path):
        read.append(now[0])
        now[0] += 2.0
        return held

    monkeypatch.setattr(growing, "rows_of", two_seconds)
    table = growing.Growing(path)
    while now[0] < 30.0:
        now[0] += 1.0
        path.write_bytes(path.read_bytes() + b"more")
        table.now()
    assert read == [0.0, 12.0, 24.0]


def test_a_table_that_cannot_be_read_in_this_moment_is_as_it_was_a_moment_ago(tmp_path, monkeypatch):
    path, load_now = write(tmp_path / "t.h5", data(6)), growing.rows_of
    monkeypatch.setattr(growing, "REST", 0.0)
    table = growing.Growing(path)

    def busy(path):
        raise OSError("file locking flag values don't match")

    write(path, data(8))
    monkeypatch.setattr(growing, "rows_of", busy)
    assert table.now().version == SIX
    monkeypatch.setattr(growing, "rows_of", load_now)
    assert table.now().version == EIGHT


@pytest.mark.parametrize("how", ["half", "nothing", "gone"])
def test_a_table_that_is_half_written_is_as_it_was_until_it_is_whole(tmp_path, monkeypatch, how):
    path, whole = write(tmp_path / "t.h5", data(6)), write(tmp_path / "whole.h5", data(8))
    monkeypatch.setattr(growing, "REST", 0.0)
    table = growing.Growing(path)
    path.unlink()
    if how != "gone":
        path.write_bytes(whole.read_bytes()[: 1000 if how == "half" else 0])
    assert table.now().version == SIX
    whole.replace(path)
    assert table.now().version == EIGHT


def test_whatever_cannot_be_read_for_an_impact_is_answered_in_its_words(served, monkeypatch):
    def damaged(*_):
        raise InputError("t.h5: its provenance is damaged")

    monkeypatch.setattr(server, "scene_of", damaged)
    status, body = ask(served, f"/scene?task=0&token={served.token}")
    assert (status, json.loads(body)) == (422, {"problem": "t.h5: its provenance is damaged"})


@browser.needed
def test_in_a_browser_the_page_grows_with_the_table_and_a_key_computes_an_impact(served):
    with browser.browser() as running:
        tab = browser.Tab(running, served.address)
        assert tab.text("#status") == "6 of 12 rows done (6 pending)."
        tab.page.focus("#plot")
        for key in ("ArrowRight", "Enter"):
            tab.page.keyboard.press(key)
        tab.wait("document.getElementById('scene').dataset.task !== undefined")
        task = tab.page.evaluate("document.getElementById('scene').dataset.task")
        assert tab.text("#scene-said").startswith(f"task {task}: N 5")
        assert tab.page.locator("#scene-pictures .small").count() == 4
        figures, is_one = "Bokeh.documents.flatMap(one => one.roots())", "part => part instanceof Bokeh.Legend"
        below = f"{figures}.filter(one => one.below.some({is_one})).map(one => one.title.text)"
        assert tab.page.evaluate(below) == ["energies"], "its words would cover curves"
        with tab.page.expect_response(lambda answer: "/scene?" in answer.url, timeout=60_000) as again:
            tab.page.keyboard.press("Enter")  # once more: it is kept already, and computed anew
        assert again.value.ok
        tab.wait(f"document.getElementById('scene-said').textContent.startsWith('task {task}: N 5')")
        tab.wait("document.querySelectorAll('#scene-pictures .small').length === 4")
        # At once: HDF5 refuses to write what a thread of the same process is reading.
        write(served.table.path.with_suffix(".new"), data()).replace(served.table.path)
        tab.wait("document.getElementById('status').textContent.startsWith('12 of 12 rows done')")
        assert tab.errors == []
        assert {url.partition("?")[0] for url in tab.asked} <= {
            f"http://127.0.0.1:{served.server_port}/{name}" for name in ("version", "rows", "scene")
        }
        assert tab.page.evaluate("document.documentElement.scrollWidth") == 1200


def test_the_command_prints_its_address_and_ends_with_ctrl_c(tmp_path):
    path = write(tmp_path / "t.h5", data())
    command = [str(BIN / "analysis"), "view", str(path)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=clean_environment()) as process:
        timer = threading.Timer(120, process.kill)
        timer.start()
        assert process.stdout.readline().startswith("open      http://127.0.0.1:")
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        timer.cancel()
    assert (process.returncode, out.splitlines()[-1], err) == (0, "ended", "")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["none.h5"], "there is no table none.h5"),
        (["t.h5", "--port", "70000"], "--port must be a whole number from 0 to 65535, got '70000'"),
    ],
)
def test_bad_input_is_one_line(arguments, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "t.h5", data())
    assert main(["view", *arguments]) == 2
    assert capsys.readouterr().err == f"analysis: {said}\n"
