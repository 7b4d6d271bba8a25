"""Where the search begins: a flight that is slow, but inside the limits.

Why: the solver may start outside, but ends sooner, and never in the wrong valley, from a flight that fits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from halfroll import _planner as kernel
from halfroll.errors import PlanError
from halfroll.planner.kernel_problem import Setup, leg_durations, leg_ends
from halfroll.planner.segments import PiecewisePolynomial, solve

_ROOM = 0.01  # relative margin at which the start needs no more slowing down
_LOOKS = 64  # a leg, along which way it goes
_STANDS_M_S = 1e-3


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


def along_its_path(flight: kernel.Problem, setup: Setup) -> kernel.Problem:
    """A flight whose nose was free, with it along the path: at each waypoint as the path has turned, and at the end as
    often around, for a nose that turned the other way would never find back."""
    ends = leg_ends(flight)
    path = PiecewisePolynomial(np.concatenate([[0.0], np.cumsum(flight.durations)]), np.array(flight.coefficients))
    t = np.linspace(0.0, path.times[-1], _LOOKS * len(ends))
    velocity = path.derivatives(t, 2)[:, 1, :2]
    t, velocity = t[moving := np.linalg.norm(velocity, axis=1) > _STANDS_M_S], velocity[moving]
    nodes, times = setup.stretch.nodes.copy(), path.times[ends]
    if len(t) > 1:
        heading = np.unwrap(np.arctan2(velocity[:, 1], velocity[:, 0]))
        heading += 2.0 * np.pi * np.round((nodes[0, 0, 3] - heading[0]) / (2.0 * np.pi))
        at_nodes = np.interp(times, t, heading)
        free = ~setup.given[:, 0, 3]
        nodes[free, 0, 3] = at_nodes[free]
        nodes[free, 1, 3] = np.interp(times, t, np.gradient(heading, t))[free]
        nodes[free, 2:, 3] = 0.0
        around = np.round((at_nodes - nodes[:, 0, 3]) / (2.0 * np.pi))
        nodes[~free, 0, 3] += 2.0 * np.pi * around[~free]
    aimed = replace(setup, stretch=replace(setup.stretch, nodes=nodes))
    return aimed.problem(flight.nodes[ends], leg_durations(flight))


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
