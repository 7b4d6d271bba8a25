"""A mission: the items an autopilot stores, and the waypoints a planner sees.

Why: files, MAVLink and the planner meet in these values; they are valid once built. What the items mean is in
mission_items.py (the table), mission_check.py (what the autopilot refuses) and course.py (what the planner flies).
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from halfroll.errors import MissionError
from halfroll.geodesy import GeoPoint, Vector

__all__ = ["CAPACITY", "NOT_GIVEN", "GeoPoint", "Mission", "MissionItem", "PlanMode", "Vector", "Waypoint"]

PlanMode = Literal["paper", "fast", "best"]  # how near the least time a mission is planned
CAPACITY = 2000  # items the autopilot stores
NOT_GIVEN = 2**31 - 1  # MAVLink's "no latitude, no longitude": here


@dataclass(frozen=True, eq=False)
class MissionItem:
    """One item as MAVLink carries it (MISSION_ITEM_INT); the sequence number is its place in the list.

    Params and z are rounded to the wire's float32, so an item from a file equals the one that comes back from the
    autopilot (NaN equals NaN). Whether the autopilot accepts it is another question: mission_check.py. Raises
    MissionError for what the wire cannot carry.
    """

    command: int
    frame: int
    params: tuple[float, float, float, float]  # p1..p4, NaN allowed
    x: int  # latitude and longitude as on the wire, NOT_GIVEN allowed; unscaled in frame 2
    y: int
    z: float
    autocontinue: bool = True

    def __post_init__(self) -> None:
        _require(0 <= self.command <= 0xFFFF, f"command {self.command} is not in 0..65535")
        _require(0 <= self.frame <= 0xFF, f"frame {self.frame} is not in 0..255")
        _require(len(self.params) == 4, f"{len(self.params)} params, an item has 4 before its position")
        for name, integer in (("x", self.x), ("y", self.y)):
            _require(-(2**31) <= integer < 2**31, f"{name} = {integer} is more than 32 bits: no latitude or longitude")
        first, second, third, fourth = (_float32(f"param {i}", p) for i, p in enumerate(self.params, start=1))
        object.__setattr__(self, "params", (first, second, third, fourth))
        object.__setattr__(self, "z", _float32("height", self.z))

    def _key(self) -> tuple[object, ...]:
        floats = (None if math.isnan(f) else f for f in (*self.params, self.z))
        return (self.command, self.frame, *floats, self.x, self.y, self.autocontinue)

    def __eq__(self, other: object) -> bool:
        return self._key() == other._key() if isinstance(other, MissionItem) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key())


def _float32(name: str, number: float) -> float:
    try:
        return float(struct.unpack("<f", struct.pack("<f", number))[0])
    except OverflowError:
        raise MissionError(f"{name} is {number:g}, more than MAVLink's 32-bit floats hold") from None


def _require(holds: bool, why: str) -> None:
    if not holds:
        raise MissionError(why)


@dataclass(frozen=True)
class Waypoint:
    """A point the planned trajectory passes, in W (north-west-up, metres from the local origin, radians).

    A derivative that is None is free (continuous); a given one is fixed at the passage. The first and the last
    waypoint of a plan, and any with hold_s > 0, are passed at rest.
    """

    position: Vector
    velocity: Vector | None = None
    acceleration: Vector | None = None
    jerk: Vector | None = None
    snap: Vector | None = None
    yaw: float = 0.0
    hold_s: float = 0.0  # wait here, at rest
    speed_max: float | None = None  # [m/s] from here to the next waypoint; None: the vehicle's
    item: int | None = None  # sequence number of the mission item it comes from, for messages and progress

    def __post_init__(self) -> None:
        for name in ("position", "velocity", "acceleration", "jerk", "snap"):
            vector = getattr(self, name)
            good = vector is None or (len(vector) == 3 and all(map(math.isfinite, vector)))
            _require(good, f"{name} {vector} is not three finite numbers")
        _require(math.isfinite(self.yaw), f"yaw is {self.yaw}, a heading is wanted")
        _require(math.isfinite(self.hold_s) and self.hold_s >= 0, f"hold is {self.hold_s} s, it must be 0 or more")
        _require(self.speed_max is None or self.speed_max > 0, f"speed limit is {self.speed_max} m/s, not above 0")


@dataclass(frozen=True)
class Mission:
    """What a person wants flown.

    `items` is what is uploaded. `waypoints` is there only when the file says more than items can (velocities, positions
    finer than the wire's 1.1 cm); then it is what the planner flies: metres north and west of `anchor` and above home.
    """

    name: str
    items: tuple[MissionItem, ...]
    planned_home: GeoPoint | None = None
    source: Path | None = None
    waypoints: tuple[Waypoint, ...] | None = None
    anchor: GeoPoint | None = None  # of `waypoints`; None: home, wherever that is
    warnings: tuple[str, ...] = ()  # what the file holds that is not flown

    def __post_init__(self) -> None:
        _require(len(self.items) > 0, f"mission {self.name!r} has no items: nothing to fly")
        _require(
            len(self.items) <= CAPACITY,
            f"mission {self.name!r} has {len(self.items)} items, the autopilot stores {CAPACITY}: split it",
        )
        for waypoint in self.waypoints or ():
            _require(
                waypoint.item is not None and 0 <= waypoint.item < len(self.items),
                f"waypoint at {waypoint.position} names item {waypoint.item}, which is not in the mission",
            )
