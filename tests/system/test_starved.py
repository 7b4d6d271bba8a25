"""No room on the disk, a folder that takes nothing, no memory, a time of day that jumps.

Why: what a machine runs out of must cost what it was for and nothing else; what was stored before stays, and a sentence
says what was lost.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from halfroll.results.log import read_log
from system.gcs import ACCEPTED, bits
from system.generations import PREFLIGHT_STORAGE, SAVE, Writer, mission_of, value_of
from system.processes import HALFROLL, MISSIONS, Ended, Running, free_instance, halfroll

BUILD = Path(__file__).parents[2] / "build" / "editable"
JUMPING_CLOCK = BUILD / "tests" / "cpp" / "shims" / "libjumping_clock.so"
SITL = HALFROLL.with_name("halfroll-sitl")
FAILED = 4

pytestmark = pytest.mark.reliability(
    "Starved", "of disk, memory, a steady clock or a link of its own: said, nothing lost"
)


def with_room_for(size: int, *words: str | Path) -> tuple[str | Path, ...]:
    """The command with a quota: no file of it grows beyond `size` bytes."""
    code = "import os, resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (n := int(sys.argv[1]), n)); "
    return sys.executable, "-c", code + "os.execv(sys.argv[2], sys.argv[2:])", str(size), *words


@contextlib.contextmanager
def client_of(*words: str | Path) -> Iterator[tuple[Running, Writer]]:
    instance = free_instance()
    with Running(*words, "--instance", str(instance)) as running:
        running.until_it_says("ready")
        with Writer(instance, running) as client:
            yield running, client


# A full disk


def test_a_log_that_finds_the_disk_full_costs_the_log_and_not_the_flight(tmp_path: Path) -> None:
    words = (SITL, "--instance", str(free_instance()), "--speed", "0", "--duration", "20")
    quota = 400_000
    with Running(*words) as running:
        free = running.wait()
    with Running(*with_room_for(quota, *words, "--log", tmp_path / "full.ulg")) as running:
        ended = running.wait()
    assert ended.code == 0
    assert "is not complete, is the disk full?" in ended.err
    assert commands(ended) == commands(free)
    assert (tmp_path / "full.ulg").stat().st_size <= quota
    assert len(read_log(tmp_path / "full.ulg")["vehicle_truth"]) > 100  # what was written can be read


def commands(ended: Ended) -> str:
    return ended.out.split("commands_sha256 ")[1].split()[0]


@pytest.mark.parametrize("room", [0, 20])
def test_what_was_stored_survives_a_save_that_finds_the_disk_full(tmp_path: Path, room: int) -> None:
    storage = ("--storage", tmp_path)
    with client_of(SITL, *storage) as (_, client):
        client.write_params(1)
        assert client.upload(mission_of(1)) == ACCEPTED
    with client_of(*with_room_for(room, SITL, *storage)) as (_, client):
        client.set_params(2)
        assert client.command(PREFLIGHT_STORAGE, SAVE) == FAILED
        assert client.upload(mission_of(2)) != ACCEPTED
    with client_of(SITL, *storage) as (_, client):
        assert client.read_params() == [value_of(1)] * 2
        assert [bits(item) for item in client.download()] == [bits(item) for item in mission_of(1)]


# A folder that takes nothing


def test_a_folder_that_takes_nothing_is_told_to_whoever_saves() -> None:
    with client_of(SITL, "--storage", "/proc") as (running, client):
        client.set_params(1)
        assert client.command(PREFLIGHT_STORAGE, SAVE) == FAILED
        assert running.process.poll() is None


def test_a_plan_for_a_folder_that_takes_nothing_names_it() -> None:
    ended = halfroll("plan", MISSIONS / "box.plan", "-o", "/proc/plan.csv", "--json")
    assert ended.code == 2
    (sentence,) = ended.sentences
    assert "/proc/plan.csv" in sentence


# A time of day that jumps


def test_a_flight_is_the_same_in_every_bit_while_the_time_of_day_jumps_by_hours() -> None:
    def fly(**environment: str) -> str:
        words = ("--instance", str(free_instance()), "--speed", "0", "--duration", "20")
        with Running(SITL, *words, **environment) as running:
            return commands(running.wait())

    assert fly(LD_PRELOAD=str(JUMPING_CLOCK)) == fly()


# No memory


def test_a_plan_that_does_not_fit_into_memory_is_refused_in_a_sentence() -> None:
    """The limit is what the process has when it begins to plan, and a little more."""
    code = """
import resource, sys
from pathlib import Path
from halfroll.missions.geodesy import DEFAULT_ORIGIN
from halfroll.missions.mission_files import load_mission
from halfroll.station.planning import PlanRequest, outcome_of
from halfroll.vehicle import load_vehicle
import halfroll.planner.near_optimal, halfroll.planner.plan
items = load_mission(sys.argv[1]).items
request = PlanRequest(items, DEFAULT_ORIGIN, DEFAULT_ORIGIN, 2.5, 0.0, load_vehicle("mit-vp"))
used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (1 << 20), -1))
outcome = outcome_of(request)
print(type(outcome).__name__, outcome)
"""
    with Running(sys.executable, "-c", code, MISSIONS / "survey.plan") as planning:
        ended = planning.wait()
    assert ended.code == 0, ended.err
    assert ended.out.startswith("PlanError the plan does not fit into memory; split the mission")
