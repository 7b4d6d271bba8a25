"""References: what a plan, or the way to its start, is as a table, and the stream that follows one at 100 Hz.

Why: what is streamed is looked up and computed in C++ (ground/stream/references.cpp), the same for the ground station
and for flights inside a process; here plans and vehicles become what it takes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfroll import _firmware
from halfroll._firmware import Leads, Path, References, RotorKind
from halfroll.planner import segments
from halfroll.vehicle import Vehicle

if TYPE_CHECKING:
    from halfroll.planner.plan import Plan

__all__ = [
    "PARAMETERS",
    "Leads",
    "Path",
    "References",
    "approach",
    "for_vehicle",
    "heading",
    "other_vehicle",
    "path_of",
]

Array = NDArray[np.float64]

TABLE_STEP_S = 0.001  # time stamps are whole milliseconds
# Autopilot parameters the outer loop depends on: the ground flies with what the vehicle has, not with what it believes.
PARAMETERS = (
    "ACT_LEAD", "ATT_WN", "ATT_ZETA", "FADE_FORCE", "HOLD_FORCE", "LAG_COMP", "POS_KD_XY", "POS_KD_Z", "POS_KI_XY",
    "POS_KI_Z", "POS_KP_XY", "POS_KP_Z", "SIGN_RULE", "VEH_DRAG", "VEH_T_REF",
)  # fmt: skip
# What tells one vehicle from another; each with the value that turns it off, as the paper has it, on any vehicle.
_TELLS_VEHICLES = {"VEH_T_REF": None, "ACT_LEAD": 0.0, "ATT_WN": None, "LAG_COMP": 1.0, "VEH_DRAG": 0.0}
_APPROACH_ACCELERATION, _APPROACH_SPEED, _APPROACH_SHORTEST_S = 2.0, 3.0, 0.5  # m/s², m/s
_PEAK_SPEED, _PEAK_ACCELERATION = 2.47, 9.5  # of a 9th-order rest-to-rest move, in distance/T and distance/T²


class TelemetryLike(Protocol):
    """What of a telemetry sample counts here (messages.Telemetry has it)."""

    @property
    def t_us(self) -> int: ...
    @property
    def q_WB(self) -> Array: ...
    @property
    def w_WB_B(self) -> Array: ...
    @property
    def p_WB(self) -> Array: ...
    @property
    def v_WB(self) -> Array: ...


def _rows(duration: float) -> Array:
    return np.asarray(np.arange(math.ceil(duration / TABLE_STEP_S - 1e-9) + 1) * TABLE_STEP_S, dtype=np.float64)


def path_of(plan: Plan) -> Path:
    """The plan's table. Its last row lies at or just after the plan's end, where it is at rest."""
    t = _rows(plan.T)
    leads_nose = plan.mode != "paper"
    return Path(
        plan.trajectory.derivatives(t, 5), plan.rates(t), list(plan.sigma_events), leads_nose, list(plan.turns or ())
    )


def approach(state: TelemetryLike, position: ArrayLike, yaw: float) -> Path:
    """From where the vehicle is, with its velocity, gently to rest at position (3,) in W, turned to yaw."""
    away = np.asarray(position, dtype=np.float64) - state.p_WB
    yaw_now = heading(state.q_WB)
    turn = math.remainder(yaw - yaw_now, 2.0 * math.pi)
    distance, speed = float(np.linalg.norm(away)), float(np.linalg.norm(state.v_WB))
    duration = max(
        _APPROACH_SHORTEST_S,
        math.sqrt(_PEAK_ACCELERATION * distance / _APPROACH_ACCELERATION),
        _PEAK_SPEED * distance / _APPROACH_SPEED,
        4.0 * speed / _APPROACH_ACCELERATION,
        abs(turn),
    )
    start = segments.rest([*state.p_WB, yaw - turn])
    start[1, :3] = state.v_WB
    pieces = segments.solve([start, segments.rest([*np.asarray(position, dtype=np.float64), yaw])], [duration])
    t = _rows(duration)
    return Path(pieces.derivatives(t, 5), np.zeros((len(t), 3)))  # so gentle that its rates need no lead


def heading(q_WB: Array) -> float:
    """Yaw of the body's nose [rad], counter-clockwise from north."""
    w, x, y, z = q_WB
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def other_vehicle(vehicle: Vehicle, params: Mapping[str, float]) -> str | None:
    """What in the autopilot's params, at least PARAMETERS, is not as `vehicle` has it; None where nothing is."""
    defaults = _firmware.Params()
    for name, off in _TELLS_VEHICLES.items():
        expected, found = vehicle.params.get(name, float(defaults[name])), params[name]
        if name == "VEH_T_REF":
            expected = 4.0 * vehicle.rotor.thrust_max_N
        elif name == "VEH_DRAG":
            expected = vehicle.params.get(name, vehicle.drag_N_s_m)
        if found != off and not math.isclose(found, expected, rel_tol=1e-3, abs_tol=1e-6):
            return f"{name} is {found:.4g}, {vehicle.name} has {expected:.4g}"
    return None


def for_vehicle(vehicle: Vehicle, params: Mapping[str, float], link_delay: float) -> References:
    """One setpoint a tick for this vehicle. params: the autopilot's, at least PARAMETERS; link_delay: what the wire is
    believed to take [s], 0 in lockstep."""
    bound = _firmware.Params()
    for name in PARAMETERS:
        bound[name] = params[name]
    return References(firmware_vehicle(vehicle), bound, Leads.of(bound, link_delay, vehicle.rotor.delay_s))


def firmware_vehicle(vehicle: Vehicle) -> _firmware.Vehicle:
    """The vehicle as the firmware's C++ knows it."""
    bound = _firmware.Vehicle()
    bound.mass, bound.inertia = vehicle.mass_kg, np.array(vehicle.inertia_kg_m2)
    bound.arm, bound.yaw_coefficient = vehicle.arm_m, vehicle.yaw_coefficient_m
    bound.rotor_kind = RotorKind.VARIABLE_PITCH if vehicle.variable_pitch else RotorKind.FIXED_PITCH
    bound.thrust_min, bound.thrust_max = vehicle.rotor.thrust_min_N, vehicle.rotor.thrust_max_N
    bound.rotor_lag, bound.rotor_lag_down = vehicle.rotor.lag_s, vehicle.rotor.lag_down_s
    return bound
