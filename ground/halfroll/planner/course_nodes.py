"""The places of a course, and what is given at each: from waypoints to the nodes that a search moves between.

Why: several waypoints may be one place, an attitude fixes derivatives, and some things no trajectory can meet; all
modes of planning begin with the same answer to that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from halfroll.body_axes import body_up
from halfroll.errors import InfeasibleSegment, MissionError
from halfroll.missions.mission import Waypoint
from halfroll.planner.attitude_nodes import asked, flat_yaw
from halfroll.planner.limits import Limits
from halfroll.planner.minimum_time import Line, Stretch
from halfroll.planner.segments import FREE, node, rest
from halfroll.vehicle import Vehicle

Array = NDArray[np.float64]

SAME_PLACE = 1e-3  # [m], closer waypoints are one
_STEEP = 3.0  # times the vertical force that is asked for: what an attitude at the most thrust leaves to steer with
_TILT_MAX = np.radians(140.0)  # yaw counted from upright has no meaning at 180


@dataclass(frozen=True)
class CourseNode:
    """One place of the course: what the waypoints there ask for together."""

    waypoint: Waypoint
    yaw: float  # the short way round from the one before
    hold_s: float
    at_rest: bool
    places: tuple[int, ...]  # of its waypoints in the course

    @property
    def upright(self) -> bool:
        """sigma from here on."""
        return self.waypoint.upright

    @property
    def name(self) -> str:
        item = self.waypoint.item
        return f"item {item}" if item is not None else f"waypoint {self.places[-1] + 1}"

    @property
    def moves(self) -> bool:
        """Whether it asks for a derivative other than zero."""
        point = self.waypoint
        if point.q_WB is not None or point.direction is not None:
            return True
        return any(np.any(d) for d in (point.velocity, point.acceleration, point.jerk, point.snap) if d is not None)

    @classmethod
    def merged(cls, waypoints: Sequence[Waypoint]) -> list[CourseNode]:
        nodes: list[CourseNode] = []
        for place, point in enumerate(waypoints):
            yaw = point.yaw if point.q_WB is None or not point.upright else flat_yaw(point.q_WB)
            new = cls(point, yaw, point.hold_s, point.hold_s > 0.0 or point.stands, (place,))
            if not nodes:
                nodes.append(new)
                continue
            new = replace(new, yaw=nodes[-1].yaw + new._turn_from(nodes[-1]))
            nodes[-1:] = nodes[-1]._joined(new) if new._is_where(nodes[-1]) else [nodes[-1], new]
        if len(nodes) < 2:
            item = waypoints[0].item if waypoints else None
            raise MissionError("a plan needs at least two different waypoints; add one more than 1 mm away", item)
        nodes[0], nodes[-1] = replace(nodes[0], at_rest=True), replace(nodes[-1], at_rest=True)
        for at in nodes:
            at._require_rest()
        return nodes

    def _turn_from(self, before: CourseNode) -> float:
        """The short way round; the nose keeps its direction until the vehicle is upright again."""
        if not (before.upright and self.upright):
            return 0.0
        turn = (self.yaw - before.yaw + np.pi) % (2.0 * np.pi) - np.pi
        return turn if abs(turn) > 1e-12 else 0.0

    def _is_where(self, before: CourseNode) -> bool:
        here, there = self.waypoint, before.waypoint
        if any(here.free + there.free):
            return False
        return bool(np.linalg.norm(np.subtract(here.position, there.position)) < SAME_PLACE)

    def _joined(self, new: CourseNode) -> list[CourseNode]:
        """With what is asked next at the same place: one node, or two at rest with a turn on the spot between them."""
        if new.waypoint.q_WB is not None and self.waypoint.q_WB is not None:
            raise MissionError(
                f"{new.name} is at the same place as {self.name}, and both give an attitude; remove one of them",
                new.waypoint.item,
            )
        if new.moves or self.moves:
            raise MissionError(
                f"{new.name} is at the same place as {self.name}, where the vehicle would have to move and to be at "
                "rest; remove one of them",
                new.waypoint.item,
            )
        new = replace(new, waypoint=replace(new.waypoint, position=self.waypoint.position))
        if abs(new.yaw - self.yaw) > 1e-9:
            return [replace(self, at_rest=True), replace(new, at_rest=True)]
        together = (self.hold_s + new.hold_s, self.at_rest or new.at_rest, self.places + new.places)
        return [CourseNode(new.waypoint, self.yaw, *together)]

    def _require_rest(self) -> None:
        """Raises MissionError for what a place where the vehicle is at rest cannot have."""
        if self.at_rest and any(self.waypoint.free):
            raise MissionError(
                f"{self.name}: the vehicle is at rest here (an end, or a hold), so its position cannot be free; "
                "give it",
                self.waypoint.item,
            )
        if self.at_rest and self.moves:
            raise MissionError(
                f"{self.name}: the vehicle is at rest here (an end, or a hold), so velocity and its derivatives must "
                "be zero; remove them or the hold",
                self.waypoint.item,
            )


def checked_nodes(waypoints: Sequence[Waypoint], vehicle: Vehicle, limits: Limits) -> list[CourseNode]:
    """The places of a course. Raises MissionError and InfeasibleSegment for what no trajectory can meet."""
    points = CourseNode.merged(waypoints)
    for point in points:
        _require_possible(point, vehicle, limits)
        if limits.floor is not None and not point.waypoint.free[2] and point.waypoint.position[2] < limits.floor:
            raise InfeasibleSegment(
                f"{point.name}: height {point.waypoint.position[2]:.2f} m is below the floor of {limits.floor:g} m; "
                "raise it",
                point.waypoint.item,
            )
        if limits.ceiling is not None and not point.waypoint.free[2] and point.waypoint.position[2] > limits.ceiling:
            raise InfeasibleSegment(
                f"{point.name}: height {point.waypoint.position[2]:.2f} m is above the ceiling of {limits.ceiling:g} "
                "m; lower it",
                point.waypoint.item,
            )
        speed = float(np.linalg.norm(point.waypoint.velocity or 0.0))
        if limits.speed_max is not None and speed > limits.speed_max:
            raise InfeasibleSegment(
                f"{point.name}: speed of {speed:.2f} m/s is above the limit of {limits.speed_max:g} m/s; lower it",
                point.waypoint.item,
            )
    return points


def _require_possible(point: CourseNode, vehicle: Vehicle, limits: Limits) -> None:
    """Raises MissionError for what the rotors, or a limit, forbid at the place itself."""
    waypoint, most = point.waypoint, 4.0 * limits.rotor_max
    turned_over = not waypoint.upright or waypoint.in_free_fall or (waypoint.thrust or 0.0) < 0.0
    if turned_over and not vehicle.variable_pitch:
        raise MissionError(
            f"{point.name}: {vehicle.name} has rotors of fixed pitch, which only push up: it can neither fly inverted "
            "nor turn over in free fall; take this out, or fly a vehicle of variable pitch",
            waypoint.item,
        )
    if waypoint.thrust is not None:
        least = 4.0 * limits.rotor_min
        if not least <= waypoint.thrust <= most:
            raise MissionError(
                f"{point.name}: a thrust of {waypoint.thrust:g} N is asked for, the rotors of {vehicle.name} may give "
                f"{least:.4g} to {most:.4g} N; give less, or leave it free",
                waypoint.item,
            )
    if waypoint.q_WB is not None:
        tilt = float(np.arccos(np.clip(body_up(waypoint.q_WB)[2], -1.0, 1.0)))
        if waypoint.upright and tilt > _TILT_MAX:
            raise MissionError(
                f"{point.name}: its attitude tilts the thrust axis by {np.degrees(tilt):.0f} deg, and upright flight "
                f"ends at {np.degrees(_TILT_MAX):.0f} deg; give upright = false, between two half rolls",
                waypoint.item,
            )
        if limits.tilt_max is not None and tilt > limits.tilt_max:
            raise MissionError(
                f"{point.name}: its attitude tilts the thrust axis by {np.degrees(tilt):.0f} deg, the limit tilt_deg "
                f"is {np.degrees(limits.tilt_max):.0f}; raise it, or switch it off",
                waypoint.item,
            )


def signed_thrust(point: CourseNode, sign: float) -> None:
    """Raises MissionError where an attitude is asked for with thrust of the other sign."""
    thrust = point.waypoint.thrust
    if thrust is not None and thrust * sign <= 0.0:
        how = "more than 0 N" if sign > 0.0 else "less than 0 N, for it flies on reversed thrust"
        raise MissionError(f"{point.name}: its thrust is {thrust:g} N, here it is {how}", point.waypoint.item)


def attitudes_allowed(points: Sequence[CourseNode], limits: Limits) -> Limits:
    """Where an attitude is steeper than the vertical force that limits ask for allows, only the size of the force is
    limited from below."""
    least = limits.force_z_min
    if least is None:
        return limits
    for point in points:
        w, sign = point.waypoint, 1.0 if point.upright else -1.0
        if w.q_WB is not None and sign * float(body_up(w.q_WB)[2]) * 4.0 * limits.rotor_max < _STEEP * least:
            return replace(limits, force_z_min=None, force_min=max(limits.force_min or 0.0, least))
    return limits


def stretch_of(points: Sequence[CourseNode], vehicle: Vehicle) -> Stretch:
    """From rest to rest without turning over."""
    nodes, lines = [], []
    for place, point in enumerate(points):
        w, sign = point.waypoint, 1.0 if point.upright else -1.0
        position = (*(FREE if free else x for x, free in zip(w.position, w.free, strict=True)), point.yaw)
        if point.at_rest:
            nodes.append(rest(position))
            continue
        signed_thrust(point, sign)
        given, along = asked(w, vehicle, sign)
        given[0] = node(position)[0]
        nodes.append(given)
        lines += [Line(place, direction, start) for direction, start in along]
    return Stretch(np.stack(nodes), speeds(points), places(points), tuple(lines))


def speeds(points: Sequence[CourseNode]) -> Array:
    """(M,) speed limit of each leg, inf where there is none."""
    given = [point.waypoint.speed_max for point in points[:-1]]
    return np.array([np.inf if speed is None else speed for speed in given])


def places(points: Sequence[CourseNode]) -> Array:
    return np.array([point.waypoint.position for point in points])
