"""A course as the kernel's problem: which limits become which rows, what is given, and what no flight can meet.

Why: ladder.py is the search and knows no single limit; here each limit of `Limits` gets its place in the kernel,
and what the kernel's proof refuses becomes a sentence for people.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from halfroll import _planner as kernel
from halfroll.errors import InfeasibleSegment
from halfroll.missions.mission import Fence, Yaw
from halfroll.planner import corridor
from halfroll.planner.course_nodes import CourseNode, attitudes_allowed, stretch_of
from halfroll.planner.flatness import kernel_vehicle
from halfroll.planner.limits import Limits
from halfroll.planner.minimum_time import NoDurations, Stretch, shortest
from halfroll.vehicle import Vehicle

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_FORCE_MIN = 0.035  # of the weight, variable pitch: the attitude must not turn at once
_NODE_SPARE = 1e-3  # [m] that a path through a waypoint on the floor or the ceiling itself may pass it
_OFF_THE_NOSE = np.radians(15.0)  # by which the nose may miss the path or the point it is to look at,
_SLACK = {"path": 0.3, "point": 0.1}  # and any angle where speed [m/s] or distance [m] are not far above this


def require_fenced(points: Sequence[CourseNode], fences: Sequence[Fence]) -> None:
    """Raises InfeasibleSegment for a waypoint outside, and for a leg whose straight line leaves a fence."""
    for fence in fences:
        for point in points:
            out = corridor.outside_by(point.waypoint.position, fence)
            if out > 0.0 and not any(point.waypoint.free[:2]):
                where = "outside" if fence.keep_in else "inside"
                raise InfeasibleSegment(
                    f"{point.name} is {out:.2f} m {where} the {fence.name}; move it, or the fence", point.waypoint.item
                )
        for here, there in pairwise(points):
            if corridor.meets(here.waypoint.position, there.waypoint.position, fence):
                at, beyond = corridor.crossed(here.waypoint.position, there.waypoint.position, fence)
                raise InfeasibleSegment(
                    f"from {here.name} to {there.name}: the straight line crosses the {fence.name}, by {beyond:.2f} m "
                    f"{place(at)}; add a waypoint that leads round",
                    there.waypoint.item,
                )


def place(at: Array) -> str:
    """In words, of x, y in W."""
    return f"at {at[0]:.2f} m north, {at[1]:.2f} m west"


@dataclass(frozen=True)
class Setup:
    """From rest to rest: everything that does not change during the search."""

    points: Sequence[CourseNode]
    stretch: Stretch
    given: Mask  # (n, 5, 4): what may not change
    pieces: list[kernel.PieceLimits]  # of each leg
    fastest: Array  # (legs,) [m/s], inf where there is no limit
    vertical: bool  # the body stays upright, thrust is signed
    limits: Limits
    vehicle: Vehicle
    yaw: Yaw

    @classmethod
    def of(
        cls, points: Sequence[CourseNode], vehicle: Vehicle, limits: Limits, yaw: Yaw, fences: Sequence[Fence]
    ) -> Setup:
        limits = attitudes_allowed(points, limits)
        stretch = _settled(stretch_of(points, vehicle), vehicle, limits)
        vertical = stretch.purely_vertical and len({point.yaw for point in points}) == 1
        fastest = np.minimum(stretch.speed_max, np.inf if limits.speed_max is None else limits.speed_max)
        places = [point.waypoint.position for point in points]
        walls = [corridor.walls(here, there, fences) for here, there in pairwise(places)]
        pieces = [kernel.PieceLimits(speed, wall) for speed, wall in zip(fastest.tolist(), walls, strict=True)]
        given = _given(stretch.nodes, [point.waypoint.q_WB is not None for point in points], yaw, vertical)
        return cls(points, stretch, given, pieces, fastest, vertical, _spared(limits, points), vehicle, yaw)

    @property
    def moves(self) -> bool:
        """Whether a velocity or higher derivative other than zero is given somewhere."""
        return bool(np.any(np.nan_to_num(self.stretch.nodes[:, 1:]) != 0.0))

    def constraints(self, limits: Limits) -> kernel.Constraints:
        walls = max(len(piece.walls) for piece in self.pieces)
        return kernel.Constraints(
            kernel_vehicle(self.vehicle),
            kernel_limits(limits, self.vehicle, self.yaw, self.vertical),
            bool(np.isfinite(self.fastest).any()),
            walls,
        )

    def problem(self, values: Array, durations: Array, timed: Sequence[bool] = ()) -> kernel.Problem:
        """With these derivatives (n, 5, 4) where they are not given, and durations (legs,), some of which may be
        `timed`: fixed."""
        nodes, still = self.stretch.nodes, self.vertical
        values = np.where(np.isnan(nodes), values, nodes)
        if still:
            values[:, 1:, [0, 1, 3]] = 0.0
        legs = list(range(len(durations)))
        return kernel.Problem(
            values, list(durations), self.given, legs, self.pieces, [still, still, False, still], True, list(timed)
        )


def leg_ends(problem: kernel.Problem) -> NDArray[np.intp]:
    """(legs + 1,) places of the waypoints among the nodes of its pieces."""
    return np.concatenate([[0], np.flatnonzero(np.diff(problem.leg, append=-1)) + 1])


def leg_durations(problem: kernel.Problem) -> Array:
    """(legs,) [s]"""
    return np.bincount(problem.leg, problem.durations).astype(np.float64)


def _settled(stretch: Stretch, vehicle: Vehicle, limits: Limits) -> Stretch:
    """Free thrusts of attitudes and free speeds: as they are best in the paper's form, which then stay."""
    if not stretch.lines:
        return stretch
    try:
        values = shortest(stretch, vehicle, limits)[stretch.legs :]
    except NoDurations:
        values = stretch.start_values
    return replace(stretch, nodes=stretch.nodes_at(values), lines=())


def _given(nodes: Array, attitudes: Sequence[bool], yaw: Yaw, vertical: bool) -> Mask:
    """attitudes: which of the nodes have one; there yaw belongs to it."""
    given = ~np.isnan(nodes)
    if yaw.rule != "given":
        given[~np.array(attitudes), :, 3] = False
        given[[0, -1], :, 3] = True
    if vertical:
        given[:, :, [0, 1, 3]] = True
    return given


def _spared(limits: Limits, points: Sequence[CourseNode]) -> Limits:
    """A waypoint on the floor or the ceiling moves it by a millimetre: a path cannot touch it and stay inside."""
    heights = [point.waypoint.position[2] for point in points if not point.waypoint.free[2]]
    if limits.floor is not None and min(heights) < limits.floor + _NODE_SPARE:
        limits = replace(limits, floor=limits.floor - _NODE_SPARE)
    if limits.ceiling is not None and max(heights) > limits.ceiling - _NODE_SPARE:
        limits = replace(limits, ceiling=limits.ceiling + _NODE_SPARE)
    return limits


def kernel_limits(limits: Limits, vehicle: Vehicle, yaw: Yaw, vertical: bool) -> kernel.Limits:
    signed = vertical and vehicle.variable_pitch
    force_min, force_z_min = limits.force_min, limits.force_z_min
    floor = _FORCE_MIN * vehicle.weight
    if vehicle.variable_pitch and force_z_min is None and 4.0 * limits.rotor_min < floor:  # else the rotors see to it
        force_min = max(force_min or 0.0, floor)
    return kernel.Limits(
        rotor_min=limits.rotor_min,
        rotor_max=limits.rotor_max,
        force_min=-np.inf if force_min is None or signed else force_min,
        force_z_min=-np.inf if force_z_min is None or signed else force_z_min,
        body_rate_max=np.inf if limits.body_rate_max is None else limits.body_rate_max,
        floor=-np.inf if limits.floor is None else limits.floor,
        ceiling=np.inf if limits.ceiling is None else limits.ceiling,
        tilt_cos_min=-np.inf if limits.tilt_max is None or signed else np.cos(limits.tilt_max),
        rotor_rate_max=np.inf if limits.rotor_rate_max is None else limits.rotor_rate_max,
        drive=kernel.Drive() if limits.drive is None else kernel.Drive(*astuple(limits.drive)),
        heading=_kernel_heading(yaw),
        vertical=vertical,
    )


def _kernel_heading(yaw: Yaw) -> kernel.Heading:
    cosine = float(np.cos(_OFF_THE_NOSE))
    if yaw.rule == "path":
        return kernel.Heading.path(cosine, _SLACK["path"])
    if yaw.rule == "point":
        return kernel.Heading.towards(*yaw.point, cosine, _SLACK["point"])
    return kernel.Heading()


def headed(points: Sequence[CourseNode], yaw: Yaw) -> list[CourseNode]:
    """With the headings that looking along the path or at a point asks for: at the ends they are flown, between they
    are where the search begins."""
    if yaw.rule in ("free", "given"):
        return list(points)
    places = np.array([point.waypoint.position[:2] for point in points], dtype=np.float64)
    if yaw.rule == "point":
        looks = np.array(yaw.point) - places
    else:
        legs = np.diff(places, axis=0)
        legs /= np.maximum(np.linalg.norm(legs, axis=1, keepdims=True), 1e-9)
        looks = np.vstack([legs[:1], legs[:-1] + legs[1:], legs[-1:]])
    turned: list[CourseNode] = []
    now = points[0].yaw
    for point, look in zip(points, looks, strict=True):
        if point.waypoint.q_WB is not None:  # which says where the nose is
            now += float(np.remainder(point.yaw - now + np.pi, 2.0 * np.pi) - np.pi)
        elif np.linalg.norm(look) > 1e-3:  # else there is no direction: as before
            now += float(np.remainder(np.arctan2(look[1], look[0]) - now + np.pi, 2.0 * np.pi) - np.pi)
        turned.append(replace(point, yaw=now))
    return turned


def infeasible(setup: Setup, problem: kernel.Problem, constraints: kernel.Constraints) -> InfeasibleSegment:
    """What stands in the way of the best flight found, and by how much."""
    found = kernel.certify(problem.coefficients, problem.durations, problem.limits, constraints)
    leg = problem.leg[found.piece]
    return InfeasibleSegment(
        f"{refused(setup, found, leg, problem.limits[found.piece], constraints)} in the best flight found; move the "
        "waypoint, give it more time, or relax the limit",
        setup.points[leg + 1].waypoint.item,
    )


def refused(
    setup: Setup, found: kernel.Certificate, leg: int, piece: kernel.PieceLimits, constraints: kernel.Constraints
) -> str:
    """What a proof that failed says in words; its worst piece is in this leg."""
    what, unit = kernel.bound_name(constraints, found.bound)
    allowed = kernel.bound_limit(constraints, found.bound, piece)
    here, there = setup.points[leg], setup.points[leg + 1]
    return f"from {here.name} to {there.name}: {_in_words(what, unit, allowed, found.excess)}"


def _in_words(what: str, unit: str, allowed: float, excess: float) -> str:
    """Squares and cosines, with which the kernel computes, as what they limit."""
    if what.endswith(" squared"):
        most, found, unit = np.sqrt(allowed), np.sqrt(allowed + excess), unit.replace("²", "")
        return f"{what.removesuffix(' squared')} would exceed {most:.4g} {unit} by {found - most:.3g} {unit}"
    if what == "cosine of tilt":
        most, tilt = (np.degrees(np.arccos(max(cosine, -1.0))) for cosine in (allowed, allowed - excess))
        return f"tilt would exceed {most:.1f} deg by {tilt - most:.3g} deg"
    if what == "heading":
        return "the nose would not follow"
    if what == "fence":
        return f"the fence would be passed by {excess:.3g} m"
    return f"{what} would be exceeded by {excess:.3g} {unit}"
