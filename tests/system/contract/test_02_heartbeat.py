"""Contract, section 2: who the autopilot says it is, and how often."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import pytest

from halfroll.wire.link import Link
from halfroll.wire.messages import GROUND
from system.contract.aircraft import ACCEPTED, DENIED, HOLD, TAKEOFF, A, Aircraft, B, Client

STANDBY, ACTIVE, CRITICAL, TERMINATED = 3, 4, 5, 6


def beat(aircraft: Aircraft) -> object:
    client = aircraft.client()
    aircraft.run(1.0)
    return client.all("HEARTBEAT")[-1]


@pytest.mark.parametrize(
    ("field", "value"),
    [("type", 2), ("autopilot", 0), ("base_mode", 29), ("custom_mode", HOLD), ("mavlink_version", 3)],
)
def test_a_heartbeat_of_the_disarmed_vehicle(grounded: Aircraft, field: str, value: int) -> None:
    assert getattr(beat(grounded), field) == value


def test_its_system_is_1_and_its_component_1(gcs: Client) -> None:
    gcs.aircraft.run(1.0)
    assert {(m.get_srcSystem(), m.get_srcComponent()) for _, m in gcs.heard} == {(1, 1)}


def test_its_system_id_is_a_parameter() -> None:
    aircraft = Aircraft.new(MAV_SYS_ID=42.0)
    client = aircraft.client()
    aircraft.run(0.1)
    assert {m.get_srcSystem() for _, m in client.heard} == {42}


def test_base_mode_says_armed(hovering: Aircraft) -> None:
    assert beat(hovering).base_mode == 157  # type: ignore[attr-defined]


@pytest.mark.parametrize("link", [A, B])
def test_a_heartbeat_comes_every_second_on_each_link(grounded: Aircraft, link: int) -> None:
    client = grounded.client(link)
    grounded.run(5.0)
    assert len(client.all("HEARTBEAT")) == 5


def arm(client: Client) -> None:
    assert client.command(400, 1) == ACCEPTED


def take_off_mode(client: Client) -> None:
    assert client.set_mode(TAKEOFF) == ACCEPTED


def terminate(client: Client) -> None:
    assert client.command(185, 1) == ACCEPTED


@pytest.mark.parametrize("change", [arm, take_off_mode, terminate])
def test_an_extra_heartbeat_shows_a_change_within_100_ms(gcs: Client, change: Callable[[Client], None]) -> None:
    gcs.aircraft.run(0.3)
    since = gcs.aircraft.t_ms - 1
    change(gcs)
    gcs.aircraft.run(0.1)
    assert len(gcs.times("HEARTBEAT", since)) == 1


@pytest.mark.parametrize(
    ("prepare", "status"),
    [
        (lambda _: None, STANDBY),
        (arm, ACTIVE),
        (terminate, TERMINATED),
    ],
    ids=["standby", "active", "terminated"],
)
def test_system_status(gcs: Client, prepare: Callable[[Client], None], status: int) -> None:
    prepare(gcs)
    gcs.aircraft.run(1.0)
    assert gcs.all("HEARTBEAT")[-1].system_status == status


def test_system_status_is_critical_while_a_failsafe_acts(hovering: Aircraft) -> None:
    client = hovering.client()
    hovering.run(1.0, pose=False)  # the position is lost
    assert hovering.autopilot.mode == "Land"
    assert client.all("HEARTBEAT")[-1].system_status == CRITICAL


def test_it_sends_mavlink_2_only(gcs: Client) -> None:
    gcs.aircraft.run(1.0)
    assert {frame[0] for frame in gcs.frames} == {0xFD}


def test_it_understands_mavlink_1(gcs: Client) -> None:
    message = gcs.encode.command_long_encode(1, 1, 410, 0, 0, 0, 0, 0, 0, 0, 0)
    answers = gcs.ask(gcs.pack(message, force_mavlink1=True))
    assert answers[0].result == ACCEPTED


# --identity px4 changes two things and nothing else.


@pytest.fixture
def px4() -> Client:
    aircraft = Aircraft.new(px4_identity=True)
    aircraft.fly(1.5)
    return aircraft.client()


def test_identity_px4_is_in_the_heartbeat(px4: Client) -> None:
    px4.aircraft.run(1.0)
    assert px4.all("HEARTBEAT")[-1].autopilot == 12


def test_with_identity_px4_a_takeoff_is_above_sea_level(px4: Client) -> None:
    assert px4.command(22, 0, 0, 0, 0, 0, 0, 12.0) == DENIED
    assert px4.command(22, 0, 0, 0, 0, 0, 0, 488.0 + 12.0) == ACCEPTED


def test_with_the_generic_identity_a_takeoff_is_above_home(gcs: Client) -> None:
    assert gcs.command(22, 0, 0, 0, 0, 0, 0, 488.0 + 100.0) == DENIED
    assert gcs.command(22, 0, 0, 0, 0, 0, 0, 12.0) == ACCEPTED


def test_nothing_else_depends_on_the_identity(px4: Client, gcs: Client) -> None:
    for client in (px4, gcs):
        client.aircraft.run(2.0)
    heard = [[m.to_dict() for _, m in client.heard if m.get_type() != "HEARTBEAT"] for client in (px4, gcs)]
    assert str(heard[0]) == str(heard[1])


@pytest.mark.parametrize(("field", "value"), [("type", 18), ("autopilot", 8), ("base_mode", 0), ("custom_mode", 0)])
def test_the_ground_station_is_no_autopilot(field: str, value: int) -> None:
    heartbeat = Link(cast(Any, None), GROUND).heartbeat()
    assert getattr(heartbeat, field) == value
