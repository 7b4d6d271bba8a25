"""What a ground station tells whoever watches: where its plan leads, and what it wants of the vehicle now.

Why: MAVLink has no message for the path of a plan, and a viewer must not ask the station anything. Datagrams to a port
of the loopback interface cost the same whether somebody reads them or nobody.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfroll.reading import parse_json

Array = NDArray[Any]

TOLD_PORT = 14640  # + instance
_DIGITS = 4


@dataclass(frozen=True)
class ToldPlan:
    """path: (N, 3) in W; gates: position (3,) and attitude (4,) or None of each waypoint; thrust_N: of a rotor."""

    vehicle: str
    duration_s: float
    path: Array
    gates: tuple[tuple[Array, Array | None], ...]
    thrust_N: tuple[float, float]
    arm_m: float


@dataclass(frozen=True)
class ToldReference:
    """What was sent last, at t_us of vehicle time. p (3,) in W, q_WD (4,)."""

    t_us: int
    p: Array
    q_WD: Array


def packed(told: ToldPlan | ToldReference) -> bytes:
    if isinstance(told, ToldReference):
        return json.dumps({"t_us": told.t_us, "p": _rounded(told.p), "q_WD": _rounded(told.q_WD)}).encode()
    gates = [[_rounded(p), None if q is None else _rounded(q)] for p, q in told.gates]
    return json.dumps(
        {
            "vehicle": told.vehicle,
            "duration_s": told.duration_s,
            "path": _rounded(told.path),
            "gates": gates,
            "thrust_N": told.thrust_N,
            "arm_m": told.arm_m,
        }
    ).encode()


def unpacked(datagram: bytes) -> ToldPlan | ToldReference | None:
    """None for what no ground station of ours has sent: anybody may write to a port."""
    try:
        said = parse_json(datagram)
        if "t_us" in said:
            return ToldReference(int(said["t_us"]), _numbers(said["p"], 3), _numbers(said["q_WD"], 4))
        gates = tuple((_numbers(p, 3), None if q is None else _numbers(q, 4)) for p, q in said["gates"])
        low, high = (float(x) for x in said["thrust_N"])
        path = np.asarray(said["path"], dtype=np.float64).reshape(-1, 3)
        if not np.isfinite(path).all():
            return None
        return ToldPlan(str(said["vehicle"]), float(said["duration_s"]), path, gates, (low, high), float(said["arm_m"]))
    except (ValueError, TypeError, KeyError, OverflowError):
        return None


def _rounded(numbers: Array) -> list[float]:
    rounded: list[float] = np.round(numbers, _DIGITS).tolist()
    return rounded


def _numbers(said: object, count: int) -> Array:
    numbers = np.asarray(said, dtype=np.float64)
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise ValueError(f"not {count} numbers")
    return numbers
