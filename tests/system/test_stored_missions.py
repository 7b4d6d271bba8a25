"""What is uploaded is what is stored and what comes back, item by item and bit by bit."""

from __future__ import annotations

import math
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from halfroll.missions.mission_files import load_mission
from system.gcs import ACCEPTED, Gcs, Item, bits
from system.processes import EXAMPLES, MISSIONS, simulator

SET_MODE, TEMPORARILY_REJECTED, NOT_STARTED = 176, 1, 2
HERE = 2**31 - 1
NAN = math.nan

FILES = sorted(
    [
        *EXAMPLES.glob("*.plan"),
        *EXAMPLES.glob("*.waypoints"),
        *(file for file in EXAMPLES.glob("*.toml") if not file.stem.startswith("campaign_")),  # these name one
        *MISSIONS.glob("*.plan"),
        *MISSIONS.glob("*.waypoints"),
    ]
)

# Every parameter that may be left open is; -0.0 and odd fractions are kept to the bit.
OPEN: list[Item] = [
    (3, 22, 1, (NAN, NAN, NAN, NAN), HERE, HERE, NAN),
    (3, 16, 0, (0.1, 1e-7, -0.0, NAN), 473978312, 85457013, 1 / 3),
    (2, 93, 1, (-1.0, NAN, NAN, NAN), 0, 0, NAN),
    (2, 530, 1, (0.0, 2.0, NAN, NAN), 0, 0, NAN),
    (2, 178, 1, (0.0, 4.0, -1.0, NAN), 0, 0, NAN),
    (0, 16, 1, (0.0, 0.0, 0.0, -179.9), 473977420, 85455940, 495.25),
    (2, 20, 1, (NAN, NAN, NAN, NAN), 0, 0, NAN),
]


def items_of(file: Path) -> list[Item]:
    return [(i.frame, i.command, int(i.autocontinue), i.params, i.x, i.y, i.z) for i in load_mission(file).items]


@pytest.fixture(scope="module")
def gcs() -> Iterator[Gcs]:
    with simulator() as (_, instance), Gcs(instance) as gcs:
        yield gcs


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_a_mission_file_comes_back_as_it_was_uploaded(gcs: Gcs, file: Path) -> None:
    sent = items_of(file)
    assert gcs.upload(sent) == ACCEPTED
    assert [bits(item) for item in gcs.download()] == [bits(item) for item in sent]


def test_parameters_left_open_come_back_as_nan(gcs: Gcs) -> None:
    assert gcs.upload(OPEN) == ACCEPTED
    assert [bits(item) for item in gcs.download()] == [bits(item) for item in OPEN]


def test_an_impossible_mission_is_stored_but_does_not_start(gcs: Gcs) -> None:
    assert gcs.upload(items_of(MISSIONS / "far_below_its_home.waypoints")) == ACCEPTED
    assert gcs.command(SET_MODE, 1, 4, 4) == ACCEPTED  # chosen while disarmed; arming would start it
    assert gcs.command(400, 1) == TEMPORARILY_REJECTED
    assert gcs.texts[-1].startswith("Arming denied: item 1 is ")


def test_a_mission_survives_a_restart(tmp_path: Path) -> None:
    with simulator("--storage", tmp_path) as (running, instance):
        with Gcs(instance) as gcs:
            assert gcs.upload(OPEN) == ACCEPTED
        running.process.send_signal(signal.SIGTERM)
        assert running.wait().code == 0
    with simulator("--storage", tmp_path) as (_, instance), Gcs(instance) as gcs:
        assert [bits(item) for item in gcs.download()] == [bits(item) for item in OPEN]
        current = gcs.mission_current()
        assert (current.total, current.mission_state) == (len(OPEN), NOT_STARTED)


def test_a_killed_simulator_has_kept_its_mission(tmp_path: Path) -> None:
    with simulator("--storage", tmp_path) as (running, instance), Gcs(instance) as gcs:
        assert gcs.upload(OPEN) == ACCEPTED
        running.process.kill()
        running.wait()
    with simulator("--storage", tmp_path) as (_, instance), Gcs(instance) as gcs:
        assert [bits(item) for item in gcs.download()] == [bits(item) for item in OPEN]


def test_without_storage_nothing_is_kept() -> None:
    for _ in range(2):
        with simulator() as (_, instance), Gcs(instance) as gcs:
            assert gcs.download() == []
            assert gcs.upload(OPEN) == ACCEPTED
