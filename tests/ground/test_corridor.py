"""Corridors: between the walls of a leg lies its straight line, and nothing that a fence forbids."""

from itertools import pairwise

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from halfroll.missions.mission import Fence
from halfroll.planner.corridor import inside, meets, outside_by, walls

corner = st.tuples(st.floats(-10, 10), st.floats(-10, 10))
spoke = st.floats(1.0, 9.0)


@st.composite
def fences(draw):
    """A star-shaped polygon about a random centre: any shape that a person draws, convex or not."""
    radii = draw(st.lists(spoke, min_size=3, max_size=9))
    angle = 2.0 * np.pi * np.arange(len(radii)) / len(radii)
    x, y = draw(corner)
    ring = np.stack([x + radii * np.cos(angle), y + radii * np.sin(angle)], axis=1)
    return Fence(draw(st.booleans()), tuple(map(tuple, ring.tolist())))


@given(fences(), corner, corner)
def test_between_the_walls_lies_the_straight_line_and_only_what_the_fence_allows(fence, start, end):
    assume(outside_by(start, fence) == outside_by(end, fence) == 0.0)
    assume(not meets(start, end, fence))
    assume(min(abs(distance(np.array(p), fence)) for p in (start, end)) > 2e-3)
    found = np.array(walls(start, end, [fence])).reshape(-1, 3)
    line = np.linspace(start, end, 50)
    assert (line @ found[:, :2].T <= found[:, 2] + 1e-9).all()
    rng = np.random.default_rng(1)
    anywhere = rng.uniform(-20, 20, (400, 2))
    between = anywhere[(anywhere @ found[:, :2].T <= found[:, 2]).all(axis=1)]
    assert all(outside_by(point, fence) <= 1e-6 for point in between)


def distance(point, fence):
    """To the nearest edge, by brute force."""
    ring = np.array([*fence.corners, fence.corners[0]])
    share = np.linspace(0.0, 1.0, 2000)[:, None]
    edges = pairwise(ring)
    return min(np.linalg.norm(a + share * (b - a) - point, axis=1).min() for a, b in edges)


@given(fences(), corner)
def test_how_far_outside_is_the_distance_to_the_nearest_edge(fence, point):
    out = outside_by(point, fence)
    if inside(np.array(point), fence) == fence.keep_in:
        assert out == 0.0
    else:
        assert abs(out - distance(np.array(point), fence)) < 2e-2


def test_a_square_has_its_four_walls_whatever_the_sense_of_its_corners():
    ring = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))
    for corners in (ring, ring[::-1]):
        found = {tuple(np.round(wall, 9) + 0.0) for wall in walls((1, 1), (3, 2), [Fence(True, corners)])}
        assert found == {(-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (1.0, 0.0, 4.0), (0.0, 1.0, 4.0)}


def test_what_is_behind_a_wall_gets_none_of_its_own():
    near = Fence(False, ((2.0, 1.0), (3.0, 1.0), (3.0, 2.0), (2.0, 2.0)))
    behind = Fence(False, ((1.0, 5.0), (4.0, 5.0), (4.0, 6.0), (1.0, 6.0)))
    assert walls((0, 0), (5, 0), [near, behind]) == walls((0, 0), (5, 0), [near])


def test_a_leg_along_the_fence_itself_may_be_flown():
    fence = Fence(True, ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)))
    assert not meets((1, 0), (3, 0), fence)
    assert outside_by((1, 0), fence) == 0.0
    found = walls((1, 0), (3, 0), [fence])
    assert (0.0, -1.0, 1e-3) in [tuple(np.round(wall, 9) + 0.0) for wall in found]
