"""The user's own way: the simulator in one terminal, the ground station in the next, any ground control station beside.

The third terminal is examples/upload_and_fly.py, plain pymavlink. What is claimed of references is counted on the wire.
"""

from __future__ import annotations

import contextlib
import itertools
import signal
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from pymavlink import mavutil

from halfroll.results.log import Log, read_log
from halfroll.results.logged_flight import require_flight
from system.gcs import Gcs
from system.processes import EXAMPLES, HALFROLL, Ended, Running, free_instance, simulator
from system.wire import Wire

SCRIPT = EXAMPLES / "upload_and_fly.py"
COMPLETE, OFFBOARD = 5, 6 << 16
OFFBOARD_IN_LOG = 5


@dataclass(frozen=True)
class Flown:
    script: Ended
    ground: Ended
    wire: Wire
    log: Log
    state: tuple[int, bool]  # mission_state, armed; as another ground control station hears it afterwards


def last_state(instance: int) -> tuple[int, bool]:
    with Gcs(instance) as gcs:
        heartbeat = gcs.until(lambda m: m.get_type() == "HEARTBEAT" and m.get_srcComponent() == 1)
        return gcs.mission_current().mission_state, bool(heartbeat.base_mode & 128)


def run_script(instance: int) -> Ended:
    with Running(sys.executable, SCRIPT, "--port", str(14550 + instance)) as script:
        return script.wait()


def fly_in_three_terminals(folder: Path, *speed: str) -> Flown:
    instance = free_instance()
    with contextlib.ExitStack() as stack:
        wire = stack.enter_context(Wire(14580 + instance, 14540 + instance))
        kept = ("--log", folder / "flight.ulg", "--tlog", folder / "flight.tlog")
        ground = stack.enter_context(Running(HALFROLL, "ground", "--instance", str(instance), *kept))
        ground.until_it_says("waiting for an autopilot")
        words = ("--scenario", "ideal", "--log", folder / "flight.ulg", "--peer-offboard", str(wire.port), *speed)
        sitl, _ = stack.enter_context(simulator(*words, instance=instance))
        script = run_script(instance)
        state = last_state(instance)
        for running in (sitl, ground):
            running.process.send_signal(signal.SIGINT)
        sitl.wait()
        return Flown(script, ground.wait(), wire, read_log(folder / "flight.ulg"), state)


@pytest.fixture(scope="module")
def in_lockstep(tmp_path_factory: pytest.TempPathFactory) -> Flown:
    return fly_in_three_terminals(tmp_path_factory.mktemp("lockstep"), "--lockstep")


@pytest.fixture(scope="module")
def in_real_time(tmp_path_factory: pytest.TempPathFactory) -> Flown:
    return fly_in_three_terminals(tmp_path_factory.mktemp("real_time"))


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Ended, Log, tuple[int, bool]]]:
    """Without a ground station, ten times faster than real time."""
    log = tmp_path_factory.mktemp("alone") / "flight.ulg"
    with simulator("--scenario", "ideal", "--speed", "10", "--log", log) as (sitl, instance):
        script, state = run_script(instance), last_state(instance)
        sitl.process.send_signal(signal.SIGINT)
        sitl.wait()
        yield script, read_log(log), state


@pytest.fixture(scope="module", params=["in_lockstep", "in_real_time"])
def flown(request: pytest.FixtureRequest) -> Flown:
    found: Flown = request.getfixturevalue(request.param)
    return found


def test_the_mission_is_flown_to_its_end(flown: Flown) -> None:
    assert flown.script.code == 0, flown.script.out + flown.script.err
    assert flown.script.out.endswith("landed and disarmed, mission complete\n")
    assert flown.state == (COMPLETE, False)


def test_the_ground_station_plans_takes_over_and_hands_back(flown: Flown) -> None:
    assert "plan ready" in flown.script.out
    assert "plan ready" in flown.ground.out
    modes = [m.custom_mode for m in flown.wire.from_autopilot("HEARTBEAT") if m.get_srcComponent() == 1]
    turns = [is_offboard for is_offboard, _ in itertools.groupby(mode == OFFBOARD for mode in modes)]
    assert turns == [False, True, False]


def stamps(flown: Flown) -> list[int]:
    return [m.time_boot_ms for m in flown.wire.from_ground("SET_ATTITUDE_TARGET")]


def test_in_lockstep_every_10_ms_of_vehicle_time_carries_one_reference(in_lockstep: Flown) -> None:
    assert set(np.diff(stamps(in_lockstep))) == {10}


def test_in_real_time_there_are_about_100_references_per_second_of_the_vehicle(in_real_time: Flown) -> None:
    sent = stamps(in_real_time)
    assert 95.0 < (len(sent) - 1) / (1e-3 * (sent[-1] - sent[0])) <= 101.0


def test_references_span_the_whole_time_in_offboard(flown: Flown) -> None:
    state = flown.log["vehicle_state"]
    offboard_s = state.t[state["mode"] == OFFBOARD_IN_LOG]
    sent = stamps(flown)
    assert 1e-3 * (sent[-1] - sent[0]) == pytest.approx(offboard_s[-1] - offboard_s[0], abs=0.3)


def test_ctrl_c_ends_the_ground_station_in_order(flown: Flown) -> None:
    assert flown.ground.code in (0, 130)
    assert "Traceback" not in flown.ground.err


def test_it_lands_where_it_took_off(flown: Flown) -> None:
    truth = flown.log["vehicle_truth"]
    assert np.linalg.norm(truth["p"][-1]) < 0.3
    assert not flown.log["vehicle_state"]["armed"][-1]


def test_without_a_ground_station_the_autopilot_flies_the_same_mission(
    alone: tuple[Ended, Log, tuple[int, bool]], in_lockstep: Flown
) -> None:
    script, log, state = alone
    assert script.code == 0, script.out + script.err
    assert "the autopilot flies alone" in script.out
    assert state == (COMPLETE, False)
    assert OFFBOARD_IN_LOG not in log["vehicle_state"]["mode"]
    assert in_the_air_s(log) > in_the_air_s(in_lockstep.log)


def in_the_air_s(log: Log) -> float:
    armed = log["vehicle_state"].t[log["vehicle_state"]["armed"] != 0]
    return float(armed[-1] - armed[0])


def test_the_log_of_the_simulator_tells_of_the_plan_when_the_station_is_given_it(in_lockstep: Flown) -> None:
    flight = require_flight(in_lockstep.log)
    assert flight.verdict.line == "Flown within limits"
    assert flight.plan is not None
    assert len(in_lockstep.log["trajectory_reference"]) == pytest.approx(100 * flight.plan.T, abs=2)
    assert not in_lockstep.log.damaged


def test_its_raw_link_is_a_tlog(in_lockstep: Flown) -> None:
    path = in_lockstep.log.path.with_suffix(".tlog")
    with contextlib.closing(mavutil.mavlink_connection(str(path), dialect="development")) as raw:
        kinds = [message.get_type() for message in iter(raw.recv_match, None)]
    assert kinds.count("SET_ATTITUDE_TARGET") >= len(in_lockstep.log["trajectory_reference"])
    assert "BAD_DATA" not in kinds
