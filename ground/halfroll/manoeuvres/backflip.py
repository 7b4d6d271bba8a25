"""The translating backflip (the paper's Fig 3): a whole turn backwards while flying forwards, on thrust that never
reverses. Why: twice the thrust axis is level, pulling back, then forwards; between the two it points down."""

from __future__ import annotations

import math

from halfroll.manoeuvres.place import Place
from halfroll.missions.mission import Waypoint

_BACK, _FORWARD, _RISE = 0.473, 0.570, 0.118  # of the travel: where the thrust axis is level, and how high


def backflip(start: Place, travel: float) -> list[Waypoint]:
    """travel [m] towards the heading."""
    return [
        start.tilted(_BACK * travel, _RISE * travel, -0.5 * math.pi, upright=False),
        start.tilted(_FORWARD * travel, _RISE * travel, -1.5 * math.pi, upright=True),
        start.still(travel, 0.0),
    ]
