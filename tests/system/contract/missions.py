"""Items and missions that the contract's tests send, and what is read of the answers."""

from __future__ import annotations

import math
import struct
from typing import Any

from system.contract.aircraft import ORIGIN_LAT, ORIGIN_LON, B, Client, Item

OK, ERROR, UNSUPPORTED, NO_SPACE, INVALID_SEQUENCE, DENIED, CANCELLED = 0, 1, 3, 4, 13, 14, 15  # MAV_MISSION_RESULT
P1 = 6  # MAV_MISSION_INVALID_PARAM1
FENCE, RALLY, ALL = 1, 2, 255  # MAV_MISSION_TYPE

DEGE7_PER_M = 1e7 / 111_195.0  # north; near enough to place things


def item(
    command: int,
    *params: float,
    frame: int = 3,
    north: float = 0.0,
    east: float = 0.0,
    z: float = 10.0,
    x: int | None = None,
    y: int | None = None,
) -> Item:
    """At a place near the origin [m]; params not given are 0."""
    p1, p2, p3, p4 = (*params, *[0.0] * (4 - len(params)))
    lat = round(ORIGIN_LAT + north * DEGE7_PER_M) if x is None else x
    lon = round(ORIGIN_LON + east * DEGE7_PER_M / 0.677) if y is None else y
    return frame, command, 1, (p1, p2, p3, p4), lat, lon, z


def away(command: int, *params: float) -> Item:
    """An item without a place."""
    return item(command, *params, frame=2, x=0, y=0, z=0.0)


def waypoint(north: float, east: float = 0.0, z: float = 10.0, hold_s: float = 0.0) -> Item:
    return item(16, hold_s, north=north, east=east, z=z)


TAKEOFF_ITEM = item(22, z=10.0)
LAND_ITEM = item(21)
RTL_ITEM = away(20)
LINE: list[Item] = [TAKEOFF_ITEM, waypoint(20.0), waypoint(40.0), waypoint(60.0), RTL_ITEM]
FLIP = away(31010, 1, 1, math.nan, math.nan)
# Commands stored and passed over: nothing is fitted to obey them.
SKIPPED = [195, 197, 201, 203, 204, 205, 206, 214, 181, 183, 187, 211, 530, 531, 532, 1000, 1001]
SKIPPED += [2000, 2001, 2500, 2501]


def bits(each: Item) -> tuple[object, ...]:
    """Comparable in every bit, NaN included."""
    frame, command, autocontinue, params, x, y, z = each
    return frame, command, autocontinue, struct.pack("<5f", *params, z), x, y


def other(client: Client) -> Client:
    """Another ground control station on the same link."""
    return client.aircraft.client(B, slot=1, system=250)


def acks(answers: list[Any]) -> list[int]:
    return [m.type for m in answers if m.get_type() == "MISSION_ACK"]


def kinds(answers: list[Any]) -> list[str]:
    return [m.get_type() for m in answers]
