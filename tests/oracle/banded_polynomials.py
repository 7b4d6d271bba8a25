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

FIFTH = np.diag(_FALLING[GIVEN, GIVEN:]) @ _HERMITE[GIVEN:]  # (5, 10): powers 0..4 of the 5th derivative from the ends
GRAM = 1.0 / (np.arange(5)[:, None] + np.arange(5) + 1.0)  # integrals of products of those powers


def solve_many(given, durations):
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
    scaled_given = np.nan_to_num(given, nan=0.0) * h[:, :, None, None] ** d[:, None]  # (B, N+1, 5, 4)

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


def _solve_blocks(rows, scaled_given):
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
        raise ValueError(f"node {(failed - 1) // GIVEN % nodes}: what is given there does not determine a trajectory")
    solution, _ = lapack.dgbtrs(factors, _BAND, _BAND, rhs, pivots)
    residual = rhs - _multiply(rows, solution.reshape(B, nodes, GIVEN, axes)).reshape(n, axes)
    correction, _ = lapack.dgbtrs(factors, _BAND, _BAND, residual, pivots)
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
