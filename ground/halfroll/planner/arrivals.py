"""Given times of arrival: which legs have one, and how their times are shared out.

Why: least time and given times are two questions. The first is answered for the whole stretch as if no time were
given; then the legs between two given times share the time between them as they did in that fastest flight, and their
durations are fixed. With nothing left to shorten the solver ends in the middle of the limits: the gentlest flight.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from halfroll.errors import InfeasibleSegment, MissionError
from halfroll.planner.course_nodes import CourseNode
from halfroll.planner.limits import Limits

Array = NDArray[np.float64]


def require_possible(points: Sequence[CourseNode], limits: Limits) -> None:
    """Raises for times that do not rise, or that ask for more than the speed limit even on a straight line."""
    before = points[0]
    if before.waypoint.time_s not in (None, 0.0):
        raise MissionError(
            f"{before.name}: the plan begins here at 0 s, not at {before.waypoint.time_s:g} s; take time_s out",
            before.waypoint.item,
        )
    since, distance, fastest = before.hold_s, 0.0, 0.0
    for here, there in pairwise(points):
        if any(here.waypoint.free + there.waypoint.free):
            distance = -np.inf  # not known until there is a plan
        distance += float(np.linalg.norm(np.subtract(there.waypoint.position, here.waypoint.position)))
        speeds = [speed for speed in (limits.speed_max, here.waypoint.speed_max) if speed is not None]
        fastest = max(fastest, min(speeds, default=np.inf))
        time_s = there.waypoint.time_s
        if time_s is not None:
            needed = distance / max(time_s - since, 1e-9)
            if time_s <= since:
                raise MissionError(
                    f"{there.name}: arrival at {time_s:g} s is not after {since:g} s, when {before.name} is left; "
                    "let times rise",
                    there.waypoint.item,
                )
            if needed > fastest:
                raise InfeasibleSegment(
                    f"{there.name}: arrival at {time_s:g} s needs {needed:.2f} m/s from {before.name} on, "
                    f"{needed - fastest:.2f} m/s above the limit of {fastest:g} m/s; arrive later",
                    there.waypoint.item,
                )
            before, since, distance, fastest = there, time_s, 0.0, 0.0
        since += there.hold_s


def given_times(points: Sequence[CourseNode], start_s: float) -> list[tuple[int, float]]:
    """(node, time since the stretch began at start_s) of the nodes of a stretch whose time is given."""
    return [
        (place, point.waypoint.time_s - start_s)
        for place, point in enumerate(points)
        if place > 0 and point.waypoint.time_s is not None
    ]


def shared_out(durations: Array, times: Sequence[tuple[int, float]]) -> tuple[Array, list[bool]]:
    """Durations of legs (N,) so that the nodes are reached at the given times; which legs that fixes."""
    shared, timed = durations.copy(), [False] * len(durations)
    first, since = 0, 0.0
    for node, time_s in times:
        shared[first:node] *= (time_s - since) / durations[first:node].sum()
        timed[first:node] = [True] * (node - first)
        first, since = node, time_s
    return shared, timed


def too_early(
    points: Sequence[CourseNode], durations: Array, times: Sequence[tuple[int, float]], start_s: float
) -> InfeasibleSegment:
    """For the time that is missed most by the fastest flight found, whose legs take `durations`."""
    fastest = np.concatenate([[0.0], np.cumsum(durations)])
    node, time_s = max(times, key=lambda given: fastest[given[0]] - given[1])
    point, late = points[node], fastest[node] - time_s
    if late > 0.0:
        why = f"is {late:.3g} s too early: the fastest flight found needs {start_s + fastest[node]:.2f} s; arrive later"
    else:
        why = "is met by no flight that was found; give it another time, or leave it out"
    return InfeasibleSegment(f"{point.name}: arrival at {start_s + time_s:g} s {why}", point.waypoint.item)
