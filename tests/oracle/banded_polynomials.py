"""The piecewise polynomials once more: the same equations in numpy and LAPACK, as one banded system.

Why: a second implementation that shares nothing with the kernel, and is still linear in the number of nodes.
"""

from math import factorial

import numpy as np
from scipy.linalg import lapack

ORDER, GIVEN, AXES = 10, 5, 4
_BAND = 2 * GIVEN - 1  # entries of a row reach this far from the diagonal
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


def solve_many(given, durations):
    """Coefficients (B, N, 10, 4) for B sets of durations (B, N) with the same nodes (N+1, 5, 4); inputs are trusted.

    All sets form one block-diagonal banded system, so B perturbed copies cost one LAPACK call.
    """
    B, N = durations.shape
    h = np.empty((B, N + 1))
    np.sqrt(durations[:, :-1] * durations[:, 1:], out=h[:, 1:-1])
    h[:, 0], h[:, -1] = durations[:, 0], durations[:, -1]
    left = _powers(durations / h[:, :-1], GIVEN)  # (B, N, 5): scaled node unknown -> tau-derivative of the piece
    right = _powers(durations / h[:, 1:], GIVEN)
    free = np.isnan(given)  # (N+1, 5, 4)
    scaled_given = np.where(free, 0.0, given) * _powers(h, GIVEN)[..., None]  # (B, N+1, 5, 4)

    unknown = np.empty((B, N + 1, GIVEN, AXES))
    for mask, axes in _axes_by_mask(free):
        if not mask.any():
            unknown[..., axes] = scaled_given[..., axes]
        else:
            blocks = _blocks(mask, durations, h, left, right)
            unknown[..., axes] = _solve_blocks(blocks, scaled_given[..., axes])
    ends = np.concatenate([unknown[:, :-1] * left[..., None], unknown[:, 1:] * right[..., None]], axis=2)
    return np.asarray(_HERMITE @ ends)


def _powers(x, count, first=0):
    """(..., count): x to the powers first, first + 1, ..."""
    out = np.empty((*x.shape, count))
    out[..., 0] = x**first
    for i in range(1, count):
        np.multiply(out[..., i - 1], x, out=out[..., i])
    return out


def _axes_by_mask(free):
    """Axes with the same pattern of free derivatives share one factorisation."""
    groups = []
    for axis in range(AXES):
        for mask, axes in groups:
            if np.array_equal(mask, free[:, :, axis]):
                axes.append(axis)
                break
        else:
            groups.append((free[:, :, axis], [axis]))
    return groups


def _blocks(free, durations, h, left, right):
    """(B, N+1, 5, 15): the rows of each node against the unknowns of the node before, its own, and the one after.

    Row d of a node is `scaled unknown = given` or, if d is the j-th free derivative there, continuity of derivative
    5 + j, over the largest that any of its entries can be.
    """
    B, nodes = h.shape
    rows = np.zeros((B, nodes, GIVEN, 3 * GIVEN))
    before, after = h[:, 1:-1] / durations[:, :-1], h[:, 1:-1] / durations[:, 1:]
    larger = np.maximum(before, after)
    before = _powers(before / larger, GIVEN, GIVEN)[..., None]  # the piece that ends at the node
    after = _powers(after / larger, GIVEN, GIVEN)[..., None]
    inner = rows[:, 1:-1]
    np.multiply(before * left[:, :-1, None], _END_ROWS[:, :GIVEN], out=inner[..., :GIVEN])
    np.multiply(before * right[:, :-1, None], _END_ROWS[:, GIVEN:], out=inner[..., GIVEN : 2 * GIVEN])
    inner[..., GIVEN : 2 * GIVEN] -= after * left[:, 1:, None] * _START_ROWS[:, :GIVEN]
    np.multiply(after * right[:, 1:, None], -_START_ROWS[:, GIVEN:], out=inner[..., 2 * GIVEN :])

    continuity = np.maximum(np.cumsum(free, axis=1) - 1, 0)  # (nodes, 5): which continuity row a free derivative takes
    taken = GIVEN * np.arange(nodes)[:, None] + continuity
    rows = rows.reshape(B, nodes * GIVEN, 3 * GIVEN).take(taken, axis=1)
    rows *= free[:, :, None]
    d = np.arange(GIVEN)
    rows[:, :, d, GIVEN + d] += ~free
    return rows


def _solve_blocks(rows, scaled_given):
    """Banded LU of all sets at once, and one step of iterative refinement; (B, N+1, 5, axes)."""
    B, nodes, _, axes = scaled_given.shape
    n = B * nodes * GIVEN
    band = np.zeros((B * nodes + 2, GIVEN, 3 * _BAND + 1))  # by columns of the matrix; a node more at either end
    flat = rows.reshape(B * nodes, GIVEN, 3 * GIVEN)
    for column in range(3 * GIVEN):  # what falls outside is zero: end nodes are given
        neighbour, e = divmod(column, GIVEN)
        top = 2 * _BAND + GIVEN - column
        band[neighbour : neighbour + B * nodes, e, top : top + GIVEN] = flat[:, :, column]
    band = band[1:-1].reshape(n, -1).T

    rhs = np.asfortranarray(scaled_given.reshape(n, axes))
    factors, pivots, failed = lapack.dgbtrf(band, _BAND, _BAND, overwrite_ab=True)
    if failed:
        raise ValueError(f"node {(failed - 1) // GIVEN % nodes}: what is given there does not determine a trajectory")
    solution, _ = lapack.dgbtrs(factors, _BAND, _BAND, rhs, pivots)
    residual = rhs - _multiply(rows, solution.reshape(B, nodes, GIVEN, axes)).reshape(n, axes)
    correction, _ = lapack.dgbtrs(factors, _BAND, _BAND, residual, pivots, overwrite_b=True)
    largest = np.abs(solution).max(initial=0.0)
    if not np.all(np.isfinite(correction)) or np.abs(correction).max(initial=0.0) > 1e-3 * largest:
        raise ValueError("what is given at the nodes does not determine a trajectory; give positions at more of them")
    return np.asarray((solution + correction).reshape(B, nodes, GIVEN, axes))


def _multiply(rows, unknown):
    """Block-tridiagonal product; the missing neighbours of the ends count as zero."""
    neighbours = np.zeros((*unknown.shape[:2], 3 * GIVEN, unknown.shape[3]))
    neighbours[:, :, GIVEN : 2 * GIVEN] = unknown
    neighbours[:, 1:, :GIVEN] = unknown[:, :-1]
    neighbours[:, :-1, 2 * GIVEN :] = unknown[:, 1:]
    return np.asarray(rows @ neighbours)
