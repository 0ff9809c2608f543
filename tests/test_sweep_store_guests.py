"""The store keeps what processes computed that joined its run, if they compute the run's bits."""

from dataclasses import replace

import numpy as np
import pytest

from kernel.method import choose
from sweep.plan.batches import NO_TASKS, Batches
from sweep.plan.tasks import Tasks
from sweep.schema import RESULTS
from sweep.serve import guests as served
from sweep.serve.guests import Guests
from sweep.serve.master import Master
from sweep.serve.worker import Job, compute_rows
from sweep.store import lease, mailbox, table
from sweep.store.known import Alike
from sweep.store.mailbox import BITS, GUEST, ORDER, ROWS, Sign

from .conftest import SLOW
from .waiting import wait_for

JOB = Job(
    Tasks({"N": [5, 8], "zeta_T": [1e-3], "M_over_M0": [0.5, 2.0], "V_over_V0": [0.3, 1.0, 3.0]}),
    choose("auto", 1e-2),
    certify=False,
    shown=True,
)
TASKS, OURS = len(JOB.tasks), "these bits"


def answered(folder, name):
    """Compute what this guest is to do."""
    for order in [one for one in mailbox.names(folder, ORDER) if one.startswith(name)]:
        asked = mailbox.get(folder / f"{order}{ORDER}")
        ids = JOB.tasks.find({column: asked[column] for column in asked.dtype.names if column != "rank"})
        mailbox.put(folder / f"{order}{ROWS}", compute_rows(JOB, ids, int(asked["rank"][0])))


@pytest.mark.parametrize(("said", "kept"), [(OURS, TASKS), ("other bits", 0), (None, 0)])
def test_rows_of_a_guest_are_kept_where_it_computes_the_bits_of_the_run(tmp_path, monkeypatch, capsys, said, kept):
    for pause in ("LOOK_EVERY", "LIFE_EVERY"):
        monkeypatch.setattr(served, pause, 0.0)
    batches, alike, taken = Batches(np.arange(TASKS), np.linspace(1.0, 2.0, TASKS), 1), Alike(OURS), []
    found, folder = Guests(tmp_path / "t.h5", JOB, batches, 3, None, alike), mailbox.folder_of(tmp_path / "t.h5")

    def more(ids, rows):
        taken.extend(ids[alike.are_of(rows)].tolist())
        return NO_TASKS, np.empty(0)

    master = Master(None, batches, None, lambda *_: None, True, more=more, guests=found)
    ours = replace(lease.new())
    if said is not None:
        (folder / f"{ours.token}.{BITS}").write_text(said)
    sign = Sign(folder / f"{ours.token}{GUEST}", ours)
    while len(batches) or found.busy:
        master._serve_guests(found)
        answered(folder, ours.token)
    master._take_in()
    assert len(taken) == kept
    assert master.count.done == TASKS
    assert ("1 rank computes other bits than rank 0 (these bits)" in capsys.readouterr().err) == (said != OURS)
    sign.close()
    found.close()


def test_a_run_without_a_store_asks_no_guest_which_bits_it_computes(tmp_path):
    found = Guests(tmp_path / "t.h5", JOB, Batches(np.arange(TASKS), np.ones(TASKS), 1), 3)
    assert not (mailbox.folder_of(tmp_path / "t.h5") / BITS).exists()
    found.close()


def test_what_a_guest_has_computed_no_other_sweep_computes_again(sweep, start, tmp_path):
    (tmp_path / "long.toml").write_text(SLOW.replace("1e-7", "1e-9"))
    run = start("run", "long.toml", "-o", "t.h5", "--store", "rows")
    wait_for(lambda: (mailbox.folder_of(tmp_path / "t.h5") / mailbox.RUN).exists())
    joined = start("join", "t.h5")
    _, err = run.communicate(timeout=240)
    assert run.returncode == 0, err
    assert joined.wait(60) == 0
    with table.reading(tmp_path / "t.h5") as file:
        assert np.count_nonzero(file[RESULTS]["rank"] == 1) > 0
    assert "492 rows taken from the store" in sweep("run", "long.toml", "-o", "again.h5", "--store", "rows").stderr
