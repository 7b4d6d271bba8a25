"""References: path and measured state become one setpoint a tick (100 Hz), by the outer loop that is on board too.

Why: three fields of SET_ATTITUDE_TARGET are taken from three moments of the path, each lead removing one lag between
here and the rotors. This is the only place that knows the leads.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfroll import _firmware
from halfroll._firmware import FlatReference, OuterLoop, RotorKind, Setpoint
from halfroll.planner import segments
from halfroll.vehicle import GRAVITY, Vehicle

if TYPE_CHECKING:
    from halfroll.planner.plan import Plan

Array = NDArray[np.float64]

TICK_S = 0.010  # one setpoint each
SIGMA_WINDOW_S = 0.06  # the sign of the thrust is free this close to an event of sigma
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


@dataclass(frozen=True)
class Leads:
    """How far ahead of the tick each field is taken [s]; the attitude is taken at the tick itself."""

    mid_age: float  # mean age of a setpoint while it is in use
    rate_gain: float  # of the attitude loop, Kd/J [1/s]
    delay: float  # dead time of the rotors
    lag: float  # first-order, of their thrusts

    @classmethod
    def of(cls, params: Mapping[str, float], link_delay: float, rotor_delay: float = 0.0) -> Leads:
        """params: the autopilot's; link_delay: what the wire is believed to take [s], 0 in lockstep.

        The rate leads by the attitude loop's own lag J/Kd, the thrust by the rotors'.
        """
        delay = min(rotor_delay, params["ACT_LEAD"])
        rate_gain = 2.0 * params["ATT_ZETA"] * params["ATT_WN"]
        return cls(link_delay + TICK_S / 2.0, rate_gain, delay, params["ACT_LEAD"] - delay)

    def acceleration(self, path: Path, t: float) -> Array:
        """(3,) what the rotors are asked for so that, lagging, they give the path's acceleration."""
        at = path.at(t + self.mid_age + self.delay)
        return np.asarray(at[2, :3] + self.lag * at[3, :3])

    def rate_ahead(self, path: Path, t: float) -> Array:
        """(3,) what the rate sent at t is more than the path's at t: the path's while the setpoint is in use, and what
        makes the attitude law ask for the path's angular acceleration a, with what the rotors' lag needs.

        A rate w + e makes the law ask for J (rate_gain e - w x e), the second part from its -J w x w_d.
        """
        middle = t + self.mid_age
        begin, end = middle + self.delay - TICK_S / 2.0, middle + self.delay + TICK_S / 2.0
        speed_up = path.rate_at(end) - path.rate_at(begin)
        further = path.rate_change_at(end) - path.rate_change_at(begin)
        w = path.rate_at(middle)
        extra = _without_turning(self.rate_gain, w.tolist(), ((speed_up + self.lag * further) / TICK_S).tolist())
        return np.asarray(w - path.rate_at(t) + extra)


def _without_turning(gain: float, w: list[float], b: list[float]) -> Array:
    """(3,) e of gain e - w x e = b: (gain² b + gain w x b + w (w b)) / (gain (gain² + w²))."""
    (x, y, z), (p, q, r) = w, b
    along, share = x * p + y * q + z * r, 1.0 / (gain * (gain * gain + x * x + y * y + z * z))
    crossed = (y * r - z * q, z * p - x * r, x * q - y * p)
    return np.array([share * (gain * (gain * b[i] + crossed[i]) + w[i] * along) for i in range(3)])


@dataclass(frozen=True)
class Path:
    """A path as a table over its own time, 1 ms apart; before its start and after its end it is at rest.

    derivatives (N, 5, 4): position to snap of x, y, z [m] in W and yaw [rad]; rates (N, 3): body rates [rad/s] that its
    exact inverse dynamics need, body components; sigma_events: when the thrust turns over, upright before the first.
    """

    derivatives: Array
    rates: Array
    sigma_events: tuple[float, ...] = ()
    leads_nose: bool = False  # see _nose_led; not while it turns over, nor upside down
    turns: tuple[tuple[float, float], ...] = ()

    @property
    def duration(self) -> float:
        return (len(self.derivatives) - 1) * TABLE_STEP_S

    def at(self, t: float) -> Array:
        """(5, 4), linear between table rows."""
        return _interpolated(self.derivatives, t)

    def rate_at(self, t: float) -> Array:
        return _interpolated(self.rates, t)

    def rate_change_at(self, t: float) -> Array:
        return _interpolated(self._rate_changes, t)

    @cached_property
    def _rate_changes(self) -> Array:
        return np.asarray(np.gradient(self.rates, TABLE_STEP_S, axis=0))

    def sigma_at(self, t: float) -> float:
        return -1.0 if bisect_right(self.sigma_events, t) % 2 else 1.0

    def leads_nose_at(self, t: float) -> bool:
        turning = any(start <= t <= end for start, end in self.turns)
        return self.leads_nose and not turning and self.sigma_at(t) > 0.0

    def is_near_sigma_event(self, t: float) -> bool:
        return any(abs(t - event) < SIGMA_WINDOW_S for event in self.sigma_events)


def _interpolated(table: Array, t: float) -> Array:
    row = min(max(t / TABLE_STEP_S, 0.0), float(len(table) - 1))
    below = min(int(row + 1e-6), max(len(table) - 2, 0))
    share = row - below
    return np.asarray(table[below] + share * (table[min(below + 1, len(table) - 1)] - table[below]))


def _rows(duration: float) -> Array:
    return np.asarray(np.arange(math.ceil(duration / TABLE_STEP_S - 1e-9) + 1) * TABLE_STEP_S, dtype=np.float64)


def path_of(plan: Plan) -> Path:
    """The plan's table. Its last row lies at or just after the plan's end, where it is at rest."""
    t = _rows(plan.T)
    leads_nose = plan.mode != "paper"
    return Path(plan.trajectory.derivatives(t, 5), plan.rates(t), plan.sigma_events, leads_nose, plan.turns or ())


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


class References:
    """One setpoint a tick along a path. `loop` is the bound outer loop, holding the autopilot's gains."""

    def __init__(self, loop: OuterLoop, leads: Leads) -> None:
        self._loop, self._leads = loop, leads

    @classmethod
    def for_vehicle(cls, vehicle: Vehicle, params: Mapping[str, float], link_delay: float) -> References:
        """params: the autopilot's, at least PARAMETERS."""
        bound = _firmware.Params()
        for name in PARAMETERS:
            bound[name] = params[name]
        return cls(
            _firmware.OuterLoop(firmware_vehicle(vehicle), bound), Leads.of(params, link_delay, vehicle.rotor.delay_s)
        )

    def begin(self, state: TelemetryLike) -> None:
        """Forget what was flown before; continue from this attitude."""
        self._loop.reset(state.q_WB)

    def setpoint(self, path: Path, start_us: int, state: TelemetryLike) -> Setpoint:
        """What to send at the tick of `state` when `path` began at start_us of vehicle time."""
        t = (state.t_us - start_us) * 1e-6
        planned = path.at(t)
        asked: dict[str, Any] = {
            "t_us": state.t_us,
            "q_WB": state.q_WB,
            "w_WB_B": state.w_WB_B,
            "p_WB": state.p_WB,
            "v_WB": state.v_WB,
            "lead_acceleration": self._leads.acceleration(path, t),
            "mid_age": self._leads.mid_age,
            "sigma": path.sigma_at(t),
            "sigma_event_near": path.is_near_sigma_event(t),
        }

        def step(loop: OuterLoop, now: FlatReference, lead_rate: Array) -> Setpoint:
            # telemetry is the estimate for its own stamp, the tick
            return loop.step(**asked, at_sample=now, now=now, lead_rate=lead_rate)

        now = _flat(planned)
        if path.leads_nose_at(t):
            tried = step(self._loop.copy(), now, _NO_RATE)
            now = _flat(_nose_led(planned, path.rate_at(t)[2], tried))
        return step(self._loop, now, self._leads.rate_ahead(path, t))


def _nose_led(planned: Array, rate: float, tried: Setpoint) -> Array:
    """`planned` (5, 4) with the yaw and yaw rate for which position feedback turns the planned attitude the shortest
    way to the thrust axis of `tried`, at the planned body rate about it.

    Near the horizon the yaw of one attitude, counted from upright, depends so strongly on where the thrust axis points
    that feedback of a degree would turn the nose as far, with the little torque that rotors have for it.
    """
    force = planned[2, :3] + np.array([0.0, 0.0, GRAVITY])
    axis = force / np.linalg.norm(force)
    q_planned = _firmware.multiply(_least_rotation(_UP, axis), _about_up(planned[0, 3]))
    tried_axis = np.asarray(_firmware.rotate(tried.q_WD, _UP), dtype=np.float64)
    q_wanted = _firmware.multiply(_least_rotation(axis, tried_axis), q_planned)
    turn = _firmware.multiply(_firmware.conjugate(_least_rotation(_UP, tried_axis)), q_wanted)
    led = planned.copy()
    led[0, 3] = 2.0 * math.atan2(turn[3], turn[0])
    led[1, 3] += rate - tried.w_WD_D[2]
    return led


_UP = np.array([0.0, 0.0, 1.0])
_NO_RATE = np.zeros(3)


def _least_rotation(a: Array, b: Array) -> Array:
    """(4,): turns unit vector a onto b the shortest way; not for opposite ones."""
    q = np.array([1.0 + float(a @ b), *np.cross(a, b)])
    return np.asarray(q / np.linalg.norm(q))


def _about_up(yaw: float) -> Array:
    return np.array([math.cos(yaw / 2.0), 0.0, 0.0, math.sin(yaw / 2.0)])


def _flat(derivatives: Array) -> FlatReference:
    position, velocity, acceleration, jerk, snap = derivatives[:, :3]
    yaw, yaw_rate, yaw_acceleration = derivatives[:3, 3].tolist()
    return FlatReference(
        position=position,
        velocity=velocity,
        acceleration=acceleration,
        jerk=jerk,
        snap=snap,
        yaw=yaw,
        yaw_rate=yaw_rate,
        yaw_acceleration=yaw_acceleration,
    )


def firmware_vehicle(vehicle: Vehicle) -> _firmware.Vehicle:
    """The vehicle as the firmware's C++ knows it."""
    bound = _firmware.Vehicle()
    bound.mass, bound.inertia = vehicle.mass_kg, np.array(vehicle.inertia_kg_m2)
    bound.arm, bound.yaw_coefficient = vehicle.arm_m, vehicle.yaw_coefficient_m
    bound.rotor_kind = RotorKind.VARIABLE_PITCH if vehicle.variable_pitch else RotorKind.FIXED_PITCH
    bound.thrust_min, bound.thrust_max = vehicle.rotor.thrust_min_N, vehicle.rotor.thrust_max_N
    bound.rotor_lag, bound.rotor_lag_down = vehicle.rotor.lag_s, vehicle.rotor.lag_down_s
    return bound
