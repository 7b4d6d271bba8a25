"""Contract, section 7: what keeps the vehicle from arming, named; and when it disarms by itself."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from system.contract.aircraft import ACCEPTED, HOLD, LAND, MISSION, NOT_NOW, OFFBOARD, TAKEOFF, Aircraft, Client
from system.contract.missions import LINE, item, waypoint

FORCE = 21196
TAKEOFF_HERE = item(22, x=0, y=0)


def booting() -> Aircraft:
    return Aircraft.new()


def ready() -> Aircraft:
    aircraft = Aircraft.new()
    aircraft.fly(1.5)
    return aircraft


def terminated() -> Aircraft:
    aircraft = ready()
    aircraft.client().command(185, 1)
    return aircraft


def tilted() -> Aircraft:
    """Dropped, lying on its side."""
    aircraft = Aircraft.new()
    aircraft.world.place([0, 0, 100], [0, 0, 0], [0.6, 0.8, 0, 0], [0, 0, 0], [0, 0, 0, 0])
    aircraft.fly(1.5)
    return aircraft


def uploading() -> Aircraft:
    aircraft = ready()
    aircraft.client().count(3)
    return aircraft


def far_mission() -> Aircraft:
    aircraft = ready()
    client = aircraft.client()
    assert client.upload([TAKEOFF_HERE, waypoint(6500.0)]) == 0
    assert client.set_mode(MISSION) == ACCEPTED
    return aircraft


def high_mission() -> Aircraft:
    aircraft = ready()
    client = aircraft.client()
    client.upload([TAKEOFF_HERE, (0, 16, 1, (0, 0, 0, 0), 473977420, 85455940, 488.0 + 600.0)])
    assert client.set_mode(MISSION) == ACCEPTED
    return aircraft


@pytest.mark.parametrize(
    ("prepare", "why", "even_forced"),
    [
        (booting, "no attitude", True),
        (terminated, "terminated", True),
        (tilted, "not upright", False),
        (uploading, "mission upload in progress", False),
        (far_mission, "item 1 is 6 km away", False),
        (high_mission, "item 1 is 600 m above home", False),
    ],
)
def test_arming_is_denied_with_the_reason(prepare: Callable[[], Aircraft], why: str, even_forced: bool) -> None:
    client = prepare().client()
    assert client.command(400, 1) == NOT_NOW
    assert client.texts[-1] == f"Arming denied: {why}"
    assert client.command(400, 1, FORCE) == (NOT_NOW if even_forced else ACCEPTED)


@pytest.mark.parametrize("mode", [HOLD, MISSION, TAKEOFF, OFFBOARD])
def test_it_arms_in(gcs: Client, mode: int) -> None:
    assert gcs.upload(LINE) == 0
    assert gcs.set_mode(mode) == ACCEPTED
    assert gcs.command(400, 1) == ACCEPTED


def test_it_does_not_arm_while_landing_or_returning(gcs: Client) -> None:
    """Neither mode is entered on the ground, so there is nothing to refuse at arming."""
    assert gcs.set_mode(LAND) == NOT_NOW
    assert gcs.command(400, 1) == ACCEPTED


def test_neither_gcs_heartbeat_nor_radio_nor_calibration_is_needed(grounded: Aircraft) -> None:
    assert grounded.client().command(400, 1) == ACCEPTED


def test_arming_sets_home_here(gcs: Client) -> None:
    assert gcs.command(179, 0, 0, 0, 0, 47.398, 8.546, 490.0) == ACCEPTED
    assert gcs.command(400, 1) == ACCEPTED
    assert gcs.command(400, 0) == ACCEPTED
    assert gcs.command(400, 1) == ACCEPTED
    m = gcs.request(242)
    assert (m.x, m.y) == pytest.approx((0.0, 0.0), abs=0.01)


def test_a_home_chosen_since_the_last_disarm_is_kept(gcs: Client) -> None:
    assert gcs.command_int(179, 0, (0, 0, 0, 0), 473980000, 85460000, 490.0) == ACCEPTED
    assert gcs.command(400, 1) == ACCEPTED
    assert gcs.request(242).latitude == 473980000


@pytest.mark.parametrize(("name", "seconds"), [("COM_DISARM_PRFLT", 10.0), ("COM_DISARM_PRFLT", 3.0)])
def test_armed_but_not_taking_off_it_disarms(gcs: Client, name: str, seconds: float) -> None:
    gcs.set_param(name, seconds)
    assert gcs.command(400, 1) == ACCEPTED
    gcs.aircraft.fly(seconds - 0.1)
    assert gcs.aircraft.autopilot.armed
    gcs.aircraft.fly(0.2)
    assert not gcs.aircraft.autopilot.armed


@pytest.mark.parametrize("seconds", [2.0, 5.0])
def test_landed_it_disarms(pilot: Client, seconds: float) -> None:
    aircraft = pilot.aircraft
    pilot.set_param("COM_DISARM_LAND", seconds)
    assert pilot.set_mode(LAND) == ACCEPTED
    while not aircraft.autopilot.on_ground:
        aircraft.fly(0.01)
    aircraft.fly(seconds - 0.1)
    assert aircraft.autopilot.armed
    aircraft.fly(0.2)
    assert not aircraft.autopilot.armed
