"""A straight leg flown upside down, between two half rolls. Why: cameras and grippers on top look down from it."""

from __future__ import annotations

import math
from dataclasses import replace

from halfroll.manoeuvres.half_roll import half_roll
from halfroll.manoeuvres.place import Place
from halfroll.missions.mission import Waypoint


def inverted_leg(start: Place, length: float, travel: float) -> list[Waypoint]:
    """length [m] towards the heading; it rolls to the right, travel [m] aside, and back."""
    aside = replace(start, heading=start.heading - math.pi / 2.0)
    over = half_roll(aside, travel)
    inverted = replace(start, position=over[-1].position, upright=False)
    there = inverted.still(length, 0.0)
    back = replace(aside, position=there.position, heading=aside.heading + math.pi, upright=False)
    return [*over, there, *half_roll(back, travel)]
