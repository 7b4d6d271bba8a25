"""A whole turn on the spot: twice through free fall. Why: the shortest way round, with little room; it rises, hangs
from its reversed thrust for a moment, and is back where it began."""

from __future__ import annotations

import math

from halfroll.manoeuvres.place import Place
from halfroll.missions.mission import Waypoint

_RISE = 0.3  # [m], a first guess


def flip(start: Place, swing: float) -> list[Waypoint]:
    """swing [m]: how far it goes to either side; more of it makes it slower, and turn more evenly."""
    up = start.upright
    half_way = math.pi if up else 0.0
    return [
        start.falling(swing, _RISE, upright=not up, free_along=False),
        start.tilted(0.0, _RISE * 7.0 / 6.0, half_way, upright=not up, free=True),
        start.falling(-swing, _RISE, upright=up, free_along=False),
        start.still(0.0, 0.0, upright=up),
    ]
