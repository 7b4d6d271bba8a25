"""Contract, section 9: jumps, what the on-board follower makes of each kind of item, and item 0 as home."""

from __future__ import annotations

import pytest

from system.contract.aircraft import NAN, ORIGIN_LAT, ORIGIN_LON, Aircraft, Client, Item
from system.contract.missions import FLIP, LAND_ITEM, RTL_ITEM, SKIPPED, TAKEOFF_ITEM, away, bits, item, waypoint

OK, P1, X = 0, 6, 10


# Jumps


def test_a_loop_without_a_place_is_refused(gcs: Client) -> None:
    assert gcs.upload([TAKEOFF_ITEM, away(178, 1, 5), away(177, 1, -1)]) == P1


def test_a_loop_over_a_place_is_taken(gcs: Client) -> None:
    assert gcs.upload([TAKEOFF_ITEM, waypoint(5.0), away(177, 1, -1)]) == OK


def test_a_jump_is_flown_as_often_as_it_says(gcs: Client) -> None:
    reached = flown(gcs, [TAKEOFF_ITEM, waypoint(6.0), waypoint(0.0), away(177, 1, 2), LAND_ITEM])
    assert reached == [0, 1, 2, 3, 1, 2, 3, 1, 2, 3, 4]


def flown(client: Client, mission: list[Item], seconds: float = 90.0) -> list[int]:
    """Items reached, in order."""
    assert client.upload(mission) == OK
    assert client.command(300) == 0
    assert client.command(400, 1) == 0
    for _ in range(round(seconds)):
        client.aircraft.run(1.0)
        if not client.aircraft.autopilot.armed:
            break
    return [m.seq for m in client.all("MISSION_ITEM_REACHED")]


# What the on-board follower makes of them


def test_skipped_items_are_reached_at_once(gcs: Client) -> None:
    skipped = [away(command) for command in SKIPPED]
    reached = flown(gcs, [TAKEOFF_ITEM, *skipped, LAND_ITEM])
    assert reached == list(range(len(SKIPPED) + 2))


def test_every_kind_of_item_is_passed_and_those_not_flown_are_named(gcs: Client) -> None:
    mission = [
        TAKEOFF_ITEM,
        item(82, north=3.0),
        item(31000, 30, 0, NAN, NAN, north=6.0),
        item(19, 0.5, north=6.0),
        away(93, 0.5),
        away(112, 0.5),
        away(115, 90),
        away(178, 1, 3),
        away(189),
        away(210, 0),
        FLIP,
        LAND_ITEM,
    ]
    assert flown(gcs, mission) == list(range(len(mission)))
    assert "Mission: item 2 attitude not flown" in gcs.texts
    assert "Mission: item 10 skipped" in gcs.texts


def test_a_loiter_without_end_stays(gcs: Client) -> None:
    flown(gcs, [TAKEOFF_ITEM, item(17, north=5.0), LAND_ITEM], seconds=40.0)
    assert gcs.aircraft.world.p_WB[0] == pytest.approx(5.0, abs=0.2)
    assert gcs.request(42).seq == 1


# Item 0 as home

HOME: Item = (0, 16, 1, (0.0, 0.0, 0.0, 0.0), ORIGIN_LAT, ORIGIN_LON, 488.0)
NOWHERE: Item = (0, 16, 1, (0.0, 0.0, 0.0, 0.0), 0, 0, 0.0)


def first_flown(client: Client) -> int:
    return int(client.request(42).seq)


@pytest.mark.parametrize(
    ("rule", "mission", "first"),
    [
        (2, [HOME, TAKEOFF_ITEM, waypoint(5.0)], 1),
        (2, [NOWHERE, TAKEOFF_ITEM, waypoint(5.0)], 1),
        (2, [TAKEOFF_ITEM, waypoint(5.0)], 0),
        (2, [HOME, waypoint(5.0)], 0),
        (1, [waypoint(0.0), waypoint(5.0)], 1),
        (0, [HOME, TAKEOFF_ITEM, waypoint(5.0)], 0),
    ],
)
def test_item_0_may_be_home(gcs: Client, rule: int, mission: list[Item], first: int) -> None:
    gcs.set_param("MIS_SEQ0_HOME", rule)
    assert gcs.upload(mission) == OK
    assert first_flown(gcs) == first
    assert [bits(i) for i in gcs.download()] == [bits(i) for i in mission]


def test_item_0_at_nowhere_that_is_not_home_is_refused_at_the_end(gcs: Client) -> None:
    answers = gcs.count(2)
    assert gcs.item(0, NOWHERE)[-1].get_type() == "MISSION_REQUEST_INT"
    answers = gcs.item(1, waypoint(5.0))
    assert answers[-1].type == X


def test_an_item_0_that_is_home_does_not_move_ours(gcs: Client) -> None:
    before = gcs.request(242)
    assert gcs.upload([NOWHERE, TAKEOFF_ITEM, RTL_ITEM]) == OK
    after = gcs.request(242)
    assert (before.latitude, before.longitude) == (after.latitude, after.longitude)


def test_a_jump_counts_items_as_uploaded(gcs: Client) -> None:
    reached = flown(gcs, [HOME, TAKEOFF_ITEM, waypoint(5.0), away(177, 2, 1), LAND_ITEM])
    assert reached == [1, 2, 3, 2, 3, 4]


def test_a_float_item_is_stored_as_the_integer_one(grounded: Aircraft) -> None:
    client = grounded.client()
    client.count(1)
    message = client.encode.mission_item_encode(1, 1, 0, 3, 22, 0, 1, 0, 0, 0, 0, 47.5, 8.5, 10.0)
    assert client.only("MISSION_ACK", message).type == OK
    ((_, _, _, _, x, y, z),) = client.download()
    assert (x, y, z) == (475000000, 85000000, 10.0)
