"""SET_POSITION_TARGET_LOCAL_NED and _GLOBAL_INT in OFFBOARD, flown by the on-board follower."""

from __future__ import annotations

import math

import numpy as np
import pytest
from session import Session, hovering

LOCAL, BODY, BODY_OFFSET = 1, 8, 9
GLOBAL_INT, RELATIVE_INT, TERRAIN_INT = 5, 6, 11
POSITION, VELOCITY, ACCELERATION = 0b000000111, 0b000111000, 0b111000000
FORCE, YAW, YAW_RATE = 512, 1024, 2048
EVERYTHING = POSITION | VELOCITY | ACCELERATION | YAW | YAW_RATE
OFFBOARD_LOST = "Failsafe: offboard lost, Hold"


@pytest.fixture(scope="module")
def offboard() -> Session:
    flight = hovering(scenario="ideal", height=10.0)
    assert flight.mode(6) == 0
    return flight


def stream(
    flight: Session,
    ms: int,
    use: int,
    p: tuple[float, float, float] = (math.nan,) * 3,
    v: tuple[float, float, float] = (math.nan,) * 3,
    a: tuple[float, float, float] = (math.nan,) * 3,
    *,
    yaw: float = math.nan,
    yaw_rate: float = math.nan,
    frame: int = LOCAL,
    period_ms: int = 50,
) -> None:
    """What is not used is NaN. On the wire's axes: north, east, down."""
    for _ in range(ms // period_ms):
        mask = EVERYTHING & ~use
        target = flight._ours.set_position_target_local_ned_encode(
            flight.t_ms, 1, 1, frame, mask, *p, *v, *a, yaw, yaw_rate
        )
        flight.step(target)
        flight.run(period_ms - 1)


def stream_global(flight: Session, ms: int, frame: int, lat: float, lon: float, alt: float) -> None:
    nan = math.nan
    for _ in range(ms // 50):
        flight.step(
            flight._ours.set_position_target_global_int_encode(
                flight.t_ms, 1, 1, frame, EVERYTHING & ~POSITION, round(lat * 1e7), round(lon * 1e7), alt, *[nan] * 8
            )
        )
        flight.run(49)


def yaw_of(flight: Session) -> float:
    """Compass heading [rad]."""
    w, x, y, z = flight.world.q_WB
    return -math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def test_a_place_is_flown_to_and_held(offboard: Session) -> None:
    flight = offboard.copy()
    stream(flight, 12000, POSITION | YAW, p=(8.0, -5.0, -12.0), yaw=1.0)
    assert flight.world.p_WB == pytest.approx([8.0, 5.0, 12.0], abs=0.05)
    assert yaw_of(flight) == pytest.approx(1.0, abs=0.02)
    assert flight.texts() == []
    assert flight.autopilot.mode == "Offboard"


def test_a_velocity_is_flown_at_20_Hz_without_a_stutter(offboard: Session) -> None:
    flight = offboard.copy()
    stream(flight, 4000, VELOCITY, v=(3.0, 1.0, -0.5))
    speeds = []
    for _ in range(40):
        stream(flight, 50, VELOCITY, v=(3.0, 1.0, -0.5))
        speeds.append(flight.world.v_WB)
    assert np.abs(np.array(speeds) - [3.0, -1.0, 0.5]).max() < 0.05
    assert flight.texts() == []


def test_an_acceleration_alone_is_flown(offboard: Session) -> None:
    flight = offboard.copy()
    for _ in range(10):
        stream(flight, 100, ACCELERATION, a=(2.0, 0.0, 0.0), period_ms=10)
    assert flight.world.v_WB[0] == pytest.approx(2.0 * (1.0 - 0.125), abs=0.25)  # less the onset of the reference


def test_height_and_speed_may_be_mixed_axis_by_axis(offboard: Session) -> None:
    flight = offboard.copy()
    stream(flight, 8000, VELOCITY & 0b000011000 | 0b100, p=(math.nan, math.nan, -13.0), v=(1.5, 0.0, math.nan))
    assert flight.world.p_WB[2] == pytest.approx(13.0, abs=0.05)
    assert flight.world.v_WB[0] == pytest.approx(1.5, abs=0.05)


def test_a_moving_place_with_its_speed_and_acceleration_is_followed_closely(offboard: Session) -> None:
    flight = offboard.copy()
    stream(flight, 4000, POSITION, p=(4.0, 0.0, -10.0))
    radius, w, errors = 4.0, 0.5, []
    began = flight.t_ms
    for k in range(300):
        phase = w * 1e-3 * (flight.t_ms - began)
        c, s = math.cos(phase), math.sin(phase)
        stream(
            flight,
            50,
            POSITION | VELOCITY | ACCELERATION,
            p=(radius * c, radius * s, -10.0),
            v=(-radius * w * s, radius * w * c, 0.0),
            a=(-radius * w * w * c, -radius * w * w * s, 0.0),
        )
        phase = w * 1e-3 * (flight.t_ms - began)
        truth = np.array([radius * math.cos(phase), -radius * math.sin(phase), 10.0])
        if k > 100:
            errors.append(np.linalg.norm(flight.world.p_WB - truth))
    assert max(errors) < 0.1


def test_a_yaw_rate_turns_it(offboard: Session) -> None:
    flight = offboard.copy()
    stream(flight, 2000, VELOCITY | YAW_RATE, v=(0.0, 0.0, 0.0), yaw_rate=0.5)
    assert yaw_of(flight) == pytest.approx(1.0, abs=0.1)


def test_a_speed_along_the_nose_follows_the_heading(offboard: Session) -> None:
    flight = offboard.copy()
    stream(flight, 5000, POSITION | YAW, p=(0.0, 0.0, -10.0), yaw=math.pi / 2)
    stream(flight, 4000, VELOCITY, v=(2.0, 0.0, 0.0), frame=BODY)
    assert flight.world.v_WB == pytest.approx([0.0, -2.0, 0.0], abs=0.1)  # facing east


@pytest.mark.parametrize(("frame", "alt"), [(GLOBAL_INT, 500.0), (RELATIVE_INT, 12.0)])
def test_a_place_on_earth_is_flown_to(offboard: Session, frame: int, alt: float) -> None:
    flight = offboard.copy()
    stream_global(flight, 10000, frame, 47.397742 + 5.0 / 111180.0, 8.545594, alt)
    assert flight.world.p_WB == pytest.approx([5.0, 0.0, 12.0], abs=0.1)


@pytest.mark.parametrize(
    ("use", "frame", "why"),
    [
        (POSITION, BODY_OFFSET, "frame"),
        (POSITION, BODY, "frame"),
        (0b011, LOCAL, "axis without target"),
        (POSITION | YAW, LOCAL, "yaw"),  # used but NaN
        (VELOCITY, LOCAL, "velocity"),
        (POSITION | ACCELERATION, LOCAL, "acceleration"),
        (POSITION | YAW_RATE, LOCAL, "yaw rate"),
    ],
)
def test_what_cannot_be_used_is_dropped_whole_and_said(offboard: Session, use: int, frame: int, why: str) -> None:
    flight = offboard.copy()
    stream(flight, 100, use, p=(50.0, 0.0, -10.0), frame=frame)
    assert [text for _, _, text in flight.texts()] == [f"Offboard: setpoint dropped ({why})"]
    assert flight.world.p_WB == pytest.approx([0.0, 0.0, 10.0], abs=0.05)


def test_a_global_place_in_a_frame_above_terrain_is_dropped(offboard: Session) -> None:
    flight = offboard.copy()
    stream_global(flight, 100, TERRAIN_INT, 47.0, 8.5, 10.0)
    assert [text for _, _, text in flight.texts()] == ["Offboard: setpoint dropped (frame)"]


def test_a_force_is_dropped(offboard: Session) -> None:
    flight = offboard.copy()
    flight.step(flight._ours.set_position_target_local_ned_encode(0, 1, 1, LOCAL, FORCE, *[0.0] * 11))
    assert [text for _, _, text in flight.texts()] == ["Offboard: setpoint dropped (type mask)"]


def test_a_lost_stream_of_speeds_stops_then_holds(offboard: Session) -> None:
    flight = offboard.copy()
    stream(flight, 4000, VELOCITY, v=(4.0, 0.0, 0.0))
    last_ms, where = flight.t_ms - 50, flight.world.p_WB
    flight.run(6000)
    assert [text for _, _, text in flight.texts()] == ["Offboard: setpoints lost, recovering", OFFBOARD_LOST]
    times = [t - last_ms for t, _, _ in flight.texts()]
    assert 150 <= times[0] <= 180
    assert 500 <= times[1] <= 530
    assert np.linalg.norm(flight.world.v_WB) < 0.05
    assert np.linalg.norm(flight.world.p_WB - where) < 0.5 + 0.3 * 4.0 + 4.0**2 / 12.0


def test_the_first_source_owns_the_stream(offboard: Session) -> None:
    flight = offboard.copy()
    stream(flight, 200, VELOCITY, v=(0.0, 0.0, 0.0))
    other = type(flight._ours)(None, srcSystem=254, srcComponent=190)
    frame = other.set_position_target_local_ned_encode(0, 1, 1, LOCAL, EVERYTHING & ~POSITION, 9.0, 9.0, -9.0, *[0] * 8)
    flight.step(rx=frame.pack(other))
    flight.run(10)
    assert [text for _, _, text in flight.texts()] == ["Offboard: setpoint dropped (another source)"]


def test_attitude_and_position_may_alternate(offboard: Session) -> None:
    flight = offboard.copy()
    hover = 0.571 * 9.81 / 12.0
    for _ in range(3):
        stream(flight, 1000, POSITION, p=(0.0, 0.0, -10.0))
        for _ in range(30):
            flight.step(flight._ours.set_attitude_target_encode(flight.t_ms, 1, 1, 7, [1, 0, 0, 0], 0, 0, 0, hover))
            flight.run(9)
    stream(flight, 3000, POSITION, p=(0.0, 0.0, -10.0))
    assert flight.world.p_WB == pytest.approx([0.0, 0.0, 10.0], abs=0.1)
    assert flight.texts() == []


def test_it_takes_off_to_a_place_in_offboard() -> None:
    flight = Session()
    flight.run(1000)
    assert flight.mode(6) == 0
    stream(flight, 500, POSITION, p=(0.0, 0.0, 0.0))
    assert flight.command(400, 1) == 0
    stream(flight, 8000, POSITION, p=(0.0, 0.0, -5.0))
    assert flight.world.p_WB == pytest.approx([0.0, 0.0, 5.0], abs=0.05)
