"""A mission: the items an autopilot stores, and the waypoints a planner sees.

Why: files, MAVLink and the planner meet in these values; they are valid once built. What the items mean is in
mission_items.py (the table), mission_check.py (what the autopilot refuses) and course.py (what the planner flies).
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Literal

from halfroll.errors import InputError, MissionError
from halfroll.missions.geodesy import GeoPoint, Vector, local_from_global
from halfroll.vehicle import GRAVITY

__all__ = [
    "CAPACITY",
    "DEFAULT_OPTIONS",
    "NOT_GIVEN",
    "NO_RULES",
    "Demand",
    "Fence",
    "GeoPoint",
    "Mission",
    "MissionItem",
    "PlanMode",
    "PlanOptions",
    "Quaternion",
    "Rules",
    "Vector",
    "Waypoint",
    "Yaw",
]

Quaternion = tuple[float, float, float, float]
PlanMode = Literal["paper", "fast", "best"]  # how near the least time a mission is planned
LimitsKind = Literal["mission", "rotors"]
_FREE_FALL = 1e-6  # [m/s²]
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
    waypoint of a plan, and any with hold_s > 0, are passed at rest. An attitude fixes the acceleration but for the size
    of the thrust (Eq 28), body rates fix the jerk but for its part along the thrust (Eqs 15-17); both fix the yaw.
    """

    position: Vector
    velocity: Vector | None = None
    acceleration: Vector | None = None
    jerk: Vector | None = None
    snap: Vector | None = None
    yaw: float = 0.0
    hold_s: float = 0.0  # wait here, at rest
    speed_max: float | None = None  # [m/s] from here to the next waypoint; None: the vehicle's
    time_s: float | None = None  # arrive here at this time of the plan
    free: tuple[bool, bool, bool] = (False, False, False)  # axes of the position that are only a first guess
    item: int | None = None  # sequence number of the mission item it comes from, for messages and progress
    q_WB: Quaternion | None = None  # attitude here
    thrust: float | None = None  # [N] signed, along the body's z; None: with an attitude, whatever is best
    body_rate: Vector | None = None  # [rad/s] in B; with attitude and thrust
    direction: Vector | None = None  # unit vector of the velocity, at whatever speed is best
    upright: bool = True  # sigma from here on: False, the thrust axis points down

    def __post_init__(self) -> None:
        for name in ("position", "velocity", "acceleration", "jerk", "snap"):
            vector = getattr(self, name)
            good = vector is None or (len(vector) == 3 and all(map(math.isfinite, vector)))
            _require(good, f"{name} {vector} is not three finite numbers")
        for one, other, fix in _CONTRADICTIONS:
            _require(
                getattr(self, one) is None or getattr(self, other) is None,
                f"{_WORDS.get(one, one)} and {_WORDS.get(other, other)} are both given, and both fix "
                f"{fix}; take one out",
            )
        _require(self.thrust is None or self.q_WB is not None, "thrust is given without an attitude; give both")
        _require(
            self.body_rate is None or (self.q_WB is not None and self.thrust is not None),
            "body rates are given, and the jerk they need depends on attitude and thrust; give both, too",
        )
        moving = self.q_WB is not None or self.direction is not None
        _require(
            not (moving and self.hold_s), "it holds, at rest, where an attitude or a velocity is given; take one out"
        )
        _require(math.isfinite(self.yaw), f"yaw is {self.yaw}, a heading is wanted")
        _require(math.isfinite(self.hold_s) and self.hold_s >= 0, f"hold is {self.hold_s} s, it must be 0 or more")
        _require(self.speed_max is None or self.speed_max > 0, f"speed limit is {self.speed_max} m/s, not above 0")
        _require(
            self.time_s is None or (math.isfinite(self.time_s) and self.time_s >= 0),
            f"time of arrival is {self.time_s} s, it must be 0 or more",
        )

    @property
    def in_free_fall(self) -> bool:
        """Its acceleration is gravity's: the thrust passes through zero here."""
        a = self.acceleration
        return a is not None and math.hypot(a[0], a[1], a[2] + GRAVITY) < _FREE_FALL

    @property
    def standing(self) -> Waypoint:
        """At rest here."""
        return replace(self, velocity=_STILL, acceleration=_STILL, jerk=_STILL, snap=_STILL)

    @property
    def stands(self) -> bool:
        """Velocity to snap are all given as zero."""
        derivatives = (self.velocity, self.acceleration, self.jerk, self.snap)
        return all(derivative is not None and not any(derivative) for derivative in derivatives)


@dataclass(frozen=True)
class Demand:
    """What a flip asks of its own flight. NaN: nothing."""

    item: int
    least_height: float  # [m] of W's z
    longest_s: float


_STILL: Vector = (0.0, 0.0, 0.0)
_WORDS = {"q_WB": "attitude", "body_rate": "body rate", "direction": "direction of velocity"}
_CONTRADICTIONS = (
    ("q_WB", "acceleration", "the acceleration"),
    ("body_rate", "jerk", "the jerk"),
    ("direction", "velocity", "the velocity"),
)


@dataclass(frozen=True)
class Fence:
    """A polygon that must not be left (keep_in), or not be entered. corners: any simple polygon, north and west [m]."""

    keep_in: bool
    corners: tuple[tuple[float, float], ...]
    name: str = "fence"

    def __post_init__(self) -> None:
        _require(len(self.corners) >= 3, f"{self.name} has {len(self.corners)} corners, a polygon has at least 3")
        _require(all(map(math.isfinite, (x for corner in self.corners for x in corner))), f"{self.name} is not finite")

    def moved(self, north: float, west: float) -> Fence:
        return replace(self, corners=tuple((x + north, y + west) for x, y in self.corners))


YawRule = Literal["free", "given", "path", "point"]
_YAW_IN_WORDS: tuple[YawRule, ...] = ("free", "given", "path")


@dataclass(frozen=True)
class Yaw:
    """Where the nose points between places of rest: anywhere (`free`: whatever is fastest), as the waypoints say
    (`given`), where it flies (`path`), or towards a point (north, west) in metres from home."""

    rule: YawRule = "free"
    point: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def parsed(cls, words: str) -> Yaw:
        """free, given, path, or NORTH,WEST. Raises MissionError."""
        for rule in _YAW_IN_WORDS:
            if words == rule:
                return cls(rule)
        try:
            north, west = (float(word) for word in words.split(","))
        except ValueError:
            raise MissionError(f"yaw {words!r} is not known; give free, given, path, or NORTH,WEST in metres") from None
        return cls("point", (north, west))


@dataclass(frozen=True)
class Rules:
    """What a mission asks of the flight between its points. Metres north and west of `anchor`, None being home."""

    fences: tuple[Fence, ...] = ()
    limits: tuple[tuple[str, float | None], ...] = ()  # by the names of limits.SETTABLE; None: off
    yaw: Yaw | None = None
    anchor: GeoPoint | None = None

    def in_world(self, origin: GeoPoint, home: GeoPoint) -> Rules:
        """With everything in W around origin."""
        north, west, _ = local_from_global(origin, self.anchor or home)
        yaw = self.yaw
        if yaw is not None and yaw.rule == "point":
            yaw = replace(yaw, point=(yaw.point[0] + north, yaw.point[1] + west))
        return replace(self, fences=tuple(f.moved(north, west) for f in self.fences), yaw=yaw, anchor=origin)


NO_RULES = Rules()


def limits_kind(name: str) -> LimitsKind:
    """Raises InputError for a name that is none."""
    if name == "mission":
        return "mission"
    if name == "rotors":
        return "rotors"
    raise InputError(f"limits {name!r} are not known; give mission or rotors")


@dataclass(frozen=True)
class PlanOptions:
    """How a mission is planned, whatever the mission."""

    mode: PlanMode = "paper"
    limits: LimitsKind = "mission"  # all of them, or rotor thrust alone
    margin: float | None = None  # share of rotor thrust kept free; None: 0.1 of a mission, 0 of rotors alone
    changes: tuple[tuple[str, float | None], ...] = ()  # as Rules.limits, which they overrule
    yaw: Yaw | None = None  # None: as the mission says; a point is in W

    @classmethod
    def of(
        cls,
        mode: PlanMode = "paper",
        limits: LimitsKind = "mission",
        margin: float | None = None,
        changes: Mapping[str, float | None] | None = None,
        yaw: str | None = None,
    ) -> PlanOptions:
        """As people give them: limits by name, yaw in words. Raises InputError."""
        if margin is not None and not 0.0 <= margin < 1.0:
            raise InputError(f"margin {margin:g} is no share of the rotors' thrust; give 0 or more and less than 1")
        asked_yaw = None if yaw is None else Yaw.parsed(yaw)
        return cls(mode, limits_kind(limits), margin, tuple((changes or {}).items()), asked_yaw)


DEFAULT_OPTIONS = PlanOptions()


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
    rules: Rules = NO_RULES
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

    def _repr_html_(self) -> str:
        """For a notebook."""
        return str(import_module("halfroll.results.cards").mission_card(self))
