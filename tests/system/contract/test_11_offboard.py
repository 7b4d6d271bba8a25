"""Contract, section 11: setpoints taken and dropped, whose they are, and what their absence does."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from system.contract.aircraft import ACCEPTED, HOVER, INF, NAN, OFFBOARD, A, Aircraft, Client, dialect

LEVEL = [1.0, 0.0, 0.0, 0.0]


@pytest.fixture
def streamer(hovering: Aircraft) -> Client:
    """In OFFBOARD on a good stream."""
    client = hovering.client(A)
    assert client.command(511, dialect.MAVLINK_MSG_ID_ATTITUDE_TARGET, 2500) == ACCEPTED
    assert client.set_mode(OFFBOARD) == ACCEPTED
    hovering.stream(client, 0.3)
    return client


def used(client: Client) -> Any:
    """The setpoint in use."""
    client.aircraft.run(0.003)
    return client.all("ATTITUDE_TARGET")[-1]


def up(aircraft: Aircraft) -> float:
    _, x, y, _ = aircraft.world.q_WB
    return float(1.0 - 2.0 * (x * x + y * y))


# Fields


@pytest.mark.parametrize("thrust", [-1.0, -0.5, 0.0, 0.3, 1.0])
def test_thrust_keeps_its_sign_and_size(streamer: Client, thrust: float) -> None:
    streamer.aircraft.stream(streamer, 0.02, thrust=thrust)
    assert used(streamer).thrust == pytest.approx(thrust, abs=1e-6)


def test_thrust_is_a_fraction_of_the_reference_thrust(streamer: Client) -> None:
    aircraft = streamer.aircraft
    aircraft.stream(streamer, 0.3, thrust=0.75)
    assert sum(aircraft.world.rotor_thrust) == pytest.approx(0.75 * streamer.read_param("VEH_T_REF"), rel=0.02)


def test_negative_thrust_pushes_down(streamer: Client) -> None:
    streamer.aircraft.stream(streamer, 0.2, thrust=-0.3)
    assert sum(streamer.aircraft.world.rotor_thrust) < -2.0


def test_thrust_is_projected_on_the_axis_the_body_has(streamer: Client) -> None:
    """A tilt asked for at once is not there at once, so less of the force is wanted along the body."""
    tilt = math.radians(80)
    q = [math.cos(tilt / 2), math.sin(tilt / 2), 0.0, 0.0]
    streamer.aircraft.step(streamer.pack(streamer.attitude_target(q=q)), A)
    assert sum(streamer.aircraft.commanded) < 0.5 * 0.571 * 9.80665


def test_inverted_hover(streamer: Client) -> None:
    aircraft = streamer.aircraft
    aircraft.stream(streamer, 1.2, q=[0.0, 1.0, 0.0, 0.0], thrust=-HOVER)
    assert up(aircraft) < -0.99
    before = aircraft.world.v_WB[2]
    aircraft.stream(streamer, 0.5, q=[0.0, 1.0, 0.0, 0.0], thrust=-HOVER)
    assert aircraft.world.v_WB[2] == pytest.approx(before, abs=0.3)


def test_q_and_minus_q_are_one_attitude(streamer: Client) -> None:
    for _ in range(20):
        streamer.aircraft.stream(streamer, 0.01, q=LEVEL)
        streamer.aircraft.stream(streamer, 0.01, q=[-1.0, 0.0, 0.0, 0.0])
    assert up(streamer.aircraft) > 0.999


def test_an_attitude_is_on_the_wires_axes(streamer: Client) -> None:
    """Right wing down on the wire drives the vehicle east, which is minus y here."""
    roll = math.radians(20)
    streamer.aircraft.stream(streamer, 0.5, q=[math.cos(roll / 2), math.sin(roll / 2), 0.0, 0.0])
    assert streamer.aircraft.world.v_WB[1] < -0.5


# type_mask


@pytest.mark.parametrize("mask", [0, 1, 2, 4, 3, 5, 6, 7, 128])
def test_a_mask_is_taken_and_echoed(streamer: Client, mask: int) -> None:
    streamer.aircraft.stream(streamer, 0.02, type_mask=mask)
    assert used(streamer).type_mask == mask
    assert streamer.texts == []


def test_body_rates_are_followed_when_the_attitude_is_ignored(streamer: Client) -> None:
    streamer.aircraft.stream(streamer, 0.5, type_mask=128, q=[0.0] * 4, body_yaw_rate=1.0)
    assert streamer.aircraft.world.w_WB_B[2] == pytest.approx(-1.0, abs=0.1)


def test_masked_fields_may_hold_anything(streamer: Client) -> None:
    rates = dict.fromkeys(("body_roll_rate", "body_pitch_rate", "body_yaw_rate"), NAN)
    streamer.aircraft.stream(streamer, 0.05, type_mask=7, **rates)
    streamer.aircraft.stream(streamer, 0.05, type_mask=128, q=[NAN] * 4)
    assert streamer.texts == []


DROPPED: dict[str, dict[str, Any]] = {
    "quaternion NaN": {"q": [NAN, 0.0, 0.0, 0.0]},
    "quaternion infinite": {"q": [INF, 0.0, 0.0, 0.0]},
    "quaternion too short": {"q": [0.89, 0.0, 0.0, 0.0]},
    "quaternion too long": {"q": [1.11, 0.0, 0.0, 0.0]},
    "quaternion zero": {"q": [0.0] * 4},
    "thrust NaN": {"thrust": NAN},
    "thrust above 1": {"thrust": 1.002},
    "thrust below -1": {"thrust": -1.002},
    "roll rate NaN": {"body_roll_rate": NAN},
    "pitch rate infinite": {"body_pitch_rate": INF},
    "yaw rate too fast": {"body_yaw_rate": 40.1},
    "no throttle": {"type_mask": 64},
    "body thrust vector": {"type_mask": 32},
    "mask 8": {"type_mask": 8},
    "mask 16": {"type_mask": 16},
    "attitude and a rate ignored": {"type_mask": 129},
    "attitude and all rates ignored": {"type_mask": 135},
}


@pytest.mark.parametrize("name", DROPPED)
def test_a_setpoint_is_dropped_whole_with_one_text_a_second(streamer: Client, name: str) -> None:
    aircraft = streamer.aircraft
    for _ in range(150):  # a good one between, so that nothing is lost
        aircraft.step(streamer.pack(streamer.attitude_target(**{"thrust": 0.6, **DROPPED[name]})), A)
        aircraft.step(streamer.pack(streamer.attitude_target()), A)
        assert not math.isnan(aircraft.world.rotor_thrust[0])
        aircraft.run(0.008)
    assert used(streamer).thrust == pytest.approx(HOVER, rel=1e-5)
    assert len(streamer.texts) == 2
    assert streamer.texts[0].startswith("Offboard: setpoint dropped (")


def test_a_dropped_setpoint_does_not_refresh_the_loss_timer(streamer: Client) -> None:
    streamer.aircraft.stream(streamer, 0.7, thrust=NAN)
    assert streamer.aircraft.autopilot.mode == "Hold"


@pytest.mark.parametrize("norm", [0.91, 1.09])
def test_a_quaternion_nearly_unit_is_normalised(streamer: Client, norm: float) -> None:
    streamer.aircraft.stream(streamer, 0.05, q=[norm, 0.0, 0.0, 0.0])
    assert np.linalg.norm(used(streamer).q) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("older_ms", [1, 100, 1000])
def test_a_setpoint_older_than_the_last_is_dropped(streamer: Client, older_ms: int) -> None:
    stamp = streamer.aircraft.t_ms
    streamer.aircraft.stream(streamer, 0.01, time_boot_ms=stamp)
    streamer.aircraft.stream(streamer, 0.01, time_boot_ms=stamp - older_ms, thrust=0.6)
    assert used(streamer).thrust == pytest.approx(HOVER, rel=1e-5)


@pytest.mark.parametrize("stamp", [0, 5, 2**32 - 1])
def test_any_other_clocks_stamp_means_the_time_of_arrival(streamer: Client, stamp: int) -> None:
    streamer.aircraft.stream(streamer, 0.3, time_boot_ms=stamp, thrust=0.5)
    assert streamer.texts == []
    assert used(streamer).thrust == pytest.approx(0.5)


@pytest.mark.parametrize(("late_ms", "turned_s"), [(0, 0.003), (-40, 0.043), (10, -0.007), (-60, 0.003), (30, 0.003)])
def test_a_stamp_near_vehicle_time_dates_the_setpoint(streamer: Client, late_ms: int, turned_s: float) -> None:
    """Its attitude is turned with its rate from its stamp to now."""
    aircraft = streamer.aircraft
    aircraft.stream(streamer, 0.02, time_boot_ms=0)
    stamp = aircraft.t_ms + 1 + late_ms
    aircraft.step(streamer.pack(streamer.attitude_target(time_boot_ms=stamp, body_yaw_rate=2.0)), A)
    target = used(streamer)
    assert 2 * math.asin(target.q[3]) == pytest.approx(2.0 * turned_s, abs=2.0 * 0.003)


# Outside OFFBOARD, and at its entry


def test_setpoints_outside_offboard_are_no_error_and_no_command(pilot: Client) -> None:
    pilot.aircraft.stream(pilot, 0.5, thrust=1.0)
    assert pilot.aircraft.autopilot.mode == "Hold"
    assert abs(pilot.aircraft.world.v_WB[2]) < 0.1
    assert pilot.texts == []


@pytest.mark.parametrize(("age_ms", "counts"), [(50, True), (150, False)])
def test_a_setpoint_just_before_entry_counts_as_the_first(pilot: Client, age_ms: int, counts: bool) -> None:
    aircraft = pilot.aircraft
    assert pilot.command(511, dialect.MAVLINK_MSG_ID_ATTITUDE_TARGET, 2500) == ACCEPTED
    aircraft.step(pilot.pack(pilot.attitude_target(thrust=0.5)), pilot.link)
    aircraft.run(age_ms / 1000)
    assert pilot.set_mode(OFFBOARD) == ACCEPTED
    assert (used(pilot).thrust == pytest.approx(0.5)) == counts


def test_until_the_first_setpoint_it_holds(pilot: Client) -> None:
    assert pilot.set_mode(OFFBOARD) == ACCEPTED
    pilot.aircraft.run(0.9)
    assert pilot.aircraft.world.p_WB == pytest.approx([0, 0, 12.0], abs=0.1)
    assert pilot.aircraft.autopilot.mode == "Offboard"


def test_without_any_setpoint_it_holds_after_a_second(pilot: Client) -> None:
    assert pilot.set_mode(OFFBOARD) == ACCEPTED
    pilot.aircraft.run(1.03)
    assert pilot.aircraft.autopilot.mode == "Hold"
    assert pilot.texts == ["Offboard: no setpoints"]


def test_disarmed_it_waits_for_setpoints_without_end(gcs: Client) -> None:
    assert gcs.set_mode(OFFBOARD) == ACCEPTED
    gcs.aircraft.run(5.0)
    assert gcs.aircraft.autopilot.mode == "Offboard"


# Owner


def test_the_first_source_is_the_owner_and_others_are_dropped(streamer: Client) -> None:
    aircraft = streamer.aircraft
    other = aircraft.client(A, slot=1, system=240)
    for _ in range(30):
        aircraft.step(other.pack(other.attitude_target(thrust=0.7)), A, 1)
        aircraft.stream(streamer, 0.01)
    assert used(streamer).thrust == pytest.approx(HOVER, rel=1e-5)
    assert streamer.texts == ["Offboard: setpoint dropped (another source)"]


# The ladder; tests/firmware/test_offboard_loss.py flies each rung from more situations


def test_at_20_Hz_there_is_no_warning(streamer: Client) -> None:
    streamer.aircraft.stream(streamer, 3.0, period_ms=50)
    assert streamer.texts == []


@pytest.mark.parametrize(("name", "value"), [("OFB_RATE_T", 0.06), ("OFB_HOLD_T", 0.3), ("OFB_LOSS_T", 1.0)])
def test_a_rung_is_a_parameter(streamer: Client, name: str, value: float) -> None:
    aircraft = streamer.aircraft
    streamer.set_param(name, value)
    aircraft.stream(streamer, 0.05, body_yaw_rate=1.0)
    last = aircraft.t_ms - 9
    aircraft.run(1.2)
    times = {
        "OFB_RATE_T": next(
            t for t, m in streamer.heard if m.get_type() == "ATTITUDE_TARGET" and t > last and m.body_yaw_rate == 0.0
        ),
        "OFB_HOLD_T": streamer.times("STATUSTEXT")[0],
        "OFB_LOSS_T": streamer.times("STATUSTEXT")[1],
    }
    assert value * 1000 <= times[name] - last + 1 <= value * 1000 + 26


def test_rates_alone_become_zero_rates(streamer: Client) -> None:
    streamer.aircraft.stream(streamer, 0.1, type_mask=128, body_yaw_rate=1.0)
    streamer.aircraft.run(0.1)
    m = used(streamer)
    assert (m.body_yaw_rate, m.type_mask) == (0.0, 128)


def test_after_the_loss_only_a_mode_command_resumes(streamer: Client) -> None:
    aircraft = streamer.aircraft
    aircraft.run(0.7)
    aircraft.stream(streamer, 0.5)
    assert aircraft.autopilot.mode == "Hold"
    assert streamer.set_mode(OFFBOARD) == ACCEPTED
    aircraft.stream(streamer, 0.5)
    assert aircraft.autopilot.mode == "Offboard"
    assert used(streamer).thrust == pytest.approx(HOVER, rel=1e-5)
