"""Lists of points as missions: CSV and KML. Why: these say where to fly but not in items; here they become a
Mission that the autopilot stores, and keep what items cannot say as waypoints.

Heights are above home unless a KML says absolute. Points in metres lie around home; their items are placed around the
default origin.
"""

from __future__ import annotations

import csv
import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from halfroll.errors import MissionError
from halfroll.missions.geodesy import DEFAULT_ORIGIN, GeoPoint, global_from_local
from halfroll.missions.mission import Mission, MissionItem, Waypoint
from halfroll.missions.mission_items import Command
from halfroll.wire.frames import attitude_to_degrees, degrees_to_wire, heading_deg_to_yaw, yaw_to_heading_deg

_ABOVE_HOME, _ABSOLUTE = 3, 0
_LEAST_TAKEOFF = 0.5  # [m] a first point lower than this is not where a takeoff ends


@dataclass(frozen=True)
class Entry:
    """One item of a mission, and the waypoints that are flown for it."""

    waypoints: tuple[Waypoint, ...]
    number: int
    item: MissionItem


def mission_of_entries(
    name: str, entries: Sequence[Entry], anchor: GeoPoint | None, warnings: tuple[str, ...] = ()
) -> Mission:
    """Waypoints around home, and their items: the first is where the takeoff ends."""
    for before, entry in pairwise(entries):
        here, there = before.waypoints[-1], entry.waypoints[0]
        if math.dist(here.position, there.position) < 1e-3 and not any(here.free + there.free):
            raise MissionError(
                f"waypoint {entry.number} is where the one before is; take one of them out", entry.number
            )
    waypoints = tuple(waypoint for entry in entries for waypoint in entry.waypoints)
    items = tuple(entry.item for entry in entries)
    return Mission(name, items, DEFAULT_ORIGIN, waypoints=waypoints, anchor=anchor, warnings=warnings)


def item_of_waypoint(point: Waypoint) -> MissionItem:
    """The nearest item to what a waypoint says; the first one ends the takeoff. Raises MissionError."""
    index = point.item or 0
    lat_deg, lon_deg, _ = global_from_local(DEFAULT_ORIGIN, point.position)
    takeoff = index == 0 and point.position[2] >= _LEAST_TAKEOFF
    heading_deg = yaw_to_heading_deg(point.yaw)
    params = (0.0 if takeoff else point.hold_s, 0.0, 0.0, heading_deg)
    command = Command.TAKEOFF if takeoff else Command.WAYPOINT
    if point.q_WB is not None:
        roll_deg, pitch_deg, heading_deg = attitude_to_degrees(point.q_WB)
        speed = math.nan if point.velocity is None else math.hypot(*point.velocity)
        command, params = Command.WAYPOINT_USER_1, (roll_deg, pitch_deg, speed, heading_deg)
    return _item(index, command, _ABOVE_HOME, params, lat_deg, lon_deg, point.position[2])


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
    if {"sigma", "thrust_N"} <= set(columns):
        raise MissionError("it holds the samples of a plan, not waypoints; the plan itself is in the .json beside it")
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
    entries = [Entry((point,), number, item_of_waypoint(point)) for number, point in enumerate(waypoints)]
    return mission_of_entries(name, entries, None, warnings)


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
        root = ET.fromstring(text, ET.XMLParser(target=_WithoutDoctype()))
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


class _WithoutDoctype(ET.TreeBuilder):
    """No KML has a document type; one could define entities that grow a thousandfold, or name other files."""

    def doctype(self, *_: object) -> None:
        raise MissionError("it has a DOCTYPE, which no KML has; take it out")


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
