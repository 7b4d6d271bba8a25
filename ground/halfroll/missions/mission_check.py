"""What the autopilot would refuse, item by item. Why: an upload stops at the first bad item; a person wants to hear of
all of them, before flying. The rules are the autopilot's: what it answers at upload, then what it finds at the start.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum, IntEnum

from halfroll.missions.geodesy import DEFAULT_ORIGIN, GeoPoint, local_from_global
from halfroll.missions.mission import NOT_GIVEN, MissionItem
from halfroll.missions.mission_items import (
    ABSOLUTE_FRAMES,
    HOME_FRAMES,
    NO_POSITION_FRAME,
    TABLE,
    Command,
    ItemKind,
    Place,
    command_name,
    first_flown,
    is_here,
)
from halfroll.wire.frames import degrees_from_wire

DISTANCE_MAX = 5000.0  # [m] MIS_DIST_1WP
ALTITUDE_MAX = 500.0  # [m] MIS_ALT_MAX
_DEPTH_MAX = 100.0  # [m] lowest height "above home" that is accepted at upload


class Result(IntEnum):
    """MAV_MISSION_RESULT"""

    UNSUPPORTED_FRAME = 2
    UNSUPPORTED = 3
    INVALID_PARAM1 = 6
    INVALID_PARAM2 = 7
    INVALID_PARAM3 = 8
    INVALID_PARAM4 = 9
    INVALID_PARAM5_X = 10
    INVALID_PARAM6_Y = 11
    INVALID_PARAM7 = 12


class Severity(str, Enum):
    UPLOAD = "refused at upload"
    START = "refused at start"
    NOTE = "not flown"


@dataclass(frozen=True)
class Finding:
    """One thing about one item that a person should know. `why` is a sentence with the way out."""

    index: int
    command: int
    why: str
    severity: Severity
    result: Result | None = None  # of the upload

    @property
    def is_error(self) -> bool:
        return self.severity is not Severity.NOTE

    def __str__(self) -> str:
        return f"item {self.index} ({command_name(self.command)}): {self.why}"


def check_items(
    items: tuple[MissionItem, ...],
    home: GeoPoint = DEFAULT_ORIGIN,
    *,
    seq0_home: int = 2,
    distance_max: float = DISTANCE_MAX,
    altitude_max: float = ALTITUDE_MAX,
) -> list[Finding]:
    """All that is wrong or not flown, in item order; `home` is where the vehicle will be armed.

    An item that is refused at upload is named once, with the result the autopilot would answer.
    """
    first = first_flown(items, seq0_home)
    findings = []
    near_checked = False
    circling = _circling(items, first)
    for index, item in enumerate(items):
        refusal = _upload_error(item, index < first, altitude_max) or _jump_error(items, index, circling)
        if refusal:
            result, why = refusal
            findings.append(Finding(index, item.command, why, Severity.UPLOAD, result))
            continue
        if index < first:
            continue
        kind = TABLE[item.command]
        if kind.ends_a_leg and kind.place is not Place.NONE and not is_here(item) and not near_checked:
            near_checked = True
            if (distance := _distance(home, item)) > distance_max:
                limit = f"at most {distance_max / 1000:g} km are allowed"
                why = f"it is {distance / 1000:.1f} km from home, {limit}; move it to where the vehicle is"
                findings.append(Finding(index, item.command, why, Severity.START))
        if low_or_high := _height_error(item, kind, home, altitude_max):
            findings.append(Finding(index, item.command, low_or_high, Severity.START))
        if kind.not_flown:
            findings.append(Finding(index, item.command, kind.not_flown, Severity.NOTE))
    return findings


def _upload_error(item: MissionItem, is_home: bool, altitude_max: float) -> tuple[Result, str] | None:
    """The first error of one item, in the autopilot's order."""
    kind = TABLE.get(item.command)
    if kind is None:
        return Result.UNSUPPORTED, f"{command_name(item.command)} is not supported; take it out of the mission"
    if item.frame not in kind.frames or (item.frame == NO_POSITION_FRAME and kind.place_of(item) is Place.REQUIRED):
        allowed = ", ".join(map(str, kind.frames))
        return (
            Result.UNSUPPORTED_FRAME,
            f"frame {item.frame} is not supported here; use one of {allowed} (3: above home)",
        )
    for number, (rule, value) in enumerate(zip(kind.params, item.params, strict=True), start=1):
        if complaint := rule.complaint(value) or _half_attitude(item, number):
            return Result(Result.INVALID_PARAM1 + number - 1), f"param {number}, {complaint}"
    return next(_place_errors(item, kind, is_home, altitude_max), None)


def _half_attitude(item: MissionItem, number: int) -> str | None:
    if item.command != Command.WAYPOINT_USER_1 or number > 2:
        return None
    alone = math.isnan(item.params[number - 1]) and not math.isnan(item.params[2 - number])
    return "roll and pitch are given together or not at all" if alone else None


def _place_errors(
    item: MissionItem, kind: ItemKind, is_home: bool, altitude_max: float
) -> Iterator[tuple[Result, str]]:
    place = kind.place_of(item)
    required = place is Place.REQUIRED
    if place is Place.ZERO:
        for result, angle in ((Result.INVALID_PARAM5_X, item.x), (Result.INVALID_PARAM6_Y, item.y)):
            if angle != 0:
                yield result, "it has no position, so latitude and longitude must be 0; clear them"
    if required or (place is Place.OPTIONAL and not is_here(item)):
        lat_deg, lon_deg = degrees_from_wire(item.x), degrees_from_wire(item.y)
        if abs(lat_deg) > 90:
            given = abs(item.x) < NOT_GIVEN
            what = f"latitude {lat_deg:g} is beyond 90 degrees" if given else "its latitude is not given"
            yield Result.INVALID_PARAM5_X, f"{what}; set its position"
        if required and item.x == 0 and item.y == 0 and not (is_home and item.frame == 0):
            yield Result.INVALID_PARAM5_X, "latitude and longitude are both 0; set its position"
        if abs(lon_deg) > 180:
            given = abs(item.y) < NOT_GIVEN
            what = f"longitude {lon_deg:g} is beyond 180 degrees" if given else "its longitude is not given"
            yield Result.INVALID_PARAM6_Y, f"{what}; set its position"
    if place in (Place.NONE, Place.ZERO) or kind.any_height:
        return
    if math.isinf(item.z) or (required and math.isnan(item.z)):
        yield Result.INVALID_PARAM7, "its height is not given; set it"
    if item.frame in HOME_FRAMES:
        if item.z > altitude_max:
            yield Result.INVALID_PARAM7, f"{item.z:g} m above home is over the limit of {altitude_max:g} m; lower it"
        if item.z < -_DEPTH_MAX:
            yield Result.INVALID_PARAM7, f"{-item.z:g} m below home is under the limit of {_DEPTH_MAX:g} m; raise it"


def _jump_error(items: tuple[MissionItem, ...], index: int, circling: set[int]) -> tuple[Result, str] | None:
    if items[index].command != Command.DO_JUMP:
        return None
    target = int(items[index].params[0])
    if target >= len(items):
        return Result.INVALID_PARAM1, f"it jumps to item {target}, the last one is {len(items) - 1}"
    if index in circling:
        return Result.INVALID_PARAM1, f"jumping to item {target} goes round without a position to fly to; add one"
    return None


def _circling(items: tuple[MissionItem, ...], first: int) -> set[int]:
    """Items from which jumps can come back without having flown anywhere.

    Struck out, again and again, is every item where time must pass: places, ends, and what only leads to such.
    """
    circling = set(range(len(items)))
    struck = True
    while struck:
        struck = False
        for index in sorted(circling, reverse=True):  # backwards: without jumps, one round is enough
            flies = index >= first and _takes_time(items[index])
            if flies or not circling & _successors(items, index):
                circling.remove(index)
                struck = True
    return circling


def _takes_time(item: MissionItem) -> bool:
    kind = TABLE.get(item.command)
    return kind is not None and kind.ends_a_leg


def _successors(items: tuple[MissionItem, ...], index: int) -> set[int]:
    item = items[index]
    target, repeats = item.params[:2]
    jumps = item.command == Command.DO_JUMP and repeats != 0 and math.isfinite(target)
    return {index + 1, int(target)} if jumps else {index + 1}


def _distance(home: GeoPoint, item: MissionItem) -> float:
    point = GeoPoint(degrees_from_wire(item.x), degrees_from_wire(item.y), home.alt)
    return math.hypot(*local_from_global(home, point))


def _height_error(item: MissionItem, kind: ItemKind, home: GeoPoint, altitude_max: float) -> str | None:
    if not kind.ends_a_leg or kind.place is Place.NONE or kind.any_height or math.isnan(item.z):
        return None
    above_home = item.z - home.alt if item.frame in ABSOLUTE_FRAMES else item.z
    frame = f"{item.z:g} m above sea level is " if item.frame in ABSOLUTE_FRAMES else ""
    if above_home < 0:
        return f"{frame}{-above_home:g} m below home; raise it or use heights above home (frame 3)"
    if above_home > altitude_max:
        return f"{frame}{above_home:g} m above home, at most {altitude_max:g} m are allowed; lower it"
    return None
