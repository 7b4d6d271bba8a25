"""A level figure of eight through its own start. Why: the usual test of an autopilot, as fast as rotors give."""

from __future__ import annotations

import math
from dataclasses import replace

from halfroll.manoeuvres.place import Place
from halfroll.missions.mission import Waypoint


def figure_eight(start: Place, size: float) -> list[Waypoint]:
    """size [m] from the middle to either end, along the heading; half as wide across."""
    points = []
    for eighth in range(1, 8):
        angle = eighth * math.pi / 4.0
        along, across = size * math.sin(angle), 0.25 * size * math.sin(2.0 * angle)
        x, y, z = start.point(along, 0.0)
        place = (x - across * math.sin(start.heading), y + across * math.cos(start.heading), z)
        points.append(replace(start.passed(along, 0.0), position=place))
    return [*points, start.still(0.0, 0.0)]
