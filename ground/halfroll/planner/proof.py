"""The proof of a path that is given: that polynomials which something else than the kernel found keep their limits.

Why: mode paper searches with numpy and checks at samples; what it returns is held to the same proof as any other plan.
The rotors' rates are not asked of it: its form has no freedom to obey them. An inverted leg is proven by its mirror
image; what turns over has its own proof, which comes with its plan (aerobatics.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from halfroll import _planner as kernel
from halfroll.missions.mission import Waypoint, Yaw
from halfroll.planner.aerobatics import Plane, turns_over
from halfroll.planner.course_nodes import CourseNode, attitudes_allowed, checked_nodes
from halfroll.planner.kernel_problem import Setup, refused
from halfroll.planner.limits import Limits
from halfroll.planner.plan import Plan, mirrored, mirrored_back, stretches
from halfroll.planner.segments import PiecewisePolynomial


def proven(plan: Plan, waypoints: Sequence[Waypoint], limits: Limits) -> Plan:
    """The plan of the paper's form through these waypoints, certified; or with the leg and the limit that are in doubt
    among its warnings."""
    limits = replace(limits, drive=None, rotor_rate_max=None)
    doubts, checked = [], plan.certified
    piece, mirror = 0, 0.0
    for points in stretches(checked_nodes(waypoints, plan.vehicle, limits)):
        piece += int(points[0].hold_s > 0.0)
        pieces = slice(piece, piece + len(points) - 1)
        piece += len(points) - 1
        if turns_over(points):
            mirror = Plane.of(points).heading
            continue
        path = PiecewisePolynomial(plan.trajectory.times, plan.trajectory.coefficients)
        allowed = attitudes_allowed(points, limits)
        if not points[0].upright:
            points, allowed, path = mirrored(points, mirror), allowed.inverted, mirrored_back(path, mirror)
        setup = Setup.of([_place_alone(point) for point in points], plan.vehicle, allowed, Yaw("given"), ())
        constraints = setup.constraints(setup.limits)
        found = kernel.certify(path.coefficients[pieces], path.durations[pieces].tolist(), setup.pieces, constraints)
        if not found.proven:
            doubts.append(f"not proven: {refused(setup, found, found.piece, setup.pieces[found.piece], constraints)}")
    return replace(plan, certified=checked and not doubts, warnings=(*plan.warnings, *doubts))


def _place_alone(point: CourseNode) -> CourseNode:
    """Without attitude and direction, which the path has met."""
    return replace(point, waypoint=replace(point.waypoint, q_WB=None, thrust=None, body_rate=None, direction=None))
