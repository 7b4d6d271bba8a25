"""The interior-point method of flights with virtual knots, against optima that are known otherwise."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import linprog

from halfroll.planner.central_path import Slopes, minimised

Array = NDArray[np.float64]
BARRIERS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)


@dataclass
class Linear:
    """cost . z over A z <= b."""

    cost: Array
    A: Array
    b: Array
    seen: list[float] = field(default_factory=list)

    def total(self, z: Array) -> tuple[float, Array, Array]:
        return float(self.cost @ z), self.cost, np.zeros(len(z))

    def margins(self, z: Array) -> Array:
        return np.asarray((self.b - self.A @ z)[None])

    def slopes(self, z: Array) -> Slopes:
        return Slopes(-self.A[None], np.eye(len(z))[None])

    def told(self, z: Array) -> None:
        self.seen.append(float(self.margins(z).min()))


def box_and_planes(seed: int, unknowns: int) -> Linear:
    rng = np.random.default_rng(seed)
    planes = rng.normal(size=(2 * unknowns, unknowns))
    A = np.concatenate([np.eye(unknowns), -np.eye(unknowns), planes])
    b = np.concatenate([np.full(2 * unknowns, 2.0), rng.uniform(0.1, 1.0, 2 * unknowns)])
    return Linear(rng.normal(size=unknowns), A, b)


@given(st.integers(0, 10_000), st.integers(2, 8))
def test_a_linear_program_ends_where_simplex_does(seed: int, unknowns: int) -> None:
    problem = box_and_planes(seed, unknowns)
    z = minimised(problem, np.zeros(unknowns), BARRIERS, 1e-6, problem.told)
    best = linprog(problem.cost, problem.A, problem.b, bounds=(None, None))
    assert problem.margins(z).min() > 0.0
    assert problem.total(z)[0] == pytest.approx(best.fun, abs=1e-3)


def test_what_starts_a_little_outside_its_limits_ends_inside() -> None:
    problem = box_and_planes(1, 5)
    direction = np.ones(5)
    most = min(b / a for a, b in zip(problem.A @ direction, problem.b, strict=True) if a > 0.0)
    start = 1.1 * most * direction
    assert problem.margins(start).min() < -0.01
    z = minimised(problem, start, BARRIERS, 0.02, problem.told)
    assert problem.margins(z).min() > 0.0
    assert problem.seen[-1] == problem.margins(z).min()
