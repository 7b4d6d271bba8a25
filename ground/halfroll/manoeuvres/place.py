"""Where a manoeuvre begins, and points as seen from there. Why: every manoeuvre is drawn in one vertical plane from its
own start, by metres along and up; only this knows where that lies in W."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

from halfroll.missions.geodesy import Vector
from halfroll.missions.mission import Quaternion, Waypoint
from halfroll.vehicle import GRAVITY

Axis = Literal["roll", "pitch"]

_STILL: Vector = (0.0, 0.0, 0.0)
_FREE = (True, True, True)


@dataclass(frozen=True)
class Place:
    """At rest. heading [rad]: of the plane of the manoeuvre; yaw [rad] as the waypoints before give it."""

    position: Vector
    yaw: float
    upright: bool
    heading: float
    item: int | None = None

    def point(self, along: float, up: float) -> Vector:
        """(3,) in W."""
        x, y, z = self.position
        return (x + along * math.cos(self.heading), y + along * math.sin(self.heading), z + up)

    def passed(self, along: float, up: float, *, upright: bool | None = None, free: bool = False) -> Waypoint:
        """A point on the way; free: only a first guess."""
        return Waypoint(
            self.point(along, up),
            yaw=self.yaw,
            free=_FREE if free else (False, False, False),
            item=self.item,
            upright=self.upright if upright is None else upright,
        )

    def falling(self, along: float, up: float, *, upright: bool, free_along: bool = True) -> Waypoint:
        """In free fall for an instant, at whatever height; upright: from here on."""
        free = (free_along, free_along, True)
        return replace(self.passed(along, up, upright=upright), acceleration=(0.0, 0.0, -GRAVITY), free=free)

    def tilted(self, along: float, up: float, tilt: float, *, upright: bool, free: bool = False) -> Waypoint:
        """With the thrust axis tilted [rad] from up towards the heading, thrust as is best; upright: from here on."""
        return replace(self.passed(along, up, upright=upright, free=free), q_WB=self.attitude(tilt))

    def still(self, along: float, up: float, *, upright: bool | None = None) -> Waypoint:
        """At rest."""
        at = self.passed(along, up, upright=upright)
        return replace(at, velocity=_STILL, acceleration=_STILL, jerk=_STILL, snap=_STILL)

    def attitude(self, tilt: float) -> Quaternion:
        """Of the thrust axis alone: turned by tilt about the horizontal across the heading."""
        half = tilt / 2.0
        return (
            math.cos(half),
            -math.sin(self.heading) * math.sin(half),
            math.cos(self.heading) * math.sin(half),
            0.0,
        )


def heading_of(axis: Axis, turns: float, yaw: float) -> float:
    """Heading [rad] towards which the thrust axis tilts first: to the right for a roll, backwards for a pitch (nose
    up); the other way for turns below 0."""
    towards = yaw - math.pi / 2.0 if axis == "roll" else yaw + math.pi
    return towards if turns >= 0.0 else towards + math.pi


def after(waypoint: Waypoint, heading: float) -> Place:
    """At rest at the last waypoint of what is before."""
    return Place(waypoint.position, waypoint.yaw, waypoint.upright, heading, waypoint.item)
