"""What a viewer shows: what stands still (`Setting`), one instant of a flight (`Moment`), and many of them in order.

Why: live, logged and planned flights look alike, so whatever draws them knows these values and no source of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, overload

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from halfroll.planner.plan import Plan
    from halfroll.vehicle import Vehicle

Array = NDArray[np.float64]

AT_LIMIT = 0.995  # share of a limit from which a rotor counts as saturated
_PATH_POINTS = 600
_SMALLEST_EXTENT_M, _ARM_OF_EXTENT = 2.0, 0.04  # drawn no smaller than that share of the scene


@dataclass(frozen=True)
class Gate:
    """A waypoint; with an attitude, a window that is flown through in it. position (3,) in W, q_WB (4,)."""

    position: Array
    q_WB: Array | None = None


@dataclass(frozen=True)
class Setting:
    """What does not move. path: (N, 3) of the reference in W, N = 0 where none is known."""

    title: str
    thrust_N: tuple[float, float]  # least and largest of a rotor
    arm_m: float
    path: Array = field(default_factory=lambda: np.zeros((0, 3)))
    gates: tuple[Gate, ...] = ()

    @property
    def corners(self) -> tuple[Array, Array]:
        """(3,), (3,): the box around everything that stands still, and the origin."""
        points = np.vstack([np.zeros((1, 3)), self.path, *(gate.position[None] for gate in self.gates)])
        return points.min(axis=0), points.max(axis=0)

    @property
    def seat(self) -> tuple[Array, Array]:
        """(3,) where a camera sees all of it from, and (3,) what it looks at: from the south-east, above."""
        low, high = self.corners
        middle, size = 0.5 * (low + high), max(float(np.linalg.norm(high - low)), 2.0 * _SMALLEST_EXTENT_M)
        return middle + size * np.array([-0.6, -0.6, 0.45]), middle

    @property
    def magnification(self) -> float:
        """How many times its size the vehicle is drawn, so that it is seen from where the whole path is."""
        low, high = self.corners
        extent = max(float((high - low).max()), _SMALLEST_EXTENT_M)
        return max(1.0, _ARM_OF_EXTENT * extent / self.arm_m)


@dataclass(frozen=True)
class Moment:
    """One instant. Vectors (3,) in W, body rate in B, quaternions (4,), rotor thrust (4,) [N]; SI and radians.

    What is not known is None; link figures are of the viewer's own link.
    """

    t_s: float
    p_WB: Array
    q_WB: Array
    v_WB: Array
    w_WB_B: Array
    rotor_N: Array | None = None
    reference_p: Array | None = None
    reference_q: Array | None = None
    mode: str = ""
    armed: bool = False
    item: int | None = None
    items: int | None = None
    warning: str = ""  # a failsafe that acts, in words
    link_rate_Hz: float | None = None
    link_age_s: float | None = None

    @property
    def speed(self) -> float:
        return float(np.linalg.norm(self.v_WB))

    @property
    def error_m(self) -> float | None:
        """From the reference; None without one."""
        return None if self.reference_p is None else float(np.linalg.norm(self.p_WB - self.reference_p))


@dataclass(frozen=True)
class Columns(Sequence[Moment]):
    """Moments by columns, as logs and plans have them; a row becomes a Moment when somebody looks at it.

    t_s (N,), vectors (N, 3), quaternions (N, 4), rotor_N (N, 4), mode and armed (N,), item (N,). What is not known
    of a row is NaN, of an item -1.
    """

    t_s: Array
    p_WB: Array
    q_WB: Array
    v_WB: Array
    w_WB_B: Array
    rotor_N: Array
    reference_p: Array
    reference_q: Array
    mode: Sequence[str]
    armed: NDArray[np.bool_]
    item: NDArray[np.int_]
    items: int | None = None

    def __len__(self) -> int:
        return len(self.t_s)

    @overload
    def __getitem__(self, row: int) -> Moment: ...

    @overload
    def __getitem__(self, row: slice) -> Sequence[Moment]: ...

    def __getitem__(self, row: int | slice) -> Moment | Sequence[Moment]:
        if isinstance(row, slice):
            return [self[i] for i in range(*row.indices(len(self)))]
        item = int(self.item[row])
        return Moment(
            float(self.t_s[row]),
            self.p_WB[row],
            self.q_WB[row],
            self.v_WB[row],
            self.w_WB_B[row],
            rotor_N=_known(self.rotor_N[row]),
            reference_p=_known(self.reference_p[row]),
            reference_q=_known(self.reference_q[row]),
            mode=self.mode[row],
            armed=bool(self.armed[row]),
            item=None if item < 0 else item,
            items=None if item < 0 else self.items,
        )

    def beside(self, plan: Plan, plan_start_s: float) -> Columns:
        """With the plan, which began at plan_start_s, as the reference while it is flown, and of nobody before and
        after."""
        t_s = self.t_s - plan_start_s
        inside = (t_s >= 0.0) & (t_s <= plan.T)
        p = np.asarray(plan.at(np.clip(t_s, 0.0, plan.T)).position, dtype=np.float64)
        item = np.where(inside, due_waypoint(plan, t_s), -1)
        return replace(self, reference_p=np.where(inside[:, None], p, np.nan), item=item, items=len(plan.waypoints))


def _known(row: Array) -> Array | None:
    return None if np.isnan(row[0]) else row


def due_waypoint(plan: Plan, t_s: Array) -> NDArray[np.int_]:
    """(N,) numbers, from 1, of the waypoints that are flown to at the plan's times t_s (N,)."""
    passed = np.searchsorted(np.asarray(plan.times_s), t_s, side="right")
    return np.asarray(np.minimum(passed + 1, len(plan.waypoints)))


@dataclass(frozen=True)
class Recording:
    """A whole flight, or a plan as if it were flown: moments at rising times."""

    setting: Setting
    moments: Sequence[Moment]
    times: Array  # (N,) of the moments

    @classmethod
    def of(cls, setting: Setting, moments: Sequence[Moment]) -> Recording:
        return cls(setting, moments, np.array([moment.t_s for moment in moments], dtype=np.float64))

    @classmethod
    def of_columns(cls, setting: Setting, columns: Columns) -> Recording:
        return cls(setting, columns, columns.t_s)

    @property
    def span(self) -> tuple[float, float]:
        return float(self.times[0]), float(self.times[-1])

    def at(self, t_s: float) -> Moment:
        """The last moment not after t_s; the first before all of them."""
        return self.moments[max(int(np.searchsorted(self.times, t_s + 1e-9, side="right")) - 1, 0)]

    def window(self, t_s: float, length_s: float, count: int) -> Sequence[Moment]:
        """At most `count` moments of the last length_s before t_s, in order."""
        first, last = np.searchsorted(self.times, [t_s - length_s, t_s + 1e-9], side="left")
        chosen = range(int(first), max(int(last), int(first) + 1), max(1, -(-(int(last) - int(first)) // count)))
        return [self.moments[min(i, len(self.moments) - 1)] for i in chosen]

    def thinned(self, rate_Hz: float) -> Recording:
        """At most so many moments a second, the last one kept."""
        due = np.arange(self.times[0], self.times[-1], 1.0 / rate_Hz)
        rows = np.unique(np.append(np.searchsorted(self.times, due - 1e-9), len(self.times) - 1))
        return Recording(self.setting, [self.moments[int(row)] for row in rows], self.times[rows])


def setting_of(vehicle: Vehicle, plan: Plan | None, title: str) -> Setting:
    thrust_N = (vehicle.rotor.thrust_min_N, vehicle.rotor.thrust_max_N)
    if plan is None:
        return Setting(title, thrust_N, vehicle.arm_m)
    t = np.linspace(0.0, plan.T, _PATH_POINTS)
    gates = tuple(
        Gate(np.array(point.position), None if point.q_WB is None else np.array(point.q_WB)) for point in plan.waypoints
    )
    return Setting(title, thrust_N, vehicle.arm_m, np.asarray(plan.at(t).position, dtype=np.float64), gates)


def planned(plan: Plan, title: str, rate_Hz: float = 100.0) -> Recording:
    """The plan as if it were flown without error."""
    columns = plan.sample(rate_Hz)

    def vectors(*names: str) -> Array:
        return np.stack([columns[name] for name in names], axis=1)

    t, p, q = columns["t_s"], vectors("x_m", "y_m", "z_m"), vectors("q_w", "q_x", "q_y", "q_z")
    v, f = vectors("vx_m_s", "vy_m_s", "vz_m_s"), vectors("f1_N", "f2_N", "f3_N", "f4_N")
    w = plan.rates(t)
    count = len(t)
    as_flown = Columns(
        t, p, q, v, w, f, p, q, ["PLAN"] * count, np.full(count, True), due_waypoint(plan, t), len(plan.waypoints)
    )
    return Recording.of_columns(setting_of(plan.vehicle, plan, title), as_flown)


def roll_pitch_heading_deg(q_WB: Array) -> tuple[float, float, float]:
    """As aviation and every ground control station count: right wing down, nose up, clockwise from north; the heading
    from -180 to 180, so that due north is no jump."""
    w, x, y, z = q_WB
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return math.degrees(roll), -math.degrees(pitch), math.degrees(-yaw)


def saturated(rotor_N: Array, thrust_N: tuple[float, float]) -> NDArray[np.bool_]:
    """(4,) which rotors are at a limit. rotor_N (4,)"""
    low, high = thrust_N
    edge = (1.0 - AT_LIMIT) * high
    return np.asarray((rotor_N <= low + edge) | (rotor_N >= high - edge))
