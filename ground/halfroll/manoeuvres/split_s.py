"""Half a roll, then half a loop downwards: back the way it came, lower. Why: the quickest way to turn round and lose
height; the loop begins with a fall from the inverted hover, in which the thrust changes its sign."""

from __future__ import annotations

import math
from dataclasses import replace

from halfroll.manoeuvres.half_roll import half_roll
from halfroll.manoeuvres.place import Place
from halfroll.missions.mission import Waypoint


def split_s(start: Place, height: float, travel: float) -> list[Waypoint]:
    """height [m] that it loses; travel [m] of the half roll towards the heading, and of the half loop back."""
    roll = half_roll(start, travel)
    inverted = replace(start, position=roll[-1].position, upright=False)
    loop = [
        inverted.falling(0.0, -0.15 * height, upright=False),
        inverted.tilted(-0.3 * travel, -0.5 * height, 1.5 * math.pi, upright=True, free=True),
        inverted.still(-travel, -height, upright=True),
    ]
    return [*roll, *loop]
