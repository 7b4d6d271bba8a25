"""Mission files of ground stations, read and written. Why: a .plan, a WPL list, KML, CSV or TOML become one Mission
here, and nothing behind this module knows that formats differ.

QGC .plan (fileType Plan, mission version 2) and QGC WPL 110 are here; lists of points are in point_files.py, our own
TOML in toml_missions.py.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

from halfroll.errors import InputError, MissionError
from halfroll.missions.geodesy import DEFAULT_ORIGIN, GeoPoint, global_from_local, local_from_global
from halfroll.missions.mission import NOT_GIVEN, Fence, Mission, MissionItem, Rules
from halfroll.missions.mission_items import NO_POSITION_FRAME, Command, first_flown, is_here
from halfroll.missions.point_files import mission_from_csv, mission_from_kml
from halfroll.missions.toml_missions import mission_from_toml
from halfroll.reading import read_text
from halfroll.wire.frames import degrees_from_wire, degrees_to_wire

_WPL_HEADER = "QGC WPL"
_WPL_FIELDS = 12
_CIRCLE_CORNERS = 32


def load_mission(path: str | Path) -> Mission:
    """The mission in a file, whatever its format. Raises InputError; MissionError for what is inside.

    Numbers are checked for being numbers here; what the autopilot accepts is mission_check's to say.
    """
    path = Path(path)
    text = _read(path)
    start, suffix = text.lstrip()[:1], path.suffix.lower()
    try:
        if text.lstrip().startswith(_WPL_HEADER):
            mission = _from_waypoints(text, path.stem)
        elif suffix == ".toml":
            mission = mission_from_toml(text, path.stem)
        elif suffix == ".csv":
            mission = mission_from_csv(text, path.stem)
        elif suffix == ".kml" or start == "<":
            mission = mission_from_kml(text, path.stem)
        elif suffix in (".plan", ".json") or start == "{":
            mission = _from_plan(text, path.stem)
        elif suffix in (".waypoints", ".txt"):
            raise MissionError(f'first line is {text[:20].splitlines()[:1]}, "QGC WPL 110" is wanted')
        else:
            raise InputError(f"no mission format known for {suffix!r}; use .plan, .waypoints, .kml, .csv or .toml")
    except InputError as error:
        raise type(error)(f"{path}: {error}", error.item) from error
    return replace(mission, source=path)


def _read(path: Path) -> str:
    try:
        return read_text(path, "utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file; check the name") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, a mission file is wanted") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not a text file; use .plan, .waypoints, .kml (not .kmz), .csv or .toml") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error}); check its permissions") from None


# ---- QGroundControl .plan


def _from_plan(text: str, name: str) -> Mission:
    plan = _parsed(text)
    if plan.get("fileType") != "Plan":
        raise MissionError(f'fileType is {plan.get("fileType")!r}, "Plan" is wanted; save a plan in QGroundControl')
    _version(plan, "file", 1)
    content = plan.get("mission")
    if not isinstance(content, dict) or not isinstance(content.get("items"), list):
        raise MissionError("it has no mission.items list; save it as a plan in QGroundControl")
    _version(content, "mission", 2)
    simple = list(_simple_items(content["items"]))
    seq_of_id: dict[float, int] = {}
    for seq, raw in enumerate(simple):
        seq_of_id.setdefault(_number(raw.get("doJumpId", seq + 1), seq, "doJumpId"), seq)
    items = tuple(_plan_item(seq, raw, seq_of_id) for seq, raw in enumerate(simple))
    home, rules = _planned_home(content.get("plannedHomePosition")), _fences(plan.get("geoFence"))
    return Mission(name, items, home, warnings=tuple(_ignored(plan)), rules=rules)


def _fences(fence: Any) -> Rules:
    """Polygons and circles of a QGroundControl fence, which the planner obeys; a circle as a polygon of 32 corners."""
    if not isinstance(fence, dict):
        return Rules()
    polygons, circles = (_list(fence.get(what) or [], f"geoFence.{what}") for what in ("polygons", "circles"))
    rings: list[tuple[bool, list[GeoPoint]]] = []
    for number, polygon in enumerate(polygons, start=1):
        what = f"polygon {number} of the fence"
        if not isinstance(polygon, dict):
            raise MissionError(f"{what} is {polygon!r}, an object with corners is wanted")
        corners = _list(polygon.get("polygon"), what)
        rings.append((bool(polygon.get("inclusion", True)), [_corner(corner, what) for corner in corners]))
    for number, entry in enumerate(circles, start=1):
        what = f"circle {number} of the fence"
        circle = entry.get("circle") if isinstance(entry, dict) else None
        if not isinstance(circle, dict):
            raise MissionError(f"{what} has no circle; draw it again in QGroundControl")
        keep_in, radius = bool(entry.get("inclusion", True)), _number(circle.get("radius"), None, f"radius of {what}")
        centre = _corner(circle.get("center"), what)
        reach = radius if keep_in else radius / math.cos(math.pi / _CIRCLE_CORNERS)  # on the safe side of the circle
        angles = (2.0 * math.pi * i / _CIRCLE_CORNERS for i in range(_CIRCLE_CORNERS))
        rings.append(
            (keep_in, [global_from_local(centre, (reach * math.cos(a), reach * math.sin(a), 0.0)) for a in angles])
        )
    anchor = rings[0][1][0] if rings and rings[0][1] else None
    fences = []
    for number, (keep_in, ring) in enumerate(rings, start=1):
        local = (local_from_global(anchor or corner, corner) for corner in ring)
        fences.append(Fence(keep_in, tuple((n, w) for n, w, _ in local), f"fence {number}"))
    return Rules(tuple(fences), anchor=anchor)


def _list(entry: Any, what: str) -> list[Any]:
    if not isinstance(entry, list):
        raise MissionError(f"{what} is {entry!r}, a list is wanted")
    return entry


def _corner(entry: Any, what: str) -> GeoPoint:
    if not isinstance(entry, list) or len(entry) != 2:
        raise MissionError(f"{what}: a corner is {entry!r}, latitude and longitude are wanted")
    lat_deg, lon_deg = (_number(angle, None, what) for angle in entry)
    return GeoPoint(lat_deg, lon_deg, DEFAULT_ORIGIN.alt)


def _parsed(text: str) -> dict[str, Any]:
    def no_constant(name: str) -> NoReturn:
        raise MissionError(f"it contains {name}, which is no JSON number; write null for a value that is not given")

    try:
        plan = json.loads(text, parse_constant=no_constant)
    except json.JSONDecodeError as error:
        raise MissionError(f"is not JSON: {error.msg} at line {error.lineno}, column {error.colno}") from None
    except ValueError as error:  # an integer of thousands of digits
        raise MissionError(f"is not JSON: {error}") from None
    except RecursionError:
        raise MissionError("is nested too deeply to be a plan") from None
    if not isinstance(plan, dict):
        raise MissionError("is JSON but not a plan: an object {…} is wanted")
    return plan


def _version(holder: dict[str, Any], what: str, wanted: int) -> None:
    if holder.get("version") != wanted:
        raise MissionError(
            f"{what} version is {holder.get('version')!r}, only {wanted} is known; save it in a newer QGroundControl"
        )


def _simple_items(raw_items: list[Any]) -> Iterator[dict[str, Any]]:
    """Simple items in flight order; complex ones through the items QGroundControl stored in them."""
    seq = 0
    for raw in raw_items:
        kind = raw.get("type") if isinstance(raw, dict) else None
        if kind == "SimpleItem":
            stored: Any = [raw]
        elif kind == "ComplexItem":
            transect = raw.get("TransectStyleComplexItem")
            stored = transect.get("Items") if isinstance(transect, dict) else None
            if not isinstance(stored, list) or not all(isinstance(item, dict) for item in stored):
                raise MissionError(
                    f"item {seq} is a complex item ({raw.get('complexItemType')!r}) without stored items; "
                    "replace it by waypoints, or save a survey with QGroundControl",
                    seq,
                )
        else:
            raise MissionError(f"item {seq} has type {kind!r}, SimpleItem or ComplexItem is wanted", seq)
        yield from stored
        seq += len(stored)


def _plan_item(seq: int, raw: dict[str, Any], seq_of_id: dict[Any, int]) -> MissionItem:
    params = raw.get("params")
    if not isinstance(params, list) or len(params) != 7:
        raise MissionError(f"item {seq} needs a list of 7 params, it has {params!r}", seq)
    numbers = [
        math.nan if value is None else _number(value, seq, f"param {i}") for i, value in enumerate(params, start=1)
    ]
    command, frame = (_whole(raw.get(key), seq, key) for key in ("command", "frame"))
    if command == Command.DO_JUMP:
        target = seq_of_id.get(numbers[0])
        if target is None:
            raise MissionError(f"item {seq} (DO_JUMP) names doJumpId {numbers[0]:g}, which no item has", seq)
        numbers[0] = float(target)
    return _item(seq, command, frame, numbers, bool(raw.get("autoContinue", True)))


def _planned_home(raw: Any) -> GeoPoint | None:
    if not isinstance(raw, list) or len(raw) != 3 or any(value is None for value in raw[:2]):
        return None
    lat, lon, alt = (_number(0.0 if value is None else value, None, "plannedHomePosition") for value in raw)
    return GeoPoint(lat, lon, alt)


def _ignored(plan: dict[str, Any]) -> Iterator[str]:
    rally = plan.get("rallyPoints")
    if isinstance(rally, dict) and rally.get("points"):
        yield "the rally points of the plan are not used: return is to home"


def save_plan(path: str | Path, mission: Mission) -> None:
    """The items of a mission as a QGroundControl plan; loading it gives the same items."""
    home = mission.planned_home or DEFAULT_ORIGIN
    items = []
    for seq, item in enumerate(mission.items):
        params = list(_seven(item))
        if item.command == Command.DO_JUMP:
            params[0] += 1.0  # names a doJumpId, counted from 1
        items.append(
            {
                "autoContinue": item.autocontinue,
                "command": item.command,
                "doJumpId": seq + 1,
                "frame": item.frame,
                "params": [None if math.isnan(value) else value for value in params],
                "type": "SimpleItem",
            }
        )
    content = {
        "cruiseSpeed": 15,
        "firmwareType": 0,
        "globalPlanAltitudeMode": 1,
        "hoverSpeed": 5,
        "items": items,
        "plannedHomePosition": list(home),
        "vehicleType": 2,
        "version": 2,
    }
    plan = {
        "fileType": "Plan",
        "geoFence": {"circles": [], "polygons": _polygons(mission.rules, home), "version": 2},
        "groundStation": "QGroundControl",
        "mission": content,
        "rallyPoints": {"points": [], "version": 2},
        "version": 1,
    }
    Path(path).write_text(json.dumps(plan, indent=4) + "\n", encoding="utf-8")


def _polygons(rules: Rules, home: GeoPoint) -> list[dict[str, Any]]:
    polygons = []
    for fence in rules.fences:
        corners = (global_from_local(rules.anchor or home, (x, y, 0.0)) for x, y in fence.corners)
        ring = [[corner.lat_deg, corner.lon_deg] for corner in corners]
        polygons.append({"inclusion": fence.keep_in, "polygon": ring, "version": 1})
    return polygons


# ---- QGC WPL 110


def _from_waypoints(text: str, name: str) -> Mission:
    header, *lines = text.lstrip().splitlines()
    if header.split() != ["QGC", "WPL", "110"]:
        raise MissionError(f'first line is {header.strip()!r}, only "QGC WPL 110" is known; save it in that version')
    items: list[MissionItem] = []
    for number, line in enumerate(lines, start=2):
        if line.strip() and not line.lstrip().startswith("#"):
            items.append(_wpl_item(number, line.split(), len(items)))
    if not items:
        raise MissionError("it has no items after its first line")
    home, warnings = None, []
    if items[0].command == Command.WAYPOINT and items[0].frame == 0 and not is_here(items[0]):
        home = GeoPoint(degrees_from_wire(items[0].x), degrees_from_wire(items[0].y), items[0].z)
        if not first_flown(tuple(items)):
            warnings = ["line 0 (home) is flown as a waypoint, because item 1 is no TAKEOFF; add one"]
    return Mission(name, tuple(items), home, warnings=tuple(warnings))


def _wpl_item(number: int, fields: list[str], seq: int) -> MissionItem:
    if len(fields) != _WPL_FIELDS:
        raise MissionError(f"line {number} has {len(fields)} fields, an item has {_WPL_FIELDS}", seq)
    try:
        index, _, frame, command = (int(field) for field in fields[:4])
        numbers = [float(field) for field in fields[4:11]]
        autocontinue = bool(int(fields[11]))
    except ValueError as error:
        raise MissionError(f"line {number} (item {seq}): {error}", seq) from None
    if index != seq:
        raise MissionError(f"line {number} has index {index}, {seq} is next; number the items from 0 without gaps", seq)
    for place, value in enumerate(numbers, start=1):
        if math.isinf(value):
            raise MissionError(f"item {seq}: param {place} is infinite, a number or nan is wanted", seq)
    return _item(seq, command, frame, numbers, autocontinue)


def save_waypoints(path: str | Path, mission: Mission) -> None:
    """The items as QGC WPL 110. Line 0 is home: it is put before a mission that has none, and jumps are renumbered.

    Raises MissionError where the autopilot would fly that line: a home line needs a TAKEOFF after it.
    """
    items = mission.items
    if not first_flown(items):
        if items[0].command != Command.TAKEOFF:
            raise MissionError("line 0 of QGC WPL is home only before a TAKEOFF; add one first, or save a .plan", 0)
        lat_deg, lon_deg, alt = mission.planned_home or DEFAULT_ORIGIN
        home = MissionItem(Command.WAYPOINT, 0, (0.0,) * 4, degrees_to_wire(lat_deg), degrees_to_wire(lon_deg), alt)
        items = (home, *(_jumping(item, item.params[0] + 1) for item in items))
    lines = [f"{_WPL_HEADER} 110"]
    for seq, item in enumerate(items):
        numbers = "\t".join(repr(value) for value in _seven(item))
        lines.append(f"{seq}\t{int(seq == 0)}\t{item.frame}\t{item.command}\t{numbers}\t{int(item.autocontinue)}")
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


# ---- both


def _jumping(item: MissionItem, target: float) -> MissionItem:
    return replace(item, params=(target, *item.params[1:])) if item.command == Command.DO_JUMP else item


def _item(seq: int, command: int, frame: int, numbers: list[float], autocontinue: bool) -> MissionItem:
    p1, p2, p3, p4, lat, lon, z = numbers
    try:
        x, y = (_place(value, frame) for value in (lat, lon))
        return MissionItem(command, frame, (p1, p2, p3, p4), x, y, z, autocontinue)
    except (MissionError, ValueError) as error:
        raise MissionError(f"item {seq}: {error}", seq) from None


def _place(value: float, frame: int) -> int:
    """Param 5 or 6 as the wire's integer: degE7, except in frame 2, where it passes unscaled."""
    if math.isnan(value):
        return NOT_GIVEN
    return round(value) if frame == NO_POSITION_FRAME else degrees_to_wire(value)


def _seven(item: MissionItem) -> tuple[float, ...]:
    """p1..p7 as files have them, NaN where not given."""
    unscaled = item.frame == NO_POSITION_FRAME
    place = (math.nan if i == NOT_GIVEN else float(i) if unscaled else degrees_from_wire(i) for i in (item.x, item.y))
    return (*item.params, *place, item.z)


def _number(value: Any, seq: int | None, what: str) -> float:
    where = what if seq is None else f"item {seq}: {what}"
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise MissionError(f"{where} is {value!r}, a number or null is wanted", seq)
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise MissionError(f"{where} is infinite, a number or null is wanted", seq)
    return number


def _whole(value: Any, seq: int, what: str) -> int:
    number = _number(value, seq, what)
    if not number.is_integer():
        raise MissionError(f"item {seq}: {what} is {value!r}, a whole number is wanted", seq)
    return int(number)
