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
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfroll.errors import InfeasibleSegment, InputError, MissionError, PlanError
from halfroll.flatness import UPRIGHT, FlatOutputs, inverse_dynamics
from halfroll.limits import Limits, margins
from halfroll.minimum_time import NoDurations, Stretch, shortest
from halfroll.mission import Waypoint
from halfroll.segments import FREE, PiecewisePolynomial, node, rest, standing
from halfroll.vehicle import Vehicle

__all__ = ["FlatPoint", "Limits", "Plan", "plan_course"]

Array = NDArray[np.float64]
Progress = Callable[[str], None]

SAME_PLACE = 1e-3  # [m], closer waypoints are one
_SAMPLES_PER_PIECE = 1000  # to find where the thrust axis crosses the horizon
_PUSHES_UP = 0.05  # of the largest thrust: rotors that push no less than this could have fixed pitch
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
    certified: bool  # every limit holds in the dense, refined check (limits.margins)
    violation_N: float  # by how much a rotor exceeds its limit
    warnings: tuple[str, ...] = ()
    flips: tuple[float, ...] = ()  # times at which F passes through zero (free-fall flips)
    mode: str = "paper"

    @property
    def T(self) -> float:
        """[s]"""
        return float(self.trajectory.times[-1])

    @cached_property
    def sigma_events(self) -> tuple[float, ...]:
        """Times at which sigma changes sign; it starts at +1."""
        below = self._dense.thrust_axis[:, 2] < 0.0 if self._headed_from_upright else None
        if below is not None:
            return tuple(float(t) for t in self._dense_times[1:][below[1:] != below[:-1]])
        return tuple(float(t) for t in self._dense.charts.changes)

    @property
    def piece_sigma(self) -> Array:
        """(N,) sigma of each piece of the trajectory, in its middle."""
        middles = self.trajectory.times[:-1] + self.trajectory.durations / 2.0
        return np.asarray(self.at(middles).sigma)

    @property
    def _headed_from_upright(self) -> bool:
        """Whether yaw is measured from upright even where the vehicle tilts past the horizon."""
        return self.mode != "paper"

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
        """Columns by the names of COLUMNS, ready for a DataFrame; the first and the last row are the ends, at rest."""
        t = np.arange(ceil(self.T * rate_hz - 1e-6)) / rate_hz
        t = np.append(t, self.T)
        d, o = self.trajectory.derivatives(t), self.outputs(t)
        flat = [t, *d[:, :5, :3].reshape(len(t), 15).T, *d[:, :3, 3].T]
        return dict(zip(COLUMNS, [*flat, o.sigma, o.thrust, *o.q_WD.T, *o.rotors.T], strict=True))

    @cached_property
    def _dense(self) -> FlatOutputs:
        t, charts = self._dense_times, UPRIGHT if self._headed_from_upright else None
        return inverse_dynamics(t, self.trajectory.derivatives(t), self.vehicle, self.flips, charts)

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

    def save(self, path: str | Path) -> None:
        """Write .npz or .json (both read back bit for bit by `load`), or .csv (1 kHz samples)."""
        path = Path(path)
        if path.suffix == ".csv":
            columns = self.sample()
            np.savetxt(
                path, np.stack(list(columns.values()), axis=1), "%.12g", ",", header=",".join(columns), comments=""
            )
        elif path.suffix == ".json":
            pieces = {"times": self.trajectory.times.tolist(), "coefficients": self.trajectory.coefficients.tolist()}
            path.write_text(
                json.dumps({**self._description(), "trajectory": pieces}, indent=1) + "\n", encoding="utf-8"
            )
        elif path.suffix == ".npz":
            description = np.array(json.dumps(self._description()))
            np.savez(path, plan=description, times=self.trajectory.times, coefficients=self.trajectory.coefficients)
        else:
            raise InputError(f"{path}: a plan is written as .npz, .json or .csv; choose one of these endings")

    @classmethod
    def load(cls, path: str | Path) -> Plan:
        """Read what `save` wrote as .npz or .json. Raises InputError."""
        path = Path(path)
        try:
            if path.suffix == ".npz":
                with np.load(path, allow_pickle=False) as stored:
                    table, pieces = json.loads(str(stored["plan"])), {k: stored[k] for k in ("times", "coefficients")}
            elif path.suffix == ".json":
                table = json.loads(path.read_text(encoding="utf-8"))
                pieces = {k: np.array(table["trajectory"][k], dtype=float) for k in ("times", "coefficients")}
            else:
                raise InputError(f"{path}: a plan is read from .npz or .json")
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
            )
        except OSError as error:
            raise InputError(f"plan {path}: {error.strerror or error}; check the path") from None
        except (KeyError, ValueError, TypeError) as error:
            raise InputError(f"{path} is not a plan that halfroll wrote ({error}); plan the mission again") from None

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
    points = checked_nodes(waypoints, limits)
    trajectory: PiecewisePolynomial | None = None
    arrivals, fastest = [0.0], []
    first = 0
    for last in range(1, len(points)):
        if not points[last].at_rest:
            continue
        stretch = stretch_of(points[first : last + 1])
        durations = _durations(stretch, points[first : last + 1], vehicle, limits, progress)
        flown = stretch.trajectory(durations)
        start = 0.0 if trajectory is None else float(trajectory.times[-1])
        arrivals += (start + flown.times[1:]).tolist()
        fastest += stretch.speed_max.tolist()
        if points[last].hold_s > 0.0:
            flown = flown.then(standing(flown.at(flown.times[-1])[0], points[last].hold_s))
            fastest.append(np.inf)
        trajectory = flown if trajectory is None else trajectory.then(flown)
        first = last
    assert trajectory is not None
    if points[0].hold_s > 0.0:
        trajectory = standing(trajectory.at(0.0)[0], points[0].hold_s).then(trajectory)
        arrivals = [0.0, *(t + points[0].hold_s for t in arrivals[1:])]
        fastest.insert(0, np.inf)
    found = margins(trajectory, vehicle, limits, segment_speed_max=fastest)
    times = {place: t for point, t in zip(points, arrivals, strict=True) for place in point.places}
    return Plan(
        waypoints=tuple(waypoints),
        vehicle=vehicle,
        trajectory=trajectory,
        times_s=tuple(times[place] for place in range(len(waypoints))),
        rotor_min=found.rotor_min,
        rotor_max=found.rotor_max,
        certified=found.checked,
        violation_N=found.violation,
        warnings=tuple(radical(trajectory, points, arrivals)),
    )


def checked_nodes(waypoints: Sequence[Waypoint], limits: Limits) -> list[CourseNode]:
    """The places of a course. Raises MissionError and InfeasibleSegment for what no trajectory can meet."""
    points = CourseNode.merged(waypoints)
    for point in points:
        if limits.floor is not None and not point.waypoint.free[2] and point.waypoint.position[2] < limits.floor:
            raise InfeasibleSegment(
                f"{point.name}: height {point.waypoint.position[2]:.2f} m is below the floor of "
                f"{limits.floor:g} m; raise it",
                point.waypoint.item,
            )
        if limits.ceiling is not None and not point.waypoint.free[2] and point.waypoint.position[2] > limits.ceiling:
            raise InfeasibleSegment(
                f"{point.name}: height {point.waypoint.position[2]:.2f} m is above the ceiling of "
                f"{limits.ceiling:g} m; lower it",
                point.waypoint.item,
            )
        speed = float(np.linalg.norm(point.waypoint.velocity or 0.0))
        if limits.speed_max is not None and speed > limits.speed_max:
            raise InfeasibleSegment(
                f"{point.name}: speed of {speed:.2f} m/s is above the limit of {limits.speed_max:g} m/s; lower it",
                point.waypoint.item,
            )
    return points


@dataclass(frozen=True)
class CourseNode:
    """One place of the course: what the waypoints there ask for together."""

    waypoint: Waypoint
    yaw: float  # the short way round from the one before
    hold_s: float
    at_rest: bool
    places: tuple[int, ...]  # of its waypoints in the course

    @property
    def name(self) -> str:
        item = self.waypoint.item
        return f"item {item}" if item is not None else f"waypoint {self.places[-1] + 1}"

    @property
    def moves(self) -> bool:
        """Whether it asks for a derivative other than zero."""
        point = self.waypoint
        return any(np.any(d) for d in (point.velocity, point.acceleration, point.jerk, point.snap) if d is not None)

    @classmethod
    def merged(cls, waypoints: Sequence[Waypoint]) -> list[CourseNode]:
        nodes: list[CourseNode] = []
        for place, point in enumerate(waypoints):
            new = cls(point, point.yaw, point.hold_s, point.hold_s > 0.0, (place,))
            before = nodes[-1] if nodes else None
            if before is not None:
                turn = (point.yaw - before.yaw + np.pi) % (2.0 * np.pi) - np.pi
                new = replace(new, yaw=before.yaw + (turn if abs(turn) > 1e-12 else 0.0))
            if (
                before is not None
                and not any(point.free + before.waypoint.free)
                and np.linalg.norm(np.subtract(point.position, before.waypoint.position)) < SAME_PLACE
            ):
                if new.moves or before.moves:
                    raise MissionError(
                        f"{new.name} is at the same place as {before.name}, where the vehicle would have to move and "
                        "to be at rest; remove one of them",
                        point.item,
                    )
                new = replace(new, waypoint=replace(point, position=before.waypoint.position))
                if abs(new.yaw - before.yaw) > 1e-9:  # a turn on the spot
                    nodes[-1] = replace(before, at_rest=True)
                    nodes.append(replace(new, at_rest=True))
                else:
                    together = (before.hold_s + new.hold_s, before.at_rest or new.at_rest, before.places + new.places)
                    nodes[-1] = cls(new.waypoint, before.yaw, *together)
            else:
                nodes.append(new)
        if len(nodes) < 2:
            item = waypoints[0].item if waypoints else None
            raise MissionError("a plan needs at least two different waypoints; add one more than 1 mm away", item)
        nodes[0], nodes[-1] = replace(nodes[0], at_rest=True), replace(nodes[-1], at_rest=True)
        for at in nodes:
            if at.at_rest and any(at.waypoint.free):
                raise MissionError(
                    f"{at.name}: the vehicle is at rest here (an end, or a hold), so its position cannot be free; "
                    "give it",
                    at.waypoint.item,
                )
            if at.at_rest and at.moves:
                raise MissionError(
                    f"{at.name}: the vehicle is at rest here (an end, or a hold), so velocity and its derivatives "
                    "must be zero; remove them or the hold",
                    at.waypoint.item,
                )
        return nodes


def stretch_of(points: Sequence[CourseNode]) -> Stretch:
    nodes = []
    for point in points:
        w = point.waypoint
        position = (*(FREE if free else x for x, free in zip(w.position, w.free, strict=True)), point.yaw)
        if point.at_rest:
            nodes.append(rest(position))
        else:
            derivatives = [
                (*d, FREE) if d is not None else (FREE,) * 4 for d in (w.velocity, w.acceleration, w.jerk, w.snap)
            ]
            nodes.append(node(position, *derivatives))
    speeds = [point.waypoint.speed_max for point in points[:-1]]
    return Stretch(np.stack(nodes), np.array([np.inf if speed is None else speed for speed in speeds]))


def _durations(
    stretch: Stretch, points: Sequence[CourseNode], vehicle: Vehicle, limits: Limits, progress: Progress | None
) -> Array:
    """Shortest durations; with variable pitch never longer than what rotors that only push up would need."""

    def told(total: float, iteration: int) -> None:
        if progress is not None:
            progress(f"{points[0].name} to {points[-1].name}: {total:.3f} s after {iteration} steps")

    starts: list[Array] = []
    push = _PUSHES_UP * vehicle.rotor.thrust_max_N
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
