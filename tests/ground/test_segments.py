"""The 9th-order polynomials between nodes: exact at the nodes, smooth between, the same as the textbook's."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfroll import _planner
from halfroll.errors import InputError, PlanError
from halfroll.planner.segments import (
    FREE,
    PiecewisePolynomial,
    monomials,
    node,
    rest,
    solve,
    solve_many,
    solve_with_slopes,
    standing,
)
from oracle import banded_polynomials, textbook_polynomials


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


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(2, 9))
def test_positions_are_met_and_all_derivatives_to_the_eighth_are_continuous(seed, n):
    nodes, durations = random_course(seed, n)
    path = solve(nodes, durations)
    assert path.at(path.times)[:, :4] == pytest.approx(nodes[:, 0], abs=1e-9)
    if n > 2:  # rounding grows by about the condition of the system, 1e4 for durations up to 1:4
        assert max(jumps(path, d) for d in range(9)) < 1e-7


def some_more_given(nodes, seed):
    """The nodes with a random mix of velocities to snaps given inside, in x, y, z and yaw, and a free position."""
    rng = np.random.default_rng(100 + seed)
    inner = nodes[1:-1]
    nodes[1:-1] = np.where(rng.random(inner.shape) < 0.3, rng.normal(size=inner.shape), inner)
    nodes[2, :, 1] = [FREE, 1.0, FREE, FREE, FREE]
    return nodes


def textbook(nodes, durations, continuity=8):
    """(N, 10, 4) in local time tau, as ours."""
    return (
        np.stack(
            [
                textbook_polynomials.solve_axis(
                    durations, [{d: x for d, x in enumerate(column) if not np.isnan(x)} for column in axis], continuity
                )
                for axis in np.moveaxis(nodes, 2, 0)
            ],
            axis=-1,
        )
        * (durations[:, None] ** np.arange(10))[:, :, None]
    )


@pytest.mark.parametrize("seed", range(5))
def test_it_is_the_dense_textbook_solution_with_any_derivatives_given(seed):
    nodes, durations = random_course(seed, 6)
    nodes = some_more_given(nodes, seed)
    expected = textbook(nodes, durations)
    assert solve(nodes, durations).coefficients == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("continuity", [4, 5, 6, 7])
@pytest.mark.parametrize("seed", range(3))
def test_with_less_continuity_it_is_the_textbook_path_of_least_snap(seed, continuity):
    nodes, durations = random_course(seed, 5)
    nodes = some_more_given(nodes, seed)
    nodes[-1, 3:] = FREE
    expected = textbook(nodes, durations, continuity)
    path = solve(nodes, durations, continuity)
    assert path.coefficients == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("continuity", [4, 5, 6, 7, 8])
def test_what_is_continuous_is_what_was_asked_for(continuity):
    path = solve(*random_course(11, 6), continuity)
    assert max(jumps(path, d) for d in range(continuity + 1)) < 1e-9
    if continuity < 8:
        assert jumps(path, 8) > 1e-3


def test_free_derivatives_at_the_ends_make_the_path_of_least_crackle():
    nodes, durations = random_course(12, 7)
    nodes[0, 2:], nodes[-1, 1:, :2] = FREE, FREE

    def crackle(values):
        found = 0.0
        for k, T in enumerate(durations):
            ends = np.concatenate([values[k], values[k + 1]]) * np.tile(T ** np.arange(5.0), 2)[:, None]
            fifth = banded_polynomials.FIFTH @ ends  # coefficients of the 5th derivative by tau
            found += (fifth * (banded_polynomials.GRAM @ fifth)).sum() / T**9
        return found

    path = solve(nodes, durations)
    values = path.derivatives(path.times, 5)
    least, rng = crackle(values), np.random.default_rng(1)
    assert path.at(path.times[0], 7) == pytest.approx(0.0, abs=1e-6)
    for _ in range(20):
        other = values + np.where(np.isnan(nodes), 1e-2 * rng.normal(size=nodes.shape), 0.0)
        assert crackle(other) > least


@pytest.mark.parametrize("continuity", [4, 6, 8])
@pytest.mark.parametrize("seed", range(3))
def test_slopes_of_a_cost_are_its_differences(seed, continuity):
    nodes, durations = random_course(seed, 6)
    nodes = some_more_given(nodes, seed)
    nodes[-1, 2:, 0] = FREE
    weights = np.random.default_rng(seed).normal(size=(5, 10, 4))

    def cost(nodes, durations):
        c = solve(nodes, durations, continuity).coefficients
        return (weights * c * (1.0 + 0.1 * c)).sum()

    path, slopes = solve_with_slopes(nodes, durations, continuity)
    by_durations, by_given = slopes(weights * (1.0 + 0.2 * path.coefficients))
    assert not by_given[np.isnan(nodes)].any()
    size, h = np.abs(by_durations).max(), 1e-5
    for k in range(5):
        change = h * durations * (np.arange(5) == k)
        difference = (cost(nodes, durations + change) - cost(nodes, durations - change)) / (2 * change[k])
        assert difference == pytest.approx(by_durations[k], abs=1e-6 * size), k
    for k, d, axis in np.argwhere(~np.isnan(nodes)):
        change = np.zeros_like(nodes)
        change[k, d, axis] = h
        difference = (cost(nodes + change, durations) - cost(nodes - change, durations)) / (2 * h)
        assert difference == pytest.approx(by_given[k, d, axis], abs=1e-6 * np.abs(by_given).max()), (k, d, axis)


def test_many_times_at_once_are_the_same_as_one_by_one():
    nodes, durations = random_course(13, 6)
    sets = durations * np.array([[1.0], [1.1], [0.7]])
    for coefficients, one in zip(solve_many(nodes, sets), sets, strict=True):
        assert np.array_equal(coefficients, solve(nodes, one).coefficients)


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


@pytest.mark.parametrize("n", [1000, 10_000])
def test_thousands_of_nodes_are_solved_to_rounding(n):
    nodes, durations = random_course(7, n)
    nodes[n // 3 : n // 2 : 7, 1, :3], nodes[n // 2 : -1 : 9, 2, 3] = 1.0, 0.5  # velocities, yaw accelerations
    nodes[10:-1:50, 4, 2] = -2.0  # snaps
    path = solve(nodes, durations)
    values = path.derivatives(path.times, 5)
    assert values[~np.isnan(nodes)] == pytest.approx(nodes[~np.isnan(nodes)], abs=1e-9)
    assert path.coefficients.sum(axis=1) == pytest.approx(nodes[1:, 0], abs=1e-9)  # every piece ends at its node
    assert max(jumps(path, d) for d in range(5)) < 1e-9
    banded = banded_polynomials.solve(nodes, durations)
    assert path.coefficients == pytest.approx(banded, abs=1e-8 * np.abs(banded).max())


def test_memory_grows_with_the_number_of_nodes_and_no_faster():
    small, large = (_planner.ClosedForm(*random_course(9, n)).bytes for n in (1000, 10_000))
    assert large == pytest.approx(10 * small, rel=0.01)
    assert large < 1000 * 10_000


@pytest.mark.parametrize("ending", [".npz", ".json", ".csv"])
def test_a_saved_trajectory_reads_back_bit_for_bit(tmp_path, ending):
    path, file = solve(*random_course(14, 5)), tmp_path / f"path{ending}"
    path.save(file)
    again = PiecewisePolynomial.load(file)
    assert again.times.tobytes() == path.times.tobytes()
    assert again.coefficients.tobytes() == path.coefficients.tobytes()


def test_files_that_are_no_trajectories_are_refused(tmp_path):
    (tmp_path / "no.csv").write_text("t,x\n0,1\n")
    (tmp_path / "no.json").write_text("{}")
    for name, says in [("no.csv", "not a trajectory"), ("no.json", "not a trajectory"), ("none.npz", "No such file")]:
        with pytest.raises(InputError, match=says):
            PiecewisePolynomial.load(tmp_path / name)
    with pytest.raises(InputError, match="choose one of these endings"):
        solve(*random_course(14, 5)).save(tmp_path / "path.xml")


@pytest.mark.parametrize("shortest", [1e-1, 1e-2, 1e-3])
def test_very_unequal_durations_are_no_matter(shortest):
    rng = np.random.default_rng(2)
    nodes, _ = random_course(10, 60)
    durations = np.exp(rng.uniform(np.log(shortest), 0.0, 59))
    path = solve(nodes, durations)
    assert max(jumps(path, d) for d in range(1, 9)) < 1e-6


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
        (lambda nodes, T: (nodes, T, 3), "continuity 3 cannot be had"),
        (lambda nodes, T: (np.where(np.arange(4) == 3, FREE, nodes), T), "node 2 does not determine a trajectory"),
    ],
)
def test_bad_input_is_refused_by_name(change, says):
    nodes = np.array([rest([0, 0, 0, 0]), node([2, 0, 0, 0]), rest([1, 0, 0, 0])])
    with pytest.raises(PlanError, match=says):
        solve(*change(nodes, [1.0, 1.0]))
