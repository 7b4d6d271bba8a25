"""Segments: the 9th-order polynomials between nodes (Eqs 23-24).

Why: the only place that knows the basis; plan.py and limits.py ask for derivatives and never see a coefficient. A
node has the derivatives 0..4 of four axes (x, y, z, yaw), each given or free. Where k of them are given at an inner
node, all others up to the (9-k)-th are continuous, so every axis has as many equations as unknowns.

The equations are solved by the kernel (kernel/closed_form.hpp), in time and memory linear in the number of nodes.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from math import factorial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfroll import _planner as kernel
from halfroll.errors import InputError, PlanError
from halfroll.reading import parse_json, read_arrays, read_text

Array = NDArray[np.float64]

ORDER = 10  # coefficients of a piece
GIVEN = 5  # derivatives 0..4 of a node that can be given
AXES = 4  # x, y, z, yaw
FREE = np.nan
CONTINUITIES = range(4, 9)

_FALLING = np.array([[factorial(i) / factorial(i - d) if i >= d else 0.0 for i in range(ORDER)] for d in range(ORDER)])


def monomials(tau: ArrayLike, derivative: int) -> Array:
    """(len(tau), 10): the derivative of 1, tau, .. tau^9, so that `monomials(tau, d) @ coefficients` is d/dtau^d."""
    power = np.maximum(np.arange(ORDER) - derivative, 0)
    return np.asarray(_FALLING[derivative] * np.atleast_1d(np.asarray(tau, dtype=float))[:, None] ** power)


_CSV_COLUMNS = ["start_s", "end_s", *(f"{axis}_tau{i}" for i in range(ORDER) for axis in ("x", "y", "z", "yaw"))]


@dataclass(frozen=True)
class PiecewisePolynomial:
    """Pieces of 9th order in local time tau = (t - t_k) / T_k.

    times (N+1,) [s], increasing; coefficients (N, 10, 4): lowest power first, axes x, y, z [m], yaw [rad].
    Before the first and after the last time it stands still at the end point.
    """

    times: Array
    coefficients: Array

    @property
    def durations(self) -> Array:
        return np.diff(self.times)

    def at(self, t: ArrayLike, derivative: int = 0) -> Array:
        """(len(t), 4): the derivative at times t. At a node, the piece that starts there."""
        t = np.atleast_1d(np.asarray(t, dtype=float))
        return self._evaluate(t, range(derivative, derivative + 1))[:, 0]

    def derivatives(self, t: ArrayLike, count: int = 6) -> Array:
        """(len(t), count, 4): derivatives 0..count-1 at times t."""
        return self._evaluate(np.atleast_1d(np.asarray(t, dtype=float)), range(count))

    def _evaluate(self, t: Array, orders: range) -> Array:
        piece = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.times) - 2)
        duration = self.durations[piece]
        tau = np.clip((t - self.times[piece]) / duration, 0.0, 1.0)
        outside = (t < self.times[0]) | (t > self.times[-1])
        powers = tau[:, None] ** np.arange(ORDER)
        out = np.empty((len(t), len(orders), AXES))
        for row, order in enumerate(orders):
            terms = _FALLING[order, order:] * powers[:, : ORDER - order]
            out[:, row] = np.einsum("ti,tia->ta", terms, self.coefficients[piece, order:]) / duration[:, None] ** order
            if order > 0:
                out[outside, row] = 0.0
        return out

    def save(self, path: str | Path) -> None:
        """Write .npz, .json or .csv (a piece a row); `load` reads each of them back bit for bit. Raises InputError."""
        path = Path(path)
        if path.suffix == ".npz":
            np.savez(path, times=self.times, coefficients=self.coefficients)
        elif path.suffix == ".json":
            pieces = {"times": self.times.tolist(), "coefficients": self.coefficients.tolist()}
            path.write_text(json.dumps(pieces) + "\n", encoding="utf-8")
        elif path.suffix == ".csv":
            rows = [_CSV_COLUMNS]
            for start, end, piece in zip(
                self.times[:-1].tolist(), self.times[1:].tolist(), self.coefficients, strict=True
            ):
                rows.append([repr(number) for number in (start, end, *piece.ravel().tolist())])
            path.write_text("".join(",".join(row) + "\n" for row in rows), encoding="utf-8")
        else:
            raise InputError(f"{path}: a trajectory is written as .npz, .json or .csv; choose one of these endings")

    @classmethod
    def load(cls, path: str | Path) -> PiecewisePolynomial:
        """Read what `save` wrote. Raises InputError."""
        path = Path(path)
        try:
            if path.suffix == ".npz":
                return cls(*read_arrays(path, ("times", "coefficients")))
            text = read_text(path)
            if path.suffix == ".json":
                pieces = parse_json(text)
                return cls(np.array(pieces["times"], dtype=float), np.array(pieces["coefficients"], dtype=float))
            header, *rows = (line.split(",") for line in text.splitlines())
            if header != _CSV_COLUMNS or not rows:
                raise ValueError("its columns are not those of a trajectory")
            numbers = np.array(rows, dtype=float)
            return cls(np.append(numbers[:, 0], numbers[-1, 1]), numbers[:, 2:].reshape(-1, ORDER, AXES))
        except OSError as error:
            raise InputError(f"trajectory {path}: {error.strerror or error}; check the path") from None
        except (KeyError, ValueError, TypeError) as error:
            raise InputError(f"{path} is not a trajectory that halfroll wrote ({error})") from None

    def then(self, following: PiecewisePolynomial) -> PiecewisePolynomial:
        """This one, followed by another whose clock is moved to start where this one ends."""
        shifted = following.times[1:] - following.times[0] + self.times[-1]
        return PiecewisePolynomial(
            np.concatenate([self.times, shifted]), np.concatenate([self.coefficients, following.coefficients])
        )


def standing(point: ArrayLike, duration: float) -> PiecewisePolynomial:
    """One piece that stays at point (4,) for this long: a hold at rest."""
    coefficients = np.zeros((1, ORDER, AXES))
    coefficients[0, 0] = np.asarray(point, dtype=float)
    return PiecewisePolynomial(np.array([0.0, duration]), coefficients)


def node(position: ArrayLike, *derivatives: ArrayLike) -> Array:
    """(5, 4): a node passed at position (4,), the derivatives 1..4 that are named are given, the rest free."""
    given = np.full((GIVEN, AXES), FREE)
    for d, row in enumerate((position, *derivatives)):
        given[d] = np.asarray(row, dtype=float)
    return given


def rest(position: ArrayLike) -> Array:
    """(5, 4): a node at position (4,), at rest: velocity to snap are zero."""
    return node(position, *[np.zeros(AXES)] * (GIVEN - 1))


Slopes = Callable[[ArrayLike], tuple[Array, Array]]


def solve(nodes: ArrayLike, durations: ArrayLike, continuity: int = 8) -> PiecewisePolynomial:
    """The trajectory through the nodes in these times; O(n).   Eqs 23-24

    nodes (n, 5, 4): derivatives 0..4 of each axis, NaN where free; durations (n-1,) [s], > 0. A node at rest in the
    middle (all 20 given) simply has C4 continuity there; for a hold put a `standing` piece between two solves. A
    derivative d that is free at an end leaves derivative 9-d zero there.

    continuity: 8 is the paper's, where k derivatives are given all others are continuous up to the (9-k)-th. With
    4..7, none above that one need be, and what is left open makes the integral of the squared snap least.
    Raises PlanError.
    """
    return _path(_solved(nodes, durations, continuity))


def solve_with_slopes(
    nodes: ArrayLike, durations: ArrayLike, continuity: int = 8
) -> tuple[PiecewisePolynomial, Slopes]:
    """`solve`, and a function from the slopes of any cost over the coefficients (N, 10, 4) to its exact slopes over the
    durations (N,) and over the given derivatives (n, 5, 4), zero where free; O(n) too."""
    form = _solved(nodes, durations, continuity)
    return _path(form), form.slopes


def solve_many(given: Array, durations: Array) -> Array:
    """Coefficients (B, N, 10, 4) for B sets of durations (B, N) with the same nodes (N+1, 5, 4); inputs are trusted.
    Raises PlanError."""
    coefficients: Array | None = kernel.closed_forms(given, durations)
    if coefficients is None:
        raise PlanError("what is given at the nodes does not determine a trajectory, or the durations are too unequal")
    return coefficients


def _solved(nodes: ArrayLike, durations: ArrayLike, continuity: int) -> kernel.ClosedForm:
    given, T = np.asarray(nodes, dtype=float), np.asarray(durations, dtype=float)
    _check(given, T, continuity)
    form = kernel.ClosedForm(given, T, continuity)
    if not form.solved:
        raise PlanError(
            f"what is given at the nodes up to node {form.stuck} does not determine a trajectory: give positions at "
            "more of them; or the durations are too unequal to compute it"
        )
    return form


def _path(form: kernel.ClosedForm) -> PiecewisePolynomial:
    return PiecewisePolynomial(np.concatenate([[0.0], np.cumsum(form.durations)]), form.coefficients)


def _check(given: Array, T: Array, continuity: int) -> None:
    if given.ndim != 3 or given.shape[1:] != (GIVEN, AXES):
        raise PlanError(
            f"nodes have shape {given.shape}; give (n, 5, 4): derivatives 0..4 of x, y, z, yaw at each node"
        )
    if len(given) < 2:
        raise PlanError("a trajectory needs at least two nodes")
    if T.shape != (len(given) - 1,):
        raise PlanError(f"{len(given)} nodes need {len(given) - 1} durations, not {T.size}")
    if not (T.min() > 0.0 and T.max() < np.inf):
        k = int(np.argmin(np.where(np.isfinite(T), T, -np.inf)))
        raise PlanError(f"segment {k} has duration {T[k]:g} s; node times must be finite and increase")
    if np.isinf(given).any():
        k, d, axis = (int(i) for i in np.argwhere(np.isinf(given))[0])
        raise PlanError(f"node {k}: derivative {d} of axis {('x', 'y', 'z', 'yaw')[axis]} is not finite; give a number")
    if continuity not in CONTINUITIES:
        raise PlanError(f"continuity {continuity} cannot be had with 9th-order pieces; choose 4 to 8 (8: the paper's)")
