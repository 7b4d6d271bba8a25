"""Near-optimal plans: modes `fast` and `best`, within a few percent of the least possible time and proven.

Why: the paper's polynomials are one piece a leg with continuity through the 8th derivative, which costs half as much
time again. Here every leg has virtual knots, only what smooth rotor commands need is continuous (the 4th derivative),
yaw is optimised too, and an interior-point method (the C++ kernel) moves all of it. This module is the recipe: how a
course becomes the kernel's problem, from coarse to fine, repaired between the samples, proven, kept only if it wins.
docs/planner.md explains each step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from halfroll import _planner as kernel
from halfroll.errors import InfeasibleSegment
from halfroll.limits import Limits
from halfroll.minimum_time import Stretch
from halfroll.mission import PlanMode, Waypoint
from halfroll.plan import CourseNode, Plan, checked_nodes, plan_course, radical, stretch_of
from halfroll.segments import PiecewisePolynomial, solve, standing
from halfroll.vehicle import GRAVITY, Vehicle

Array = NDArray[np.float64]
Progress = Callable[[str], None]
Mode = Literal["fast", "best"]

PUSHES_UP = 0.05  # of the largest thrust: rotors that push no less than this could have fixed pitch
_FORCE_MIN = 0.035  # of the weight, variable pitch: the attitude must not turn at once
_SPARE = 1e-5  # relative margin left for the proof
_REPAIRS = 8
_DURATION_MIN = {True: 0.002, False: 0.012}  # [s] of a piece, tied or not: free knots would otherwise make slivers
# Where the barrier starts [s], and below which relative margin the limits start shifted:
_COLD, _REFINED, _REPAIR, _OTHER_LIMITS = (1e-2, 0.02), (1e-4, 0.01), (5e-5, 0.003), (1e-3, 0.02)
_REPAIR_STEPS = 120
_STRETCHED_AWAY = 4e-4  # relative
_FLOOR_SPARE = 1e-3  # [m] that a path through a waypoint on the floor itself may dip below it
_ROOM = 0.01  # relative margin at which the start needs no more slowing down
_STRETCHES = (1.00005, 1.0001, 1.0002, 1.0004, 1.001, 1.003, 1.008)
_SLOWINGS = (1.0, 1.01, 1.03, 1.1, 1.3, 1.7, 2.5)  # of the start
_HOPELESS = 0.05  # relative excess after three repairs


@dataclass(frozen=True)
class _Rung:
    """One level of refinement: pieces a leg, samples a piece, where the barrier ends, at most so many steps."""

    pieces: int
    samples: int
    barrier_end: float
    steps: int


@dataclass(frozen=True)
class _Recipe:
    ladder: tuple[_Rung, ...]
    tied: bool  # the pieces of a leg keep their shares of its time
    curvature: float = (
        0.25  # share of the constraints' curvature: 0 takes more but cheaper steps, 1 is often indefinite
    )


def _recipe(mode: Mode, legs: int) -> _Recipe:
    """Short courses get many knots, whose times are free; long ones few."""
    coarse = _Rung(1, 48, 1e-3, 60)
    ladder: tuple[_Rung, ...]
    if legs <= 2:
        ladder = (coarse, _Rung(4, 32, 1e-5, 100), _Rung(8, 32, 3e-6, 150))
        return _Recipe(ladder if mode == "best" else ladder[:2], tied=False)
    if legs <= 8:
        ladder = (coarse, _Rung(2, 32, 1e-4, 60), _Rung(4, 32, 3e-5, 80), _Rung(8, 24, 2e-6, 150))
        return _Recipe(ladder if mode == "best" else (coarse, replace(ladder[1], barrier_end=1e-5)), tied=True)
    if legs <= 100:
        ladder = (coarse, _Rung(2, 32, 1e-5, 100), _Rung(4, 24, 5e-6, 120))
        return _Recipe(ladder if mode == "best" else ladder[:2], tied=True)
    return _Recipe((_Rung(1, 32, 1e-4, 60),), tied=True, curvature=0.0)


@dataclass
class _Search:
    """The kernel on one stretch from rest to rest."""

    recipe: _Recipe
    moving: bool  # a velocity or higher derivative other than zero is given somewhere
    progress: Callable[[float], None]
    interrupted: bool = False

    def minimise(
        self,
        problem: kernel.Problem,
        constraints: kernel.Constraints,
        rung: _Rung,
        start: tuple[float, float],
        tightening: kernel.Tightening | None = None,
    ) -> kernel.Problem:
        """The solver, once; the problem itself if it is stopped before it has found anything inside the limits."""
        barrier, shift = start
        better, feasible, interrupted, _ = kernel.minimise_time(
            problem,
            constraints,
            kernel.Tightening() if tightening is None else tightening,
            samples=rung.samples,
            barrier_start=barrier,
            barrier_end=rung.barrier_end,
            iterations=rung.steps,
            duration_min=_DURATION_MIN[problem.tied],
            shift=shift,
            curvature=self.recipe.curvature,
            progress=self._told,
        )
        self.interrupted |= interrupted
        return problem if interrupted and not feasible else better

    def _told(self, total: float) -> bool:
        try:
            self.progress(total)
        except KeyboardInterrupt:
            return False
        return True

    def planned(self, start: kernel.Problem, constraints: kernel.Constraints) -> kernel.Problem | None:
        """The recipe; where forces turn too quickly for its samples, again with three times as many; else the start."""
        finer = tuple(replace(rung, samples=3 * rung.samples) for rung in self.recipe.ladder[:2])
        for ladder, tied in ((self.recipe.ladder, self.recipe.tied), (finer, True)):
            start.tied = tied
            problem = self.climb(start, constraints, ladder)
            better = self.repaired(problem, constraints, ladder[-1])
            if better is not None or self.interrupted:
                break
        if better is None and not self.moving:
            better = self._slowed(start, constraints, 4 * ladder[0].samples, _SLOWINGS)
        return better

    def climb(
        self, problem: kernel.Problem, constraints: kernel.Constraints, ladder: Sequence[_Rung]
    ) -> kernel.Problem:
        """From coarse to fine: splitting a piece does not change the path, so each level starts where one ended."""
        pieces = 1
        for k, rung in enumerate(ladder):
            if self.interrupted:
                break
            problem = problem.split(rung.pieces // pieces)
            pieces = rung.pieces
            problem = self.minimise(problem, constraints, rung, _COLD if k == 0 else _REFINED)
        return problem

    def proven(self, problem: kernel.Problem, constraints: kernel.Constraints) -> bool:
        return kernel.certify(problem.coefficients, problem.durations, problem.speed_max, constraints).proven

    def repaired(self, problem: kernel.Problem, constraints: kernel.Constraints, rung: _Rung) -> kernel.Problem | None:
        """The problem with a trajectory that is proven to stay inside the limits, or None.

        Peaks between the samples are pressed down by asking more around them and solving on; what is left of them in
        the end is below a thousandth of a limit, and is stretched away.
        """
        rung = replace(rung, steps=_REPAIR_STEPS)
        tightening, spare = kernel.Tightening(), _SPARE
        for k in range(_REPAIRS):
            least = kernel.tighten_around_peaks(problem, constraints, rung.samples, spare, tightening)
            if least >= 0.5 * spare:
                if self.proven(problem, constraints):
                    return problem
                spare *= 4.0
            elif k > 0 and least > -_STRETCHED_AWAY:
                slower = self._slowed(problem, constraints, rung.samples, _STRETCHES)
                if slower is not None:
                    return slower
            if self.interrupted or (k > 2 and least < -_HOPELESS):
                break
            problem = self.minimise(problem, constraints, rung, _REPAIR, tightening)
        return self._slowed(problem, constraints, rung.samples, _STRETCHES)

    def _slowed(
        self, problem: kernel.Problem, constraints: kernel.Constraints, samples: int, factors: Sequence[float]
    ) -> kernel.Problem | None:
        """The least of these slowings-down by which the proof succeeds. Not where a speed is given: it would change."""
        if self.moving:
            return None
        for factor in factors:
            slower = problem.stretched(factor)
            if slower.least_margin(constraints, 8 * samples) >= 0.5 * _SPARE and self.proven(slower, constraints):
                return slower
        return None


def limits_of(vehicle: Vehicle, kind: Literal["mission", "rotors"] = "mission", margin: float | None = None) -> Limits:
    """As Limits.of, but rotor thrust alone is really alone: the thrust axis may tilt below the horizon."""
    limits = Limits.of(vehicle, kind, margin)
    return replace(limits, force_z_min=None) if kind == "rotors" else limits


def plan_in_mode(
    waypoints: Sequence[Waypoint],
    vehicle: Vehicle,
    mode: PlanMode,
    limits: Literal["mission", "rotors"] = "mission",
    margin: float | None = None,
    progress: Progress | None = None,
) -> Plan:
    """The plan of any mode, inside the limits of that name. Raises as `plan_course`."""
    if mode == "paper":
        return plan_course(waypoints, vehicle, Limits.of(vehicle, limits, margin), progress)
    return plan_near_optimal(waypoints, vehicle, limits_of(vehicle, limits, margin), mode, progress)


def plan_near_optimal(
    waypoints: Sequence[Waypoint],
    vehicle: Vehicle,
    limits: Limits | None = None,
    mode: Mode = "best",
    progress: Progress | None = None,
    *,
    yaw: Literal["free", "given"] = "free",
) -> Plan:
    """A proven flight through all waypoints, at rest at both ends and where one holds, close to the shortest there is.

    limits: default Limits.of(vehicle). yaw: whether headings between
    places of rest are optimised or flown as given. progress is told in words how far it is; Ctrl-C during it ends the
    search with the best proven flight so far. Raises MissionError and InfeasibleSegment as `plan_course`.
    """
    limits = Limits.of(vehicle) if limits is None else limits
    points = checked_nodes(waypoints, limits)
    flown: list[PiecewisePolynomial] = []
    arrivals = [points[0].hold_s]
    ranges = []
    if points[0].hold_s > 0.0:
        flown.append(standing((*points[0].waypoint.position, points[0].yaw), points[0].hold_s))
    first = 0
    for last in range(1, len(points)):
        if not points[last].at_rest:
            continue
        problem, rotors = _stretch_planned(points[first : last + 1], vehicle, limits, mode, progress, yaw)
        times = np.concatenate([[0.0], np.cumsum(problem.durations)])
        ends = np.flatnonzero(np.diff(problem.leg, append=last)) + 1
        arrivals += (arrivals[-1] + (points[first].hold_s if first else 0.0) + times[ends]).tolist()
        flown.append(PiecewisePolynomial(times, problem.coefficients))
        ranges.append(rotors)
        if points[last].hold_s > 0.0:
            flown.append(standing((*points[last].waypoint.position, points[last].yaw), points[last].hold_s))
        first = last
    trajectory = flown[0]
    for following in flown[1:]:
        trajectory = trajectory.then(following)
    at = {place: t for point, t in zip(points, arrivals, strict=True) for place in point.places}
    at[0] = 0.0
    return Plan(
        waypoints=tuple(waypoints),
        vehicle=vehicle,
        trajectory=trajectory,
        times_s=tuple(at[place] for place in range(len(waypoints))),
        rotor_min=tuple(np.min([low for low, _ in ranges], axis=0).tolist()),
        rotor_max=tuple(np.max([high for _, high in ranges], axis=0).tolist()),
        certified=True,
        violation_N=0.0,
        warnings=tuple(radical(trajectory, points)),
        mode=mode,
    )


def _stretch_planned(
    points: Sequence[CourseNode],
    vehicle: Vehicle,
    limits: Limits,
    mode: Mode,
    progress: Progress | None,
    yaw: Literal["free", "given"],
) -> tuple[kernel.Problem, tuple[Array, Array]]:
    """From rest to rest: (proven problem, smallest and largest thrust of each rotor)."""
    stretch = stretch_of(points)
    vertical = stretch.purely_vertical and len({point.yaw for point in points}) == 1
    best = np.inf

    def told(total: float) -> None:
        nonlocal best
        best = min(best, total)
        if progress is not None:
            progress(f"{points[0].name} to {points[-1].name}: {best:.3f} s")

    search = _Search(_recipe(mode, stretch.legs), _moving(stretch.nodes), told)
    fastest = np.minimum(stretch.speed_max, np.inf if limits.speed_max is None else limits.speed_max)
    given = _given(stretch.nodes, yaw, vertical)
    if limits.floor is not None and min(point.waypoint.position[2] for point in points) < limits.floor + _FLOOR_SPARE:
        limits = replace(limits, floor=limits.floor - _FLOOR_SPARE)
    tried = [limits]
    push = PUSHES_UP * vehicle.rotor.thrust_max_N
    if limits.rotor_min < push - 1e-9:  # first as if the rotors could only push up
        tried.insert(0, replace(limits, rotor_min=push))
    found: kernel.Problem | None = None
    for now in tried:
        better: kernel.Problem | None = None
        constraints = _constraints(vehicle, now, vertical, bool(np.isfinite(fastest).any()))
        if found is not None and not vertical:
            problem = search.minimise(found, constraints, search.recipe.ladder[-1], _OTHER_LIMITS)
            better = search.repaired(problem, constraints, search.recipe.ladder[-1])
        else:
            start = _warm_start(stretch, given, fastest, constraints, vertical)
            better = search.planned(start, constraints)
        if better is not None and (found is None or better.total < found.total):
            found = better
        if search.interrupted:
            break
    if found is None:
        raise _infeasible(start, constraints, points)
    low, high = kernel.rotor_range(found, constraints, 200)
    return found, (low, high)


def _moving(nodes: Array) -> bool:
    """Whether a velocity or higher derivative other than zero is given somewhere."""
    return bool(np.any(np.nan_to_num(nodes[:, 1:]) != 0.0))


def _given(nodes: Array, yaw: Literal["free", "given"], vertical: bool) -> NDArray[np.bool_]:
    """(n, 5, 4): what may not change."""
    given = ~np.isnan(nodes)
    if yaw == "free":
        given[1:-1, :, 3] = False
    if vertical:
        given[:, :, [0, 1, 3]] = True
    return given


def _constraints(vehicle: Vehicle, limits: Limits, vertical: bool, any_speed_limit: bool) -> kernel.Constraints:
    signed = vertical and vehicle.variable_pitch
    force_min, force_z_min = limits.force_min, limits.force_z_min
    if vehicle.variable_pitch and force_z_min is None:
        force_min = max(force_min or 0.0, _FORCE_MIN * vehicle.weight)
    return kernel.Constraints(
        kernel.Vehicle(
            mass=vehicle.mass_kg,
            inertia=list(vehicle.inertia_kg_m2),
            arm=vehicle.arm_m,
            yaw_coefficient=vehicle.yaw_coefficient_m,
            gravity=GRAVITY,
        ),
        kernel.Limits(
            rotor_min=limits.rotor_min,
            rotor_max=limits.rotor_max,
            force_min=-np.inf if force_min is None or signed else force_min,
            force_z_min=-np.inf if force_z_min is None or signed else force_z_min,
            body_rate_max=np.inf if limits.body_rate_max is None else limits.body_rate_max,
            floor=-np.inf if limits.floor is None else limits.floor,
            vertical=vertical,
        ),
        any_speed_limit,
    )


def _warm_start(
    stretch: Stretch, given: NDArray[np.bool_], fastest: Array, constraints: kernel.Constraints, vertical: bool
) -> kernel.Problem:
    """The paper's polynomials, or stopping at every point where that is shorter (legs of very unequal length), in times
    by distance, slowed down until they fit."""
    nodes = stretch.nodes
    known = np.nan_to_num(nodes[:, 0, :3])
    distance = np.linalg.norm(np.diff(known, axis=0), axis=1)
    turn = np.abs(np.nan_to_num(np.diff(nodes[:, 0, 3])))
    durations = 0.45 * np.sqrt(distance) + 0.12 + 0.2 * np.sqrt(turn)
    durations[0] += 0.25 * np.sqrt(distance[0])
    durations[-1] += 0.25 * np.sqrt(distance[-1])
    durations = np.maximum(durations, 1.5 * distance / fastest)

    def problem(values: Array, times: Array) -> kernel.Problem:
        values = np.where(np.isnan(nodes), values, nodes)
        if vertical:
            values[:, 1:, [0, 1, 3]] = 0.0
        frozen = [vertical, vertical, False, vertical]
        return kernel.Problem(values, list(times), given, list(range(len(times))), fastest.tolist(), frozen, True)

    def smooth(factor: float) -> kernel.Problem:
        path = solve(nodes, factor * durations)
        return problem(path.derivatives(path.times, 5), factor * durations)

    def stopping(factor: float) -> kernel.Problem:
        return problem(np.zeros_like(nodes), factor * np.maximum(durations, 2.5 * distance / fastest))

    starts = [_slow_enough(make, constraints) for make in (smooth, stopping)[: 1 if len(durations) == 1 else 2]]
    return min(starts, key=lambda start: (max(0.0, _ROOM - start[1]), start[0].total))[0]


def _slow_enough(
    make: Callable[[float], kernel.Problem], constraints: kernel.Constraints
) -> tuple[kernel.Problem, float]:
    """(problem, least margin) at the first factor that leaves room in the limits, or that leaves the most."""
    tried = []
    for factor in 1.12 ** np.arange(32):
        start = make(float(factor))
        tried.append((start, start.least_margin(constraints, 48)))
        if tried[-1][1] > _ROOM:
            break
    return max(tried, key=lambda start: min(start[1], _ROOM))


def _infeasible(
    problem: kernel.Problem, constraints: kernel.Constraints, points: Sequence[CourseNode]
) -> InfeasibleSegment:
    refused = kernel.certify(problem.coefficients, problem.durations, problem.speed_max, constraints)
    leg = problem.leg[refused.piece]
    ends = points[leg], points[leg + 1]
    what, unit = kernel.bound_name(constraints, refused.bound)
    return InfeasibleSegment(
        f"from {ends[0].name} to {ends[1].name}: {what} would be exceeded by {refused.excess:.3g} {unit} in the best "
        "flight found; move the waypoint or relax the limit",
        ends[1].waypoint.item,
    )
