"""The 9th-order polynomials between nodes: exact at the nodes, smooth between, the same as the textbook's."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfroll.errors import PlanError
from halfroll.segments import FREE, monomials, node, rest, solve, standing
from oracle import textbook_polynomials


def random_course(seed, n, shortest=0.5, longest=2.0):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-5.0, 5.0, (n, 4))
    nodes = np.array([rest(points[0]), *(node(p) for p in points[1:-1]), rest(points[-1])])
    return nodes, rng.uniform(shortest, longest, n - 1)


def jumps(path, derivative):
    """Largest jump of a derivative over all inner nodes, relative to its size there."""
    scale = path.durations[:, None] ** derivative
    before = (monomials(1.0, derivative) @ path.coefficients)[:, 0] / scale
    after = (monomials(0.0, derivative) @ path.coefficients)[:, 0] / scale
    return np.abs(before[:-1] - after[1:]).max() / np.abs(after).max()


def test_one_leg_from_rest_to_rest_is_the_known_polynomial():
    path = solve([rest([0, 0, 0, 0]), rest([1, 0, 0, 0])], [1.0])
    assert path.coefficients[0, :, 0] == pytest.approx([0, 0, 0, 0, 0, 126, -420, 540, -315, 70], abs=1e-9)


def test_its_peaks_are_the_reference_numbers():
    path = solve([rest([0, 0, 0, 0]), rest([1, 0, 0, 0])], [1.0])
    t = np.linspace(0.0, 1.0, 20001)
    peaks = [np.abs(path.at(t, d)[:, 0]).max() for d in (1, 2, 3, 4)]
    assert peaks == pytest.approx([2.4609, 9.3720, 78.75, 622.5], rel=1e-4)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(2, 9))
def test_positions_are_met_and_all_derivatives_to_the_eighth_are_continuous(seed, n):
    nodes, durations = random_course(seed, n)
    path = solve(nodes, durations)
    assert path.at(path.times)[:, :4] == pytest.approx(nodes[:, 0], abs=1e-9)
    if n > 2:  # rounding grows by about the condition of the system, 1e4 for durations up to 1:4
        assert max(jumps(path, d) for d in range(9)) < 1e-7


@pytest.mark.parametrize("seed", range(5))
def test_it_is_the_dense_textbook_solution_with_any_derivatives_given(seed):
    nodes, durations = random_course(seed, 6)
    rng = np.random.default_rng(100 + seed)
    nodes[1:-1] = np.where(rng.random((4, 5, 4)) < 0.3, rng.normal(size=(4, 5, 4)), nodes[1:-1])
    nodes[2, :, 1] = [FREE, 1.0, FREE, FREE, FREE]  # a free position
    path = solve(nodes, durations)
    for axis in range(4):
        wanted = [{d: x for d, x in enumerate(column) if not np.isnan(x)} for column in nodes[:, :, axis]]
        textbook = textbook_polynomials.solve_axis(durations, wanted)
        mine = path.coefficients[:, :, axis] / durations[:, None] ** np.arange(10)
        assert mine == pytest.approx(textbook, abs=1e-6 * np.abs(textbook).max())


def test_a_node_with_k_given_derivatives_is_continuous_to_the_9_minus_kth():
    nodes, durations = random_course(3, 5)
    nodes[2] = node(nodes[2, 0], [1, 2, 3, 0], [0, 0, -9.81, 0])
    path = solve(nodes, durations)
    assert path.derivatives(path.times[2])[0, 1:3] == pytest.approx(nodes[2, 1:3])
    assert max(jumps(path, d) for d in range(7)) < 1e-8
    assert jumps(path, 7) > 1e-6


def test_a_node_at_rest_in_the_middle_stands_still():
    nodes, durations = random_course(4, 4)
    nodes[1] = rest(nodes[1, 0])
    assert solve(nodes, durations).derivatives(durations[0], 5)[0, 1:] == pytest.approx(0.0, abs=1e-8)


def test_a_hold_is_a_piece_that_stands_still_between_two_solves():
    there = solve([rest([0, 0, 1, 0]), rest([1, 0, 1, 0])], [1.0])
    path = there.then(standing([1, 0, 1, 0], 2.0)).then(solve([rest([1, 0, 1, 0]), rest([1, 1, 1, 0])], [1.0]))
    assert path.times == pytest.approx([0.0, 1.0, 3.0, 4.0])
    assert path.at([1.0, 2.0, 3.0]) == pytest.approx(np.tile([1, 0, 1, 0], (3, 1)))


def test_before_the_start_and_after_the_end_it_holds():
    nodes, durations = random_course(5, 3)
    path = solve(nodes, durations)
    outside = path.derivatives([-1.0, path.times[-1] + 1.0])
    assert outside[:, 0] == pytest.approx(nodes[[0, -1], 0], abs=1e-9)
    assert not outside[:, 1:].any()


def test_derivatives_agree_with_finite_differences():
    path = solve(*random_course(6, 4))
    t, h = np.linspace(0.1, path.times[-1] - 0.1, 50), 1e-5
    for d in range(5):
        difference = (path.at(t + h, d) - path.at(t - h, d)) / (2 * h)
        assert difference == pytest.approx(path.at(t, d + 1), abs=1e-6 * np.abs(path.at(t, d + 1)).max())


def test_a_thousand_nodes_are_solved_to_rounding():
    nodes, durations = random_course(7, 1000)
    path = solve(nodes, durations)
    assert path.coefficients.sum(axis=1) == pytest.approx(nodes[1:, 0], abs=1e-9)  # every piece ends at its node
    assert max(jumps(path, d) for d in range(9)) < 1e-8


def test_stretching_time_only_rescales_the_derivatives():
    nodes, durations = random_course(8, 5)
    one, two = solve(nodes, durations), solve(nodes, 2.0 * durations)
    t = np.linspace(0.0, one.times[-1], 30)
    assert two.at(2.0 * t, 3) == pytest.approx(one.at(t, 3) / 8.0, abs=1e-8)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda nodes, T: (nodes, [1.0, -1.0]), "segment 1 has duration -1 s"),
        (lambda nodes, T: (nodes, [0.0, 1.0]), "segment 0 has duration 0 s"),
        (lambda nodes, T: (nodes, [1.0, np.nan]), "segment 1 has duration nan"),
        (lambda nodes, T: (nodes, [1.0]), "3 nodes need 2 durations"),
        (lambda nodes, T: (nodes[:1], []), "at least two nodes"),
        (lambda nodes, T: (nodes[:, :4], T), "give \\(n, 5, 4\\)"),
        (lambda nodes, T: (np.where(nodes == 2.0, np.inf, nodes), T), "node 1: derivative 0 of axis x is not finite"),
        (lambda nodes, T: (nodes[[0, 1, 1]], T), "node 2 is an end"),
    ],
)
def test_bad_input_is_refused_by_name(change, says):
    nodes = np.array([rest([0, 0, 0, 0]), node([2, 0, 0, 0]), rest([1, 0, 0, 0])])
    with pytest.raises(PlanError, match=says):
        solve(*change(nodes, [1.0, 1.0]))
