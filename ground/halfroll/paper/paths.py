"""The paths that the paper flies: nodes and times as read from its figures, x and z in one vertical plane.

Why: given times and accelerations are its inputs, not results; every figure takes them from here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halfroll.missions.mission import Waypoint
from halfroll.planner.limits import Limits, margins
from halfroll.planner.minimum_time import Stretch, shortest
from halfroll.planner.plan import Plan
from halfroll.planner.segments import FREE, PiecewisePolynomial, node, rest, solve
from halfroll.vehicle import GRAVITY, Vehicle

Array = NDArray[np.float64]

FLIP_S, FLIP_WIDTH_M = 1.0634, 0.4  # Fig 2
BACKFLIP_TIMES_S = (0.0, 0.670, 0.968, 1.150, 1.397, 2.110)  # Fig 3
BACKFLIP_X_M = (0.0, 1.00, 1.98, 2.39, 3.17, 4.19)
BACKFLIP_Z_M = (0.0, 0.102, 0.495, 0.489, 0.108, 0.0)
BACKFLIP_PUSH = 5.0  # [m/s²] along -x at its third node, +x at its fourth, in free fall
CLIMB_HEIGHTS_M = (0.0, 0.25, 0.90, 1.0)  # Fig 5
CLIMB_S = 0.7826  # Fig 6 flies the shortest climb stretched to this


def rotor_limits(vehicle: Vehicle) -> Limits:
    """Rotor thrust alone, as the paper has it."""
    return Limits(vehicle.rotor.thrust_min_N, vehicle.rotor.thrust_max_N)


def free_fall_flip(
    vehicle: Vehicle, start_m: float = 0.0, duration: float = FLIP_S, width: float = FLIP_WIDTH_M
) -> Plan:
    """Fig 2: hover, half way the force is zero at a free position, hover upside down."""
    apex = node([FREE, 0.0, FREE, 0.0])
    apex[2, [0, 2]] = 0.0, -GRAVITY
    nodes = [rest([0.0, 0.0, start_m, 0.0]), apex, rest([width, 0.0, start_m, 0.0])]
    return _plan(vehicle, solve(nodes, [duration / 2.0] * 2), flips=(duration / 2.0,))


def backflip(vehicle: Vehicle, start_m: float = 0.0) -> Plan:
    """Fig 3: hover to hover, a whole turn backwards while translating."""
    pushes = {2: -BACKFLIP_PUSH, 3: BACKFLIP_PUSH}
    nodes = []
    for k, (x, z) in enumerate(zip(BACKFLIP_X_M, BACKFLIP_Z_M, strict=True)):
        place = [x, 0.0, start_m + z, 0.0]
        ends = k in (0, len(BACKFLIP_X_M) - 1)
        given = rest(place) if ends else node(place)
        if k in pushes:
            given[2, [0, 2]] = pushes[k], -GRAVITY
        nodes.append(given)
    return _plan(vehicle, solve(nodes, np.diff(BACKFLIP_TIMES_S)))


def climb(vehicle: Vehicle, node_times: Sequence[float], start_m: float = 0.0) -> Plan:
    """Figs 5 and 6: straight up through CLIMB_HEIGHTS_M at these times."""
    return _plan(vehicle, solve(_climb_nodes(CLIMB_HEIGHTS_M, start_m), np.diff(node_times)))


def shortest_climb(vehicle: Vehicle, heights: Sequence[float] = CLIMB_HEIGHTS_M) -> Plan:
    """Through these heights in the least time that the rotors allow.   Eqs 25-27"""
    nodes = np.stack(_climb_nodes(heights, 0.0))
    legs = len(heights) - 1
    stretch = Stretch(nodes, np.full(legs, np.inf), nodes[:, 0, :3])
    return _plan(vehicle, solve(nodes, shortest(stretch, vehicle, rotor_limits(vehicle))))


def _climb_nodes(heights: Sequence[float], start_m: float) -> list[Array]:
    places = [[0.0, 0.0, start_m + z, 0.0] for z in heights]
    return [rest(places[0]), *(node(place) for place in places[1:-1]), rest(places[-1])]


def _plan(vehicle: Vehicle, trajectory: PiecewisePolynomial, flips: tuple[float, ...] = ()) -> Plan:
    found = margins(trajectory, vehicle, rotor_limits(vehicle), flips=flips)
    ends = trajectory.at(trajectory.times[[0, -1]])
    return Plan(
        waypoints=tuple(Waypoint(tuple(end[:3]), yaw=float(end[3])) for end in ends.tolist()),
        vehicle=vehicle,
        trajectory=trajectory,
        times_s=(0.0, float(trajectory.times[-1])),
        rotor_min=found.rotor_min,
        rotor_max=found.rotor_max,
        certified=found.checked,
        violation_N=found.violation,
        flips=flips,
    )
