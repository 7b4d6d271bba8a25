"""What a flight came to: a log against its plan, in numbers.

Why: the only judge of "flown within limits". Everything is measured on the simulator's true state, not on the
autopilot's estimate of it.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfroll.errors import InputError
from halfroll.results.log import Log, Topic

if TYPE_CHECKING:
    from halfroll.planner.plan import Plan
    from halfroll.vehicle import Vehicle

FloatArray = NDArray[np.float64]
Rotors = tuple[float, float, float, float]

TRACKING_LIMIT_M = 0.5  # farther from the plan than this, the flight was not the one that was certified
WAYPOINT_LIMIT_M = 0.5  # a passed waypoint that was missed by more does not count as flown
SATURATION_LIMIT = 0.05  # share of the planned part in which the mixer may have to cut what control asks for
EDGE_SATURATION_LIMIT = 0.3  # the same for a plan that itself uses all that the rotors have (margin 0)
EDGE = 0.02  # a plan that keeps less than this share of the largest thrust free does
AT_LIMIT_N = 1e-4  # the mixer never goes beyond a limit, it stays at it; logged in single precision
HAND_BACK_TOLERANCE_S = 0.02  # two ticks of the reference stream


@dataclass(frozen=True)
class Check:
    """One condition of "within limits", with what was measured and what is allowed, as a person reads it."""

    what: str
    got: str
    allowed: str
    holds: bool


@dataclass(frozen=True)
class FlightFigures:
    """The figures of one flight. Errors are distances in space [m], thrusts are commands over the planned part [N]."""

    T_planned_s: float
    T_flown_s: float  # from the plan's start until the autopilot left OFFBOARD
    flight_s: float  # arm to disarm
    tracking_rms_m: float
    tracking_max_m: float
    waypoint_miss_m: tuple[float, ...]  # true position when each waypoint is due, to that waypoint
    waypoint_miss_max_m: float
    rotor_min_N: Rotors
    rotor_max_N: Rotors
    checks: tuple[Check, ...]
    rotor_saturated: float = 0.0  # share of the planned part in which a rotor command is at a limit

    @property
    def within_limits(self) -> bool:
        return all(check.holds for check in self.checks)

    def as_json(self) -> dict[str, Any]:
        return {key: value for key, value in asdict(self).items() if key != "checks"}


def evaluate(plan: Plan, plan_start_s: float, log: Log, vehicle: Vehicle) -> FlightFigures:
    """The figures of a flight whose plan began at `plan_start_s` of vehicle time.

    Raises InputError when the log does not reach into the planned part.
    """
    truth, commands, state = log["vehicle_truth"], log["rotor_commands"], log["vehicle_state"]
    planned = between(truth, plan_start_s, plan_start_s + plan.T)
    commanded = commands["thrust"][between(commands, plan_start_s, plan_start_s + plan.T)].astype(np.float64)
    if not planned.any() or not len(commanded):
        raise InputError(
            f"{log.path}: the plan began at {plan_start_s:.2f} s, but the log covers "
            f"{truth.t[0]:.2f} to {truth.t[-1]:.2f} s"
        )
    t = truth.t[planned] - plan_start_s
    flown = path_figures(plan, t, truth["p"][planned], planned_positions(plan, t), commanded, vehicle)
    armed = state.t[np.asarray(state["armed"], dtype=bool)]
    low, high = vehicle.rotor.thrust_min_N, vehicle.rotor.thrust_max_N
    saturated = flown.rotor_saturated
    kept = min(min(plan.rotor_min) - low, high - max(plan.rotor_max))
    saturation_limit = SATURATION_LIMIT if kept > EDGE * high else EDGE_SATURATION_LIMIT
    flown_s = _hand_back(state, plan_start_s, truth.t[-1]) - plan_start_s
    worst, miss = flown.tracking_max_m, max(flown.waypoint_miss_m)
    checks = (
        Check(
            "plan flown to its end", f"{flown_s:.2f} s", f"{plan.T:.2f} s", flown_s >= plan.T - HAND_BACK_TOLERANCE_S
        ),
        Check("distance from the plan", f"{worst:.3f} m", f"{TRACKING_LIMIT_M:g} m", worst <= TRACKING_LIMIT_M),
        Check("distance from waypoints when due", f"{miss:.3f} m", f"{WAYPOINT_LIMIT_M:g} m", miss <= WAYPOINT_LIMIT_M),
        Check(
            "rotor at its limit",
            f"{100.0 * saturated:.1f} % of the time",
            f"{100.0 * saturation_limit:g} %",
            saturated <= saturation_limit,
        ),
        Check("landed and disarmed", "no" if state["armed"][-1] else "yes", "yes", not state["armed"][-1]),
    )
    return FlightFigures(
        T_planned_s=float(plan.T),
        T_flown_s=float(flown_s),
        flight_s=float(armed[-1] - armed[0]) if len(armed) else 0.0,
        tracking_rms_m=flown.tracking_rms_m,
        tracking_max_m=worst,
        waypoint_miss_m=flown.waypoint_miss_m,
        waypoint_miss_max_m=miss,
        rotor_min_N=flown.rotor_min_N,
        rotor_max_N=flown.rotor_max_N,
        checks=checks,
        rotor_saturated=saturated,
    )


@dataclass(frozen=True)
class PathFigures:
    """How near the plan a vehicle was flown, and what of its rotors that took."""

    tracking_rms_m: float
    tracking_max_m: float
    waypoint_miss_m: tuple[float, ...]
    rotor_min_N: Rotors
    rotor_max_N: Rotors
    rotor_saturated: float


def path_figures(
    plan: Plan, t: FloatArray, p: FloatArray, planned: FloatArray, commanded: FloatArray, vehicle: Vehicle
) -> PathFigures:
    """t (N,) [s] of the plan, rising; p and planned (N, 3), true and planned positions then; commanded (M, 4) [N] in
    the planned part."""
    error = np.linalg.norm(p - planned, axis=1)
    at = np.stack([np.interp(plan.times_s, t, column) for column in p.T], axis=1)
    misses = np.linalg.norm(at - waypoints(plan), axis=1)
    low, high = vehicle.rotor.thrust_min_N, vehicle.rotor.thrust_max_N
    at_limit = (commanded <= low + AT_LIMIT_N) | (commanded >= high - AT_LIMIT_N)
    return PathFigures(
        tracking_rms_m=float(np.sqrt(np.mean(error**2))),
        tracking_max_m=float(error.max()),
        waypoint_miss_m=tuple(float(distance) for distance in misses),
        rotor_min_N=_rotors(commanded.min(axis=0)),
        rotor_max_N=_rotors(commanded.max(axis=0)),
        rotor_saturated=float(np.mean(at_limit.any(axis=1))),
    )


def planned_positions(plan: Plan, t: FloatArray) -> FloatArray:
    """(N, 3) planned positions in W at the plan times t (N,); at rest before its start and after its end."""
    return np.asarray(plan.trajectory.at(np.clip(t, 0.0, plan.T))[:, :3], dtype=np.float64)


def waypoints(plan: Plan) -> FloatArray:
    """(n, 3) the waypoints that the plan passes, in W."""
    return np.array([waypoint.position for waypoint in plan.waypoints], dtype=np.float64)


def between(topic: Topic, start_s: float, end_s: float) -> NDArray[np.bool_]:
    """Which samples lie in start_s…end_s of vehicle time."""
    slack = 1e-7  # time stamps are whole microseconds
    return (topic.t >= start_s - slack) & (topic.t <= end_s + slack)


def at_times(topic: Topic, name: str, t: FloatArray) -> FloatArray:
    """(len(t), k) the field at times t, linear between samples."""
    return np.stack([np.interp(t, topic.t, column) for column in topic[name].T], axis=1)


def _hand_back(state: Topic, plan_start_s: float, end_s: float) -> float:
    """When the mode that flew the plan was left. Vehicle time [s]."""
    after = state.t >= plan_start_s
    if not after.any():
        return end_s
    t, mode = state.t[after], state["mode"][after]
    left = t[mode != mode[0]]
    return float(left[0]) if len(left) else end_s


def _rotors(thrust: FloatArray) -> Rotors:
    return (float(thrust[0]), float(thrust[1]), float(thrust[2]), float(thrust[3]))
