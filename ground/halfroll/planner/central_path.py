"""An interior-point method for a few hundred unknowns: the shortest time inside smooth margins.

Why: where a flight turns over the kernel's solver, which knows upright thrust, cannot help, and linear programs zigzag
among many knots. This is its recipe (docs/planner.md, section 5) in dense numpy: primal-dual steps, margins that start
shifted where they are not met, second derivatives by Gauss and Newton, and damping in place of what these leave out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_STEPS = 40  # at most, for each barrier
_NEAR, _DONE = 10.0, 0.3  # of the barrier: what a step promises when a stage ends, and when the last does
_KEPT = 0.01  # of a margin, at least, in one step
_LONGEST_STEP = 1.6  # in a unit of the problem's
_DAMPING, _LEAST_DAMPING = 1e-4, 1e-9
_TRIES, _CUTS, _CUT = 6, 4, 0.4
_ARMIJO, _ROUNDING = 1e-4, 1e-14
_CENTRAL = 1e3  # how far a multiplier may be from its place on the central path, as a factor


@dataclass(frozen=True)
class Slopes:
    """Of margins (N, m) over n unknowns, in N blocks: by k inner variables of each block, and of those."""

    inner: Array  # (N, m, k)
    outer: Array  # (N, k, n)

    def along(self, step: Array) -> Array:
        """(N, m)"""
        return np.asarray((self.inner @ (self.outer @ step)[..., None])[..., 0])

    def weighted(self, weight: Array) -> Array:
        """(n,) sum of the margins' slopes by this weight (N, m)."""
        return np.asarray(((weight[:, None] @ self.inner) @ self.outer).sum(axis=(0, 1)))

    def squared(self, weight: Array) -> Array:
        """(n, n) sum of their outer products."""
        gram = self.inner.transpose(0, 2, 1) @ (weight[..., None] * self.inner)
        return np.asarray((self.outer.transpose(0, 2, 1) @ (gram @ self.outer)).sum(axis=0))


class Problem(Protocol):
    """Unknowns are scaled: a step of 1 is a large one."""

    def total(self, z: Array) -> tuple[float, Array, Array]:
        """What is to become small, of order 1; its slopes; the diagonal of its second derivatives."""

    def margins(self, z: Array) -> Array:
        """(N, m), >= 0 where the limits hold; not finite where there is no flight."""

    def slopes(self, z: Array) -> Slopes: ...


def minimised(
    problem: Problem, z: Array, barriers: Sequence[float], least: float, told: Callable[[Array], None]
) -> Array:
    """The unknowns at the end of the central path, from z on; barriers: weights of the logarithms, falling; margins
    below `least` start shifted up to it."""
    margin = problem.margins(z)
    shift = np.maximum(0.0, least - margin)
    multiplier = barriers[0] / (margin + shift)
    damping = _DAMPING
    for barrier in barriers:
        ends = (_DONE if barrier == barriers[-1] else _NEAR) * barrier
        for _ in range(_STEPS):
            room = margin + shift
            multiplier = np.clip(multiplier, barrier / room / _CENTRAL, barrier / room * _CENTRAL)
            slopes = problem.slopes(z)
            time, gradient, curvature = problem.total(z)
            hessian = slopes.squared(multiplier / room)
            hessian[np.diag_indices_from(hessian)] += curvature
            gradient = gradient - slopes.weighted(barrier / room)
            here = time - barrier * float(np.log(room).sum())

            def merit(there: Array, shift: Array = shift, room: Array = room, barrier: float = barrier) -> float:
                left = problem.margins(there) + shift
                if not np.all(left > _KEPT * room):  # nor if one is not a number
                    return np.inf
                return problem.total(there)[0] - barrier * float(np.log(left).sum())

            step, taken, damping = _step(merit, z, here, gradient, hessian, damping)
            if taken == 0.0:
                break
            change = barrier / room - multiplier - multiplier / room * slopes.along(step)
            multiplier = multiplier + taken * change
            z = z + taken * step
            margin = problem.margins(z)
            shift = np.maximum(0.0, shift - (margin + shift) / 2.0)
            told(z)
            if taken >= _CUT and -float(gradient @ step) < ends and not shift.any():
                break
    return z


def _step(
    merit: Callable[[Array], float], z: Array, here: float, gradient: Array, hessian: Array, damping: float
) -> tuple[Array, float, float]:
    """(step, how much of it improves, damping of the next); 0 where nothing does."""
    for _ in range(_TRIES):
        step: Array = np.asarray(np.linalg.solve(hessian + damping * np.eye(len(z)), -gradient))
        step *= min(1.0, _LONGEST_STEP / max(float(np.abs(step).max()), 1e-12))
        promised = -float(gradient @ step)
        taken = 1.0
        for _ in range(_CUTS):
            if merit(z + taken * step) < here - _ARMIJO * taken * promised + _ROUNDING:
                calmer = 0.2 if taken == 1.0 else 3.0 if taken < 0.3 else 1.0
                return step, taken, max(_LEAST_DAMPING, calmer * damping)
            taken *= _CUT
        damping *= 8.0
    return step, 0.0, damping
