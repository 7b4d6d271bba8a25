"""Near-optimal plans: modes `fast` and `best`, within a few percent of the least possible time and proven.

Why: the paper's polynomials are one piece a leg with continuity through the 8th derivative, which costs half as much
time again. Here every leg has virtual knots, only what smooth rotor commands need is continuous (the 4th derivative),
yaw is optimised too, and an interior-point method (the C++ kernel) moves all of it. This module is the recipe: how a
course becomes the kernel's problem, from coarse to fine, repaired between the samples, proven, kept only if it wins.
docs/planner.md explains each step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from halfroll import _planner as kernel
from halfroll import corridor
from halfroll.aerobatics import turns_over
from halfroll.arrivals import given_times, require_possible, shared_out, too_early
from halfroll.course_nodes import CourseNode, checked_nodes
from halfroll.errors import InfeasibleSegment, InputError, PlanError
from halfroll.kernel_problem import Setup, headed, infeasible, require_fenced
from halfroll.limits import Limits, changed
from halfroll.mission import Demand, Fence, LimitsKind, PlanOptions, Rules, Waypoint, Yaw
from halfroll.plan import (
    Flown,
    Plan,
    mirror_of,
    mirrored,
    mirrored_back,
    plan_course,
    plan_of,
    rotor_ranges,
    stretches,
    turned_over,
)
from halfroll.proof import proven
from halfroll.segments import PiecewisePolynomial, solve
from halfroll.turning_room import require_room
from halfroll.vehicle import Vehicle

Array = NDArray[np.float64]
Progress = Callable[[str], None]
Mode = Literal["fast", "best"]

FREE_YAW = Yaw("free")
KEPT_YAW = Yaw("given")  # upside down the nose keeps its direction
PUSHES_UP = 0.05  # of the largest thrust: rotors that push no less than this could have fixed pitch
_SPARE = 1e-5  # relative margin left for the proof
_SPARES = 4  # times as much is asked where the proof fails, so many times
_REVERSE_PAYS = 0.002  # of the time, or rotors are not asked to push down: the gentler flight is easier to follow
_HOPELESS = 0.1  # relative excess of a limit from which nothing is repaired where speeds or times are given
_DURATION_MIN = {True: 0.002, False: 0.012}  # [s] of a piece, tied or not: free knots would otherwise make slivers
# Where the barrier starts (what it costs, as a share of the time), and below which relative margin the limits start
# shifted:
_COLD, _REFINED, _FINER, _REPAIR, _OTHER_LIMITS = (1.0, 0.02), (0.2, 0.01), (0.1, 0.01), (0.02, 0.003), (1.0, 0.02)
_FENCE_STEP_S = 0.005  # of a path that is checked against a fence point by point
_ROOM = 0.01  # relative margin at which the start needs no more slowing down
_STRETCHES = (1.00005, 1.0001, 1.0002, 1.0004, 1.001, 1.003, 1.008)
_SLOWINGS = (1.0, 1.01, 1.03, 1.1, 1.3, 1.7, 2.5)  # of the start
_MORE_TIME = (1.01, 1.03, 1.1)  # for legs after a given time of arrival


@dataclass(frozen=True)
class _Rung:
    """One level of refinement: pieces a leg, samples a piece, what the barrier may cost in the end (share of the time),
    at most so many steps."""

    pieces: int
    samples: int
    gap: float
    steps: int
    negligible: float = 3e-5  # a step that promises less, as a share of the time, ends a stage


@dataclass(frozen=True)
class _Recipe:
    ladder: tuple[_Rung, ...]  # what `fast` climbs
    tied: bool  # the pieces of a leg keep their shares of its time
    finer: _Rung | None = None  # where `best` goes on from there
    two_starts: bool = False  # variable pitch also from its own start, not only from the fixed-pitch flight
    gap_factor: float = 0.15  # from stage to stage
    curvature: float = 0.4  # share of the constraints': 0 takes more but cheaper steps, 1 is often indefinite

    elastic: bool = True  # limits yield to long steps; of very many, some always would

    @property
    def rungs(self) -> tuple[_Rung, ...]:
        return self.ladder if self.finer is None else (*self.ladder, self.finer)


def _recipe(mode: Mode, legs: int, limits: Limits) -> _Recipe:
    """Short courses get many knots, on one or two legs with free times; long ones few. The first level need not be
    exact: where it stops, the next begins. For thrusts alone on one or two legs walls are quicker; where motor speeds
    are limited, they end in flights that are easier to follow."""
    coarse = _Rung(1, 16, 0.3, 60, 3e-4)
    best = mode == "best"
    walls = limits.drive is not None and limits.drive.of_speed
    if legs <= 2:
        ladder = (replace(coarse, samples=32), _Rung(4, 32, 2e-3, 120, 1e-4))
        rates = limits.drive is not None or limits.rotor_rate_max is not None
        return _Recipe(ladder, False, _Rung(8, 24, 1e-3, 150) if best else None, elastic=rates and not walls)
    if legs <= 8:
        ladder = (coarse, _Rung(3, 16, 3e-3, 120, 1e-4))
        return _Recipe(ladder, True, _Rung(9, 24, 1e-3, 150) if best else None, two_starts=best, elastic=not walls)
    if legs <= 100:
        ladder = (coarse, _Rung(2, 16, 5e-3, 120, 1e-4))
        return _Recipe(ladder, True, _Rung(4, 16, 2e-3, 150) if best else None, elastic=not walls)
    return _Recipe((_Rung(1, 24, 1e-2, 80, 1e-3),), True, elastic=False)


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
        spare: float = 0.0,
    ) -> kernel.Problem:
        """The solver, once; the problem itself if it is stopped before it has found anything inside the limits."""
        gap, shift = start
        better, feasible, interrupted, _ = kernel.minimise_time(
            problem,
            constraints,
            samples=rung.samples,
            gap_start=gap,
            gap_end=rung.gap,
            gap_factor=self.recipe.gap_factor,
            negligible=rung.negligible,
            iterations=rung.steps,
            duration_min=_DURATION_MIN[problem.tied],
            shift=shift,
            curvature=self.recipe.curvature,
            elastic=self.recipe.elastic,
            spare=spare,
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
            climbed = list(self.climb(start, constraints, ladder))
            better = self.repaired(climbed[-1], constraints, ladder[len(climbed) - 1]) if climbed else None
            if better is not None or self.interrupted:
                break
        if better is None and not self.moving:
            better = self._slowed(start, constraints, 4 * ladder[0].samples, _SLOWINGS)
        return better

    def climb(
        self, problem: kernel.Problem, constraints: kernel.Constraints, ladder: Sequence[_Rung]
    ) -> Iterator[kernel.Problem]:
        """From coarse to fine: splitting a piece does not change the path, so each level starts where one ended. The
        last looks between its samples too."""
        pieces = 1
        for k, rung in enumerate(ladder):
            if self.interrupted:
                break
            problem = problem.split(rung.pieces // pieces)
            pieces = rung.pieces
            spare = _SPARE if rung is ladder[-1] else 0.0
            problem = self.minimise(problem, constraints, rung, _COLD if k == 0 else _REFINED, spare)
            yield problem

    def refined(self, flight: kernel.Problem, constraints: kernel.Constraints) -> kernel.Problem:
        """The flight with more knots, if that makes it shorter."""
        rung = self.recipe.finer
        if rung is None or self.interrupted:
            return flight
        parts = rung.pieces * len(set(flight.leg)) // len(flight.durations)
        problem = self.minimise(flight.split(max(parts, 1)), constraints, rung, _FINER, _SPARE)
        return _shorter(flight, self.repaired(problem, constraints, rung)) or flight

    def proven(self, problem: kernel.Problem, constraints: kernel.Constraints) -> bool:
        return kernel.certify(problem.coefficients, problem.durations, problem.limits, constraints).proven

    def repaired(self, problem: kernel.Problem, constraints: kernel.Constraints, rung: _Rung) -> kernel.Problem | None:
        """The problem with a trajectory that is proven to stay inside the limits, or None.

        Where the proof fails the solver goes on with more to spare; what is left then is stretched away.
        """
        spare = _SPARE
        for _ in range(_SPARES):
            if self.proven(problem, constraints):
                return problem
            hopeless = self.moving and problem.least_margin(constraints, rung.samples) < -_HOPELESS
            if self.interrupted or hopeless:
                break
            spare *= 4.0
            problem = self.minimise(problem, constraints, rung, _REPAIR, spare)
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


def limits_of(vehicle: Vehicle, kind: LimitsKind = "mission", margin: float | None = None) -> Limits:
    """As Limits.of, but rotor thrust alone is really alone: the thrust axis may tilt below the horizon."""
    limits = Limits.of(vehicle, kind, margin)
    return replace(limits, force_z_min=None) if kind == "rotors" else limits


def plan_in_mode(
    waypoints: Sequence[Waypoint],
    vehicle: Vehicle,
    options: PlanOptions,
    rules: Rules | None = None,
    progress: Progress | None = None,
    demands: Sequence[Demand] = (),
) -> Plan:
    """The plan of any mode, inside the limits that options and rules (in W) make, with room where it turns over. Raises
    as `plan_course`."""
    rules = rules or Rules()
    of = Limits.of if options.mode == "paper" else limits_of
    limits = changed(of(vehicle, options.limits, options.margin), (*rules.limits, *options.changes))
    yaw = options.yaw or rules.yaw
    if options.mode != "paper":
        plan = plan_near_optimal(
            waypoints, vehicle, limits, options.mode, progress, yaw=yaw or FREE_YAW, fences=rules.fences
        )
        require_inside(plan, rules.fences if plan.turns else ())
    elif yaw is not None and yaw.rule != "given":
        raise InputError(f"mode paper flies yaw as given, not {yaw.rule}; take mode fast or best")
    else:
        plan = proven(plan_course(waypoints, vehicle, limits, progress), waypoints, limits)
        require_inside(plan, rules.fences)
        plan = replace(plan, waypoints=_placed(waypoints, plan.trajectory, plan.times_s))
    require_room(plan, limits, demands)
    return plan


def require_inside(plan: Plan, fences: Sequence[Fence]) -> None:
    """Raises InfeasibleSegment where a plan whose path nothing can bend leaves a fence."""
    t = np.linspace(0.0, plan.T, int(plan.T / _FENCE_STEP_S) + 2) if fences else np.zeros(0)
    positions = plan.trajectory.at(t)[:, :2]
    for fence in fences:
        out = [corridor.outside_by(position, fence) for position in positions]
        if max(out) > 0.0:
            leg = int(np.searchsorted(plan.times_s, t[int(np.argmax(out))]))
            waypoint = plan.waypoints[min(leg, len(plan.waypoints) - 1)]
            raise InfeasibleSegment(
                f"on the way to {_name(waypoint, leg)} the path leaves the {fence.name} by {max(out):.2f} m, and "
                "nothing here can bend it (in mode paper, and where it turns over); move the waypoints",
                waypoint.item,
            )


def _name(waypoint: Waypoint, place: int) -> str:
    return f"waypoint {place + 1}" if waypoint.item is None else f"item {waypoint.item}"


def plan_near_optimal(
    waypoints: Sequence[Waypoint],
    vehicle: Vehicle,
    limits: Limits | None = None,
    mode: Mode = "best",
    progress: Progress | None = None,
    *,
    yaw: Yaw = FREE_YAW,
    fences: Sequence[Fence] = (),
) -> Plan:
    """A proven flight through all waypoints, at rest at both ends and where one holds, close to the shortest there is.

    limits: default Limits.of(vehicle). yaw: where the nose points between places of rest. fences: in W. progress is
    told in words how far it is; Ctrl-C during it ends the search with the best proven flight so far. Raises
    MissionError and InfeasibleSegment as `plan_course`.
    """
    limits = Limits.of(vehicle) if limits is None else limits
    points = headed(checked_nodes(waypoints, vehicle, limits), yaw)
    require_fenced(points, fences)
    require_possible(points, limits)
    flown: list[Flown] = []
    start_s = 0.0
    for part in stretches(points):
        start_s += part[0].hold_s
        flown.append(_flown(part, vehicle, limits, mode, progress, yaw, fences, start_s, flown))
        start_s += float(flown[-1].path.times[-1])
    plan = plan_of(waypoints, points, vehicle, flown, mode)
    return replace(plan, waypoints=_placed(waypoints, plan.trajectory, plan.times_s))


def _flown(
    points: Sequence[CourseNode],
    vehicle: Vehicle,
    limits: Limits,
    mode: Mode,
    progress: Progress | None,
    yaw: Yaw,
    fences: Sequence[Fence],
    start_s: float,
    before: Sequence[Flown],
) -> Flown:
    """One stretch from rest to rest, after those before; start_s: of the plan, when it begins."""
    best = np.inf

    def told(total: float, _: int = 0) -> None:
        nonlocal best
        best = min(best, total)
        if progress is not None:
            progress(f"{points[0].name} to {points[-1].name}: {best:.3f} s")

    if turns_over(points):
        return turned_over(points, vehicle, limits, told, knots=mode == "best")
    inverted, mirror = not points[0].upright, mirror_of(before)
    if inverted:
        points, limits, yaw = mirrored(points, mirror), limits.inverted, KEPT_YAW
    setup = Setup.of(points, vehicle, limits, yaw, fences)
    problem, (low, high) = _stretch_planned(setup, mode, told, start_s)
    times = np.concatenate([[0.0], np.cumsum(problem.durations)])
    ends = np.flatnonzero(np.diff(problem.leg, append=len(points) - 1)) + 1
    path = PiecewisePolynomial(times, np.array(problem.coefficients))
    path = mirrored_back(path, mirror) if inverted else path
    return Flown(path, times[ends], *rotor_ranges(list(low), list(high), inverted))


def _placed(
    waypoints: Sequence[Waypoint], trajectory: PiecewisePolynomial, times: Sequence[float]
) -> tuple[Waypoint, ...]:
    """With the positions that were found where they were free."""
    placed = []
    for waypoint, t in zip(waypoints, times, strict=True):
        x, y, z = trajectory.at(t)[0, :3].tolist()
        placed.append(replace(waypoint, position=(x, y, z)) if any(waypoint.free) else waypoint)
    return tuple(placed)


def _stretch_planned(
    setup: Setup, mode: Mode, told: Callable[[float], None], start_s: float
) -> tuple[kernel.Problem, tuple[Array, Array]]:
    """From rest to rest: (proven problem, smallest and largest thrust of each rotor)."""
    points, limits = setup.points, setup.limits
    search = _Search(_recipe(mode, setup.stretch.legs, limits), setup.moves, told)
    tried = [limits]
    push = PUSHES_UP * setup.vehicle.rotor.thrust_max_N
    if limits.rotor_min < push - 1e-9:  # first as if the rotors could only push up
        tried.insert(0, replace(limits, rotor_min=push))
    found: kernel.Problem | None = None
    for now in tried:
        constraints = setup.constraints(now)
        flights: list[kernel.Problem | None] = [found]
        if found is not None and not setup.vertical:
            rung = search.recipe.ladder[-1]
            problem = search.minimise(found, constraints, rung, _OTHER_LIMITS, _SPARE)
            flights.append(search.repaired(problem, constraints, rung))
        if len(flights) == 1 or (search.recipe.two_starts and not search.interrupted):
            start = _warm_start(setup, constraints)
            flights.append(search.planned(start, constraints))
        shortest = min((one for one in flights if one is not None), key=lambda one: one.total, default=None)
        if found is None or shortest is None or shortest.total < (1.0 - _REVERSE_PAYS) * found.total:
            found = shortest
        if search.interrupted:
            break
    if found is None:
        raise infeasible(setup, start, constraints)
    found = search.refined(found, constraints)
    if times := given_times(points, start_s):
        durations = _leg_durations(found)
        arriving = _arriving(search, setup, found, durations, times)
        if arriving is None:
            raise too_early(points, durations, times, start_s)
        found = arriving
    low, high = kernel.rotor_range(found, constraints, 200)
    return found, (low, high)


def _arriving(
    search: _Search, setup: Setup, fastest: kernel.Problem, durations: Array, times: Sequence[tuple[int, float]]
) -> kernel.Problem | None:
    """With the given times, and the legs after the last of them as short as they can be; `durations` are those of the
    legs of the fastest flight. If what is left of that hides peaks, they too get a little more time, and a fixed one.
    """
    shared, timed = shared_out(durations, times)
    search.moving = True  # nothing may be slowed down any more
    better, last = _in_times(search, setup, fastest, shared, timed)
    for more in () if better is not None or all(timed) else _MORE_TIME:
        relaxed = _leg_durations(last) * np.where(timed, 1.0, more)
        better, _ = _in_times(search, setup, last, relaxed, [True] * len(timed))
        if better is not None:
            break
    return better


def _in_times(
    search: _Search, setup: Setup, near: kernel.Problem, durations: Array, timed: Sequence[bool]
) -> tuple[kernel.Problem | None, kernel.Problem]:
    """(proven, last tried) with these durations of the legs, some of them fixed: from a flight near it in space, or
    from the paper's polynomials."""
    ends = np.concatenate([[0], np.flatnonzero(np.diff(near.leg, append=-1)) + 1])
    slower = np.concatenate([[1.0], durations / _leg_durations(near), [1.0]])
    by = np.sqrt(slower[:-1] * slower[1:])  # of each node
    values = near.nodes[ends] / by[:, None, None] ** np.arange(5)[:, None]
    path = solve(setup.stretch.nodes, durations)
    constraints = setup.constraints(setup.limits)
    starts = [setup.problem(start, durations, timed) for start in (values, path.derivatives(path.times, 5))]
    problem, better = starts[0], None
    for start in sorted(starts, key=lambda start: -start.least_margin(constraints, 48)):
        climbed = list(search.climb(start, constraints, search.recipe.rungs))
        problem = climbed[-1] if climbed else start
        better = search.repaired(problem, constraints, search.recipe.rungs[-1])
        if better is not None:
            break
    return better, problem


def _shorter(one: kernel.Problem | None, other: kernel.Problem | None) -> kernel.Problem | None:
    if one is None or other is None:
        return one or other
    return one if one.total <= other.total else other


def _leg_durations(problem: kernel.Problem) -> Array:
    return np.bincount(problem.leg, problem.durations).astype(np.float64)


def _warm_start(setup: Setup, constraints: kernel.Constraints) -> kernel.Problem:
    """The paper's polynomials, or stopping at every point where that is shorter (legs of very unequal length), in times
    by distance, slowed down until they fit."""
    nodes, fastest = setup.stretch.nodes, setup.fastest
    guess = np.zeros_like(nodes)
    guess[:, 0, :3] = [point.waypoint.position for point in setup.points]
    distance = np.linalg.norm(np.diff(guess[:, 0, :3], axis=0), axis=1)
    turn = np.abs(np.nan_to_num(np.diff(nodes[:, 0, 3])))
    durations = 0.45 * np.sqrt(distance) + 0.12 + 0.2 * np.sqrt(turn)
    durations[0] += 0.25 * np.sqrt(distance[0])
    durations[-1] += 0.25 * np.sqrt(distance[-1])
    durations = np.maximum(durations, 1.5 * distance / fastest)

    def smooth(factor: float) -> kernel.Problem:
        path = solve(nodes, factor * durations)
        return setup.problem(path.derivatives(path.times, 5), factor * durations)

    def stopping(factor: float) -> kernel.Problem:
        return setup.problem(guess, factor * np.maximum(durations, 2.5 * distance / fastest))

    makers = [smooth, stopping][: 1 if len(durations) == 1 else 2]
    try:
        solve(nodes, durations)
    except PlanError:  # given accelerations can leave the paper's form undetermined
        makers = [stopping]
    starts = [_slow_enough(make, constraints) for make in makers]
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
