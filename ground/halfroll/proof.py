"""The proof of a path that is given: that polynomials which something else than the kernel found keep their limits.

Why: mode paper searches with numpy and checks at samples; what it returns is held to the same proof as every other
plan. The rotors' rates are not asked of it: its form has no freedom to obey them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from halfroll import _planner as kernel
from halfroll.kernel_problem import Setup, refused
from halfroll.limits import Limits
from halfroll.mission import Waypoint, Yaw
from halfroll.plan import CourseNode, Plan, checked_nodes


def proven(plan: Plan, waypoints: Sequence[Waypoint], limits: Limits) -> Plan:
    """The plan of the paper's form through these waypoints, certified; or with the leg and the limit that are in doubt
    among its warnings."""
    limits = replace(limits, drive=None, rotor_rate_max=None)
    doubts = []
    for points, first in _stretches(checked_nodes(waypoints, limits)):
        pieces = slice(first, first + len(points) - 1)
        path = plan.trajectory
        setup = Setup.of(points, plan.vehicle, limits, Yaw("given"), ())
        constraints = setup.constraints(setup.limits)
        found = kernel.certify(path.coefficients[pieces], path.durations[pieces].tolist(), setup.pieces, constraints)
        if not found.proven:
            doubts.append(f"not proven: {refused(setup, found, found.piece, setup.pieces[found.piece], constraints)}")
    return replace(plan, certified=not doubts, warnings=(*plan.warnings, *doubts))


def _stretches(points: Sequence[CourseNode]) -> Iterator[tuple[Sequence[CourseNode], int]]:
    """From rest to rest, and the place of the first piece: each wait is one too."""
    piece, first = int(points[0].hold_s > 0.0), 0
    for last in range(1, len(points)):
        if points[last].at_rest:
            yield points[first : last + 1], piece
            piece += last - first + int(points[last].hold_s > 0.0)
            first = last
