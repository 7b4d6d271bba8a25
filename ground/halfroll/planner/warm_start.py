"""Where the search begins: a flight that is slow, but inside the limits.

Why: the solver may start outside, but ends sooner, and never in the wrong valley, from a flight that fits.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from halfroll import _planner as kernel
from halfroll.errors import PlanError
from halfroll.planner.kernel_problem import Setup
from halfroll.planner.segments import solve

_ROOM = 0.01  # relative margin at which the start needs no more slowing down


def warm_start(setup: Setup, constraints: kernel.Constraints) -> kernel.Problem:
    """The paper's polynomials, or stopping at every point where that is shorter (legs of very unequal length), in times
    by distance, slowed down until they fit."""
    nodes, fastest = setup.stretch.nodes, setup.fastest
    guess = np.zeros_like(nodes)
    guess[:, 0, :3] = [point.waypoint.position for point in setup.points]
    distance = np.linalg.norm(np.diff(guess[:, 0, :3], axis=0), axis=1)
    turn = np.abs(np.nan_to_num(np.diff(nodes[:, 0, 3])))
    durations = 0.45 * np.sqrt(distance) + 0.12 + 0.2 * np.sqrt(turn)
    durations[0] += 0.25 * np.sqrt(distance[0])
    durations[-1] += 0.25 * np.sqrt(distance[-1])
    durations = np.maximum(durations, 1.5 * distance / fastest)

    def smooth(factor: float) -> kernel.Problem:
        path = solve(nodes, factor * durations)
        return setup.problem(path.derivatives(path.times, 5), factor * durations)

    def stopping(factor: float) -> kernel.Problem:
        return setup.problem(guess, factor * np.maximum(durations, 2.5 * distance / fastest))

    makers = [smooth, stopping][: 1 if len(durations) == 1 else 2]
    try:
        solve(nodes, durations)
    except PlanError:  # given accelerations can leave the paper's form undetermined
        makers = [stopping]
    starts = [_slow_enough(make, constraints) for make in makers]
    return min(starts, key=lambda start: (max(0.0, _ROOM - start[1]), start[0].total))[0]


def _slow_enough(
    make: Callable[[float], kernel.Problem], constraints: kernel.Constraints
) -> tuple[kernel.Problem, float]:
    """(problem, least margin) at the first factor that leaves room in the limits, or that leaves the most."""
    tried = []
    for factor in 1.12 ** np.arange(32):
        start = make(float(factor))
        tried.append((start, start.least_margin(constraints, 48)))
        if tried[-1][1] > _ROOM:
            break
    return max(tried, key=lambda start: min(start[1], _ROOM))
