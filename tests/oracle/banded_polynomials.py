"""The piecewise polynomials once more: the same equations in numpy and LAPACK, as one banded system.

Why: a second implementation that shares nothing with the kernel, and is still linear in the number of nodes. Arrays run
over nodes last, so that each operation passes once over memory.
"""

from functools import lru_cache
from math import factorial

import numpy as np
from scipy.linalg import blas, lapack

ORDER, GIVEN, AXES = 10, 5, 4
_FALLING = np.array([[factorial(i) / factorial(i - d) if i >= d else 0.0 for i in range(ORDER)] for d in range(ORDER)])
_AT_START = np.diag(np.diag(_FALLING))
_AT_END = _FALLING
_HERMITE = np.linalg.inv(np.vstack([_AT_START[:GIVEN], _AT_END[:GIVEN]]))
_START_JUMP = _AT_START[GIVEN:] @ _HERMITE
_END_JUMP = _AT_END[GIVEN:] @ _HERMITE
_LARGEST = np.abs(np.hstack([_START_JUMP, _END_JUMP])).max(axis=1, keepdims=True)
_START_ROWS, _END_ROWS = _START_JUMP / _LARGEST, _END_JUMP / _LARGEST

FIFTH = np.diag(_FALLING[GIVEN, GIVEN:]) @ _HERMITE[GIVEN:]  # (5, 10): powers 0..4 of the 5th derivative from the ends
GRAM = 1.0 / (np.arange(5)[:, None] + np.arange(5) + 1.0)  # integrals of products of those powers


def solve(given, durations):
    """Coefficients (N, 10, 4) for nodes (N+1, 5, 4), NaN where free but never at the ends; inputs are trusted."""
    h = np.concatenate([durations[:1], np.sqrt(durations[:-1] * durations[1:]), durations[-1:]])
    left = _powers(durations / h[:-1], GIVEN)  # (5, N): scaled node unknown -> tau-derivative of the piece
    right = _powers(durations / h[1:], GIVEN)
    given = np.ascontiguousarray(given.transpose(1, 2, 0))
    free = np.isnan(given)  # (5, 4, N+1)
    scaled = np.where(free, 0.0, given) * _powers(h, GIVEN)[:, None]

    coupling = _coupling(durations, h, left, right)
    for mask, axes in _axes_by_mask(free[..., 1:-1]):
        if mask.any():
            scaled[:, axes, 1:-1] += _solve_free(coupling, mask, scaled[:, axes])
    ends = np.concatenate([scaled[..., :-1] * left[:, None], scaled[..., 1:] * right[:, None]])
    return (_HERMITE @ ends.reshape(ORDER, -1)).reshape(ends.shape).transpose(2, 0, 1)


def _powers(x, count, first=0):
    """(count, len(x)): x to the powers first, first + 1, ..."""
    out = np.empty((count, len(x)))
    out[0] = x**first
    for i in range(1, count):
        np.multiply(out[i - 1], x, out=out[i])
    return out


@lru_cache(maxsize=8)
def _kept(name, *shape, dtype=float):
    """Memory that stays between solves: to get new pages from the system would take as long as the elimination."""
    return np.empty(shape, dtype=dtype)


def _axes_by_mask(free):
    """Axes with the same pattern of free derivatives share one factorisation."""
    groups = []
    for axis in range(AXES):
        for mask, axes in groups:
            if np.array_equal(mask, free[:, axis]):
                axes.append(axis)
                break
        else:
            groups.append((free[:, axis], [axis]))
    return groups


def _coupling(durations, h, left, right):
    """(5, 3, 5, N-1): continuity of derivatives 5..9 at inner nodes, each over the largest that any of its entries can
    be, against the scaled unknowns of the node before, its own, and those of the one after."""
    before, after = h[1:-1] / durations[:-1], h[1:-1] / durations[1:]
    larger = np.maximum(before, after)
    before = _powers(before / larger, GIVEN, GIVEN)[:, None]  # the piece that ends at the node
    after = _powers(after / larger, GIVEN, GIVEN)[:, None]
    start, end = _START_ROWS[..., None], _END_ROWS[..., None]
    out, both = _kept("coupling", GIVEN, 3, GIVEN, len(larger)), _kept("both", GIVEN, GIVEN, len(larger))
    for to, times, of, rows in (
        (out[:, 0], before, left[:, :-1], end[:, :GIVEN]),
        (out[:, 1], before, right[:, :-1], end[:, GIVEN:]),
        (both, after, left[:, 1:], start[:, :GIVEN]),
        (out[:, 2], after, right[:, 1:], -start[:, GIVEN:]),
    ):
        np.multiply(times, of, out=to)
        to *= rows
    out[:, 1] -= both
    return out


def _solve_free(coupling, free, scaled):
    """(5, axes, N-1): the free unknowns of inner nodes, zero elsewhere; banded LU and one step of iterative refinement.

    A node's j-th free derivative takes its j-th continuity row. free (5, N-1); scaled (5, axes, N+1), zero where free.
    """
    inner, axes = free.shape[1], scaled.shape[1]
    count = free.sum(axis=0)
    first = np.cumsum(count) - count
    size = first[-1] + count[-1]
    place = np.where(free, first + np.cumsum(free, axis=0) - 1, size)  # of an unknown among all; size: there is none
    row = np.where(np.arange(GIVEN)[:, None] < count, first + np.arange(GIVEN)[:, None], size)

    reach = 2 * count.max() - 1  # of a row from the diagonal
    column = np.full((3, GIVEN, inner), size)
    column[0, :, 1:], column[1], column[2, :, :-1] = place[:, :-1], place, place[:, 1:]
    height = 2 * reach + 1  # of the band, which is stored by columns of the matrix
    at = _kept("at", GIVEN, 3, GIVEN, inner, dtype=int)
    np.add((row + reach)[:, None, None], (height - 1) * column, out=at)
    at[(row == size)[:, None, None] | (column == size)] = -1  # nowhere: the last entry is thrown away
    stored = _kept("stored", size * height + 1)
    stored.fill(0.0)
    stored[at] = coupling
    band = stored[:-1].reshape(size, height).T

    asked = np.zeros((GIVEN, axes, inner))
    for neighbour in range(3):
        of_neighbour = scaled[..., neighbour : neighbour + inner]
        for d in np.flatnonzero(of_neighbour.any(axis=(1, 2))):
            asked -= coupling[:, neighbour, d, None] * of_neighbour[d]
    rhs = np.empty((axes, size + 1))
    rhs[:, row] = asked.transpose(1, 0, 2)
    rhs = rhs[:, :-1].T

    factors = _kept("factors", size, 3 * reach + 1)
    factors[:, reach:] = band.T
    factors, pivots, failed = lapack.dgbtrf(factors.T, reach, reach, overwrite_ab=True)
    if failed:
        node = np.searchsorted(first, failed - 1, side="right")
        raise ValueError(f"node {node}: what is given there does not determine a trajectory")
    solution, _ = lapack.dgbtrs(factors, reach, reach, rhs, pivots)
    residual = np.empty((axes, size))
    for axis in range(axes):
        residual[axis] = rhs[:, axis] - blas.dgbmv(size, size, reach, reach, 1.0, band, solution[:, axis])
    correction, _ = lapack.dgbtrs(factors, reach, reach, residual.T, pivots, overwrite_b=True)
    if not np.all(np.isfinite(correction)) or np.abs(correction).max() > 1e-3 * np.abs(solution).max():
        raise ValueError("what is given at the nodes does not determine a trajectory; give positions at more of them")
    found = np.zeros((axes, size + 1))
    found[:, :-1] = (solution + correction).T
    return found[:, place].transpose(1, 0, 2)
