"""Stretches in which the vehicle turns over: flips through free fall, loops, half rolls.

Why: there the thrust axis goes through the horizon, where yaw counted from upright loses its meaning, and the thrust
may change its sign, where the force has no direction. Both are harmless in one vertical plane with the nose fixed: the
attitude is one angle. So a stretch that turns over lies in one vertical plane, from rest to rest, and is searched in
axes of its own: x along that plane, y across, z up. Nothing else in the planner knows flips.

Thrust changes its sign exactly at nodes of free fall (acceleration -g): the force passes through zero, the attitude
turns on. sigma, the sign of the thrust axis' vertical part, follows from the path, and must be what the waypoints say.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from halfroll import _planner as kernel
from halfroll.errors import InfeasibleSegment, MissionError
from halfroll.missions.mission import Yaw
from halfroll.planner.attitude_nodes import asked
from halfroll.planner.course_nodes import CourseNode, places, signed_thrust, speeds
from halfroll.planner.flatness import inverse_dynamics, kernel_vehicle
from halfroll.planner.kernel_problem import kernel_limits
from halfroll.planner.knotted_flips import KnottedFlight, shortened
from halfroll.planner.limits import Limits, Margins, margins
from halfroll.planner.minimum_time import Line, NoDurations, Progress, Search, Stretch, shortest
from halfroll.planner.segments import FREE, PiecewisePolynomial, node, rest
from halfroll.vehicle import Vehicle

Array = NDArray[np.float64]

_ASIDE = 1e-3  # [m], and m/s², .. : what is no farther from the plane lies in it
_SEEN_FROM = 0.2  # of a leg's time to the next node: far enough from a change of sigma to tell which it is


def turns_over(points: Sequence[CourseNode]) -> bool:
    """Whether the vehicle turns over between the first and the last of these, where it rests."""
    changes = any(point.upright != points[0].upright for point in points)
    horizontal = places(points)[:, :2]
    vertical = bool(np.ptp(horizontal, axis=0).max() < _ASIDE) and not any(any(p.waypoint.free[:2]) for p in points)
    return changes or (not vertical and any(point.waypoint.in_free_fall for point in points))


@dataclass(frozen=True)
class Plane:
    """Through the start, vertical, along a heading [rad]."""

    start: Array  # (3,)
    heading: float

    @classmethod
    def of(cls, points: Sequence[CourseNode]) -> Plane:
        """The one plane that holds all that is given. Raises MissionError."""
        start = places(points)[0]
        vectors = [(point, vector) for point in points for vector in _given(point, start)]
        longest = max((vector for _, vector in vectors), key=_size, default=np.zeros(3))
        if _size(longest) < _ASIDE:
            raise MissionError(
                f"from {points[0].name} to {points[-1].name} the vehicle turns over, and nothing says in which "
                "direction; move one of the points",
                points[-1].waypoint.item,
            )
        heading = float(np.arctan2(longest[1], longest[0]))
        across = np.array([-np.sin(heading), np.cos(heading), 0.0])
        for point, vector in vectors:
            if abs(float(across @ vector)) > _ASIDE:
                raise MissionError(
                    f"{point.name} is {abs(float(across @ vector)):.2f} m (or m/s, ..) off the vertical plane in "
                    f"which the vehicle turns over between {points[0].name} and {points[-1].name}; put it into that "
                    "plane, or let the vehicle stand before and after turning over",
                    point.waypoint.item,
                )
        return cls(start, heading)

    def into(self, vectors: Array) -> Array:
        """(.., 4) rows of derivatives of x, y, z, yaw from W; the yaw itself is not changed."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        x, y, z, yaw = np.moveaxis(vectors, -1, 0)
        return np.stack([c * x + s * y, c * y - s * x, z, yaw], axis=-1)

    def out_of(self, path: PiecewisePolynomial) -> PiecewisePolynomial:
        """A path in axes of the plane as one in W."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        x, y, z, yaw = np.moveaxis(path.coefficients, -1, 0)
        turned = np.stack([c * x - s * y, s * x + c * y, z, yaw], axis=-1)
        turned[:, 0] += (*self.start, self.heading)
        return PiecewisePolynomial(path.times, turned)


def _given(point: CourseNode, start: Array) -> list[Array]:
    w = point.waypoint
    free = np.array([w.free[0] or w.free[1]] * 2 + [True])
    vectors = [np.where(free, 0.0, np.asarray(w.position) - start)]
    vectors += [np.array(d) for d in (w.velocity, w.acceleration, w.jerk, w.snap) if d is not None]
    return vectors


def _size(vector: Array) -> float:
    return float(np.linalg.norm(vector[:2]))


@dataclass(frozen=True)
class Turning:
    """A stretch that turns over, in the axes of its plane."""

    points: Sequence[CourseNode]
    plane: Plane
    stretch: Stretch

    @classmethod
    def of(cls, points: Sequence[CourseNode], vehicle: Vehicle) -> Turning:
        """Raises MissionError for what does not fit together."""
        plane = Plane.of(points)
        signs = _thrust_signs(points)
        nodes, lines = [], []
        yaw = points[0].yaw - plane.heading
        for place, point in enumerate(points):
            w = point.waypoint
            x, _, z = plane.into(np.array([*np.subtract(w.position, plane.start), 0.0]))[:3]
            position = (FREE if w.free[0] or w.free[1] else x, 0.0, FREE if w.free[2] else z, yaw)
            if point.at_rest:
                nodes.append(rest(position))
                continue
            signed_thrust(point, signs[place])
            given, along = asked(w, vehicle, float(signs[place]))
            given, along = plane.into(given), [(plane.into(direction), start) for direction, start in along]
            given[0] = node(position)[0]
            given[:, 1] = (0.0, FREE, FREE, FREE, FREE)
            given[1:, 3] = FREE
            nodes.append(given)
            lines += [Line(place, direction, start) for direction, start in along]
        seen = places(points) - plane.start
        stretch = Stretch(np.stack(nodes), speeds(points), seen, tuple(lines), signs[:-1])
        return cls(points, plane, stretch)

    def shortest(self, vehicle: Vehicle, limits: Limits, progress: Progress | None) -> tuple[Array, Margins]:
        """(trial, margins). Raises InfeasibleSegment."""
        limits = self._limits(limits)
        try:
            trial = shortest(self.stretch, vehicle, limits, (), progress)
        except NoDurations as error:
            ends = self.points[error.segment], self.points[error.segment + 1]
            raise InfeasibleSegment(
                f"from {ends[0].name} to {ends[1].name}, turning over: {error}", ends[1].waypoint.item
            ) from None
        path, flips = self.stretch.trajectory(trial), self.stretch.flips(trial[: self.stretch.legs])
        self._require_sigma(path, path.times[1:], flips, vehicle)
        return trial, Search(self.stretch, vehicle, limits).check(trial)

    def shortened(
        self, trial: Array, vehicle: Vehicle, limits: Limits, progress: Callable[[float, int], None]
    ) -> tuple[KnottedFlight, Margins] | None:
        """The flight with virtual knots that takes less time than that of the trial, if there is one."""
        limits = self._limits(limits)
        flight = shortened(
            self.stretch, vehicle, limits, self.stretch.trajectory(trial), lambda total: progress(total, 0)
        )
        if flight is None or flight.total >= self.stretch.total(trial):
            return None
        try:
            self._require_sigma(flight.path, flight.leg_ends, flight.flips, vehicle)
        except InfeasibleSegment:
            return None
        if not self.is_proven(flight.path, flight.leg_ends, vehicle, limits, form_obeys_rates=True):
            return None
        return flight, margins(flight.path, vehicle, limits, flips=flight.flips)

    def is_proven(
        self, path: PiecewisePolynomial, leg_ends: Array, vehicle: Vehicle, limits: Limits, form_obeys_rates: bool
    ) -> bool:
        """Whether the kernel proves that this path stays inside the limits, at zero force too."""
        limits = self._limits(limits)
        if not form_obeys_rates:
            limits = replace(limits, drive=None, rotor_rate_max=None)
        leg = np.searchsorted(leg_ends, path.times[1:] - 1e-9)
        signs = np.asarray(self.stretch.thrust_sign)[leg].tolist()
        fastest = np.minimum(self.stretch.speed_max, limits.speed_max or np.inf)[leg].tolist()
        constants = kernel_limits(limits, vehicle, Yaw("given"), vertical=False)
        found = kernel.certify_planar(
            path.coefficients, path.durations.tolist(), signs, fastest, kernel_vehicle(vehicle), constants
        )
        return bool(found.proven)

    def _limits(self, limits: Limits) -> Limits:
        """Without those that keep upright; heights from the start of the stretch."""
        if limits.tilt_max is not None:
            raise MissionError(
                f"between {self.points[0].name} and {self.points[-1].name} the vehicle turns over, the limit tilt_deg "
                f"of {np.degrees(limits.tilt_max):.0f} forbids it; switch it off",
                self.points[-1].waypoint.item,
            )
        start = float(self.plane.start[2])
        return replace(
            limits,
            force_z_min=None,
            force_min=None,
            floor=None if limits.floor is None else limits.floor - start,
            ceiling=None if limits.ceiling is None else limits.ceiling - start,
        )

    def _require_sigma(
        self, path: PiecewisePolynomial, leg_ends: Array, flips: Sequence[float], vehicle: Vehicle
    ) -> None:
        """The vehicle is as the waypoints say, upright or not, on each leg. Raises InfeasibleSegment."""
        durations = np.diff(leg_ends, prepend=0.0)
        t = leg_ends - (0.5 if len(leg_ends) > 1 else _SEEN_FROM) * durations
        sigma = inverse_dynamics(t, path.derivatives(t), vehicle, flips).sigma
        for leg, point in enumerate(self.points[:-1]):
            if (sigma[leg] > 0.0) != point.upright:
                is_so = "upside down" if point.upright else "upright"
                raise InfeasibleSegment(
                    f"from {point.name} to {self.points[leg + 1].name} the vehicle would be {is_so} in the best flight "
                    "found, and its waypoint says otherwise; change `upright`, or the attitudes there",
                    point.waypoint.item,
                )


def _thrust_signs(points: Sequence[CourseNode]) -> Array:
    """(M+1,) sign of the thrust from each node on."""
    sign = 1.0 if points[0].upright else -1.0
    signs = []
    for point in points:
        if point.waypoint.in_free_fall:
            sign = -sign
        signs.append(sign)
    if points[-1].upright != points[-2].upright:
        how = "upright" if points[-1].upright else "upside down"
        raise MissionError(
            f"{points[-1].name}: the vehicle cannot turn {how} while it stands; put a half roll there",
            points[-1].waypoint.item,
        )
    if (sign > 0.0) != points[-1].upright:
        how = "upright" if points[-1].upright else "upside down"
        raise MissionError(
            f"{points[-1].name}: the vehicle ends {how}, and free fall turns its thrust over {_falls(points)} times "
            "on the way; that does not fit together: add a point of free fall, or change `upright`",
            points[-1].waypoint.item,
        )
    return np.array(signs)


def _falls(points: Sequence[CourseNode]) -> int:
    return sum(point.waypoint.in_free_fall for point in points)
