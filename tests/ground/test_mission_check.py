"""Every rule of the item table, and that all bad items are named, not only the first."""

from __future__ import annotations

import math

import pytest

from halfroll.missions.geodesy import DEFAULT_ORIGIN, GeoPoint
from halfroll.missions.mission import NOT_GIVEN, MissionItem
from halfroll.missions.mission_check import Finding, Result, Severity, check_items
from halfroll.missions.mission_items import TABLE, first_flown

NAN, INF = math.nan, math.inf
LAT, LON = 473977420, 85455940


def item(command: int, *params: float, frame: int = 3, x: int = LAT, y: int = LON, z: float = 10.0) -> MissionItem:
    p1, p2, p3, p4 = (*params, *[0.0] * (4 - len(params)))
    return MissionItem(command, frame, (p1, p2, p3, p4), x, y, z)


TAKEOFF, WAYPOINT = item(22), item(16)


def only(bad: MissionItem, home: GeoPoint = DEFAULT_ORIGIN) -> list[Finding]:
    """Findings about one item between a takeoff and a waypoint."""
    return [finding for finding in check_items((TAKEOFF, bad, WAYPOINT), home) if finding.index == 1]


@pytest.mark.parametrize(
    ("bad", "result"),
    [
        (item(18), Result.UNSUPPORTED),
        (item(84, frame=99), Result.UNSUPPORTED),  # the command is looked at before the frame
        (item(16, frame=1), Result.UNSUPPORTED_FRAME),
        (item(16, frame=2), Result.UNSUPPORTED_FRAME),
        (item(16, frame=10), Result.UNSUPPORTED_FRAME),
        (item(31010, 1, 1, frame=3), Result.UNSUPPORTED_FRAME),
        (item(16, -1), Result.INVALID_PARAM1),
        (item(16, NAN), Result.INVALID_PARAM1),
        (item(16, INF), Result.INVALID_PARAM1),
        (item(16, 0, -2), Result.INVALID_PARAM2),
        (item(16, 0, 0, 1), Result.INVALID_PARAM3),
        (item(16, 0, 0, 0, INF), Result.INVALID_PARAM4),
        (item(82, 0, 0, 0, 90), Result.INVALID_PARAM4),
        (item(31000, 181, 0, 0, 0), Result.INVALID_PARAM1),
        (item(31000, 0, 91, 0, 0), Result.INVALID_PARAM2),
        (item(31000, NAN, 0, 0, 0), Result.INVALID_PARAM1),
        (item(31000, 0, NAN, 0, 0), Result.INVALID_PARAM2),
        (item(31000, 0, 0, -1, 0), Result.INVALID_PARAM3),
        (item(19, NAN), Result.INVALID_PARAM1),
        (item(22, 0, 1), Result.INVALID_PARAM2),
        (item(21, 0, 3), Result.INVALID_PARAM2),
        (item(20, 1, frame=2), Result.INVALID_PARAM1),
        (item(93, -2, frame=2), Result.INVALID_PARAM1),
        (item(115, NAN, frame=2), Result.INVALID_PARAM1),
        (item(177, 7, 1, frame=2), Result.INVALID_PARAM1),
        (item(177, 0.5, 1, frame=2), Result.INVALID_PARAM1),
        (item(177, 0, -2, frame=2), Result.INVALID_PARAM2),
        (item(177, 1, 1, frame=2), Result.INVALID_PARAM1),  # jumps to itself
        (item(178, 4, 5, frame=2), Result.INVALID_PARAM1),
        (item(178, 1, 0, frame=2), Result.INVALID_PARAM2),
        (item(178, 1, -3, frame=2), Result.INVALID_PARAM2),
        (item(210, 0.5, frame=2), Result.INVALID_PARAM1),
        (item(31010, 3, 1, frame=2), Result.INVALID_PARAM1),
        (item(31010, 1, 0.7, frame=2), Result.INVALID_PARAM2),
        (item(31010, 1, 0, frame=2), Result.INVALID_PARAM2),
        (item(31010, 1, 5.5, frame=2), Result.INVALID_PARAM2),
        (item(2000, INF, frame=2), Result.INVALID_PARAM1),
        (item(22, z=INF), Result.INVALID_PARAM7),
        (item(93, 1, frame=2), Result.INVALID_PARAM5_X),
        (item(93, 1, frame=2, x=0), Result.INVALID_PARAM6_Y),
        (item(179, 0, frame=2), Result.UNSUPPORTED_FRAME),
        (item(179, 0, z=NAN), Result.INVALID_PARAM7),
        (item(115, 90, 0, 2, frame=2), Result.INVALID_PARAM3),
        (item(31010, 1, 1, NAN, 0, frame=2), Result.INVALID_PARAM4),
        (item(178, 1, -1.5, frame=2), Result.INVALID_PARAM2),
        (item(21, 0, 0.5), Result.INVALID_PARAM2),
        (item(16, x=900000001), Result.INVALID_PARAM5_X),
        (item(16, x=0, y=0), Result.INVALID_PARAM5_X),
        (item(16, x=NOT_GIVEN), Result.INVALID_PARAM5_X),
        (item(16, y=-1800000001), Result.INVALID_PARAM6_Y),
        (item(16, z=NAN), Result.INVALID_PARAM7),
        (item(16, z=500.5), Result.INVALID_PARAM7),
        (item(16, z=-101), Result.INVALID_PARAM7),
        (item(22, z=501), Result.INVALID_PARAM7),
    ],
)
def test_a_bad_item_is_refused_with_the_result_of_the_autopilot(bad: MissionItem, result: Result) -> None:
    (finding,) = only(bad)
    assert (finding.severity, finding.result, finding.command) == (Severity.UPLOAD, result, bad.command)


@pytest.mark.parametrize(
    "good",
    [
        item(16, 2.5, 0.3, NAN, NAN),
        item(16, frame=0, z=500),
        item(82, 1),
        item(17, NAN, NAN, NAN, NAN),
        item(19, 10, 0, 25, 1),
        item(22, 15, 0, 0, NAN, z=NAN, x=0, y=0),
        item(22, NAN, NAN, NAN, NAN, x=NOT_GIVEN, y=NOT_GIVEN),
        item(22, x=-NOT_GIVEN - 1, y=-NOT_GIVEN - 1),
        item(21, z=NAN, x=0, y=0),
        item(21, z=-50),
        item(20, NAN, NAN, NAN, NAN, frame=2, z=NAN),
        item(93, -1, NAN, 12, 30, frame=2, x=0, y=0),
        item(177, 0, -1, frame=2),
        item(178, 1, -2, frame=3, x=0, y=0),
        item(189, frame=2),
        item(179, 1, frame=2),
    ],
)
def test_a_good_item_is_not_mentioned(good: MissionItem) -> None:
    assert only(good) == []


@pytest.mark.parametrize("command", [c for c, kind in TABLE.items() if kind.not_flown])
def test_what_is_stored_but_not_flown_is_a_note_not_an_error(command: int) -> None:
    params = (1.0, 0.5, NAN, NAN) if command == 31010 else (0.0, 0.0)
    (finding,) = only(item(command, *params, frame=3 if command == 31000 else 2))
    assert (finding.severity, finding.is_error) == (Severity.NOTE, False)


def test_every_bad_item_is_named_not_only_the_first() -> None:
    items = (TAKEOFF, item(18), WAYPOINT, item(16, -1), item(5000))
    assert [finding.index for finding in check_items(items)] == [1, 3, 4]


def test_a_finding_names_item_value_limit_and_way_out() -> None:
    (finding,) = only(item(16, z=612))
    assert str(finding) == "item 1 (WAYPOINT): 612 m above home is over the limit of 500 m; lower it"


@pytest.mark.parametrize(
    "loop",
    [
        (item(178, 1, 5, frame=2), item(177, 0, 2, frame=2), TAKEOFF),
        (item(177, 2, 2, frame=2), TAKEOFF, item(177, 0, -1, frame=2), WAYPOINT),  # over the takeoff, for ever
    ],
)
def test_a_jump_loop_without_a_position_is_refused(loop: tuple[MissionItem, ...]) -> None:
    assert Result.INVALID_PARAM1 in [finding.result for finding in check_items(loop)]


HOME_LINE = item(16, frame=0, x=0, y=0, z=0)


def test_item_0_is_home_exactly_when_it_is_an_absolute_waypoint_before_a_takeoff() -> None:
    assert first_flown((HOME_LINE, TAKEOFF)) == 1
    assert first_flown((item(16, frame=3), TAKEOFF)) == 0
    assert first_flown((HOME_LINE, WAYPOINT)) == 0
    assert first_flown((HOME_LINE,)) == 0
    assert first_flown((HOME_LINE, TAKEOFF), seq0_home=0) == 0
    assert first_flown((HOME_LINE, WAYPOINT), seq0_home=1) == 1


def test_a_home_line_may_be_at_0_0_and_is_not_judged_but_a_waypoint_there_is() -> None:
    assert check_items((HOME_LINE, TAKEOFF, WAYPOINT)) == []
    assert check_items((HOME_LINE, WAYPOINT))[0].result is Result.INVALID_PARAM5_X


def test_a_first_position_farther_than_5_km_is_refused_at_the_start_and_only_the_first() -> None:
    far = item(16, x=LAT + 500000)
    findings = check_items((item(22, x=0, y=0), far, far))
    assert [(finding.index, finding.severity) for finding in findings] == [(1, Severity.START)]
    assert "5.6 km" in findings[0].why


def test_a_height_above_sea_level_is_judged_above_home_at_the_start() -> None:
    (below,) = only(item(16, frame=0, z=100))
    assert (below.severity, "388 m below home" in below.why) == (Severity.START, True)
    (above,) = only(item(16, frame=0, z=1000))
    assert "512 m above home" in above.why
    assert only(item(16, frame=0, z=100), DEFAULT_ORIGIN._replace(alt=90.0)) == []


def test_a_longitude_that_is_not_given_is_called_so():
    (finding,) = only(item(16, y=NOT_GIVEN))
    assert finding.why == "its longitude is not given; set its position"
