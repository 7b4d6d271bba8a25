"""From mission items to the waypoints that are planned. Why: what a mission means in flight - jumps, speeds, holds,
headings, where the autopilot takes over again - is decided once, and the planner sees only points in W.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field, replace

from halfroll.errors import MissionError, PlanError
from halfroll.manoeuvres.library import rolled_over, turned
from halfroll.manoeuvres.place import Axis
from halfroll.missions.geodesy import DEFAULT_ORIGIN, GeoPoint, local_from_global
from halfroll.missions.mission import CAPACITY, NOT_GIVEN, Demand, Mission, MissionItem, Rules, Vector, Waypoint
from halfroll.missions.mission_check import Finding, Severity
from halfroll.missions.mission_items import (
    ABSOLUTE_FRAMES,
    HOME_FRAMES,
    TABLE,
    Command,
    ItemKind,
    Role,
    command_name,
    first_flown,
    is_here,
)
from halfroll.wire.frames import attitude_from_degrees, degrees_from_wire, heading_deg_to_yaw

TAKEOFF_ALTITUDE = 2.5  # [m] MIS_TAKEOFF_ALT
LONGEST_WAIT_S, LONGEST_FLIGHT_S = 3600.0, 7200.0  # what is longer is a mistake, and its plan would fill the memory
_STEPS = 100_000  # a mission of more items, counting each repetition, has no end that anybody would wait for
SAME_PLACE = 0.02  # [m] waypoints this close are one: the wire's latitudes are 1.1 cm apart


@dataclass(frozen=True)
class Course:
    """What the planner flies of a mission: from hover at the first waypoint to hover at the last.

    With fewer than two waypoints there is nothing to plan, and the autopilot flies the mission alone. As missions may
    jump, `Waypoint.item` need not rise along the course.
    """

    waypoints: tuple[Waypoint, ...]
    first_item: int  # the plan may take over once this one is reached
    last_item: int  # reached at the end of the plan
    hands_back_to: int | None  # the autopilot continues with this one; None: the mission is complete
    notes: tuple[Finding, ...] = ()  # why the plan ends before the mission's positions do
    demands: tuple[Demand, ...] = ()  # of single items
    rules: Rules = field(default_factory=Rules)  # in W


def course(
    mission: Mission,
    origin: GeoPoint = DEFAULT_ORIGIN,
    home: GeoPoint | None = None,
    takeoff_altitude: float = TAKEOFF_ALTITUDE,
    start_yaw: float = 0.0,
) -> Course:
    """The course of a mission, by its own waypoints if it has them, else by its items. See `flown_waypoints`."""
    home = home or origin
    rules = mission.rules.in_world(origin, home)
    if not mission.waypoints:
        return replace(flown_waypoints(mission.items, origin, home, takeoff_altitude, start_yaw), rules=rules)
    n, w, _ = local_from_global(origin, mission.anchor or home)
    u = home.alt - origin.alt
    moved = tuple(
        replace(point, position=(point.position[0] + n, point.position[1] + w, point.position[2] + u))
        for point in mission.waypoints
    )
    moved += tuple(_back_upright(moved[-1]))
    first, last = moved[0].item or 0, moved[-1].item or 0
    return Course(moved, first, last, last + 1 if last + 1 < len(mission.items) else None, rules=rules)


def flown_waypoints(
    items: tuple[MissionItem, ...],
    origin: GeoPoint = DEFAULT_ORIGIN,
    home: GeoPoint | None = None,
    takeoff_altitude: float = TAKEOFF_ALTITUDE,
    start_yaw: float = 0.0,
    *,
    seq0_home: int = 2,
    from_item: int | None = None,
    start: Vector | None = None,
) -> Course:
    """Waypoints in W around `origin`, from the takeoff point to the last position before LAND, RTL or the end.

    home: where it was armed (default the origin); heights above home count from it, "here" of a takeoff is over it.
    start_yaw: heading in W [rad] kept until an item gives one. Without a takeoff it begins at its first position;
    with `start` (W, hovering) and `from_item`, the rest of a mission from there, its jumps counted anew. Raises
    MissionError for an item that mission_check refuses, and for a mission without a position.
    """
    walk = _Walk(items, origin, home or origin, takeoff_altitude, start_yaw)
    index = first_flown(items, seq0_home) if from_item is None else from_item
    for before in items[:index]:
        if before.command == Command.DO_CHANGE_SPEED:
            walk.change_speed(before)
    if start is not None:
        walk.legs.append(Waypoint(start, yaw=start_yaw))
        walk.turn_as_before(items[:index])
    first, hands_back_to = walk.run(index)
    if not walk.legs:
        raise MissionError("the mission has no position to fly to before it ends; add a takeoff or a waypoint", first)
    walk.end()
    last = walk.legs[-1].item
    return Course(
        tuple(walk.legs),
        first,
        first if last is None else last,
        hands_back_to,
        tuple(walk.notes),
        demands=tuple(walk.demands),
    )


def _back_upright(last: Waypoint) -> list[Waypoint]:
    """What a plan that would end upside down ends with: the autopilot takes over upright."""
    return [replace(point, item=last.item) for point in rolled_over(last, upright=True)]


def require_an_end(waypoints: tuple[Waypoint, ...], speed_max: float | None = None) -> None:
    """Raises PlanError, naming the waypoint, for holds and flights that are too long to be meant.

    speed_max [m/s]: no leg is flown faster; None if there is no such limit.
    """
    least_s = 0.0
    for place, point in enumerate(waypoints):
        what = f"waypoint {place + 1}" if point.item is None else f"item {point.item}"
        if speed_max is not None and place:
            before = waypoints[place - 1]
            least_s += math.dist(before.position, point.position) / min(speed_max, before.speed_max or speed_max)
        least_s += point.hold_s
        if point.hold_s > LONGEST_WAIT_S:
            limit = f"at most {LONGEST_WAIT_S:g} s are planned; shorten it"
            raise PlanError(f"{what}: its hold of {point.hold_s:g} s is too long, {limit}", point.item)
        if least_s > LONGEST_FLIGHT_S:
            limit = f"at most {LONGEST_FLIGHT_S / 3600.0:g} h are planned; fly faster, or split the mission"
            raise PlanError(f"{what}: the flight up to here takes {least_s / 3600.0:.1f} h, {limit}", point.item)


def endless(items: tuple[MissionItem, ...]) -> MissionError | None:
    """The item at which a mission stays for ever, or longer than anybody waits; None if it comes to an end."""
    index, jumps_done = 0, Counter[int]()
    for _ in range(_STEPS):
        kind = TABLE.get(items[index].command) if index < len(items) else None
        if index >= len(items) or (kind and kind.role is Role.END):
            return None
        params, following, why = items[index].params, index + 1, ""
        if kind and kind.role is Role.LOITER:
            why = "it circles or hovers without limit; take LOITER_TIME"
        elif kind and kind.role is Role.JUMP and params[1] != 0:
            if params[1] < 0:
                why = "it repeats for ever; give a number of repeats"
            elif jumps_done[index] < params[1]:
                jumps_done[index] += 1
                following = int(params[0])
        elif kind and (kind.role is Role.WAIT or kind.holds) and params[0] > LONGEST_WAIT_S:
            why = f"it waits {params[0]:g} s, at most {LONGEST_WAIT_S:g} s are flown; shorten it"
        if why:
            return _never_ends(items, index, why)
        index = following
    index = jumps_done.most_common(1)[0][0]
    return _never_ends(items, index, f"it repeats {items[index].params[1]:g} times; give fewer repeats")


def _never_ends(items: tuple[MissionItem, ...], index: int, why: str) -> MissionError:
    return MissionError(f"the mission never ends: item {index} ({command_name(items[index].command)}): {why}", index)


def home_of(mission: Mission) -> GeoPoint:
    """Where the simulated vehicle stands: where QGroundControl planned it to, else at the simulator's own place.

    The home of a .waypoints file is where that list was made, often on another continent, and no wish.
    """
    planned = mission.source is not None and mission.source.suffix == ".plan"
    return mission.planned_home if planned and mission.planned_home else DEFAULT_ORIGIN


@dataclass
class _Walk:
    """The mission as it is flown, item after item; `legs` grows."""

    items: tuple[MissionItem, ...]
    origin: GeoPoint
    home: GeoPoint
    takeoff_altitude: float
    yaw: float
    legs: list[Waypoint] = field(default_factory=list)
    notes: list[Finding] = field(default_factory=list)
    demands: list[Demand] = field(default_factory=list)
    speeds: dict[int, float] = field(default_factory=dict)  # [m/s] at which one of the legs ends
    speed: float | None = None
    wait_s: float = 0.0  # of DELAY items since the last waypoint; a wait after the last one is the autopilot's
    passed: int = 0  # positions, also where several are one waypoint: every jump loop has one, so this ends the walk
    jumps_done: Counter[int] = field(default_factory=Counter)

    def run(self, index: int) -> tuple[int, int | None]:
        """The first item that gave a waypoint (`index` if none) and the one the autopilot goes on with."""
        first: int | None = index if self.legs else None
        resume = index
        while index < len(self.items):
            item = self.items[index]
            kind = self._kind(index)
            following = index + 1
            if kind.role is Role.END:
                break
            if kind.role is Role.HOME:
                return self._stop(index, first, "home moves here")
            if kind.role is Role.JUMP:
                if item.params[1] < 0:
                    return self._stop(index, first, "it repeats for ever, give a number of repeats")
                following = self._jump(index, item)
                resume = following
            elif kind.role in (Role.TAKEOFF, Role.WAYPOINT, Role.LOITER):
                if self.passed >= CAPACITY:
                    return self._stop(index, first, f"it would be waypoint {CAPACITY + 1} of at most {CAPACITY}")
                self._fly(index, item, kind)
                first = index if first is None else first
                if kind.role is Role.LOITER:
                    return first, index  # stays the current item: never complete
                resume = following
            elif kind.role is Role.WAIT:
                self.wait_s += max(item.params[0], 0.0)
            elif kind.role is Role.YAW:
                self.yaw = _turned(self.yaw, item)
            elif kind.role is Role.SPEED:
                self.change_speed(item)
            elif kind.role in (Role.INVERT, Role.FLIP):
                self._turn_over(index, item, kind)
                resume = following
            index = following
        return resume if first is None else first, resume if resume < len(self.items) else None

    def change_speed(self, item: MissionItem) -> None:
        """DO_CHANGE_SPEED: p1 0 or 1 horizontal (climb and descent are the follower's), p2 -1 keep, -2 the default."""
        kind, speed, _, _ = item.params
        if kind <= 1 and speed != -1:
            self.speed = speed if speed > 0 else None

    def end(self) -> None:
        """Upright, and with the speeds that were asked for, each towards where it goes on."""
        self.legs += _back_upright(self.legs[-1])
        for place, speed in self.speeds.items():
            ends = self.legs[max(place - 1, 0)].position, self.legs[min(place + 1, len(self.legs) - 1)].position
            way = [there - here for here, there in zip(*ends, strict=True)]
            x, y, z = (speed * part / max(math.hypot(*way), 1e-9) for part in way)
            self.legs[place] = replace(self.legs[place], velocity=(x, y, z))

    def turn_as_before(self, passed: tuple[MissionItem, ...]) -> None:
        """The rest of a mission is flown upside down where these items turned over; it begins upright."""
        upright = True
        for item in passed:
            if item.command == Command.DO_INVERTED_FLIGHT:
                upright = item.params[0] == 0
            elif item.command == Command.USER_1 and item.params[1] % 1.0:
                upright = not upright
        self.legs += rolled_over(self.legs[-1], upright)

    def _turn_over(self, index: int, item: MissionItem, kind: ItemKind) -> None:
        what = f"item {index} ({kind.name})"
        if not self.legs:
            raise MissionError(f"{what} turns over before there is a place to do it; put it after a position", index)
        self._wait_here()
        here = self.legs[-1]
        if here.q_WB is not None or (len(self.legs) - 1) in self.speeds:
            raise MissionError(f"{what} begins at rest, and item {here.item} is passed moving; put one between", index)
        if kind.role is Role.INVERT:
            turned_over = rolled_over(here, upright=item.params[0] == 0)
        else:
            axis: Axis = "roll" if item.params[0] == 1 else "pitch"
            turned_over = turned(here, axis, item.params[1])
            height = item.params[2] + self.home.alt - self.origin.alt
            self.demands.append(Demand(index, height, item.params[3]))
        if turned_over:
            self.legs[-1] = here.standing
            self.legs += [replace(point, item=index, speed_max=self.speed) for point in turned_over]

    def _kind(self, index: int) -> ItemKind:
        item = self.items[index]
        kind = TABLE.get(item.command)
        if kind is None or item.frame not in kind.frames:
            what = f"item {index} ({command_name(item.command)}, frame {item.frame})"
            raise MissionError(f"{what} is not supported; `halfroll check` lists all such items", index)
        return kind

    def _stop(self, index: int, first: int | None, why: str) -> tuple[int, int]:
        self._wait_here()
        why += ": planned up to here, the autopilot flies on by itself"
        self.notes.append(Finding(index, self.items[index].command, why, Severity.NOTE))
        return index if first is None else first, index

    def _jump(self, index: int, item: MissionItem) -> int:
        self._wait_here()
        if self.jumps_done[index] >= item.params[1]:
            return index + 1
        self.jumps_done[index] += 1
        return int(item.params[0])

    def _wait_here(self) -> None:
        if self.legs:
            self.legs[-1] = replace(self.legs[-1], hold_s=self.legs[-1].hold_s + self.wait_s)
        self.wait_s = 0.0

    def _fly(self, index: int, item: MissionItem, kind: ItemKind) -> None:
        self._wait_here()
        self.passed += 1
        heading_deg = item.params[3] if kind.turns else math.nan
        if not math.isnan(heading_deg):
            self.yaw += math.remainder(heading_deg_to_yaw(heading_deg) - self.yaw, math.tau)  # the short way
        position = self._position(index, item)
        hold_s = item.params[0] if kind.holds else 0.0
        upright = not self.legs or self.legs[-1].upright
        point = Waypoint(position, yaw=self.yaw, hold_s=hold_s, speed_max=self.speed, item=index, upright=upright)
        if item.command == Command.WAYPOINT_USER_1:
            point = self._with_attitude(index, item, point)
        if not self.legs:
            self.legs.append(point)
        elif math.dist(self.legs[-1].position, position) < SAME_PLACE:
            here = self.legs[-1]
            if point.q_WB is not None or here.q_WB is not None:
                raise MissionError(
                    f"item {index} is where item {here.item} is, and one gives an attitude: there is no way between "
                    "them; take one of them out",
                    index,
                )
            point = replace(point, position=here.position, hold_s=here.hold_s + hold_s)
            self.legs[-1] = point.standing if here.stands else point
        else:
            self.legs[-1] = replace(self.legs[-1], speed_max=self.speed)
            self.legs.append(point)

    def _with_attitude(self, index: int, item: MissionItem, point: Waypoint) -> Waypoint:
        """WAYPOINT_USER_1: p1 roll, p2 pitch [deg], both or neither; p3 speed [m/s] along the way, NaN free."""
        roll_deg, pitch_deg, speed, _ = item.params
        tilted = bool(roll_deg or pitch_deg) and not math.isnan(roll_deg)
        if speed == 0.0 and tilted:
            raise MissionError(
                f"item {index} asks for an attitude of {roll_deg:g} deg roll, {pitch_deg:g} deg pitch and for no "
                "speed, and nothing stands still at an angle; give a speed, or NaN: whatever is best",
                index,
            )
        if speed == 0.0:
            return point.standing
        if speed > 0.0:
            self.speeds[len(self.legs)] = speed
        if math.isnan(roll_deg):
            return point
        return replace(point, q_WB=attitude_from_degrees(roll_deg, pitch_deg, self.yaw))

    def _position(self, index: int, item: MissionItem) -> Vector:
        alt = item.z if item.frame in ABSOLUTE_FRAMES else self.home.alt + item.z
        if math.isnan(alt) and item.command == Command.TAKEOFF:
            alt = self.home.alt + self.takeoff_altitude
        if not math.isfinite(alt):
            raise MissionError(f"item {index} ({command_name(item.command)}) has no height; set it", index)
        if not is_here(item):
            return local_from_global(self.origin, GeoPoint(degrees_from_wire(item.x), degrees_from_wire(item.y), alt))
        if item.command != Command.TAKEOFF:
            raise MissionError(f"item {index} ({command_name(item.command)}) has no position; set it", index)
        here = self.legs[-1].position if self.legs else local_from_global(self.origin, self.home)
        return here[0], here[1], alt - self.origin.alt


def _turned(yaw: float, item: MissionItem) -> float:
    """Yaw after CONDITION_YAW: p1 degrees, p3 1 clockwise, -1 the other way, else the shorter; p4 1: relative."""
    degrees, _, direction, relative = item.params
    if relative == 1:
        return yaw + heading_deg_to_yaw(degrees) * (-1 if direction == -1 else 1)
    turn = heading_deg_to_yaw(degrees) - yaw
    if direction == 1:
        return yaw - (-turn) % math.tau
    return yaw + (turn % math.tau if direction == -1 else math.remainder(turn, math.tau))


def with_takeoff_and_landing(mission: Mission) -> tuple[Mission, list[str]]:
    """The mission with a TAKEOFF first and a LAND last where it has none, and a sentence for each that was added.

    The takeoff climbs where the vehicle stands, to MIS_TAKEOFF_ALT; the landing is where the mission ends. Targets of
    DO_JUMP and the mission's own waypoints keep naming the same items.
    """
    added: list[str] = []
    items = mission.items
    kinds = [TABLE.get(item.command) for item in items]
    positions = [i for i, kind in enumerate(kinds) if kind and kind.ends_a_leg and i >= first_flown(items)]
    if not positions or items[positions[0]].command != Command.TAKEOFF:
        place = int(_begins_with_home(mission))
        mission = _inserted(mission, place, _item_here(Command.TAKEOFF))
        added.append(f"item {place}: TAKEOFF where the vehicle stands, to the default height (the mission has none)")
    if not any(kind and kind.role in (Role.END, Role.LOITER) for kind in kinds):
        mission = replace(mission, items=(*mission.items, _item_here(Command.LAND)))
        added.append(f"item {len(mission.items) - 1}: LAND where the mission ends (the mission has none)")
    return mission, added


def _item_here(command: Command) -> MissionItem:
    height = math.nan if command == Command.TAKEOFF else 0.0
    return MissionItem(command, HOME_FRAMES[0], (0.0, 0.0, 0.0, math.nan), NOT_GIVEN, NOT_GIVEN, height)


def _begins_with_home(mission: Mission) -> bool:
    """Item 0 is the home line of a file without a takeoff: a takeoff after it makes it a placeholder."""
    item = mission.items[0]
    if mission.planned_home is None or item.command != Command.WAYPOINT or item.frame != 0:
        return False
    home = mission.planned_home
    return math.isclose(degrees_from_wire(item.x), home.lat_deg, abs_tol=1e-7) and math.isclose(
        degrees_from_wire(item.y), home.lon_deg, abs_tol=1e-7
    )


def _inserted(mission: Mission, place: int, item: MissionItem) -> Mission:
    def moved(old: MissionItem) -> MissionItem:
        target = old.params[0]
        if old.command != Command.DO_JUMP or not target >= place:
            return old
        return replace(old, params=(target + 1, *old.params[1:]))

    items = [moved(old) for old in mission.items]
    items.insert(place, item)
    waypoints = mission.waypoints and tuple(
        replace(point, item=point.item + 1) if point.item is not None and point.item >= place else point
        for point in mission.waypoints
    )
    return replace(mission, items=tuple(items), waypoints=waypoints)
