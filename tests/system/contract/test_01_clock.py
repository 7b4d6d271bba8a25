"""Contract, section 1: every timer runs on vehicle time; the link is answered while it stands."""

from __future__ import annotations

import pytest

from system.contract.aircraft import ACCEPTED, OFFBOARD, A, Aircraft, Client
from system.contract.missions import LINE


def test_a_paused_simulator_lets_no_upload_time_out(gcs: Client) -> None:
    gcs.count(3)
    gcs.aircraft.stand(wall_s=60.0)
    assert not gcs.all("MISSION_ACK")
    assert gcs.item(0, LINE[0])[-1].seq == 1


def test_a_paused_simulator_asks_for_no_item_again(gcs: Client) -> None:
    gcs.count(3)
    gcs.aircraft.stand(wall_s=60.0)
    assert len(gcs.all("MISSION_REQUEST_INT")) == 1


def test_a_paused_simulator_loses_no_offboard_stream(hovering: Aircraft) -> None:
    client = hovering.client(A)
    client.set_mode(OFFBOARD)
    hovering.stream(client, 0.5)
    hovering.stand(wall_s=60.0)
    hovering.stream(client, 0.5)
    assert client.texts == []
    assert hovering.autopilot.mode == "Offboard"


def test_a_paused_vehicle_does_not_disarm(gcs: Client) -> None:
    assert gcs.command(400, 1) == ACCEPTED
    gcs.aircraft.stand(wall_s=60.0)
    assert gcs.aircraft.autopilot.armed


def test_a_paused_simulator_answers_a_command(gcs: Client) -> None:
    gcs.aircraft.stand(wall_s=1.0)
    assert gcs.command(410) == ACCEPTED


def test_a_paused_simulator_lists_its_parameters(gcs: Client) -> None:
    gcs.ask(gcs.encode.param_request_list_encode(1, 1))
    gcs.aircraft.stand(wall_s=2.0)
    values = gcs.all("PARAM_VALUE")
    assert {m.param_index for m in values} == set(range(values[0].param_count))


def test_a_paused_simulator_gives_its_mission(gcs: Client) -> None:
    assert gcs.upload(LINE) == 0
    gcs.aircraft.stand(wall_s=1.0)
    assert len(gcs.download()) == len(LINE)


def test_a_paused_simulator_sends_heartbeats_by_the_wall_clock(gcs: Client) -> None:
    gcs.aircraft.stand(wall_s=10.0)
    assert 9 <= len(gcs.all("HEARTBEAT")) <= 11


@pytest.mark.parametrize(("speed", "again_s", "cancelled_s"), [(1.0, 0.25, 5.0), (10.0, 2.5, 50.0)])
def test_mission_timers_are_multiplied_by_the_requested_speed(speed: float, again_s: float, cancelled_s: float) -> None:
    aircraft = Aircraft.new(speed=speed)
    gcs = aircraft.client()
    aircraft.run(0.1)
    gcs.count(3)
    began = aircraft.t_ms
    aircraft.run(cancelled_s + 0.1)
    asked = gcs.times("MISSION_REQUEST_INT")
    (ended,) = gcs.times("MISSION_ACK")
    assert asked[1] - asked[0] == pytest.approx(again_s * 1000, abs=2)
    assert ended - began == pytest.approx(cancelled_s * 1000, abs=2)


@pytest.mark.parametrize(("synchronised", "mode"), [(False, "Offboard"), (True, "Hold")])
def test_only_a_source_that_keeps_vehicle_time_loses_its_stream_in_vehicle_time(synchronised: bool, mode: str) -> None:
    aircraft = Aircraft.new(speed=10.0)
    aircraft.fly(1.5)
    client = aircraft.client(A)
    if synchronised:
        client.ask(client.encode.timesync_encode(0, 1))
    client.command(22, 0, 0, 0, 0, 0, 0, 12.0)
    client.command(400, 1)
    aircraft.fly(15.0)
    client.set_mode(OFFBOARD)
    aircraft.stream(client, 0.5)
    aircraft.run(1.0)  # 0.1 s of its own clock
    assert aircraft.autopilot.mode == mode


@pytest.mark.parametrize(
    ("kind", "field", "per_ms"),
    [
        ("ATTITUDE_QUATERNION", "time_boot_ms", 1),
        ("LOCAL_POSITION_NED", "time_boot_ms", 1),
        ("ATTITUDE_TARGET", "time_boot_ms", 1),
        ("GLOBAL_POSITION_INT", "time_boot_ms", 1),
        ("SYSTEM_TIME", "time_boot_ms", 1),
        ("GPS_RAW_INT", "time_usec", 1000),
        ("HOME_POSITION", "time_usec", 1000),
    ],
)
def test_what_is_dated_is_dated_in_vehicle_time(grounded: Aircraft, kind: str, field: str, per_ms: int) -> None:
    client = grounded.client(A)
    grounded.run(2.1)
    seen = [(t, getattr(m, field)) for t, m in client.heard if m.get_type() == kind]
    assert seen
    assert all(stamp == t * per_ms for t, stamp in seen)


def test_timesync_answers_with_vehicle_time(gcs: Client) -> None:
    answer = gcs.only("TIMESYNC", gcs.encode.timesync_encode(0, 77))
    assert answer.tc1 == gcs.aircraft.autopilot.t_us * 1000
