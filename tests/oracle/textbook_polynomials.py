"""The piecewise polynomials once more, as the paper writes them: one dense system per axis, monomials in t (Eqs 23-24).

Why: a second, slow implementation that shares nothing with the one under test.
"""

import numpy as np


def derivative_row(t, d):
    """(10,) such that row @ coefficients is the d-th derivative of sum c_i t^i at t."""
    return np.array([np.prod(np.arange(i - d + 1, i + 1)) * t ** (i - d) if i >= d else 0.0 for i in range(10)])


def solve_axis(durations, given):
    """(N, 10) coefficients in t from each piece's own start. given: one dict {derivative: number} per node."""
    pieces = len(durations)
    rows, numbers = [], []

    def require(parts, number):
        row = np.zeros(10 * pieces)
        for piece, t, d, sign in parts:
            row[10 * piece : 10 * piece + 10] += sign * derivative_row(t, d)
        size = np.abs(row).max()
        rows.append(row / size)
        numbers.append(number / size)

    for d, number in given[0].items():
        require([(0, 0.0, d, 1)], number)
    for d, number in given[-1].items():
        require([(pieces - 1, durations[-1], d, 1)], number)
    for k in range(1, pieces):
        for d, number in given[k].items():
            require([(k - 1, durations[k - 1], d, 1)], number)
            require([(k, 0.0, d, 1)], number)
        for d in range(10 - len(given[k])):
            if d not in given[k]:
                require([(k - 1, durations[k - 1], d, 1), (k, 0.0, d, -1)], 0.0)
    return np.linalg.solve(np.array(rows), np.array(numbers)).reshape(pieces, 10)
