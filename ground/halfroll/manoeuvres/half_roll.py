"""Half a turn through free fall (the paper's Fig 2): hover to hover upside down, or back. Why: the one way in which an
upright vehicle becomes an inverted one; every inverted leg begins and ends with it."""

from __future__ import annotations

from halfroll.manoeuvres.place import Place
from halfroll.missions.mission import Waypoint

_RISE = 0.1  # [m], a first guess


def half_roll(start: Place, travel: float) -> list[Waypoint]:
    """travel [m] towards the heading: less makes it turn faster; the thrust reverses half way, in free fall."""
    return [
        start.falling(travel / 2.0, _RISE, upright=not start.upright),
        start.still(travel, 0.0, upright=not start.upright),
    ]
