"""Contract, section 3: the modes, the ways in, and what is refused."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from system.contract.aircraft import (
    ACCEPTED,
    DENIED,
    FAILED,
    HOLD,
    LAND,
    MISSION,
    NAN,
    NOT_NOW,
    OFFBOARD,
    RTL,
    TAKEOFF,
    A,
    Aircraft,
    Client,
)
from system.contract.missions import LINE

MODES = {"Hold": HOLD, "Mission": MISSION, "Return": RTL, "Land": LAND, "Takeoff": TAKEOFF, "Offboard": OFFBOARD}


def main_and_sub(mode: int) -> tuple[int, int]:
    return mode >> 16 & 0xFF, mode >> 24


def shown(client: Client) -> int:
    """The mode of the latest heartbeat."""
    client.aircraft.run(1.0)
    return int(client.all("HEARTBEAT")[-1].custom_mode)


def by_numbers(client: Client, mode: int) -> None:
    assert client.command(176, 1, *main_and_sub(mode)) == ACCEPTED


def by_numbers_and_nan(client: Client, mode: int) -> None:
    main, sub = main_and_sub(mode)
    assert client.command(176, 1, main, sub or NAN, NAN, NAN, NAN, NAN) == ACCEPTED


def by_base_mode_157(client: Client, mode: int) -> None:
    assert client.command(176, 157, *main_and_sub(mode)) == ACCEPTED


def by_one_number(client: Client, mode: int) -> None:
    assert client.command(176, 1, mode) == ACCEPTED


def by_one_number_and_nan(client: Client, mode: int) -> None:
    assert client.command(176, 1, mode, NAN, NAN, NAN, NAN, NAN) == ACCEPTED


def by_message(client: Client, mode: int) -> None:
    answers = client.ask(client.encode.set_mode_encode(1, 1, mode))
    assert "COMMAND_ACK" not in [m.get_type() for m in answers]


WAYS = [by_numbers, by_numbers_and_nan, by_base_mode_157, by_one_number, by_one_number_and_nan, by_message]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ["Hold", "Mission", "Return", "Land", "Offboard"])
def test_a_mode_is_entered_from_flight(pilot: Client, name: str, way: Callable[[Client, int], None]) -> None:
    assert pilot.upload(LINE) == 0
    if name == "Hold":
        assert pilot.set_mode(OFFBOARD) == ACCEPTED
    way(pilot, MODES[name])
    assert pilot.aircraft.autopilot.mode == name


@pytest.mark.parametrize("way", WAYS)
def test_takeoff_is_entered_on_the_ground(gcs: Client, way: Callable[[Client, int], None]) -> None:
    way(gcs, TAKEOFF)
    assert shown(gcs) == TAKEOFF


@pytest.mark.parametrize(("standard", "name"), [(5, "Return"), (6, "Mission"), (7, "Land")])
def test_a_standard_mode_is_entered(pilot: Client, standard: int, name: str) -> None:
    assert pilot.upload(LINE) == 0
    assert pilot.command(262, standard) == ACCEPTED
    assert pilot.aircraft.autopilot.mode == name


def test_the_standard_mode_takeoff_is_entered(gcs: Client) -> None:
    assert gcs.command(262, 8) == ACCEPTED
    assert gcs.aircraft.autopilot.mode == "Takeoff"


@pytest.mark.parametrize("standard", [0, 1, 2, 3, 4, 9, 255])
def test_another_standard_mode_fails(pilot: Client, standard: int) -> None:
    assert pilot.command(262, standard) == FAILED
    assert pilot.aircraft.autopilot.mode == "Hold"


def test_it_boots_in_hold() -> None:
    aircraft = Aircraft.new()
    assert shown(aircraft.client()) == HOLD


NOT_LISTED = [
    (1, 0),
    (2, 0),
    (3, 0),
    (5, 0),
    (7, 0),
    (8, 0),
    (4, 0),
    (4, 1),
    (4, 8),
    (4, 9),
    (6, 1),
    (0, 0),
    (255, 255),
]


@pytest.mark.parametrize("mode", NOT_LISTED, ids=lambda mode: "{}_{}".format(*mode))
def test_a_mode_that_is_not_listed_is_denied(pilot: Client, mode: tuple[int, int]) -> None:
    assert pilot.command(176, 1, *mode) == DENIED
    assert shown(pilot) == HOLD


@pytest.mark.parametrize(
    "params",
    [
        (0, 4, 3),
        (2, 4, 3),
        (1.5, 4, 3),
        (-1, 4, 3),
        (256, 4, 3),
        (NAN, 4, 3),
        (1, 4.5, 3),
        (1, NAN, 3),
        (1, 4, 3.5),
        (1, 1e10),
    ],
    ids=str,
)
def test_a_set_mode_that_is_no_custom_mode_is_denied(pilot: Client, params: tuple[float, ...]) -> None:
    assert pilot.command(176, *params) == DENIED


REFUSED_ON_THE_GROUND = [("Mission", MISSION), ("Return", RTL), ("Land", LAND)]


@pytest.mark.parametrize(("name", "mode"), REFUSED_ON_THE_GROUND)
def test_a_refused_change_is_answered_explained_and_never_shown(gcs: Client, name: str, mode: int) -> None:
    assert gcs.set_mode(mode) == NOT_NOW
    assert gcs.texts[-1].startswith(f"Mode: no {name}: ")
    gcs.aircraft.run(2.0)
    assert {m.custom_mode for m in gcs.all("HEARTBEAT")} == {HOLD}


def test_takeoff_in_flight_is_refused(pilot: Client) -> None:
    assert pilot.set_mode(TAKEOFF) == NOT_NOW
    assert pilot.aircraft.autopilot.mode == "Hold"
    assert pilot.texts[-1].startswith("Mode: no Takeoff: ")


def test_offboard_needs_no_stream_to_be_entered(pilot: Client) -> None:
    assert pilot.set_mode(OFFBOARD) == ACCEPTED
    assert pilot.aircraft.autopilot.mode == "Offboard"


def test_the_ground_station_enters_offboard_from_mission(on_mission: Aircraft) -> None:
    ground = on_mission.client(A, system=1, component=191)
    assert ground.set_mode(OFFBOARD) == ACCEPTED
    assert ground.set_mode(MISSION) == ACCEPTED


@pytest.mark.parametrize("name", ["Offboard", "Return", "Land", "Mission"])
def test_the_ground_station_does_not_override_a_user(on_mission: Aircraft, name: str) -> None:
    user, ground = on_mission.client(), on_mission.client(A, system=1, component=191)
    assert user.set_mode(HOLD) == ACCEPTED
    assert ground.set_mode(MODES[name]) == NOT_NOW
    assert on_mission.autopilot.mode == "Hold"


def test_the_ground_station_gives_back_only_its_own_offboard(on_mission: Aircraft) -> None:
    user, ground = on_mission.client(A), on_mission.client(A, slot=1, system=1, component=191)
    assert user.set_mode(OFFBOARD) == ACCEPTED
    on_mission.stream(user, 0.1)
    assert ground.set_mode(MISSION) == NOT_NOW


def test_on_disarming_the_mode_becomes_hold(gcs: Client) -> None:
    assert gcs.set_mode(OFFBOARD) == ACCEPTED
    assert gcs.command(400, 1) == ACCEPTED
    assert gcs.command(400, 0) == ACCEPTED
    assert shown(gcs) == HOLD


def test_mission_chosen_before_arming_starts_on_arming(gcs: Client) -> None:
    assert gcs.upload(LINE) == 0
    assert gcs.set_mode(MISSION) == ACCEPTED
    gcs.aircraft.run(1.0)
    assert gcs.aircraft.world.p_WB[2] < 0.1
    assert gcs.command(400, 1) == ACCEPTED
    gcs.aircraft.fly(6.0)
    assert gcs.aircraft.world.p_WB[2] > 3.0


def test_armed_in_hold_it_idles_on_the_ground(gcs: Client) -> None:
    assert gcs.command(400, 1) == ACCEPTED
    gcs.aircraft.fly(5.0)
    assert gcs.aircraft.world.p_WB[2] < 0.01


ROWS = [
    (1, HOLD, 0, 0, "Hold"),
    (2, MISSION, 6, 0, "Mission"),
    (3, RTL, 5, 0, "Return"),
    (4, LAND, 7, 0, "Land"),
    (5, TAKEOFF, 8, 0, "Takeoff"),
    (6, OFFBOARD, 0, 1, "Offboard"),
]


@pytest.mark.parametrize(("index", "mode", "standard", "properties", "name"), ROWS)
def test_a_mode_is_described(gcs: Client, index: int, mode: int, standard: int, properties: int, name: str) -> None:
    m = gcs.request(435, index)
    assert (m.number_modes, m.mode_index, m.custom_mode) == (6, index, mode)
    assert (m.standard_mode, m.properties, m.mode_name) == (standard, properties, name)


def test_all_modes_are_described_when_asked_for_number_0(gcs: Client) -> None:
    answers = gcs.ask(gcs.encode.command_long_encode(1, 1, 512, 0, 435, 0, 0, 0, 0, 0, 0))
    assert [m.mode_index for m in answers[1:]] == [1, 2, 3, 4, 5, 6]


def test_the_current_mode_is_shown_at_once_when_it_changes(pilot: Client) -> None:
    assert pilot.set_mode(OFFBOARD) == ACCEPTED
    m = pilot.all("CURRENT_MODE")[-1]
    assert (m.custom_mode, m.intended_custom_mode, m.standard_mode) == (OFFBOARD, OFFBOARD, 0)


def test_the_modes_never_change_so_their_monitor_stays(gcs: Client) -> None:
    gcs.aircraft.run(11.0)
    assert [m.seq for m in gcs.all("AVAILABLE_MODES_MONITOR")] == [0, 0]
