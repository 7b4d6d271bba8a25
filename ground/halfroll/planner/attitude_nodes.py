"""What attitude, body rate and direction of a waypoint ask of the derivatives there (Eq 28; Eqs 15-18 inverted).

Why: the planner knows derivatives alone. An attitude fixes where the thrust points, so the acceleration lies on a line;
where the size of the thrust is free, the place on that line is one more unknown. A body rate turns the thrust, so the
jerk lies on a line too, along which the thrust grows.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfroll.body_axes import body_up
from halfroll.missions.mission import Quaternion, Waypoint
from halfroll.planner.segments import AXES, FREE, GIVEN
from halfroll.vehicle import GRAVITY, Vehicle

Array = NDArray[np.float64]

_SPEED = 3.0  # [m/s] by which a free speed is counted, and where it begins
_THRUST_GROWTH = 10.0  # weights a second, by which a free growth of the thrust is counted
_MOST_WEIGHTS = 1.6  # of thrust that a free one begins with


def flat_yaw(q_WB: Quaternion) -> float:
    """psi of q = (least rotation e3 -> n)(psi about z); not for straight upside down, where there is none."""
    return 2.0 * float(np.arctan2(q_WB[3], q_WB[0]))


def asked(waypoint: Waypoint, vehicle: Vehicle, sign: float) -> tuple[Array, list[tuple[Array, float]]]:
    """What is given of derivatives 1..4, (5, 4) with FREE where nothing is (the position always), and what may be added
    to it: multiples of `along` (5, 4), each with the multiple to begin with. sign: of the thrust here."""
    given = np.full((GIVEN, AXES), FREE)
    lines = []
    for order, derivative in enumerate((waypoint.velocity, waypoint.acceleration, waypoint.jerk, waypoint.snap), 1):
        if derivative is not None:
            given[order, :3] = derivative
    if waypoint.direction is not None:
        given[1, :3] = 0.0
        lines.append((_along(1, _SPEED * np.asarray(waypoint.direction)), 1.0))
    if waypoint.q_WB is not None:
        n = body_up(waypoint.q_WB)
        given[2, :3] = (0.0, 0.0, -GRAVITY)
        if waypoint.thrust is None:
            begin = min(1.0 / max(abs(float(n[2])), 1e-3), _MOST_WEIGHTS)
            lines.append((_along(2, sign * GRAVITY * n), begin))
        else:
            given[2, :3] += waypoint.thrust / vehicle.mass_kg * n
    if waypoint.body_rate is not None and waypoint.q_WB is not None and waypoint.thrust is not None:
        turning = _turned(waypoint.q_WB, np.array([waypoint.body_rate[1], -waypoint.body_rate[0], 0.0]))
        given[3, :3] = waypoint.thrust / vehicle.mass_kg * turning
        lines.append((_along(3, _THRUST_GROWTH * GRAVITY * n), 0.0))
        given[1, 3] = waypoint.body_rate[2] - (n[1] * turning[0] - n[0] * turning[1]) / (1.0 + n[2])
    return given, lines


def _along(order: int, vector: Array) -> Array:
    along = np.zeros((GIVEN, AXES))
    along[order, :3] = vector
    return along


def _turned(q: Quaternion, vector: Array) -> Array:
    """From B to W."""
    w, v = q[0], np.asarray(q[1:])
    across = 2.0 * np.cross(v, vector)
    return np.asarray(vector + w * across + np.cross(v, across))
