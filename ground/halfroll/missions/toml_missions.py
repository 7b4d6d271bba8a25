"""Our own mission format. Why: it says what items cannot: derivatives, attitudes, free places, manoeuvres, limits. The
autopilot stores the nearest items; the planner flies the waypoints.

Heights are above home. Metres lie around home, north, west and up. Angles are those of every ground station: roll right
wing down, pitch nose up, heading clockwise from north.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from halfroll.errors import MissionError
from halfroll.manoeuvres.library import AnyManoeuvre
from halfroll.missions.geodesy import DEFAULT_ORIGIN, GeoPoint, Vector, local_from_global
from halfroll.missions.mission import Fence, Mission, Quaternion, Rules, Waypoint, Yaw
from halfroll.missions.point_files import Entry, item_of_waypoint, mission_of_entries
from halfroll.reading import parse_toml
from halfroll.wire.frames import attitude_from_degrees, body_rate_from_degrees, heading_deg_to_yaw

Finite = Annotated[float, Field(allow_inf_nan=False)]
Triple = tuple[Finite, Finite, Finite]


class _Attitude(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    roll_deg: Annotated[float, Field(ge=-180, le=180, allow_inf_nan=False)] | None = None
    pitch_deg: Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False)] | None = None
    quaternion: tuple[Finite, Finite, Finite, Finite] | None = None
    thrust_N: Finite | None = None

    def q_WB(self, index: int, yaw: float) -> Quaternion:
        """Of a body whose heading is yaw, or the quaternion (w first, body to north-west-up) as it is given."""
        angles = self.roll_deg is not None or self.pitch_deg is not None
        if angles == (self.quaternion is not None):
            raise MissionError(
                f"waypoint {index}: its attitude needs either roll_deg and pitch_deg or a quaternion", index
            )
        if self.quaternion is None:
            return attitude_from_degrees(self.roll_deg or 0.0, self.pitch_deg or 0.0, yaw)
        size = math.hypot(*self.quaternion)
        if not 0.99 < size < 1.01:
            raise MissionError(f"waypoint {index}: its quaternion has length {size:.3g}, 1 is wanted", index)
        w, x, y, z = (part / size for part in self.quaternion)
        return w, x, y, z


class _Point(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    position_m: Triple | None = None
    lat_deg: Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False)] | None = None
    lon_deg: Annotated[float, Field(ge=-180, le=180, allow_inf_nan=False)] | None = None
    alt_m: Finite | None = None
    velocity_m_s: Triple | None = None
    acceleration_m_s2: Triple | None = None
    jerk_m_s3: Triple | None = None
    snap_m_s4: Triple | None = None
    direction: Triple | None = None
    attitude: _Attitude | None = None
    body_rate_deg_s: Triple | None = None
    upright: bool | None = None
    yaw_deg: Finite | None = None
    hold_s: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    speed_max_m_s: Annotated[float, Field(gt=0, allow_inf_nan=False)] | None = None
    time_s: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    free: tuple[Literal["position", "x", "y", "z"], ...] = ()

    @property
    def free_axes(self) -> tuple[bool, bool, bool]:
        x, y, z = ("position" in self.free or axis in self.free for axis in "xyz")
        return x, y, z

    @property
    def derivatives(self) -> tuple[Triple | None, ...]:
        return self.velocity_m_s, self.acceleration_m_s2, self.jerk_m_s3, self.snap_m_s4, self.direction

    @property
    def moves(self) -> bool:
        return self.attitude is not None or any(derivative and any(derivative) for derivative in self.derivatives)


class _Fence(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    keep: Literal["in", "out"]
    corners_m: Annotated[list[tuple[Finite, Finite]], Field(min_length=3)] | None = None
    corners_deg: Annotated[list[tuple[Finite, Finite]], Field(min_length=3)] | None = None


class _File(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str | None = None
    frame: Literal["local", "geodetic"] = "local"
    yaw: Literal["free", "given", "path"] | tuple[Finite, Finite] | None = None
    limits: dict[str, Annotated[float, Field(strict=True, allow_inf_nan=False)] | Literal["off"]] = {}
    fence: list[_Fence] = []
    waypoint: Annotated[list[_Point], Field(min_length=1)]
    manoeuvre: list[AnyManoeuvre] = []


def mission_from_toml(text: str, name: str) -> Mission:
    """Our own format: waypoints with optional derivatives, heading, hold and speed limit. Raises MissionError."""
    try:
        raw = parse_toml(text)
    except ValueError as error:
        raise MissionError(f"is not TOML: {error}") from None
    try:
        file = _File.model_validate(raw)
    except ValidationError as error:
        first = error.errors()[0]
        place = " ".join(str(part) for part in first["loc"])
        raise MissionError(f"{place}: {first['msg'].lower()} (it is {first['input']!r})") from None
    entries = list(_entries(file))
    if len(entries) < 2:
        raise MissionError("it has one waypoint and no manoeuvre, so nothing is flown; add one")
    anchor = DEFAULT_ORIGIN if file.frame == "geodetic" else None
    return replace(mission_of_entries(file.name or name, entries, anchor), rules=_rules(file, anchor))


def _entries(file: _File) -> Iterator[Entry]:
    """Waypoints in order, each followed by the manoeuvres that are flown there."""
    beyond = [one for one in file.manoeuvre if one.at >= len(file.waypoint)]
    if beyond:
        raise MissionError(
            f"manoeuvre {beyond[0].kind} is at waypoint {beyond[0].at}, the last one is {len(file.waypoint) - 1}"
        )
    number, yaw, upright = 0, 0.0, True
    for index, point in enumerate(file.waypoint):
        manoeuvres = [one for one in file.manoeuvre if one.at == index]
        at_end = index in (0, len(file.waypoint) - 1)
        _check_rest(index, point, at_end, bool(manoeuvres))
        if point.yaw_deg is not None:
            yaw += math.remainder(heading_deg_to_yaw(point.yaw_deg) - yaw, math.tau)  # the short way
        upright = upright if point.upright is None else point.upright
        if index == 0 and not upright:
            raise MissionError("waypoint 0: a flight begins upright; turn over at a later waypoint", 0)
        waypoint = _waypoint(index, point, file, yaw, upright)
        if manoeuvres and index > 0 and not waypoint.hold_s:
            waypoint = waypoint.standing
        waypoint = replace(waypoint, item=number)
        yield Entry((waypoint,), number, item_of_waypoint(waypoint))
        number += 1
        for manoeuvre in manoeuvres:
            flown = manoeuvre.waypoints(waypoint)
            for item, passed in manoeuvre.entries(flown):
                yield Entry(tuple(replace(one, item=number) for one in passed), number, item)
                number += 1
            waypoint = flown[-1]
        upright = waypoint.upright


def _waypoint(index: int, point: _Point, file: _File, yaw: float, upright: bool) -> Waypoint:
    rates = point.body_rate_deg_s
    try:
        return Waypoint(
            _guess(index, file) if all(point.free_axes) else _position(index, point, file.frame),
            velocity=point.velocity_m_s,
            acceleration=point.acceleration_m_s2,
            jerk=point.jerk_m_s3,
            snap=point.snap_m_s4,
            yaw=yaw,
            hold_s=point.hold_s,
            speed_max=point.speed_max_m_s,
            time_s=point.time_s,
            free=point.free_axes,
            q_WB=None if point.attitude is None else point.attitude.q_WB(index, yaw),
            thrust=None if point.attitude is None else point.attitude.thrust_N,
            body_rate=None if rates is None else body_rate_from_degrees(rates),
            direction=None if point.direction is None else _unit(index, point.direction),
            upright=upright,
        )
    except MissionError as error:
        if error.item is not None:
            raise
        raise MissionError(f"waypoint {index}: {error}", index) from None


def _unit(index: int, vector: Triple) -> Vector:
    size = math.hypot(*vector)
    if size == 0.0:
        raise MissionError(f"waypoint {index}: its direction is 0, 0, 0: no direction; give another", index)
    x, y, z = (part / size for part in vector)
    return x, y, z


def _rules(file: _File, anchor: GeoPoint | None) -> Rules:
    fences = []
    for number, fence in enumerate(file.fence, start=1):
        wanted = "corners_m" if file.frame == "local" else "corners_deg"
        if getattr(fence, wanted) is None or (fence.corners_m and fence.corners_deg):
            raise MissionError(f"fence {number} needs {wanted} alone, for frame is {file.frame}")
        corners = fence.corners_m or [
            local_from_global(DEFAULT_ORIGIN, GeoPoint(lat_deg, lon_deg, DEFAULT_ORIGIN.alt))[:2]
            for lat_deg, lon_deg in fence.corners_deg or ()
        ]
        fences.append(Fence(fence.keep == "in", tuple(corners), f"fence {number}"))
    limits = tuple((name, None if number == "off" else number) for name, number in file.limits.items())
    yaw = Yaw("point", file.yaw) if isinstance(file.yaw, tuple) else Yaw(file.yaw) if file.yaw else None
    return Rules(tuple(fences), limits, yaw, anchor)


def _guess(index: int, file: _File) -> Vector:
    """Of a free position: between the nearest points before and after that have one."""
    if index in (0, len(file.waypoint) - 1):
        raise MissionError(f"waypoint {index} is first or last, so its position cannot be free; give it", index)
    if (point := file.waypoint[index]).position_m or point.lat_deg is not None:
        return _position(index, point, file.frame)
    known = [i for i, other in enumerate(file.waypoint) if not all(other.free_axes)]
    before, after = max((i for i in known if i < index), default=0), min((i for i in known if i > index), default=-1)
    start, end = (_position(i, file.waypoint[i], file.frame) for i in (before, after))
    share = (index - before) / ((after % len(file.waypoint)) - before)
    x, y, z = (a + share * (b - a) for a, b in zip(start, end, strict=True))
    return x, y, z


def _position(index: int, point: _Point, frame: str) -> Vector:
    geodetic = (point.lat_deg, point.lon_deg, point.alt_m)
    if frame == "local":
        if point.position_m is None or geodetic != (None, None, None):
            raise MissionError(f"waypoint {index} needs position_m alone, for frame is local", index)
        return point.position_m
    if point.position_m or point.lat_deg is None or point.lon_deg is None or point.alt_m is None:
        raise MissionError(f"waypoint {index} needs lat_deg, lon_deg and alt_m alone, for frame is geodetic", index)
    return local_from_global(DEFAULT_ORIGIN, GeoPoint(point.lat_deg, point.lon_deg, DEFAULT_ORIGIN.alt + point.alt_m))


def _check_rest(index: int, point: _Point, at_end: bool, manoeuvres: bool) -> None:
    if point.moves and at_end:
        raise MissionError(f"waypoint {index} is first or last, so it is at rest; take its derivatives out", index)
    if point.moves and manoeuvres:
        raise MissionError(f"waypoint {index} moves, and a manoeuvre begins there at rest; take one of them out", index)
    if point.moves and point.hold_s:
        raise MissionError(
            f"waypoint {index} holds for {point.hold_s:g} s and moves at the same time; take one of them out", index
        )
