"""Near-optimal plans: modes `fast` and `best`, within a few percent of the least possible time and proven.

Why: the paper's polynomials are one piece a leg with continuity through the 8th derivative, which costs half as much
time again. Here every leg has virtual knots, only what smooth rotor commands need is continuous (the 4th derivative),
yaw is optimised too, and an interior-point method (the C++ kernel) moves all of it. This module is the order of things:
stretch after stretch, first as if rotors could only push up, then with given times, kept only if it wins. ladder.py is
the search itself. docs/planner.md explains each step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from halfroll import _planner as kernel
from halfroll.errors import InfeasibleSegment, InputError
from halfroll.missions.mission import Demand, Fence, LimitsKind, PlanOptions, Rules, Waypoint, Yaw
from halfroll.planner import corridor
from halfroll.planner.aerobatics import turns_over
from halfroll.planner.arrivals import given_times, require_possible, shared_out, too_early
from halfroll.planner.course_nodes import CourseNode, checked_nodes
from halfroll.planner.kernel_problem import Setup, headed, infeasible, leg_durations, leg_ends, place, require_fenced
from halfroll.planner.ladder import OTHER_LIMITS, SPARE, Mode, Search, recipe_for
from halfroll.planner.limits import Limits, changed
from halfroll.planner.plan import (
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
from halfroll.planner.proof import proven
from halfroll.planner.segments import PiecewisePolynomial, solve
from halfroll.planner.turning_room import require_room
from halfroll.planner.warm_start import along_its_path, warm_start
from halfroll.vehicle import Vehicle

Array = NDArray[np.float64]
Progress = Callable[[str], None]

FREE_YAW = Yaw("free")
KEPT_YAW = Yaw("given")  # upside down the nose keeps its direction
PUSHES_UP = 0.05  # of the largest thrust: rotors that push no less than this could have fixed pitch
_REVERSE_PAYS = 0.002  # of the time, or rotors are not asked to push down: the gentler flight is easier to follow
_NOSE_SLOWER = (1.0, 1.5, 3.0)  # than with the nose free, where the search begins
_FENCE_STEP_S = 0.005  # of a path that is checked against a fence point by point
_MORE_TIME = (1.01, 1.03, 1.1)  # for legs after a given time of arrival


def limits_of(vehicle: Vehicle, kind: LimitsKind = "mission", margin: float | None = None) -> Limits:
    """As Limits.of, but rotor thrust alone is really alone: the thrust axis may tilt below the horizon."""
    limits = Limits.of(vehicle, kind, margin)
    return replace(limits, force_z_min=None) if kind == "rotors" else limits


def limits_in(vehicle: Vehicle, options: PlanOptions, rules: Rules | None = None) -> Limits:
    """Those that options and rules make. Raises InputError."""
    of = Limits.of if options.mode == "paper" else limits_of
    of_mission = () if rules is None else rules.limits
    return changed(of(vehicle, options.limits, options.margin), (*of_mission, *options.changes))


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
    limits = limits_in(vehicle, options, rules)
    yaw = options.yaw or rules.yaw
    due = ((k, point) for k, point in enumerate(waypoints) if point.time_s is not None)
    if options.mode != "paper":
        plan = plan_near_optimal(
            waypoints, vehicle, limits, options.mode, progress, yaw=yaw or FREE_YAW, fences=rules.fences
        )
        require_inside(plan, rules.fences if plan.turns else ())
    elif yaw is not None and yaw.rule != "given":
        raise InputError(f"mode paper flies yaw as given, not {yaw.rule}; take mode fast or best")
    elif timed := next((f"{_name(point, k)} is due at {point.time_s:g} s" for k, point in due), None):
        raise InputError(f"mode paper keeps no times, and {timed}; take mode fast or best")
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
            worst = int(np.argmax(out))
            leg = int(np.searchsorted(plan.times_s, t[worst]))
            waypoint = plan.waypoints[min(leg, len(plan.waypoints) - 1)]
            raise InfeasibleSegment(
                f"on the way to {_name(waypoint, leg)} the path leaves the {fence.name} by {max(out):.2f} m "
                f"{place(positions[worst])}, and nothing here can bend it (in mode paper, and where it turns "
                "over); move the waypoints",
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
    search = Search(recipe_for(mode, setup.stretch.legs, limits), setup.moves, told)
    tried = [limits]
    push = PUSHES_UP * setup.vehicle.rotor.thrust_max_N
    if limits.rotor_min < push - 1e-9:  # first as if the rotors could only push up
        tried.insert(0, replace(limits, rotor_min=push))
    found: kernel.Problem | None = None
    for now in tried:
        constraints = setup.constraints(now)
        if found is not None and search.recipe.trusts_price:
            promised = search.push_price * (push - limits.rotor_min)  # to first order
            if promised < _REVERSE_PAYS * found.total:
                break
        flights: list[kernel.Problem | None] = [found]
        if found is not None and not setup.vertical:
            rung = search.recipe.ladder[-1]
            problem = search.minimise(found, constraints, rung, OTHER_LIMITS, SPARE)
            flights.append(search.repaired(problem, constraints, rung))
        if len(flights) == 1 or (search.recipe.two_starts and not search.interrupted):
            for start in _starts(search, setup, now):
                flights.append(search.planned(start, constraints))
                if flights[-1] is not None:  # where it is stopped, those that are left cost next to nothing
                    break
        shortest = min((one for one in flights if one is not None), key=lambda one: one.total, default=None)
        if found is None or shortest is None or shortest.total < (1.0 - _REVERSE_PAYS) * found.total:
            found = shortest
        if search.interrupted:
            break
    if found is None:
        raise infeasible(setup, start, constraints)
    found = search.refined(found, constraints)
    if times := given_times(points, start_s):
        durations = leg_durations(found)
        arriving = _arriving(search, setup, found, durations, times)
        if arriving is None:
            raise too_early(points, durations, times, start_s)
        found = arriving
    low, high = kernel.rotor_range(found, constraints, 200)
    return found, (low, high)


def _starts(search: Search, setup: Setup, limits: Limits) -> Iterator[kernel.Problem]:
    """Where the search begins; the next one where it has found nothing. With the nose along the path from the flight
    with the nose free: slowed down, until the nose follows of itself, the paper's polynomials crawl."""
    if setup.yaw.rule == "path":
        free = replace(setup, yaw=FREE_YAW)
        constraints = free.constraints(limits)
        flight = search.planned(warm_start(free, constraints), constraints)
        if flight is not None:
            aimed = along_its_path(flight, setup)
            yield from (aimed.stretched(factor) for factor in _NOSE_SLOWER)
    yield warm_start(setup, setup.constraints(limits))


def _arriving(
    search: Search, setup: Setup, fastest: kernel.Problem, durations: Array, times: Sequence[tuple[int, float]]
) -> kernel.Problem | None:
    """With the given times, and the legs after the last of them as short as they can be; `durations` are those of the
    legs of the fastest flight. If what is left of that hides peaks, they too get a little more time, and a fixed one.
    """
    shared, timed = shared_out(durations, times)
    search.moving = True  # nothing may be slowed down any more
    better, last = _in_times(search, setup, fastest, shared, timed)
    for more in () if better is not None or all(timed) else _MORE_TIME:
        relaxed = leg_durations(last) * np.where(timed, 1.0, more)
        better, _ = _in_times(search, setup, last, relaxed, [True] * len(timed))
        if better is not None:
            break
    return better


def _in_times(
    search: Search, setup: Setup, near: kernel.Problem, durations: Array, timed: Sequence[bool]
) -> tuple[kernel.Problem | None, kernel.Problem]:
    """(proven, last tried) with these durations of the legs, some of them fixed: from a flight near it in space, or
    from the paper's polynomials."""
    ends = leg_ends(near)
    slower = np.concatenate([[1.0], durations / leg_durations(near), [1.0]])
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
