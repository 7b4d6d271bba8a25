"""The piecewise polynomials once more, as the paper writes them: one dense system per axis, monomials in t (Eqs 23-24).

Why: a second, slow implementation that shares nothing with the one under test.
"""

import numpy as np


def derivative_row(t, d):
    """(10,) such that row @ coefficients is the d-th derivative of sum c_i t^i at t."""
    return np.array([np.prod(np.arange(i - d + 1, i + 1)) * t ** (i - d) if i >= d else 0.0 for i in range(10)])


def snap_squared(T):
    """(10, 10) such that c' @ this @ c is the integral of the squared snap over [0, T]."""
    points, weights = np.polynomial.legendre.leggauss(8)
    rows = np.array([derivative_row(T * (x + 1.0) / 2.0, 4) for x in points])
    return (rows.T * weights * T / 2.0) @ rows


def solve_axis(durations, given, continuity=8):
    """(N, 10) coefficients in t from each piece's own start. given: one dict {derivative: number} per node.

    continuity 8 is the paper's: as many equations as unknowns. Below it, the least integral of the squared snap among
    all paths that keep the equations, by Lagrange's multipliers.
    """
    pieces = len(durations)
    rows, numbers = [], []

    def require(parts, number):
        row = np.zeros(10 * pieces)
        for piece, t, d, sign in parts:
            row[10 * piece : 10 * piece + 10] += sign * derivative_row(t, d)
        size = np.abs(row).max()
        rows.append(row / size)
        numbers.append(number / size)

    for piece, t, node in ((0, 0.0, given[0]), (pieces - 1, durations[-1], given[-1])):
        for d, number in node.items():
            require([(piece, t, d, 1)], number)
        for d in range(5):
            if d not in node and continuity == 8:
                require([(piece, t, 9 - d, 1)], 0.0)
    for k in range(1, pieces):
        for d, number in given[k].items():
            require([(k - 1, durations[k - 1], d, 1)], number)
            require([(k, 0.0, d, 1)], number)
        for d in range(min(10 - len(given[k]), 10 if continuity == 8 else continuity + 1)):
            if d not in given[k]:
                require([(k - 1, durations[k - 1], d, 1), (k, 0.0, d, -1)], 0.0)
        for d in range(10 - len(given[k]), 5):
            if d not in given[k]:
                require([(k - 1, durations[k - 1], d, 1), (k, 0.0, d, -1)], 0.0)
    A, b = np.array(rows), np.array(numbers)
    if continuity == 8:
        return np.linalg.solve(A, b).reshape(pieces, 10)
    energy = np.zeros((10 * pieces, 10 * pieces))
    for k, T in enumerate(durations):
        energy[10 * k : 10 * k + 10, 10 * k : 10 * k + 10] = snap_squared(T)
    none = np.zeros((len(A), len(A)))
    both = np.block([[energy / np.abs(energy).max(), A.T], [A, none]])
    return np.linalg.solve(both, np.concatenate([np.zeros(10 * pieces), b]))[: 10 * pieces].reshape(pieces, 10)
