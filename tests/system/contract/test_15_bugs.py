"""Contract, section 15: faults known from elsewhere that must not be here."""

from __future__ import annotations

import numpy as np
import pytest

from system.contract.aircraft import (
    ACCEPTED,
    HOVER,
    NAN,
    OFFBOARD,
    A,
    Aircraft,
    B,
    Client,
)
from system.contract.missions import LINE, TAKEOFF_ITEM, item


@pytest.mark.parametrize("how", ["silence", "counts", "restarts"])
def test_a_transfer_is_never_busy_for_ever(gcs: Client, how: str) -> None:
    for _ in range(5):
        gcs.count(7)
        if how == "silence":
            gcs.aircraft.run(5.1)
        if how == "restarts":
            gcs.item(0, TAKEOFF_ITEM)
    if how != "silence":
        gcs.aircraft.run(5.1)
    other = gcs.aircraft.client(B, slot=1, system=250)
    assert other.upload(LINE) == 0


def test_the_retry_of_requests_does_not_hide_the_timeout(gcs: Client) -> None:
    gcs.count(3)
    gcs.aircraft.run(5.1)
    assert len(gcs.all("MISSION_REQUEST_INT")) == 20
    assert len(gcs.all("MISSION_ACK")) == 1


def test_no_current_item_of_65535_is_ever_sent(gcs: Client) -> None:
    gcs.aircraft.run(2.0)
    assert gcs.upload(LINE) == 0
    gcs.aircraft.run(1.0)
    gcs.ask(gcs.encode.mission_clear_all_encode(1, 1))
    gcs.aircraft.run(1.0)
    assert {m.seq for m in gcs.all("MISSION_CURRENT")} == {0}
    assert gcs.texts == []


@pytest.mark.parametrize("index", [-1, 255, -32768, 32767])
def test_a_radio_map_index_reaches_nothing(gcs: Client, index: int) -> None:
    for slot in (0, 3, 200, 255):
        assert gcs.ask(gcs.encode.param_map_rc_encode(1, 1, b"X", index, slot, 1.0, 1.0, 0.0, 2.0)) == []


def test_a_waypoint_without_yaw_keeps_the_heading(gcs: Client) -> None:
    assert gcs.upload([TAKEOFF_ITEM, item(16, 0, 0, 0, NAN, north=8.0), item(16, 0, 0, 0, NAN, east=8.0)]) == 0
    assert gcs.command(300) == ACCEPTED
    assert gcs.command(400, 1) == ACCEPTED
    for _ in range(40):
        gcs.aircraft.fly(0.5)
        assert np.isfinite(gcs.aircraft.world.q_WB).all()
        assert abs(gcs.aircraft.world.q_WB[3]) < 0.02


def test_a_setpoint_that_is_complained_about_is_not_flown(pilot: Client) -> None:
    assert pilot.set_mode(OFFBOARD) == ACCEPTED
    pilot.aircraft.stream(pilot, 0.1)
    pilot.aircraft.step(pilot.pack(pilot.attitude_target(thrust=1.5)), pilot.link)
    pilot.aircraft.run(0.01)
    assert sum(pilot.aircraft.world.rotor_thrust) == pytest.approx(12.0 * HOVER, rel=0.05)
    assert len(pilot.texts) == 1


def test_no_timer_runs_by_the_wall_clock(gcs: Client) -> None:
    """Twenty times faster than the wall, or with the wall standing: the same flight."""
    twin = gcs.aircraft.copy()
    assert gcs.command(400, 1) == ACCEPTED
    client = twin.client()
    assert client.command(400, 1) == ACCEPTED
    for _ in range(12000):
        twin.step()
        twin.stood_us -= 950
    gcs.aircraft.run(12.0)
    assert twin.autopilot.same_state(gcs.aircraft.autopilot)


def test_items_sent_twice_end_no_upload(gcs: Client) -> None:
    gcs.count(len(LINE))
    for seq, each in enumerate(LINE):
        gcs.item(seq, each)
        gcs.item(seq, each)
    assert [m.type for m in gcs.all("MISSION_ACK")] == [0]


def test_an_origin_set_is_reported_with_its_own_values_only(gcs: Client) -> None:
    answers = gcs.ask(gcs.encode.set_gps_global_origin_encode(1, 470000001, 80000003, 400123))
    shown = [(m.latitude, m.longitude, m.altitude) for m in answers if m.get_type() == "GPS_GLOBAL_ORIGIN"]
    assert set(shown) == {(470000001, 80000003, 400123)}


def test_the_accelerometer_is_present(gcs: Client) -> None:
    assert gcs.request(1).onboard_control_sensors_present & 0x2


def test_no_client_hears_the_answers_to_another(grounded: Aircraft) -> None:
    asker, bystander = grounded.client(B, 1, system=250), grounded.client(A)
    asker.upload(LINE)
    asker.command(400, 0)
    private = {"COMMAND_ACK", "MISSION_ACK", "MISSION_REQUEST_INT", "MISSION_COUNT"}
    assert not private & {m.get_type() for _, m in bystander.heard}


def test_unknown_commands_are_acknowledged(gcs: Client) -> None:
    assert gcs.command(54321) == 3
