"""Processes that die, ports that are taken, Ctrl-C: what was lost is said, and nobody is left behind."""

from __future__ import annotations

import os
import re
import signal
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from halfroll.errors import LinkError
from halfroll.flight import fly
from halfroll.results.log import read_log
from halfroll.station.record import Event
from system.gcs import Gcs
from system.processes import (
    HALFROLL,
    MISSIONS,
    Ended,
    Running,
    command_line,
    descendants,
    free_instance,
    halfroll,
    is_free,
    simulator,
)

STOPPED = 130
PLANNING, FLYING = "plan\n", "fly the plan\n"
SIMULATOR, CREW = "halfroll-sitl ", "halfroll.station.crew"


class Flight(Running):
    """A flight at five times real time: long enough to be met on its way."""

    def __init__(self, folder: Path) -> None:
        words = ("--scenario", "ideal", "--speed", "5", "--json", "--out", folder)
        super().__init__(HALFROLL, "fly", MISSIONS / "box.plan", *words)


@pytest.fixture
def flight(tmp_path: Path) -> Iterator[Flight]:
    with Flight(tmp_path) as flight:
        yield flight


def link_error(ended: Ended) -> str:
    """The one sentence, exit code 3, the same in JSON."""
    assert ended.code == 3
    assert "Traceback" not in ended.err
    assert "Warning" not in ended.err
    (sentence,) = ended.sentences
    assert ended.json["error"]["message"] == sentence
    return sentence


def test_a_simulator_killed_in_flight_is_what_was_lost(flight: Flight, tmp_path: Path) -> None:
    flight.until_it_says(FLYING)
    os.kill(flight.member(SIMULATOR), signal.SIGKILL)
    ended = flight.wait()
    said = link_error(ended)
    assert ended.json["error"]["kind"] == "simulator"
    assert "simulator was ended by SIGKILL" in said
    assert "of vehicle time, on the way to item" in said
    assert flight.left_behind() == {}
    assert len(read_log(tmp_path / "flight.ulg")["vehicle_truth"]) > 0  # named in the sentence
    assert str(tmp_path / "flight.ulg") in said


def test_a_simulator_killed_while_planning_is_what_was_lost(flight: Flight) -> None:
    flight.until_it_says(PLANNING)
    os.kill(flight.member(SIMULATOR), signal.SIGKILL)
    assert "simulator was ended by SIGKILL" in link_error(flight.wait())
    assert flight.left_behind() == {}


@pytest.mark.parametrize("moment", [PLANNING, FLYING])
def test_a_ground_station_killed_is_what_was_lost(flight: Flight, moment: str) -> None:
    flight.until_it_says(moment)
    os.kill(flight.member(CREW), signal.SIGKILL)
    said = link_error(flight.wait())
    assert "the ground station's process ended" in said
    assert "on the way to item" in said
    assert flight.left_behind() == {}


@pytest.mark.long
@pytest.mark.parametrize(
    ("who", "said"),
    [
        (SIMULATOR, "the autopilot (has been silent|did not answer)"),  # the second where a question was just open
        (CREW, "the ground station's process has been silent"),
    ],
)
def test_a_process_that_hangs_is_what_was_lost(flight: Flight, who: str, said: str) -> None:
    flight.until_it_says(FLYING)
    os.kill(flight.member(who), signal.SIGSTOP)
    assert re.search(said, link_error(flight.wait()))
    assert flight.left_behind() == {}


def test_a_planner_killed_while_it_plans_is_what_was_lost() -> None:
    def kill_planner(event: Event) -> None:
        if event.kind == "planning":
            (planner,) = (number for number in descendants(os.getpid()) if "spawn_main" in command_line(number))
            os.kill(planner, signal.SIGKILL)

    with pytest.raises(LinkError, match="planner's process was ended"):
        fly(MISSIONS / "box.plan", scenario="ideal", report=kill_planner)
    assert not any("halfroll" in command_line(number) for number in descendants(os.getpid()))


def test_a_planner_killed_before_it_is_asked_is_replaced() -> None:
    def kill_planner(event: Event) -> None:
        if event.kind == "upload":
            for number in descendants(os.getpid()):
                if "spawn_main" in command_line(number):
                    os.kill(number, signal.SIGKILL)

    assert fly(MISSIONS / "box.plan", scenario="ideal", report=kill_planner).plan is not None


@pytest.mark.parametrize("group", [True, False], ids=["as in a terminal", "to the command alone"])
@pytest.mark.parametrize("moment", [PLANNING, FLYING], ids=["planning", "flying"])
def test_ctrl_c_ends_everything(flight: Flight, moment: str, group: bool) -> None:
    flight.until_it_says(moment)
    assert len(flight.members()) >= 3  # command, simulator, ground station
    flight.interrupt(group)
    ended = flight.wait()
    assert ended.code == STOPPED
    assert ended.err.splitlines()[-1] == "stopped"
    assert ended.json["error"]["kind"] == "stopped"
    assert flight.left_behind() == {}


def test_a_command_killed_takes_everything_with_it(flight: Flight) -> None:
    flight.until_it_says(FLYING)
    flight.process.kill()
    assert flight.left_behind() == {}


@pytest.mark.parametrize("link", ["--port-offboard", "--port-gcs", "--port-companion"])
def test_a_simulator_whose_port_is_taken_names_it(link: str) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = str(taken.getsockname()[1])
        ended = halfroll("sitl", "--instance", str(free_instance()), link, port)
    assert ended.code == 3
    (sentence,) = ended.err.splitlines()
    assert port in sentence
    assert "--instance" in sentence


def test_a_second_simulator_on_the_same_ports_names_one_of_them() -> None:
    with simulator() as (_, instance):
        ended = halfroll("sitl", "--instance", str(instance))
    assert ended.code == 3
    assert str(14580 + instance) in ended.err


def test_a_second_ground_station_names_the_port_that_is_taken() -> None:
    instance = free_instance()
    with Running(HALFROLL, "ground", "--instance", str(instance)) as first:
        first.until_it_says("waiting for an autopilot")
        ended = halfroll("ground", "--instance", str(instance))
    assert ended.code == 3
    (sentence,) = ended.sentences
    assert str(14540 + instance) in sentence


def test_a_flight_makes_way_for_the_ports_of_others_and_leaves_nobody(tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        if is_free(14540):  # else somebody else has taken it: as good
            taken.bind(("127.0.0.1", 14540))
        words = ("--scenario", "ideal", "--out", tmp_path)
        with Running(HALFROLL, "fly", MISSIONS / "box.plan", *words) as flight:
            ended = flight.wait()
            assert ended.code == 0, ended.err
            assert flight.left_behind() == {}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_simulator_ends_in_order_when_asked(number: signal.Signals, tmp_path: Path) -> None:
    with simulator("--log", tmp_path / "flight.ulg") as (running, instance):
        with Gcs(instance) as gcs:
            gcs.until(lambda m: m.get_type() == "ATTITUDE" and m.time_boot_ms > 500)
        running.process.send_signal(number)
        ended = running.wait()
    assert ended.code == 0
    assert "commands_sha256" in ended.out
    assert not read_log(tmp_path / "flight.ulg").damaged


def test_in_lockstep_the_simulator_ends_when_asked_though_nobody_has_come() -> None:
    with simulator("--lockstep") as (running, _):
        running.process.send_signal(signal.SIGINT)
        assert running.wait().code == 0


def test_the_ground_station_lives_through_the_end_of_a_simulator_and_meets_the_next() -> None:
    instance = free_instance()
    with Running(HALFROLL, "ground", "--instance", str(instance)) as ground:
        for _ in range(2):
            ground.until_it_says("waiting for an autopilot")
            with simulator("--lockstep", instance=instance) as (_, _), Gcs(instance) as gcs:
                gcs.until(lambda m: m.get_type() == "ATTITUDE" and m.time_boot_ms > 2000)  # somebody answers the time
        assert ground.process.poll() is None
        ground.interrupt(group=True)
        ended = ground.wait()
    assert ended.code == STOPPED
    assert "Traceback" not in ended.err
