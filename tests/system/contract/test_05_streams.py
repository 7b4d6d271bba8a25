"""Contract, section 5: what is sent unasked, how often, and what it says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from system.contract.aircraft import ACCEPTED, DENIED, HOVER, OFFBOARD, A, Aircraft, B, C, Client, dialect

RATES = {  # Hz on links A, B and C
    "HEARTBEAT": (1, 1, 1),
    "SYS_STATUS": (2, 2, 2),
    "EXTENDED_SYS_STATE": (5, 2, 2),
    "ATTITUDE_QUATERNION": (100, 10, 50),
    "ATTITUDE": (0, 10, 0),
    "LOCAL_POSITION_NED": (100, 5, 50),
    "ATTITUDE_TARGET": (50, 5, 0),
    "GLOBAL_POSITION_INT": (10, 5, 10),
    "GPS_RAW_INT": (2, 2, 0),
    "VFR_HUD": (0, 4, 0),
    "BATTERY_STATUS": (1, 1, 1),
    "HOME_POSITION": (0.5, 0.5, 0.5),
    "GPS_GLOBAL_ORIGIN": (0.2, 0.2, 0.2),
    "MISSION_CURRENT": (2, 2, 2),
    "SYSTEM_TIME": (1, 1, 1),
    "ACTUATOR_OUTPUT_STATUS": (0, 0, 0),
    "CURRENT_MODE": (0.5, 0.5, 0.5),
    "AVAILABLE_MODES_MONITOR": (0.2, 0.2, 0.2),
}
SECONDS = 20


@pytest.fixture(scope="module")
def listened(_hovering: Aircraft) -> dict[int, Client]:
    """Twenty quiet seconds on all links."""
    aircraft = _hovering.copy()
    clients = {link: aircraft.client(link) for link in (A, B, C)}
    aircraft.run(SECONDS)
    return clients


@pytest.mark.parametrize("link", [A, B, C], ids=["A", "B", "C"])
@pytest.mark.parametrize("kind", RATES)
def test_a_stream_has_its_rate(listened: dict[int, Client], kind: str, link: int) -> None:
    n = len(listened[link].all(kind))
    assert n / SECONDS == pytest.approx(RATES[kind][link], rel=0.2)


def test_nothing_else_is_streamed(listened: dict[int, Client]) -> None:
    kinds = {m.get_type() for client in listened.values() for _, m in client.heard}
    assert kinds <= set(RATES)


ON_REQUEST = [
    "AUTOPILOT_VERSION",
    "AVAILABLE_MODES",
    "ODOMETRY",
    "HIGHRES_IMU",
    "ALTITUDE",
    "ACTUATOR_OUTPUT_STATUS",
    "HEARTBEAT",
    "ATTITUDE",
    "HOME_POSITION",
]


def number_of(kind: str) -> int:
    return int(getattr(dialect, f"MAVLINK_MSG_ID_{kind}"))


@pytest.mark.parametrize("kind", ON_REQUEST)
def test_a_message_comes_on_request(gcs: Client, kind: str) -> None:
    assert gcs.request(number_of(kind), 1 if kind == "AVAILABLE_MODES" else 0).get_type() == kind


def test_a_message_interval_comes_on_request(gcs: Client) -> None:
    m = gcs.request(244, number_of("ATTITUDE"))
    assert (m.message_id, m.interval_us) == (30, 100000)


@pytest.mark.parametrize("kind", ["ODOMETRY", "HIGHRES_IMU", "ALTITUDE", "ACTUATOR_OUTPUT_STATUS", "ATTITUDE"])
def test_a_message_comes_by_interval(gcs: Client, kind: str) -> None:
    assert gcs.command(511, number_of(kind), 50000) == ACCEPTED
    gcs.aircraft.run(2.0)
    assert len(gcs.all(kind)) == 40


def test_an_interval_changes_the_asking_link_only(grounded: Aircraft) -> None:
    asker, other = grounded.client(B), grounded.client(A)
    assert asker.command(511, number_of("ATTITUDE_QUATERNION"), 2500) == ACCEPTED
    grounded.run(1.0)
    assert len(asker.all("ATTITUDE_QUATERNION")) == 400
    assert len(other.all("ATTITUDE_QUATERNION")) == 100


def test_interval_minus_one_is_off_and_zero_the_default(gcs: Client) -> None:
    for interval, rate in ((-1, 0), (0, 10)):
        assert gcs.command(511, number_of("ATTITUDE"), interval) == ACCEPTED
        since = gcs.aircraft.t_ms
        gcs.aircraft.run(1.0)
        assert len(gcs.all("ATTITUDE", since)) == rate


@pytest.mark.parametrize("interval_us", [2499.0, 1.0, -2.0, math.nan, math.inf])
def test_an_interval_too_short_or_senseless_is_denied(gcs: Client, interval_us: float) -> None:
    assert gcs.command(511, number_of("ATTITUDE"), interval_us) == DENIED
    assert gcs.request(244, number_of("ATTITUDE")).interval_us == 100000


def test_a_data_stream_request_slows_nothing(grounded: Aircraft) -> None:
    client = grounded.client(A)
    assert client.ask(client.encode.request_data_stream_encode(1, 1, 0, 1, 0)) == []
    grounded.run(1.0)
    assert len(client.all("ATTITUDE_QUATERNION")) == 100


def test_the_landed_state_is_shown_at_once_when_it_changes(gcs: Client) -> None:
    assert gcs.command(22, 0, 0, 0, 0, 0, 0, 5.0) == ACCEPTED
    assert gcs.command(400, 1) == ACCEPTED
    gcs.aircraft.run(8.0)
    states = [m.landed_state for m in gcs.all("EXTENDED_SYS_STATE")]
    assert list(dict.fromkeys(states)) == [1, 3, 2]
    changed = gcs.times("EXTENDED_SYS_STATE")[states.index(3)]
    assert changed % 500 != 0  # between two that were due


def test_vtol_state_is_undefined(listened: dict[int, Client]) -> None:
    assert {m.vtol_state for m in listened[A].all("EXTENDED_SYS_STATE")} == {0}


# Attitudes


@pytest.fixture(scope="module")
def rolled(_hovering: Aircraft) -> Client:
    """Two whole rolls by body rate in OFFBOARD, then inverted hover."""
    aircraft = _hovering.copy()
    client = aircraft.client(A)
    assert client.command(511, number_of("ATTITUDE"), 10000) == ACCEPTED
    assert client.set_mode(OFFBOARD) == ACCEPTED
    for roll in np.arange(0.0, 5.0 * math.pi, 0.05):  # on the wire's axes
        q = [math.cos(roll / 2), math.sin(roll / 2), 0.0, 0.0]
        aircraft.stream(client, 0.01, q=q, body_roll_rate=5.0, thrust=HOVER * math.cos(roll))
    aircraft.stream(client, 0.4, q=[0.0, 1.0, 0.0, 0.0], thrust=-HOVER)
    return client


def test_the_quaternion_has_w_first_and_takes_body_to_ned(rolled: Client) -> None:
    m = rolled.all("ATTITUDE_QUATERNION")[-1]
    assert abs(m.q2) > 0.99  # inverted: half a turn about the nose
    assert abs(m.q1) < 0.1


def test_the_quaternion_is_continuous_from_sample_to_sample(rolled: Client) -> None:
    qs = np.array([(m.q1, m.q2, m.q3, m.q4) for m in rolled.all("ATTITUDE_QUATERNION")])
    assert (np.sum(qs[1:] * qs[:-1], axis=1) > 0.9).all()
    assert (np.sum(qs * qs[0], axis=1) < -0.5).any()  # the rolls really went round


def test_inverted_flight_shows_a_roll_near_pi(rolled: Client) -> None:
    assert abs(rolled.all("ATTITUDE")[-1].roll) > 3.0


def test_angles_stay_in_their_ranges(rolled: Client) -> None:
    for m in rolled.all("ATTITUDE"):
        assert -math.pi < m.roll <= math.pi
        assert -math.pi / 2 <= m.pitch <= math.pi / 2
        assert -math.pi < m.yaw <= math.pi


def test_attitude_and_quaternion_agree(rolled: Client) -> None:
    quaternions = {m.time_boot_ms: m for m in rolled.all("ATTITUDE_QUATERNION")}
    for m in rolled.all("ATTITUDE")[::20]:
        q = quaternions[m.time_boot_ms]
        roll = math.atan2(2 * (q.q1 * q.q2 + q.q3 * q.q4), 1 - 2 * (q.q2**2 + q.q3**2))
        assert math.remainder(roll - m.roll, 2 * math.pi) == pytest.approx(0.0, abs=1e-3)


def test_the_attitude_target_is_the_setpoint_in_use_with_the_sign_of_its_thrust(rolled: Client) -> None:
    m = rolled.all("ATTITUDE_TARGET")[-1]
    assert m.thrust == pytest.approx(-HOVER, rel=1e-5)
    assert abs(m.q[1]) == pytest.approx(1.0, abs=1e-5)


def test_throttle_is_a_hundred_times_the_size_of_the_thrust(pilot: Client) -> None:
    assert pilot.set_mode(OFFBOARD) == ACCEPTED
    pilot.aircraft.stream(pilot, 0.5, q=[0.0, 1.0, 0.0, 0.0], thrust=-0.5)
    assert pilot.all("VFR_HUD")[-1].throttle == 50


def test_the_heading_is_unknown_when_the_nose_points_up(pilot: Client) -> None:
    assert pilot.set_mode(OFFBOARD) == ACCEPTED
    up = math.sqrt(0.5)
    pilot.aircraft.stream(pilot, 0.5, q=[up, 0.0, up, 0.0], thrust=0.3)
    assert pilot.all("GLOBAL_POSITION_INT")[-1].hdg == 65535


def test_altitudes_are_above_sea_level_and_above_home_in_millimetres(pilot: Client) -> None:
    pilot.aircraft.run(0.5)
    m = pilot.all("GLOBAL_POSITION_INT")[-1]
    assert m.alt == pytest.approx(488000 + 12000, abs=100)
    assert m.relative_alt == pytest.approx(12000, abs=100)


def test_gps_has_a_fix(listened: dict[int, Client]) -> None:
    assert all(m.fix_type >= 3 for m in listened[B].all("GPS_RAW_INT"))


def test_the_battery_is_number_0(listened: dict[int, Client]) -> None:
    assert {m.id for m in listened[B].all("BATTERY_STATUS")} == {0}


def test_actuator_outputs_are_rotor_thrusts_over_the_largest(pilot: Client) -> None:
    m = pilot.request(number_of("ACTUATOR_OUTPUT_STATUS"))
    assert m.active == 4
    assert m.actuator[:4] == pytest.approx([0.571 * 9.80665 / 4 / 3.0] * 4, rel=0.05)
    assert m.actuator[4:] == [0.0] * 28


# SYS_STATUS

FITTED = {
    "3D_GYRO": 0x1,
    "3D_ACCEL": 0x2,
    "3D_MAG": 0x4,
    "ABSOLUTE_PRESSURE": 0x8,
    "GPS": 0x20,
    "ANGULAR_RATE_CONTROL": 0x400,
    "ATTITUDE_STABILIZATION": 0x800,
    "Z_ALTITUDE_CONTROL": 0x2000,
    "XY_POSITION_CONTROL": 0x4000,
    "MOTOR_OUTPUTS": 0x8000,
    "AHRS": 0x200000,
    "BATTERY": 0x2000000,
    "PREARM_CHECK": 0x10000000,
}
GEOFENCE = 0x100000


@pytest.mark.parametrize("name", FITTED)
def test_a_sensor_is_present_enabled_and_healthy(listened: dict[int, Client], name: str) -> None:
    m = listened[B].all("SYS_STATUS")[-1]
    for field in ("present", "enabled", "health"):
        assert getattr(m, f"onboard_control_sensors_{field}") & FITTED[name]


def test_nothing_else_is_present(listened: dict[int, Client]) -> None:
    m = listened[B].all("SYS_STATUS")[-1]
    assert m.onboard_control_sensors_present == sum(FITTED.values())
    assert m.onboard_control_sensors_enabled == sum(FITTED.values())


def test_the_geofence_is_healthy_for_mavproxys_sake(listened: dict[int, Client]) -> None:
    assert listened[B].all("SYS_STATUS")[-1].onboard_control_sensors_health & GEOFENCE


def test_the_prearm_check_is_unhealthy_while_the_vehicle_would_not_arm(gcs: Client) -> None:
    gcs.count(3)  # an upload is in progress
    gcs.aircraft.run(0.6)
    assert not gcs.all("SYS_STATUS")[-1].onboard_control_sensors_health & FITTED["PREARM_CHECK"]


def test_home_exists_before_arming(listened: dict[int, Client], gcs: Client) -> None:
    assert gcs.request(number_of("HOME_POSITION")).get_type() == "HOME_POSITION"
