"""Through a narrow window that stands at an angle. Why: place, attitude and direction of flight are all given there;
how fast, and with how much thrust, is whatever is best."""

from __future__ import annotations

import math
from dataclasses import replace

from halfroll.manoeuvres.place import Place
from halfroll.missions.mission import Quaternion, Waypoint


def window(start: Place, attitude: Quaternion, ahead: float, up: float) -> list[Waypoint]:
    """ahead [m] towards the heading and up [m] of the start stands the window; as far behind it is rest again."""
    through = replace(
        start.passed(ahead, up),
        q_WB=attitude,
        direction=(math.cos(start.heading), math.sin(start.heading), 0.0),
    )
    return [through, start.still(2.0 * ahead, up)]
