"""Room to turn over: how far a flight comes down while it does, and what more it may lose if it is broken off.

Why: upside down the autopilot cannot simply stop; it first rolls upright, falling meanwhile. A flip must begin so high
that it may be broken off at any moment.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from halfroll.errors import MissionError
from halfroll.missions.mission import Demand
from halfroll.planner.limits import Limits
from halfroll.planner.plan import Plan

BROKEN_OFF_M = (
    1.5  # [m] height that is lost at most when the stream of references ends while it turns over, or upside down
)
_STEP_S = 0.002
_ROUNDING_M = 2e-3  # best flights may be a millimetre lower than the paper's


def require_room(plan: Plan, limits: Limits, demands: Sequence[Demand] = ()) -> None:
    """Raises MissionError, naming the item, for a manoeuvre that begins too low, or does not keep what it was to."""
    for start, end in plan.turns or ():
        last = int(np.searchsorted(plan.times_s, end - 1e-9))
        waypoint = plan.waypoints[min(last, len(plan.waypoints) - 1)]
        where = f"item {waypoint.item}" if waypoint.item is not None else f"waypoint {last + 1}"
        heights = plan.trajectory.at(np.arange(start, end, _STEP_S))[:, 2]
        lowest, begins = float(heights.min()), float(heights[0])
        if limits.floor is not None and lowest - BROKEN_OFF_M < limits.floor - _ROUNDING_M:
            raise MissionError(
                f"{where}: turning over comes down to {lowest:.1f} m, and by {BROKEN_OFF_M:g} m more if it is broken "
                f"off; begin at {limits.floor + BROKEN_OFF_M + begins - lowest:.1f} m or higher (it is {begins:.1f} "
                f"m; the floor is {limits.floor:g} m)",
                waypoint.item,
            )
        for demand in demands:
            if demand.item != waypoint.item:
                continue
            if not math.isnan(demand.least_height) and lowest < demand.least_height - _ROUNDING_M:
                raise MissionError(
                    f"{where}: the flip comes down to {lowest:.2f} m, it is to stay above {demand.least_height:.2f} m; "
                    "begin it higher",
                    waypoint.item,
                )
            if end - start > demand.longest_s:
                raise MissionError(
                    f"{where}: a flip takes {end - start:.2f} s, it is to take at most {demand.longest_s:.2f} s; "
                    "allow more",
                    waypoint.item,
                )
