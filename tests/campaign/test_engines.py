"""Threads, processes and a Dask cluster keep the same rows; what stops a campaign loses none and doubles none."""

import errno
import multiprocessing
import os
import shutil
import signal
import threading
import time

import numpy as np
import pyarrow.parquet as pq
import pytest
from spaces import dies, hop_space

from halfroll.campaign import archive as archives
from halfroll.campaign.archive import open_archive, part_files, read_runs
from halfroll.campaign.engines import Dask, Processes, Threads
from halfroll.campaign.flying import StopRule, fly_campaign
from halfroll.campaign.prepared import prepare
from halfroll.errors import FlightError, LinkError

RUNS = 24


@pytest.fixture(autouse=True)
def _small_parts(monkeypatch):
    for module in ("archive", "flying"):
        monkeypatch.setattr(f"halfroll.campaign.{module}.PART_RUNS", 8)


@pytest.fixture(scope="module")
def cluster():
    """Two workers in processes of their own."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as started:
        yield started


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    vary = {
        "vehicle.mass_kg": {"uniform": [0.9, 1.1], "times": True},
        "scenario.mocap.dropout": {"uniform": [0.0, 0.5]},
    }
    return prepare(hop_space(tmp_path_factory.mktemp("space"), vary=vary))


@pytest.fixture(scope="module")
def flown(prepared, tmp_path_factory):
    """By one thread."""
    with pytest.MonkeyPatch.context() as patch:
        for module in ("archive", "flying"):
            patch.setattr(f"halfroll.campaign.{module}.PART_RUNS", 8)
        folder = tmp_path_factory.mktemp("flown")
        fly_campaign(prepared, Threads(1), folder, RUNS)
    return folder


def bytes_of(folder):
    return {file.name: file.read_bytes() for file in part_files(folder)}


def test_two_threads_keep_the_very_bytes_of_one(prepared, flown, tmp_path):
    fly_campaign(prepared, Threads(2), tmp_path, RUNS)
    assert bytes_of(tmp_path) == bytes_of(flown)
    assert read_runs(tmp_path)["run"].to_pylist() == list(range(RUNS))


@pytest.mark.long
@pytest.mark.filterwarnings("default")  # of Dask, about slow machines
def test_processes_and_a_dask_cluster_keep_the_very_bytes_of_threads(prepared, flown, tmp_path, cluster):
    fly_campaign(prepared, Processes(2), tmp_path / "processes", RUNS)
    fly_campaign(prepared, Dask(cluster.scheduler_address), tmp_path / "dask", RUNS)
    assert bytes_of(tmp_path / "processes") == bytes_of(flown)
    assert bytes_of(tmp_path / "dask") == bytes_of(flown)


class Interrupting:
    """Threads, and Ctrl-C after some rows."""

    def __init__(self, after):
        self.after, self.asked = after, []

    def fly_runs(self, prepared, indices):
        self.asked = list(indices)
        yield from Threads(2).fly_runs(prepared, self.asked[: self.after])
        raise KeyboardInterrupt


def test_what_was_flown_before_an_interruption_is_not_flown_again(prepared, flown, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        fly_campaign(prepared, Interrupting(11), tmp_path, RUNS)
    assert sorted(read_runs(tmp_path)["run"].to_pylist()) == list(range(11))
    going_on = Interrupting(RUNS)
    with pytest.raises(KeyboardInterrupt):
        fly_campaign(prepared, going_on, tmp_path, RUNS)
    assert going_on.asked == list(range(11, RUNS))
    assert bytes_of(tmp_path) == bytes_of(flown)
    assert not list((tmp_path / "unfinished").glob("*"))


def test_an_archive_takes_no_run_twice_and_no_other_campaign(prepared, flown, tmp_path):
    archive = open_archive(tmp_path, prepared.space)
    row = pq.read_table(part_files(flown)[0]).to_pylist()[0]
    archive.keep(row)
    with pytest.raises(archives.InputError, match="run 0 is kept already"):
        archive.keep(row)
    archive.flush()
    other = hop_space(prepared.space.folder, vary=WIDE)
    with pytest.raises(archives.SpaceError, match="with another s"):
        open_archive(tmp_path, other)


@pytest.mark.parametrize("file", ["runs/part-000001.parquet", "unfinished/000003.parquet"])
def test_a_file_of_an_archive_that_is_damaged_is_named_and_its_runs_are_flown_again_without_it(
    prepared, flown, tmp_path, file
):
    shutil.copytree(flown, tmp_path / "archive")
    damaged = tmp_path / "archive" / file
    damaged.parent.mkdir(exist_ok=True)
    damaged.write_bytes(b"PAR1 no more than this")
    for look in (lambda: open_archive(tmp_path / "archive", prepared.space), lambda: read_runs(tmp_path / "archive")):
        with pytest.raises(archives.InputError, match=f"{damaged.name} holds no runs of a campaign"):
            look()
    damaged.unlink()
    fly_campaign(prepared, Threads(2), tmp_path / "archive", RUNS)
    assert bytes_of(tmp_path / "archive") == bytes_of(flown)


def test_a_part_with_fewer_runs_than_a_part_has_is_no_part(prepared, flown, tmp_path):
    shutil.copytree(flown, tmp_path / "archive")
    part = tmp_path / "archive" / "runs" / "part-000000.parquet"
    pq.write_table(pq.read_table(part).slice(0, 5), part)
    with pytest.raises(archives.InputError, match="5 runs instead of 8"):
        open_archive(tmp_path / "archive", prepared.space)


def test_a_disk_that_is_full_ends_it_with_a_sentence_and_what_was_kept_stays(prepared, flown, tmp_path, monkeypatch):
    write, written = pq.write_table, []

    def full(table, where, **how):
        written.append(where)
        if len(written) > 2:
            raise OSError(errno.ENOSPC, "no")
        write(table, where, **how)

    with monkeypatch.context() as patch:
        patch.setattr(pq, "write_table", full)
        with pytest.raises(archives.InputError, match=r"cannot be written \(No space left on device\); what was kept"):
            fly_campaign(prepared, Threads(1), tmp_path, RUNS)
    assert bytes_of(tmp_path).items() < bytes_of(flown).items()
    fly_campaign(prepared, Threads(1), tmp_path, RUNS)
    assert bytes_of(tmp_path) == bytes_of(flown)


WIDE = {"vehicle.mass_kg": {"uniform": [0.9, 1.1], "times": True}}


def killed_once(pids, folder):
    """A thread that kills one of these processes once rows come in."""

    def kill():
        while not part_files(folder):
            time.sleep(0.02)
        os.kill(pids()[0], signal.SIGKILL)

    thread = threading.Thread(target=kill, daemon=True)
    thread.start()
    return thread


def children():
    """Of this process."""
    return [process.pid for process in multiprocessing.active_children()]


@pytest.mark.long
def test_a_worker_process_that_is_killed_costs_no_run(prepared, flown, tmp_path):
    (tmp_path / "runs").mkdir()
    before = set(children())  # a cluster's
    killer = killed_once(lambda: [pid for pid in children() if pid not in before], tmp_path)
    fly_campaign(prepared, Processes(2), tmp_path, 4 * RUNS)
    killer.join(1.0)
    assert not killer.is_alive()
    assert read_runs(tmp_path)["run"].to_pylist() == list(range(4 * RUNS))
    assert bytes_of(tmp_path).items() >= bytes_of(flown).items()


@pytest.mark.long
@pytest.mark.filterwarnings("default")
def test_a_dask_worker_that_is_killed_costs_no_run(prepared, flown, tmp_path, cluster):
    def workers():
        from distributed import Client

        with Client(cluster.scheduler_address, set_as_default=False) as client:
            return list(client.run(os.getpid).values())

    pids = workers()
    (tmp_path / "runs").mkdir()
    killer = killed_once(lambda: pids, tmp_path)
    fly_campaign(prepared, Dask(cluster.scheduler_address), tmp_path, 8 * RUNS)
    killer.join(1.0)
    assert not killer.is_alive()
    assert read_runs(tmp_path)["run"].to_pylist() == list(range(8 * RUNS))
    assert bytes_of(tmp_path).items() >= bytes_of(flown).items()


def test_a_scheduler_that_is_not_there_is_a_link_error(prepared, tmp_path):
    with pytest.raises(LinkError, match="no Dask scheduler answers at tcp://"):
        fly_campaign(prepared, Dask("tcp://127.0.0.1:1"), tmp_path, RUNS)


def test_enough_is_the_same_number_of_runs_whoever_flies(prepared, tmp_path):
    rule = StopRule.parsed("ci<0.15")
    for name, engine in (("one", Threads(1)), ("two", Threads(2))):
        fly_campaign(prepared, engine, tmp_path / name, 200, rule)
    assert bytes_of(tmp_path / "one") == bytes_of(tmp_path / "two")
    assert read_runs(tmp_path / "one").num_rows == 16  # all succeed: 8 leave 0 to 37 % of failures, 16 0 to 21 %
    again = fly_campaign(prepared, Interrupting(0), tmp_path / "one", 200, rule)  # flies none
    assert again.kept == 16


def test_a_block_that_kills_its_process_again_and_again_ends_the_campaign(prepared, tmp_path, monkeypatch):
    monkeypatch.setattr("halfroll.campaign.engines._fly_block_here", dies)
    with pytest.raises(FlightError, match="runs 0 to 9 have ended their process 3 times"):
        fly_campaign(prepared, Processes(1), tmp_path, 10)


def test_success_is_what_the_rows_say(flown):
    rows = read_runs(flown)
    assert all(
        bool(why) != good for why, good in zip(rows["why"].to_pylist(), rows["succeeded"].to_pylist(), strict=True)
    )
    assert np.all(np.array(rows["tracking_max_m"]) >= np.array(rows["tracking_rms_m"]))
