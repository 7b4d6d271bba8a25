"""Segments: the 9th-order polynomials between nodes (Eqs 23-24).

Why: the only place that knows the basis and solves for it; plan.py and limits.py ask for derivatives and never see a
coefficient. A node has the derivatives 0..4 of four axes (x, y, z, yaw), each given or free. Where k of them are
given at an inner node, all others up to the (9-k)-th are continuous, so every axis has as many equations as unknowns.

The unknowns are not the 10 coefficients of each piece but the 5 derivatives at each node (the Hermite form): then
positions are met by construction, only the derivatives 5..9-k have to be made equal on both sides, and the system has a
half-bandwidth of 9 whatever the number of nodes. Derivative d at node k is scaled by h^d, h the geometric mean of the
durations on its two sides, which keeps the system well conditioned for unequal pieces.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import lapack

from halfroll.errors import PlanError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

ORDER = 10  # coefficients of a piece
GIVEN = 5  # derivatives 0..4 of a node that can be given
AXES = 4  # x, y, z, yaw
FREE = np.nan

_BAND = 2 * GIVEN - 1  # entries of a row reach this far from the diagonal
_FALLING = np.array([[factorial(i) / factorial(i - d) if i >= d else 0.0 for i in range(ORDER)] for d in range(ORDER)])


def monomials(tau: ArrayLike, derivative: int) -> Array:
    """(len(tau), 10): the derivative of 1, tau, .. tau^9, so that `monomials(tau, d) @ coefficients` is d/dtau^d."""
    power = np.maximum(np.arange(ORDER) - derivative, 0)
    return np.asarray(_FALLING[derivative] * np.atleast_1d(np.asarray(tau, dtype=float))[:, None] ** power)


_AT_START = np.vstack([monomials(0.0, d) for d in range(ORDER)])  # (10, 10), derivative d of the piece at tau = 0
_AT_END = np.vstack([monomials(1.0, d) for d in range(ORDER)])
# Hermite form: coefficients from the tau-derivatives 0..4 at the start and 0..4 at the end.
# Its entries are whole numbers over 4!, so rounding makes them exact.
_HERMITE = np.rint(24.0 * np.linalg.inv(np.vstack([_AT_START[:GIVEN], _AT_END[:GIVEN]]))) / 24.0
_START_JUMP = _AT_START[GIVEN:] @ _HERMITE  # (5, 10), derivatives 5..9 at the start of a piece
_END_JUMP = _AT_END[GIVEN:] @ _HERMITE


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


def solve(nodes: ArrayLike, durations: ArrayLike) -> PiecewisePolynomial:
    """The trajectory through the nodes in these times; O(n).   Eqs 23-24

    nodes (n, 5, 4): derivatives 0..4 of each axis, NaN where free; durations (n-1,) [s], > 0. All 5 derivatives must be
    given at both ends. A node at rest in the middle (all 20 given) simply has C4 continuity there; for a hold put a
    `standing` piece between two solves. Raises PlanError.
    """
    given, T = np.asarray(nodes, dtype=float), np.asarray(durations, dtype=float)
    _check(given, T)
    coefficients = solve_many(given, T[None])[0]
    return PiecewisePolynomial(np.concatenate([[0.0], np.cumsum(T)]), coefficients)


def _check(given: Array, T: Array) -> None:
    if given.ndim != 3 or given.shape[1:] != (GIVEN, AXES):
        raise PlanError(
            f"nodes have shape {given.shape}; give (n, 5, 4): derivatives 0..4 of x, y, z, yaw at each node"
        )
    if len(given) < 2:
        raise PlanError("a trajectory needs at least two nodes")
    if T.shape != (len(given) - 1,):
        raise PlanError(f"{len(given)} nodes need {len(given) - 1} durations, not {T.size}")
    if not np.all(np.isfinite(T) & (T > 0.0)):
        k = int(np.argmin(np.where(np.isfinite(T), T, -np.inf)))
        raise PlanError(f"segment {k} has duration {T[k]:g} s; node times must be finite and increase")
    if np.any(np.isinf(given)):
        k, d, axis = (int(i) for i in np.argwhere(np.isinf(given))[0])
        raise PlanError(f"node {k}: derivative {d} of axis {('x', 'y', 'z', 'yaw')[axis]} is not finite; give a number")
    for k in (0, len(given) - 1):
        if np.any(np.isnan(given[k])):
            raise PlanError(f"node {k} is an end: all of position to snap must be given there (0 for rest)")


def solve_many(given: Array, durations: Array) -> Array:
    """Coefficients (B, N, 10, 4) for B sets of durations (B, N) with the same nodes (N+1, 5, 4); inputs are trusted.

    All sets form one block-diagonal banded system, so B perturbed copies cost one LAPACK call.
    """
    B, N = durations.shape
    h = np.empty((B, N + 1))
    h[:, 1:-1] = np.sqrt(durations[:, :-1] * durations[:, 1:])
    h[:, 0], h[:, -1] = durations[:, 0], durations[:, -1]
    d = np.arange(GIVEN)
    left = (durations / h[:, :-1])[..., None] ** d  # (B, N, 5): scaled node unknown -> tau-derivative of the piece
    right = (durations / h[:, 1:])[..., None] ** d
    scaled_given: Array = np.nan_to_num(given, nan=0.0) * h[:, :, None, None] ** d[:, None]  # (B, N+1, 5, 4)

    unknown = np.empty((B, N + 1, GIVEN, AXES))
    free = np.isnan(given)  # (N+1, 5, 4)
    for mask, axes in _axes_by_mask(free):
        if not mask.any():
            unknown[..., axes] = scaled_given[..., axes]
        else:
            blocks = _blocks(mask, durations, h, left, right)
            unknown[..., axes] = _solve_blocks(blocks, scaled_given[..., axes])
    ends = np.concatenate([unknown[:, :-1] * left[..., None], unknown[:, 1:] * right[..., None]], axis=2)
    return np.asarray(_HERMITE @ ends)


def _axes_by_mask(free: Mask) -> list[tuple[Mask, list[int]]]:
    """Axes with the same pattern of free derivatives share one factorisation."""
    groups: list[tuple[Mask, list[int]]] = []
    for axis in range(AXES):
        for mask, axes in groups:
            if np.array_equal(mask, free[:, :, axis]):
                axes.append(axis)
                break
        else:
            groups.append((free[:, :, axis], [axis]))
    return groups


def _blocks(free: Mask, durations: Array, h: Array, left: Array, right: Array) -> Array:
    """(B, N+1, 5, 15): the rows of each node against the unknowns of the node before, its own, and the one after.

    Row d of a node is `scaled unknown = given` or, if d is the j-th free derivative there, continuity of derivative
    5 + j. Rows are divided by their largest entry.
    """
    B, nodes = h.shape
    rows = np.zeros((B, nodes, GIVEN, 3 * GIVEN))
    r = np.arange(GIVEN, ORDER)
    before = (h[:, 1:-1] / durations[:, :-1])[..., None, None] ** r[:, None] * _END_JUMP  # piece that ends at the node
    after = (h[:, 1:-1] / durations[:, 1:])[..., None, None] ** r[:, None] * _START_JUMP
    rows[:, 1:-1, :, :5] = before[..., :5] * left[:, :-1, None, :]
    rows[:, 1:-1, :, 5:10] = before[..., 5:] * right[:, :-1, None, :] - after[..., :5] * left[:, 1:, None, :]
    rows[:, 1:-1, :, 10:] = -after[..., 5:] * right[:, 1:, None, :]

    continuity = np.maximum(np.cumsum(free, axis=1) - 1, 0)  # (nodes, 5): which continuity row a free derivative takes
    rows = rows[:, np.arange(nodes)[:, None], continuity]
    identity = np.eye(GIVEN, 3 * GIVEN, GIVEN)
    rows = np.where(free[None, :, :, None], rows, identity)
    return np.asarray(rows / np.abs(rows).max(axis=-1, keepdims=True))


def _solve_blocks(rows: Array, scaled_given: Array) -> Array:
    """Banded LU of all sets at once, and one step of iterative refinement; (B, N+1, 5, axes)."""
    B, nodes, _, axes = scaled_given.shape
    n = B * nodes * GIVEN
    flat = rows.reshape(n, 3 * GIVEN)
    in_node = np.tile(np.arange(GIVEN), B * nodes)
    offset = np.arange(-GIVEN, 2 * GIVEN)[None, :] - in_node[:, None]  # column minus row
    column = np.arange(n)[:, None] + offset
    inside = (column >= 0) & (column < n)  # what falls outside is zero: end nodes are given
    band = np.zeros((3 * _BAND + 1, n))
    band[(2 * _BAND - offset)[inside], column[inside]] = flat[inside]

    rhs = scaled_given.reshape(n, axes)
    factors, pivots, failed = lapack.dgbtrf(band, _BAND, _BAND)
    if failed:
        raise PlanError(f"node {(failed - 1) // GIVEN % nodes}: what is given there does not determine a trajectory")
    solution, _ = lapack.dgbtrs(factors, _BAND, _BAND, rhs, pivots)
    residual = rhs - _multiply(rows, solution.reshape(B, nodes, GIVEN, axes)).reshape(n, axes)
    correction, _ = lapack.dgbtrs(factors, _BAND, _BAND, residual, pivots)
    largest = np.abs(solution).max(initial=0.0)
    if not np.all(np.isfinite(correction)) or np.abs(correction).max(initial=0.0) > 1e-3 * largest:
        raise PlanError("what is given at the nodes does not determine a trajectory; give positions at more of them")
    return np.asarray((solution + correction).reshape(B, nodes, GIVEN, axes))


def _multiply(rows: Array, unknown: Array) -> Array:
    """Block-tridiagonal product; the missing neighbours of the ends count as zero."""
    neighbours = np.zeros((*unknown.shape[:2], 3 * GIVEN, unknown.shape[3]))
    neighbours[:, :, GIVEN : 2 * GIVEN] = unknown
    neighbours[:, 1:, :GIVEN] = unknown[:, :-1]
    neighbours[:, :-1, 2 * GIVEN :] = unknown[:, 1:]
    return np.asarray(rows @ neighbours)
