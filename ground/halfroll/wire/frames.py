"""The wire's axes and integers. Why: the only lines where our world meets MAVLink's, so a sign can be wrong once only.

W is north-west-up and B forward-left-up; MAVLink's NED and FRD are both a half turn about x away, so one involution
serves positions, velocities, rates and attitudes. Its latitudes and longitudes are degE7 integers, its headings
clockwise from north.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

_HALF_TURN: dict[int, NDArray[np.float64]] = {3: np.array([1.0, -1.0, -1.0]), 4: np.array([1.0, 1.0, -1.0, -1.0])}


def to_wire(array: ArrayLike) -> NDArray[np.float64]:
    """Vectors (…, 3) of W or B, or quaternions (…, 4) [w, x, y, z] body to world, in NED/FRD. Else ValueError."""
    values = np.asarray(array, dtype=np.float64)
    size = values.shape[-1] if values.ndim else 0
    if size not in _HALF_TURN:
        raise ValueError(f"a vector has 3 numbers and a quaternion 4, not {size}")
    return np.multiply(values, _HALF_TURN[size])


from_wire = to_wire  # a half turn undoes itself


def degrees_to_wire(degrees: float) -> int:
    """Latitude or longitude in degE7 (1.1 cm), to the nearest. Raises ValueError for what is no angle on Earth."""
    if not abs(degrees) <= 360.0:
        raise ValueError(f"{degrees:g} is no latitude or longitude in degrees")
    return round(degrees * 1e7)


def degrees_from_wire(degrees_e7: int) -> float:
    return degrees_e7 / 1e7


def heading_deg_to_yaw(heading_deg: float) -> float:
    """Compass heading [deg, clockwise from north] as yaw in W [rad, counter-clockwise from north]; not wrapped."""
    return -math.radians(heading_deg)


def yaw_to_heading_deg(yaw: float) -> float:
    """Yaw in W [rad] as compass heading in [0, 360) degrees."""
    return math.degrees(-yaw) % 360.0


Quaternion = tuple[float, float, float, float]


def attitude_from_degrees(roll_deg: float, pitch_deg: float, yaw: float) -> Quaternion:
    """q_WB of roll right wing down, pitch nose up [deg] and yaw in W [rad]; turned in the order yaw, pitch, roll."""
    cr, sr = math.cos(math.radians(roll_deg) / 2.0), math.sin(math.radians(roll_deg) / 2.0)
    cp, sp = math.cos(math.radians(pitch_deg) / 2.0), -math.sin(math.radians(pitch_deg) / 2.0)
    cy, sy = math.cos(yaw / 2.0), math.sin(yaw / 2.0)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def attitude_to_degrees(q_WB: Quaternion) -> tuple[float, float, float]:
    """Roll, pitch and heading [deg] of q_WB; pitch in [-90, 90], heading in [0, 360)."""
    w, x, y, z = q_WB
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = -math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return math.degrees(roll), math.degrees(pitch), yaw_to_heading_deg(yaw)


def body_rate_from_degrees(rates_deg_s: tuple[float, float, float]) -> tuple[float, float, float]:
    """w_WB_B [rad/s] of rates about the wire's axes [deg/s]: right wing down, nose up, clockwise."""
    roll, pitch, yaw = rates_deg_s
    return math.radians(roll), -math.radians(pitch), -math.radians(yaw)
