"""Lists of points as missions: our TOML, CSV and KML. Why: these say where to fly but not in items; here they become a
Mission that the autopilot stores, and keep what items cannot say as waypoints.

Heights are above home unless a KML says absolute. Points in metres lie around home; their items are placed around the
default origin.
"""

from __future__ import annotations

import csv
import math
import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from halfroll.errors import MissionError
from halfroll.frames import degrees_to_wire, heading_deg_to_yaw, yaw_to_heading_deg
from halfroll.geodesy import DEFAULT_ORIGIN, GeoPoint, Vector, global_from_local, local_from_global
from halfroll.mission import Fence, Mission, MissionItem, Rules, Waypoint, Yaw
from halfroll.mission_items import Command

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_ABOVE_HOME, _ABSOLUTE = 3, 0
_LEAST_TAKEOFF = 0.5  # [m] a first point lower than this is not where a takeoff ends

# ---- TOML

Finite = Annotated[float, Field(allow_inf_nan=False)]
Triple = tuple[Finite, Finite, Finite]


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
        return self.velocity_m_s, self.acceleration_m_s2, self.jerk_m_s3, self.snap_m_s4


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
    waypoint: Annotated[list[_Point], Field(min_length=2)]


_NOT_YET = {"upright", "attitude"}  # in the format, not yet planned


def mission_from_toml(text: str, name: str) -> Mission:
    """Our own format: waypoints with optional derivatives, heading, hold and speed limit. Raises MissionError."""
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise MissionError(f"is not TOML: {error}") from None
    except RecursionError:
        raise MissionError("is nested too deeply to be a mission") from None
    points = raw.get("waypoint")
    for index, point in enumerate(points if isinstance(points, list) else []):
        if isinstance(point, dict) and (missing := sorted(_NOT_YET & point.keys())):
            raise MissionError(f"waypoint {index}: {missing[0]} cannot be flown yet; take it out", index)
    try:
        file = _File.model_validate(raw)
    except ValidationError as error:
        first = error.errors()[0]
        place = " ".join(str(part) for part in first["loc"])
        raise MissionError(f"{place}: {first['msg'].lower()} (it is {first['input']!r})") from None
    waypoints, yaw = [], 0.0
    for index, point in enumerate(file.waypoint):
        _check_rest(index, point, at_end=index in (0, len(file.waypoint) - 1))
        if point.yaw_deg is not None:
            yaw += math.remainder(heading_deg_to_yaw(point.yaw_deg) - yaw, math.tau)  # the short way
        position = _guess(index, file) if all(point.free_axes) else _position(index, point, file.frame)
        waypoints.append(
            Waypoint(
                position,
                velocity=point.velocity_m_s,
                acceleration=point.acceleration_m_s2,
                jerk=point.jerk_m_s3,
                snap=point.snap_m_s4,
                yaw=yaw,
                hold_s=point.hold_s,
                speed_max=point.speed_max_m_s,
                time_s=point.time_s,
                free=point.free_axes,
                item=index,
            )
        )
    anchor = DEFAULT_ORIGIN if file.frame == "geodetic" else None
    return replace(_mission_of_waypoints(file.name or name, waypoints, anchor), rules=_rules(file, anchor))


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


def _check_rest(index: int, point: _Point, at_end: bool) -> None:
    moving = any(derivative and any(derivative) for derivative in point.derivatives)
    if moving and at_end:
        raise MissionError(f"waypoint {index} is first or last, so it is at rest; take its derivatives out", index)
    if moving and point.hold_s:
        raise MissionError(
            f"waypoint {index} holds for {point.hold_s:g} s and moves at the same time; take one of them out", index
        )


def _mission_of_waypoints(
    name: str, waypoints: Sequence[Waypoint], anchor: GeoPoint | None, warnings: tuple[str, ...] = ()
) -> Mission:
    """Waypoints around home with one item each: the first is where the takeoff ends, the rest are passed."""
    for index, (here, there) in enumerate(pairwise(waypoints), start=1):
        if math.dist(here.position, there.position) < 1e-3 and not any(here.free + there.free):
            raise MissionError(f"waypoint {index} is where the one before is; take one of them out", index)
    items = []
    for index, point in enumerate(waypoints):
        lat_deg, lon_deg, _ = global_from_local(DEFAULT_ORIGIN, point.position)
        takeoff = index == 0 and point.position[2] >= _LEAST_TAKEOFF
        command = Command.TAKEOFF if takeoff else Command.WAYPOINT
        params = (0.0 if takeoff else point.hold_s, 0.0, 0.0, yaw_to_heading_deg(point.yaw))
        items.append(_item(index, command, _ABOVE_HOME, params, lat_deg, lon_deg, point.position[2]))
    return Mission(name, tuple(items), DEFAULT_ORIGIN, waypoints=tuple(waypoints), anchor=anchor, warnings=warnings)


def _item(
    index: int, command: int, frame: int, params: tuple[float, float, float, float], lat: float, lon: float, z: float
) -> MissionItem:
    try:
        return MissionItem(command, frame, params, degrees_to_wire(lat), degrees_to_wire(lon), z)
    except (MissionError, ValueError) as error:
        raise MissionError(f"point {index}: {error}", index) from None


# ---- CSV

_COLUMNS = {
    "lat": "lat", "latitude": "lat", "lon": "lon", "lng": "lon", "long": "lon", "longitude": "lon",
    "alt": "alt", "altitude": "alt", "height": "alt", "x": "x", "y": "y", "z": "z",
    "yaw": "yaw", "heading": "yaw", "hold": "hold",
}  # fmt: skip


def mission_from_csv(text: str, name: str) -> Mission:
    """Points under a header: lat,lon,alt (degrees, m above home) or x,y,z (m north, west, up from home).

    Columns yaw [deg, clockwise from north] and hold [s] are optional; further ones are named in a warning.
    """
    lines = text.strip().splitlines()
    header = lines[0] if lines else ""
    delimiter = next((mark for mark in (";", "\t") if mark in header), ",")
    try:
        table = [row for row in csv.reader(lines, delimiter=delimiter) if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise MissionError(f"is not CSV: {error}") from None
    columns, *rows = table or [[]]
    names = [_COLUMNS.get(_without_unit(column)) for column in columns]
    geodetic = {"lat", "lon", "alt"} <= set(names)
    if not geodetic and not {"x", "y", "z"} <= set(names):
        raise MissionError(f"its first line is {header!r}, a header with lat,lon,alt or x,y,z is wanted")
    warnings = tuple(
        f"column {column.strip()!r} is not used" for column, known in zip(columns, names, strict=True) if not known
    )
    points = [_row(index, names, row) for index, row in enumerate(rows)]
    if not points:
        raise MissionError("it has a header but no points")
    if geodetic:
        items = [
            _item(
                i,
                Command.WAYPOINT,
                _ABOVE_HOME,
                (p["hold"], 0.0, 0.0, p.get("yaw", math.nan)),
                p["lat"],
                p["lon"],
                p["alt"],
            )
            for i, p in enumerate(points)
        ]
        return Mission(name, tuple(items), warnings=warnings)
    waypoints, yaw = [], 0.0
    for index, point in enumerate(points):
        if "yaw" in point:
            yaw += math.remainder(heading_deg_to_yaw(point["yaw"]) - yaw, math.tau)
        position = (point["x"], point["y"], point["z"])
        waypoints.append(Waypoint(position, yaw=yaw, hold_s=point["hold"], item=index))
    return _mission_of_waypoints(name, waypoints, None, warnings)


def _without_unit(column: str) -> str:
    name = column.strip().lower()
    for unit in ("_deg", "_m", "_s"):
        name = name.removesuffix(unit)
    return name


def _row(index: int, names: Sequence[str | None], row: Sequence[str]) -> dict[str, float]:
    point = {"hold": 0.0}
    for column, cell in zip(names, row, strict=False):
        if column is None or (column in ("yaw", "hold") and not cell.strip()):
            continue
        try:
            point[column] = float(cell)
        except ValueError:
            raise MissionError(f"point {index}: {column} is {cell!r}, a number is wanted", index) from None
        if not math.isfinite(point[column]):
            raise MissionError(f"point {index}: {column} is {cell.strip()}, a finite number is wanted", index)
    missing = [column for column in names if column and column not in point and column not in ("yaw", "hold")]
    if missing:
        raise MissionError(f"point {index} has no {missing[0]}", index)
    return point


# ---- KML


def mission_from_kml(text: str, name: str) -> Mission:
    """The points of its lines, or of its placemarks where it has no line. Heights are above home unless absolute."""
    try:
        root = ET.fromstring(text)
    except ET.ParseError as error:
        line, column = error.position
        raise MissionError(f"is not KML: XML error at line {line}, column {column + 1}") from None
    shapes = [shape for tag in ("LineString", "Point") for shape in root.iter() if _tag(shape) == tag]
    lines = [shape for shape in shapes if _tag(shape) == "LineString"]
    points = [point for shape in lines or shapes for point in _coordinates(shape)]
    if not points:
        raise MissionError("it has no LineString or Point with coordinates; draw a path")
    if not any(alt for _, _, alt, _ in points):
        raise MissionError("its points have no heights; give the path an altitude, relative to the ground")
    items = [
        _item(i, Command.WAYPOINT, frame, (0.0, 0.0, 0.0, math.nan), lat, lon, alt)
        for i, (lat, lon, alt, frame) in enumerate(points)
    ]
    return Mission(name, tuple(items))


def _coordinates(shape: ET.Element) -> Iterator[tuple[float, float, float, int]]:
    inside = {_tag(child): (child.text or "").strip() for child in shape}
    frame = _ABSOLUTE if inside.get("altitudeMode") == "absolute" else _ABOVE_HOME
    for number, triple in enumerate(inside.get("coordinates", "").split()):
        try:
            lon, lat, *height = (float(part) for part in triple.split(","))
            (alt,) = height or [0.0]
        except ValueError:
            raise MissionError(f"point {number} is {triple!r}, longitude,latitude,height is wanted", number) from None
        if not all(map(math.isfinite, (lon, lat, alt))):
            raise MissionError(f"point {number} is {triple!r}, finite numbers are wanted", number)
        yield lat, lon, alt, frame


def _tag(element: ET.Element) -> str:
    return element.tag.rpartition("}")[2]
