"""The wire's axes: a round trip cannot catch a wrong sign, so physical facts are stated."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from halfroll.wire.frames import (
    degrees_from_wire,
    degrees_to_wire,
    from_wire,
    heading_deg_to_yaw,
    to_wire,
    yaw_to_heading_deg,
)

NORTH, WEST, UP = np.eye(3)
FORWARD, LEFT = NORTH, WEST  # of B


def test_a_point_west_of_home_has_negative_east_on_the_wire() -> None:
    assert to_wire(WEST).tolist() == [0, -1, 0]


def test_a_point_above_home_has_negative_down_on_the_wire() -> None:
    assert to_wire([0.0, 0.0, 5.0]).tolist() == [0, 0, -5]


def test_turning_the_nose_right_is_a_positive_yaw_rate_in_frd_and_negative_in_b() -> None:
    assert to_wire([0.0, 0.0, -1.0])[2] == 1


def test_an_attitude_means_the_same_rotation_of_the_same_body_vector_on_both_sides() -> None:
    rng = np.random.default_rng(1)
    for q in Rotation.random(20, random_state=1):
        x, y, z, w = q.as_quat()
        on_wire = to_wire([w, x, y, z])
        body = rng.normal(size=3)
        wire_rotation = Rotation.from_quat(np.roll(on_wire, -1))
        np.testing.assert_allclose(wire_rotation.apply(to_wire(body)), to_wire(q.apply(body)), atol=1e-12)


def test_half_a_roll_is_inverted_flight_with_the_nose_north_on_both_sides() -> None:
    assert to_wire([0.0, 1.0, 0.0, 0.0]).tolist() == [0, 1, 0, 0]


@pytest.mark.parametrize("shape", [(3,), (4,), (7, 3), (5, 2, 4)])
def test_going_to_the_wire_and_back_changes_nothing(shape: tuple[int, ...]) -> None:
    values = np.random.default_rng(2).normal(size=shape)
    np.testing.assert_array_equal(from_wire(to_wire(values)), values)


def test_an_array_that_is_neither_vector_nor_quaternion_is_refused() -> None:
    with pytest.raises(ValueError, match="not 2"):
        to_wire([1.0, 2.0])


@given(st.integers(-(2**31), 2**31 - 1))
def test_every_dege7_integer_survives_being_degrees(degrees_e7: int) -> None:
    assert degrees_to_wire(degrees_from_wire(degrees_e7)) == degrees_e7


def test_east_is_heading_90_and_a_quarter_turn_clockwise() -> None:
    yaw = heading_deg_to_yaw(90.0)
    nose = math.cos(yaw) * NORTH + math.sin(yaw) * WEST
    np.testing.assert_allclose(nose, -WEST, atol=1e-15)
    assert yaw_to_heading_deg(yaw) == 90.0
