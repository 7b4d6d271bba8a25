"""A loop upwards and backwards, on thrust towards its middle. Why: the thrust never reverses, it only turns: going up
its axis is level and points back, on top it points down, coming down it is level and points forwards."""

from __future__ import annotations

import math

from halfroll.manoeuvres.place import Place
from halfroll.missions.mission import Waypoint

_UP, _TOP, _DOWN = (1.5, 0.8), (1.2, 1.3), (0.9, 0.8)  # along and up, of the size; the top is a first guess
_END = 2.4


def power_loop(start: Place, size: float) -> list[Waypoint]:
    """size [m]: the loop is about as high; it ends 2.4 times as far along the heading, after run-up and run-out."""
    return [
        start.tilted(_UP[0] * size, _UP[1] * size, -0.5 * math.pi, upright=False),
        start.tilted(_TOP[0] * size, _TOP[1] * size, -math.pi, upright=False, free=True),
        start.tilted(_DOWN[0] * size, _DOWN[1] * size, -1.5 * math.pi, upright=True),
        start.still(_END * size, 0.0),
    ]
