"""What the planner flies of a mission: one claim per rule."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from halfroll.errors import MissionError, PlanError
from halfroll.missions.geodesy import DEFAULT_ORIGIN, GeoPoint, global_from_local
from halfroll.missions.mission import NOT_GIVEN, Mission, MissionItem, Waypoint
from halfroll.missions.mission_check import check_items
from halfroll.planner.course import Course, course, endless, flown_waypoints, require_an_end, with_takeoff_and_landing
from halfroll.wire.frames import degrees_to_wire

NAN = math.nan


def at(n: float, w: float, u: float, command: int = 16, hold: float = 0.0, heading_deg: float = NAN) -> MissionItem:
    lat_deg, lon_deg, _ = global_from_local(DEFAULT_ORIGIN, (n, w, u))
    return MissionItem(command, 3, (hold, 0.0, 0.0, heading_deg), degrees_to_wire(lat_deg), degrees_to_wire(lon_deg), u)


def do(command: int, *params: float) -> MissionItem:
    p1, p2, p3, p4 = (*params, *[0.0] * (4 - len(params)))
    return MissionItem(command, 2, (p1, p2, p3, p4), 0, 0, 0.0)


TAKEOFF, A, B, C, LAND, RTL = at(0, 0, 3, 22), at(10, 0, 5), at(10, 10, 5), at(0, 10, 5), at(0, 0, 0, 21), do(20)


def items_of(flown: Course) -> list[int | None]:
    return [point.item for point in flown.waypoints]


def test_the_course_goes_from_the_takeoff_point_through_all_positions_up_to_the_landing() -> None:
    flown = flown_waypoints((TAKEOFF, A, do(206), B, LAND))
    assert (items_of(flown), flown.first_item, flown.last_item, flown.hands_back_to) == ([0, 1, 3], 0, 3, 4)
    for point, wanted in zip(flown.waypoints, [(0, 0, 3), (10, 0, 5), (10, 10, 5)], strict=True):
        assert point.position == pytest.approx(wanted, abs=0.01)


def test_a_mission_that_just_ends_hands_nothing_back() -> None:
    assert flown_waypoints((TAKEOFF, A)).hands_back_to is None


def test_items_after_the_last_position_are_left_to_the_autopilot() -> None:
    flown = flown_waypoints((TAKEOFF, A, do(93, 2), do(206), RTL))
    assert (flown.hands_back_to, flown.waypoints[-1].hold_s) == (2, 0)


@pytest.mark.parametrize("nowhere", [(0, 0), (NOT_GIVEN, NOT_GIVEN), (-NOT_GIVEN - 1, 5)])
def test_a_takeoff_without_a_place_is_over_home_at_the_default_height(nowhere: tuple[int, int]) -> None:
    takeoff = replace(TAKEOFF, x=nowhere[0], y=nowhere[1], z=NAN)
    home = GeoPoint(*global_from_local(DEFAULT_ORIGIN, (3.0, -4.0, 1.0)))
    flown = flown_waypoints((takeoff, A), home=home, takeoff_altitude=2.5)
    assert flown.waypoints[0].position == pytest.approx((3.0, -4.0, 3.5))


def test_heights_are_above_home_or_above_sea_level_as_the_frame_says() -> None:
    home = DEFAULT_ORIGIN._replace(alt=490.0)
    flown = flown_waypoints((TAKEOFF, A, replace(B, frame=0, z=500.0), replace(C, frame=6)), home=home)
    assert [point.position[2] for point in flown.waypoints] == [5, 7, 12, 7]


def test_a_home_line_is_not_flown() -> None:
    home_line = MissionItem(16, 0, (0.0,) * 4, 0, 0, 0.0)
    assert items_of(flown_waypoints((home_line, TAKEOFF, A))) == [1, 2]


def test_a_mission_without_a_takeoff_begins_at_its_first_position() -> None:
    assert items_of(flown_waypoints((do(530), A, B))) == [1, 2]


def test_the_rest_of_a_mission_begins_where_the_vehicle_hovers() -> None:
    flown = flown_waypoints((TAKEOFF, A, B, C, LAND), from_item=2, start=(1.0, 2.0, 3.0), start_yaw=0.5)
    assert flown.waypoints[0] == Waypoint((1.0, 2.0, 3.0), yaw=0.5)
    assert (items_of(flown)[1:], flown.first_item, flown.hands_back_to) == ([2, 3], 2, 4)


def test_the_rest_of_a_mission_keeps_the_speed_set_before() -> None:
    flown = flown_waypoints((TAKEOFF, do(178, 1, 4), A, B), from_item=3, start=(0.0, 0.0, 5.0))
    assert flown.waypoints[0].speed_max == 4


def test_a_finite_jump_is_unrolled_and_the_rest_begins_behind_it() -> None:
    flown = flown_waypoints((TAKEOFF, A, B, do(177, 1, 2), LAND))
    assert items_of(flown) == [0, 1, 2, 1, 2, 1, 2]
    assert (flown.last_item, flown.hands_back_to) == (2, 4)


def test_an_inner_jump_is_spent_when_the_outer_one_comes_round() -> None:
    flown = flown_waypoints((TAKEOFF, A, do(177, 1, 1), B, do(177, 1, 1)))
    assert items_of(flown) == [0, 1, 3, 1, 3]  # A twice in a row is one place


def test_a_jump_without_end_is_planned_up_to_and_then_flown_by_the_autopilot() -> None:
    flown = flown_waypoints((TAKEOFF, A, B, do(177, 1, -1), LAND))
    assert (items_of(flown), flown.hands_back_to) == ([0, 1, 2], 3)
    assert "for ever" in flown.notes[0].why


def test_a_loop_of_too_many_waypoints_is_cut_and_says_so() -> None:
    flown = flown_waypoints((TAKEOFF, A, B, do(177, 1, 30000)))
    assert len(flown.waypoints) == 2000
    assert "of at most 2000" in flown.notes[0].why


def test_a_long_loop_around_one_place_ends_too() -> None:
    flown = flown_waypoints((TAKEOFF, *[do(177, 0, 65535)] * 3, A))
    assert (items_of(flown), flown.hands_back_to) == ([0], 0)


def test_a_loiter_without_end_is_where_the_plan_ends_and_stays_current() -> None:
    flown = flown_waypoints((TAKEOFF, A, at(5, 5, 5, 17), B))
    assert (items_of(flown), flown.hands_back_to) == ([0, 1, 2], 2)


def test_the_plan_ends_where_home_moves() -> None:
    flown = flown_waypoints((TAKEOFF, A, do(93, 2), do(179, 1), B))
    assert (items_of(flown), flown.waypoints[-1].hold_s, flown.hands_back_to) == ([0, 1], 2, 3)


def test_a_speed_change_limits_the_legs_after_it_until_the_default_comes_back() -> None:
    flown = flown_waypoints(
        (TAKEOFF, A, do(178, 1, 4), B, do(178, 1, -1), do(178, 2, 1), C, do(178, 1, -2), at(0, 0, 5))
    )
    assert [point.speed_max for point in flown.waypoints[:-1]] == [None, 4, 4, None]


def test_hold_loiter_time_and_delay_are_waits_at_rest() -> None:
    flown = flown_waypoints((TAKEOFF, at(10, 0, 5, hold=2), do(93, 3), do(112, 0.5), at(10, 10, 5, 19, hold=4), C))
    assert [point.hold_s for point in flown.waypoints] == [0, 5.5, 4, 0]


def test_headings_are_clockwise_from_north_and_nan_keeps_the_last() -> None:
    flown = flown_waypoints((TAKEOFF, at(10, 0, 5, heading_deg=90), B), start_yaw=0.3)
    assert [point.yaw for point in flown.waypoints] == pytest.approx([0.3, -math.pi / 2, -math.pi / 2])


@given(st.lists(st.floats(-720, 720), min_size=1, max_size=6))
def test_no_heading_turns_more_than_half_a_turn_at_once(headings: list[float]) -> None:
    points = [at(10.0 * i, 0, 5, heading_deg=heading) for i, heading in enumerate(headings, start=1)]
    yaws = [point.yaw for point in flown_waypoints((TAKEOFF, *points)).waypoints]
    for before, after, heading in zip(yaws, yaws[1:], headings, strict=False):
        assert abs(after - before) <= math.pi + 1e-9
        assert math.isclose(math.cos(after + math.radians(heading)), 1.0, abs_tol=1e-6)


@pytest.mark.parametrize(
    ("turn", "yaw_deg"),
    [
        (do(115, 90), -90),
        (do(115, 270), 90),
        (do(115, 270, 0, 1), -270),  # clockwise, the long way
        (do(115, 90, 0, -1), 270),
        (do(115, 30, 0, 1, 1), -30),
        (do(115, 30, 0, -1, 1), 30),
    ],
)
def test_a_turn_item_sets_the_heading_of_what_follows(turn: MissionItem, yaw_deg: float) -> None:
    assert math.degrees(flown_waypoints((TAKEOFF, turn, A)).waypoints[1].yaw) == pytest.approx(yaw_deg)


def test_two_items_at_one_place_are_one_waypoint() -> None:
    flown = flown_waypoints((TAKEOFF, at(0, 0, 3, hold=1, heading_deg=90), A))
    assert items_of(flown) == [1, 2]
    assert (flown.first_item, flown.waypoints[0].hold_s) == (0, 1)


@pytest.mark.parametrize(
    ("items", "why"),
    [
        ((do(206), LAND), "no position to fly to"),
        ((TAKEOFF, replace(A, command=18)), "item 1 .command 18, frame 3. is not supported"),
        ((TAKEOFF, replace(A, frame=2)), "frame 2. is not supported"),
        ((TAKEOFF, replace(A, z=NAN)), "has no height"),
        ((TAKEOFF, replace(A, x=0, y=0)), "has no position"),
    ],
)
def test_a_mission_that_cannot_be_walked_is_refused(items: tuple[MissionItem, ...], why: str) -> None:
    with pytest.raises(MissionError, match=why):
        flown_waypoints(items)


# ---- takeoff and landing


def test_a_mission_that_takes_off_and_lands_is_left_alone() -> None:
    mission = Mission("m", (TAKEOFF, A, LAND))
    assert with_takeoff_and_landing(mission) == (mission, [])


def test_a_takeoff_and_a_landing_are_added_and_jumps_keep_their_targets() -> None:
    mission, added = with_takeoff_and_landing(Mission("m", (do(530), A, B, do(177, 1, 1))))
    assert [item.command for item in mission.items] == [22, 530, 16, 16, 177, 21]
    assert mission.items[4].params[0] == 2
    assert len(added) == 2
    assert not any(finding.is_error for finding in check_items(mission.items))
    assert items_of(course(mission)) == [0, 2, 3, 2, 3]


def test_a_takeoff_goes_behind_a_home_line_which_is_then_not_flown() -> None:
    home_line = replace(at(0, 0, 0), frame=0, z=488.0)
    mission, _ = with_takeoff_and_landing(Mission("m", (home_line, A, do(177, 1, 1), RTL), DEFAULT_ORIGIN))
    assert [item.command for item in mission.items] == [16, 22, 16, 177, 20]
    assert mission.items[3].params[0] == 2
    assert items_of(course(mission))[0] == 1


def test_waypoints_of_the_file_keep_naming_their_items() -> None:
    points = (Waypoint((0.0, 0.0, 0.2), item=0), Waypoint((10.0, 0.0, 5.0), item=1))
    mission, _ = with_takeoff_and_landing(Mission("m", (at(0, 0, 0.2), A), waypoints=points))
    flown = course(mission)
    assert (items_of(flown), flown.first_item, flown.hands_back_to) == ([1, 2], 1, 3)


def test_no_landing_is_added_where_the_mission_loiters_without_end() -> None:
    mission, added = with_takeoff_and_landing(Mission("m", (TAKEOFF, at(5, 5, 5, 17))))
    assert (len(mission.items), added) == (2, [])


@pytest.mark.parametrize(
    ("items", "at_item"),
    [
        ((TAKEOFF, A, B, do(177, 1, -1), LAND), 3),
        ((TAKEOFF, do(93, 4000), A, LAND), 1),
        ((TAKEOFF, A, B, do(177, 1, 65535), LAND), 3),
    ],
)
def test_a_mission_that_never_ends_is_told_by_the_item_that_it_stays_at(items, at_item):
    error = endless(items)
    assert error is not None
    assert error.item == at_item
    assert f"never ends: item {at_item}" in str(error)


def test_jumps_that_are_done_some_day_end():
    assert endless((TAKEOFF, A, B, do(177, 1, 3), LAND)) is None


def test_a_flight_of_more_than_two_hours_is_refused():
    legs = tuple(Waypoint((1000.0 * (i % 2), 0.0, 5.0), speed_max=1.0, item=i) for i in range(10))
    with pytest.raises(PlanError, match=r"item 8: the flight up to here takes 2\.2 h") as caught:
        require_an_end(legs, 12.0)
    assert caught.value.item == 8
