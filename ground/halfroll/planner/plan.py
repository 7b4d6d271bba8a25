"""Plans: the shortest checked flight through waypoints, in the paper's form (Eqs 25-27).

Why: the arrow from waypoints to a `Plan`, which everything that flies, draws or judges a flight reads. The course is
cut where the vehicle rests; the durations of each stretch come from minimum_time.py.
"""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from importlib import import_module
from itertools import pairwise
from math import ceil, isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfroll.errors import InfeasibleSegment, InputError, PlanError
from halfroll.missions.mission import Waypoint
from halfroll.planner.aerobatics import Turning, turns_over
from halfroll.planner.course_nodes import CourseNode, attitudes_allowed, checked_nodes, stretch_of
from halfroll.planner.flatness import FlatOutputs, inverse_dynamics
from halfroll.planner.limits import Limits, margins
from halfroll.planner.minimum_time import NoDurations, Stretch, shortest
from halfroll.planner.segments import PiecewisePolynomial, standing
from halfroll.reading import parse_json, read_arrays, read_text
from halfroll.vehicle import Vehicle

__all__ = ["FlatPoint", "Limits", "Plan", "plan_course"]

Array = NDArray[np.float64]
Progress = Callable[[str], None]

_SAMPLES_PER_PIECE = 1000  # to find where the thrust axis crosses the horizon
_PUSHES_UP = 20.0  # the largest thrust by this: rotors that push no less than this could have fixed pitch
COLUMNS = (
    "t_s", "x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s", "ax_m_s2", "ay_m_s2", "az_m_s2", "jx_m_s3", "jy_m_s3",
    "jz_m_s3", "sx_m_s4", "sy_m_s4", "sz_m_s4", "yaw_rad", "yaw_rate_rad_s", "yaw_acc_rad_s2", "sigma", "thrust_N",
    "q_w", "q_x", "q_y", "q_z", "f1_N", "f2_N", "f3_N", "f4_N",
)  # fmt: skip


@dataclass(frozen=True)
class FlatPoint:
    """The plan at one time, or at N times with a leading axis N: vectors (3,) in W, SI."""

    position: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    snap: Array
    yaw: Any
    yaw_rate: Any
    yaw_acceleration: Any
    sigma: Any  # +1 upright, -1 inverted


@dataclass(frozen=True)
class Plan:
    """A flight from rest at the first waypoint to rest at the last; its time t [s] starts at 0."""

    waypoints: tuple[Waypoint, ...]
    vehicle: Vehicle
    trajectory: PiecewisePolynomial
    times_s: tuple[float, ...]  # arrival at each waypoint; where it holds, the wait follows
    rotor_min: tuple[float, ...]  # [N], smallest thrust of each rotor
    rotor_max: tuple[float, ...]
    certified: bool  # every limit is proven to hold at every time; else `warnings` say which is in doubt
    violation_N: float  # by how much a rotor exceeds its limit
    warnings: tuple[str, ...] = ()
    flips: tuple[float, ...] = ()  # times at which F passes through zero (free-fall flips)
    mode: str = "paper"
    turns: tuple[tuple[float, float], ...] | None = None  # from when to when it turns over; None: not said

    @property
    def T(self) -> float:
        """[s]"""
        return float(self.trajectory.times[-1])

    @cached_property
    def sigma_events(self) -> tuple[float, ...]:
        """Times at which sigma changes sign; it starts at +1."""
        t, sigma, changes = self._dense_times, self._dense.sigma, self._dense.charts.changes
        events = t[1:][sigma[1:] != sigma[:-1]]
        nearest = [changes[np.abs(changes - event).argmin()] if len(changes) else np.inf for event in events]
        spacing = float(np.diff(t).max())
        return tuple(
            float(exact if abs(exact - event) <= spacing else event)
            for event, exact in zip(events, nearest, strict=True)
        )

    @property
    def piece_sigma(self) -> Array:
        """(N,) sigma of each piece of the trajectory, in its middle."""
        middles = self.trajectory.times[:-1] + self.trajectory.durations / 2.0
        return np.asarray(self.at(middles).sigma)

    @property
    def _turns(self) -> tuple[tuple[float, float], ...] | None:
        """When charts change; near-optimal flights measure yaw from upright even past the horizon, but for these."""
        return () if self.turns is None and self.mode != "paper" else self.turns

    def at(self, t: float | ArrayLike) -> FlatPoint:
        """The plan at time t, a number (a few microseconds) or N of them; at rest before 0 and after T."""
        if isinstance(t, (int, float)):
            times, tables = self._tables
            t = min(max(t, 0.0), times[-1])
            k = min(bisect_right(times, t) - 1, len(tables) - 1)
            d = tables[k] @ (t - times[k]) ** _POWERS
            sigma = 1.0 - 2.0 * (bisect_right(self.sigma_events, t) % 2)
            return FlatPoint(d[0, :3], d[1, :3], d[2, :3], d[3, :3], d[4, :3], d[0, 3], d[1, 3], d[2, 3], sigma)
        t = np.asarray(t, dtype=float)
        many = self.trajectory.derivatives(t.ravel(), 5).reshape(*t.shape, 5, 4)
        sigmas = 1.0 - 2.0 * (np.searchsorted(np.array(self.sigma_events), t, side="right") % 2)
        p, v, a, j, s = (many[..., d, :3] for d in range(5))
        return FlatPoint(p, v, a, j, s, many[..., 0, 3], many[..., 1, 3], many[..., 2, 3], sigmas)

    def outputs(self, t: Array) -> FlatOutputs:
        """Attitude, rates, torque and rotor thrusts at increasing times t."""
        return inverse_dynamics(t, self.trajectory.derivatives(t), self.vehicle, self.flips, self._dense.charts)

    def rates(self, t: ArrayLike) -> Array:
        """(len(t), 3) [rad/s]: body rates, body components, at increasing times t."""
        return self.outputs(np.atleast_1d(np.asarray(t, dtype=float))).w_WD_D

    def rates_table(self, dt: float) -> Array:
        """(K, 3) [rad/s]: body rates at 0, dt, 2 dt, .. until the end or just after it."""
        return self.rates(np.arange(ceil(self.T / dt - 1e-9) + 1) * dt)

    def sample(self, rate_hz: float = 1000.0) -> dict[str, Array]:
        """Columns by the names of COLUMNS, ready for a DataFrame; the first and the last row are the ends, at rest.
        Raises InputError for a rate that is none."""
        if not (rate_hz > 0.0 and isfinite(rate_hz)):
            raise InputError(f"a plan is sampled at more than 0 Hz, not {rate_hz:g} Hz")
        t = np.arange(ceil(self.T * rate_hz - 1e-6)) / rate_hz
        t = np.append(t, self.T)
        d, o = self.trajectory.derivatives(t), self.outputs(t)
        flat = [t, *d[:, :5, :3].reshape(len(t), 15).T, *d[:, :3, 3].T]
        return dict(zip(COLUMNS, [*flat, o.sigma, o.thrust, *o.q_WD.T, *o.rotors.T], strict=True))

    @cached_property
    def _dense(self) -> FlatOutputs:
        t = self._dense_times
        return inverse_dynamics(t, self.trajectory.derivatives(t), self.vehicle, self.flips, None, self._turns)

    @property
    def _dense_times(self) -> Array:
        pieces = self.trajectory.times[:-1, None], self.trajectory.durations[:, None]
        return np.append((pieces[0] + pieces[1] * np.arange(_SAMPLES_PER_PIECE) / _SAMPLES_PER_PIECE).ravel(), self.T)

    @cached_property
    def _tables(self) -> tuple[list[float], list[Array]]:
        """Start times, and for each piece (5, 4, 10): derivatives 0..4 in powers of the time since its start."""
        powers = np.arange(10)
        scaled = self.trajectory.coefficients / self.trajectory.durations[:, None, None] ** powers[:, None]
        tables = np.zeros((len(scaled), 5, 4, 10))
        for d in range(5):
            tables[:, d] = np.moveaxis(scaled, 1, 2)
            scaled = np.concatenate([scaled[:, 1:] * powers[1:, None], np.zeros_like(scaled[:, :1])], axis=1)
        return self.trajectory.times.tolist(), list(tables)

    def plot(self) -> Any:
        """A matplotlib figure of path, speed, tilt and rotor thrusts."""
        from halfroll.drawing import plan_figure

        rotor, title = self.vehicle.rotor, f"{self.vehicle.name}, mode {self.mode}: {self.T:.3f} s"
        points = np.array([waypoint.position for waypoint in self.waypoints])
        return plan_figure(self.sample(200.0), points, (rotor.thrust_min_N, rotor.thrust_max_N), title)

    def _repr_html_(self) -> str:
        """For a notebook."""
        return str(import_module("halfroll.results.cards").plan_card(self))

    def save(self, path: str | Path) -> None:
        """Write .npz or .json (both read back bit for bit by `load`), or .csv (1 kHz samples)."""
        path = Path(path)
        if path.suffix == ".csv":
            columns = self.sample()
            np.savetxt(
                path, np.stack(list(columns.values()), axis=1), "%.12g", ",", header=",".join(columns), comments=""
            )
        elif path.suffix == ".json":
            path.write_text(self.as_json() + "\n", encoding="utf-8")
        elif path.suffix == ".npz":
            description = np.array(json.dumps(self._description()))
            np.savez(path, plan=description, times=self.trajectory.times, coefficients=self.trajectory.coefficients)
        else:
            raise InputError(f"{path}: a plan is written as .npz, .json or .csv; choose one of these endings")

    def as_json(self) -> str:
        """All of it, bit for bit: what `save` writes as .json."""
        pieces = {"times": self.trajectory.times.tolist(), "coefficients": self.trajectory.coefficients.tolist()}
        return json.dumps({**self._description(), "trajectory": pieces}, indent=1)

    @classmethod
    def of_json(cls, text: str, where: str = "this text") -> Plan:
        """What as_json wrote. Raises InputError."""
        try:
            table = parse_json(text)
            return cls._described(
                table, {k: np.array(table["trajectory"][k], dtype=float) for k in ("times", "coefficients")}
            )
        except (KeyError, ValueError, TypeError) as error:
            raise InputError(f"{where} is not a plan that halfroll wrote ({error}); plan the mission again") from None

    @classmethod
    def load(cls, path: str | Path) -> Plan:
        """Read what `save` wrote as .npz or .json. Raises InputError."""
        path = Path(path)
        try:
            if path.suffix == ".npz":
                description, times, coefficients = read_arrays(path, ("plan", "times", "coefficients"))
                return cls._described(parse_json(str(description)), {"times": times, "coefficients": coefficients})
            if path.suffix == ".json":
                return cls.of_json(read_text(path), str(path))
            raise InputError(f"{path}: a plan is read from .npz or .json")
        except OSError as error:
            raise InputError(f"plan {path}: {error.strerror or error}; check the path") from None
        except (KeyError, ValueError, TypeError) as error:
            raise InputError(f"{path} is not a plan that halfroll wrote ({error}); plan the mission again") from None

    @classmethod
    def _described(cls, table: dict[str, Any], pieces: dict[str, Array]) -> Plan:
        return cls(
            waypoints=tuple(_waypoint(point) for point in table["waypoints"]),
            vehicle=Vehicle.model_validate(table["vehicle_numbers"]),
            trajectory=PiecewisePolynomial(**pieces),
            times_s=tuple(table["times_s"]),
            rotor_min=tuple(table["rotor_min_N"]),
            rotor_max=tuple(table["rotor_max_N"]),
            certified=table["certified"],
            violation_N=table["violation_N"],
            warnings=tuple(table["warnings"]),
            flips=tuple(table["flips_s"]),
            mode=table["mode"],
            turns=None if table["turns_s"] is None else tuple((start, end) for start, end in table["turns_s"]),
        )

    def _description(self) -> dict[str, Any]:
        return {
            "vehicle": self.vehicle.name,
            "mode": self.mode,
            "T_s": self.T,
            "times_s": list(self.times_s),
            "rotor_min_N": list(self.rotor_min),
            "rotor_max_N": list(self.rotor_max),
            "certified": self.certified,
            "violation_N": self.violation_N,
            "warnings": list(self.warnings),
            "flips_s": list(self.flips),
            "turns_s": None if self.turns is None else [list(turn) for turn in self.turns],
            "waypoints": [asdict(point) for point in self.waypoints],
            "vehicle_numbers": self.vehicle.model_dump(mode="json"),
        }


_POWERS = np.arange(10)


def _waypoint(table: dict[str, Any]) -> Waypoint:
    fields: dict[str, Any] = {key: tuple(entry) if isinstance(entry, list) else entry for key, entry in table.items()}
    return Waypoint(**fields)


def plan_course(
    waypoints: Sequence[Waypoint], vehicle: Vehicle, limits: Limits | None = None, progress: Progress | None = None
) -> Plan:
    """The shortest flight found through all waypoints, at rest at both ends and where one holds.

    limits: default Limits.of(vehicle). progress is told in words how far it is. Waypoints closer than SAME_PLACE are
    one; a turn there is flown at rest. Raises MissionError for waypoints that contradict each other,
    InfeasibleSegment when no durations are found whose margins all stay >= 0.
    """
    limits = Limits.of(vehicle) if limits is None else limits
    points = checked_nodes(waypoints, vehicle, limits)
    flown: list[Flown] = []
    for part in stretches(points):
        flown.append(_flown(part, vehicle, limits, progress, flown))
    return plan_of(waypoints, points, vehicle, flown, "paper")


@dataclass(frozen=True)
class Flown:
    """One stretch from rest to rest as it will be flown, its time from 0."""

    path: PiecewisePolynomial
    arrivals: Array  # (n-1,) at its points after the first
    rotor_min: tuple[float, ...]
    rotor_max: tuple[float, ...]
    certified: bool = True
    violation: float = 0.0
    flips: tuple[float, ...] = ()  # when its thrust changes sign
    plane: float | None = None  # heading of the plane in which it turns over, if it does


def mirror_of(before: Sequence[Flown]) -> float:
    """Heading [rad] of the plane in which the vehicle last turned over."""
    return next((now.plane for now in reversed(before) if now.plane is not None), 0.0)


def mirrored(points: Sequence[CourseNode], mirror: float) -> list[CourseNode]:
    """An inverted stretch as the upright one whose rotors do the same with opposite signs: its nose on the other side
    of the plane in which the vehicle turned over."""
    return [replace(point, yaw=2.0 * mirror - point.yaw) for point in points]


def mirrored_back(path: PiecewisePolynomial, mirror: float) -> PiecewisePolynomial:
    coefficients = path.coefficients.copy()
    coefficients[:, :, 3] *= -1.0
    coefficients[:, 0, 3] += 2.0 * mirror
    return PiecewisePolynomial(path.times, coefficients)


def stretches(points: Sequence[CourseNode]) -> list[Sequence[CourseNode]]:
    """From rest to rest; each begins where the one before ends."""
    rests = [place for place, point in enumerate(points) if point.at_rest]
    return [points[first : last + 1] for first, last in pairwise(rests)]


def plan_of(
    waypoints: Sequence[Waypoint], points: Sequence[CourseNode], vehicle: Vehicle, flown: Sequence[Flown], mode: str
) -> Plan:
    """All stretches in a row, with the holds between them."""
    parts = stretches(points)
    arrivals, turns, flips = [points[0].hold_s], [], []
    paths = []
    for part, now in zip(parts, flown, strict=True):
        if part[0].hold_s > 0.0:
            paths.append(standing(now.path.at(0.0)[0], part[0].hold_s))
        start = sum(float(path.times[-1]) for path in paths)
        paths.append(now.path)
        arrivals += (start + now.arrivals).tolist()
        flips += [start + flip for flip in now.flips]
        if now.plane is not None:
            turns.append((start, start + float(now.path.times[-1])))
    if points[-1].hold_s > 0.0:
        paths.append(standing(paths[-1].at(paths[-1].times[-1])[0], points[-1].hold_s))
    trajectory = paths[0]
    for path in paths[1:]:
        trajectory = trajectory.then(path)
    at = {place: t for point, t in zip(points, arrivals, strict=True) for place in point.places}
    at[0] = 0.0
    return Plan(
        waypoints=tuple(waypoints),
        vehicle=vehicle,
        trajectory=trajectory,
        times_s=tuple(at[place] for place in range(len(waypoints))),
        rotor_min=tuple(np.min([now.rotor_min for now in flown], axis=0).tolist()),
        rotor_max=tuple(np.max([now.rotor_max for now in flown], axis=0).tolist()),
        certified=all(now.certified for now in flown),
        violation_N=max(now.violation for now in flown),
        warnings=(*radical(trajectory, points, arrivals), *_doubts(parts, flown)),
        flips=tuple(flips),
        mode=mode,
        turns=tuple(turns),
    )


def _doubts(parts: Sequence[Sequence[CourseNode]], flown: Sequence[Flown]) -> list[str]:
    return [
        f"not proven: from {part[0].name} to {part[-1].name}, where it turns over, limits hold at dense samples only"
        for part, now in zip(parts, flown, strict=True)
        if now.plane is not None and not now.certified
    ]


def _flown(
    points: Sequence[CourseNode],
    vehicle: Vehicle,
    limits: Limits,
    progress: Progress | None,
    before: Sequence[Flown],
) -> Flown:
    def told(total: float, iteration: int) -> None:
        if progress is not None:
            progress(f"{points[0].name} to {points[-1].name}: {total:.3f} s after {iteration} steps")

    if turns_over(points):
        return turned_over(points, vehicle, limits, told)
    inverted = not points[0].upright
    limits = attitudes_allowed(points, limits.inverted if inverted else limits)
    mirror = mirror_of(before)
    stretch = stretch_of(mirrored(points, mirror) if inverted else points, vehicle)
    path = stretch.trajectory(_trial(stretch, points, vehicle, limits, told))
    found = margins(path, vehicle, limits, segment_speed_max=stretch.speed_max, turns=())
    rotors = rotor_ranges(found.rotor_min, found.rotor_max, inverted)
    path = mirrored_back(path, mirror) if inverted else path
    return Flown(path, path.times[1:], *rotors, found.checked, found.violation)


def turned_over(
    points: Sequence[CourseNode],
    vehicle: Vehicle,
    limits: Limits,
    told: Callable[[float, int], None],
    knots: bool = False,
) -> Flown:
    """A stretch that turns over, in the paper's form or, if that is shorter, with virtual knots."""
    turning = Turning.of(points, vehicle)
    trial, found = turning.shortest(vehicle, limits, told)
    path = turning.stretch.trajectory(trial)
    arrivals, flips = path.times[1:], turning.stretch.flips(path.durations)
    certified = found.checked and turning.is_proven(path, arrivals, vehicle, limits, form_obeys_rates=False)
    if knots and (better := turning.shortened(trial, vehicle, limits, told)) is not None:
        flight, found = better
        certified = True
        path, arrivals, flips = flight.path, flight.leg_ends, flight.flips
    return Flown(
        turning.plane.out_of(path), arrivals, found.rotor_min, found.rotor_max, certified, found.violation,
        tuple(flip for flip in flips if flip > 0.0), turning.plane.heading,
    )  # fmt: skip


def rotor_ranges(
    rotor_min: Sequence[float], rotor_max: Sequence[float], inverted: bool
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Of a stretch that is flown inverted and was planned as its mirror image: pushing down is pulling up, and left is
    right."""
    if not inverted:
        return tuple(rotor_min), tuple(rotor_max)
    left, back, right, front = range(4)
    mirrored = (right, back, left, front)
    return tuple(-rotor_max[k] for k in mirrored), tuple(-rotor_min[k] for k in mirrored)


def _trial(
    stretch: Stretch,
    points: Sequence[CourseNode],
    vehicle: Vehicle,
    limits: Limits,
    told: Callable[[float, int], None],
) -> Array:
    """Shortest durations; with variable pitch never longer than what rotors that only push up would need."""
    starts: list[Array] = []
    push = vehicle.rotor.thrust_max_N / _PUSHES_UP
    if stretch.legs > 1 and limits.rotor_min < push:
        up = replace(limits, rotor_min=push, force_z_min=max(limits.force_z_min or 0.0, 4.0 * push))
        try:
            starts = [shortest(stretch, vehicle, up, (), told)]
        except PlanError:
            starts = []
    try:
        return shortest(stretch, vehicle, limits, starts, told)
    except NoDurations as error:
        ends = points[error.segment], points[error.segment + 1]
        raise InfeasibleSegment(f"from {ends[0].name} to {ends[1].name}: {error}", ends[1].waypoint.item) from None


def radical(trajectory: PiecewisePolynomial, points: Sequence[CourseNode], arrivals: Sequence[float]) -> list[str]:
    """Free polynomials may swing far out between their nodes: farther than twice the span of the nodes, by name.

    arrivals: [s], at each of the points.
    """
    nodes = np.array([point.waypoint.position for point in points])
    middle, span = (nodes.min(axis=0) + nodes.max(axis=0)) / 2.0, float(np.linalg.norm(np.ptp(nodes, axis=0)))
    t = np.linspace(0.0, trajectory.times[-1], 100 * len(trajectory.durations))
    far = np.linalg.norm(trajectory.at(t)[:, :3] - middle, axis=1)
    if span == 0.0 or far.max() <= 2.0 * span:
        return []
    leg = int(np.clip(np.searchsorted(arrivals, t[far.argmax()]), 1, len(points) - 1))
    return [
        f"from {points[leg - 1].name} to {points[leg].name} the path swings out to {far.max():.1f} m from the middle "
        f"of waypoints that span {span:.1f} m; add a waypoint there, give more time, or fix fewer derivatives"
    ]
