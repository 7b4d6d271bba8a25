"""Contract, section 12: landed states, return, home and frames. (Failsafes: test_12_failsafes.py.)"""

from __future__ import annotations

import math

import numpy as np
import pytest

from system.contract.aircraft import ACCEPTED, HOVER, INT32_MAX, LAND, NAN, OFFBOARD, RTL, A, Aircraft, Client

ON_GROUND, IN_AIR, TAKING_OFF, LANDING = 1, 2, 3, 4
A_M, E2 = 6378137.0, 6.69437999014e-3


def landed(client: Client) -> int:
    return int(client.request(245).landed_state)


def test_on_the_ground(gcs: Client) -> None:
    assert landed(gcs) == ON_GROUND
    assert gcs.command(400, 1) == ACCEPTED
    gcs.aircraft.run(1.0)
    assert landed(gcs) == ON_GROUND


def test_in_the_air(pilot: Client) -> None:
    assert landed(pilot) == IN_AIR


def test_inverted_is_in_the_air(pilot: Client) -> None:
    assert pilot.set_mode(OFFBOARD) == ACCEPTED
    pilot.aircraft.stream(pilot, 1.5, q=[0.0, 1.0, 0.0, 0.0], thrust=-HOVER)
    assert landed(pilot) == IN_AIR
    assert pilot.aircraft.autopilot.armed


def test_landing(pilot: Client) -> None:
    assert pilot.set_mode(LAND) == ACCEPTED
    pilot.aircraft.run(2.0)
    assert landed(pilot) == LANDING


def test_the_last_part_of_a_return_is_a_landing(pilot: Client) -> None:
    assert pilot.set_mode(RTL) == ACCEPTED
    pilot.aircraft.run(2.0)
    assert landed(pilot) == LANDING


# Return


def go_to(client: Client, north_m: float, height_m: float) -> None:
    lat = 473977420 + round(north_m * 90)
    assert client.command_int(192, 6, (12, 1, 0, NAN), lat, 85455940, height_m) == ACCEPTED
    client.aircraft.fly(15.0)


def highest_of_return(client: Client) -> float:
    assert client.set_mode(RTL) == ACCEPTED
    highest = 0.0
    for _ in range(600):
        client.aircraft.fly(0.2)
        highest = max(highest, client.aircraft.world.p_WB[2])
        if not client.aircraft.autopilot.armed:
            return highest
    raise AssertionError("not home after two minutes")


@pytest.mark.parametrize(("north", "height", "highest"), [(30.0, 8.0, 20.0), (30.0, 25.0, 25.0), (3.0, 8.0, 8.0)])
def test_a_return_climbs_to_its_height_unless_higher_or_near(
    pilot: Client, north: float, height: float, highest: float
) -> None:
    pilot.set_param("RTL_RETURN_ALT", 20.0)
    go_to(pilot, north, height)
    assert highest_of_return(pilot) == pytest.approx(highest, abs=0.4)
    assert np.linalg.norm(pilot.aircraft.world.p_WB) < 0.3


# Frames: the contract's formula, written down a second time


def local_of(lat_deg: float, lon_deg: float) -> tuple[float, float]:
    lat0, lon0, h0 = math.radians(47.397742), math.radians(8.545594), 488.0
    s = math.sin(lat0)
    m = A_M * (1 - E2) / (1 - E2 * s * s) ** 1.5
    n = A_M / math.sqrt(1 - E2 * s * s)
    north = (math.radians(lat_deg) - lat0) * (m + h0)
    east = (math.radians(lon_deg) - lon0) * math.cos(lat0) * (n + h0)
    return north, east


@pytest.mark.parametrize(("north", "east"), [(0, 0), (1000, 0), (0, 1000), (-700, 700), (333.3, -12.5)])
def test_global_and_local_positions_agree_within_2_cm_at_1_km(north: float, east: float) -> None:
    aircraft = Aircraft.new()
    aircraft.world.place([north, -east, 100.0], [0, 0, 0], [1, 0, 0, 0], [0, 0, 0], [1.4] * 4)
    client = aircraft.client(A)
    aircraft.run(0.5)
    place, local = client.request(33), client.request(32)
    expected = local_of(place.lat * 1e-7, place.lon * 1e-7)
    assert (local.x, local.y) == pytest.approx(expected, abs=0.02)
    assert place.alt / 1000 - 488.0 == pytest.approx(-local.z, abs=0.02)


@pytest.mark.parametrize(("lat", "lon"), [(473977420, 85455940), (474067354, 85455940), (473977420, 85588480)])
def test_home_is_the_same_place_in_degrees_and_in_metres(gcs: Client, lat: int, lon: int) -> None:
    assert gcs.command_int(179, 0, (0, 0, 0, 0), lat, lon, 490.0) == ACCEPTED
    m = gcs.request(242)
    assert (m.latitude, m.longitude) == (lat, lon)
    assert (m.x, m.y) == pytest.approx(local_of(lat * 1e-7, lon * 1e-7), abs=0.02)
    assert m.z == pytest.approx(-2.0, abs=0.02)


def test_home_tells_its_heading_and_no_approach(gcs: Client) -> None:
    m = gcs.request(242)
    assert np.linalg.norm(m.q) == pytest.approx(1.0, abs=1e-5)
    assert all(math.isnan(v) for v in (m.approach_x, m.approach_y, m.approach_z))


def test_the_origin_is_where_local_positions_begin(gcs: Client) -> None:
    m = gcs.request(49)
    assert (m.latitude, m.longitude, m.altitude) == (473977420, 85455940, 488000)


def test_a_position_not_given_is_kept(pilot: Client) -> None:
    assert pilot.command_int(192, 6, (-1, 1, 0, NAN), INT32_MAX, INT32_MAX, 15.0) == ACCEPTED
    pilot.aircraft.fly(8.0)
    assert pilot.aircraft.world.p_WB == pytest.approx([0, 0, 15.0], abs=0.2)
