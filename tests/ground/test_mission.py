"""Mission values: valid once built, and equal when the wire cannot tell them apart."""

from __future__ import annotations

import math
import pickle

import pytest

from halfroll.errors import MissionError
from halfroll.missions.mission import CAPACITY, Mission, MissionItem, Waypoint

ITEM = MissionItem(16, 3, (0.0, 0.0, 0.0, math.nan), 473977420, 85455940, 10.1)


def test_an_item_equals_its_copy_from_another_process_although_it_holds_nan() -> None:
    assert pickle.loads(pickle.dumps(ITEM)) == ITEM
    assert hash(pickle.loads(pickle.dumps(ITEM))) == hash(ITEM)


def test_an_item_holds_what_32_bit_floats_hold() -> None:
    assert ITEM.z == 10.100000381469727


def test_items_that_differ_in_one_field_are_not_equal() -> None:
    assert MissionItem(16, 3, ITEM.params, ITEM.x, ITEM.y, 10.2) != ITEM
    assert MissionItem(16, 3, (0.0, 0.0, 0.0, 0.0), ITEM.x, ITEM.y, 10.1) != ITEM


@pytest.mark.parametrize(
    ("build", "why"),
    [
        (lambda: MissionItem(70000, 3, ITEM.params, 0, 0, 0.0), "command 70000"),
        (lambda: MissionItem(16, 300, ITEM.params, 0, 0, 0.0), "frame 300"),
        (lambda: MissionItem(16, 3, ITEM.params, 2**31, 0, 0.0), "x = 2147483648"),
        (lambda: MissionItem(16, 3, (1e39, 0, 0, 0), 0, 0, 0.0), "param 1 is 1e"),
        (lambda: MissionItem(16, 3, (0, 0, 0), 0, 0, 0.0), "3 params"),  # type: ignore[arg-type]
        (lambda: Waypoint((0.0, math.nan, 0.0)), "position"),
        (lambda: Waypoint((0.0, 0.0, 0.0), velocity=(math.inf, 0.0, 0.0)), "velocity"),
        (lambda: Waypoint((0.0, 0.0, 0.0), hold_s=-1.0), "hold is -1"),
        (lambda: Waypoint((0.0, 0.0, 0.0), speed_max=0.0), "speed limit"),
        (lambda: Waypoint((0.0, 0.0, 0.0), yaw=math.nan), "yaw"),
        (lambda: Mission("empty", ()), "no items"),
        (lambda: Mission("long", (ITEM,) * (CAPACITY + 1)), "2001 items"),
        (lambda: Mission("odd", (ITEM,), waypoints=(Waypoint((0.0, 0.0, 0.0), item=1),)), "names item 1"),
    ],
)
def test_what_makes_no_sense_cannot_be_built(build: object, why: str) -> None:
    with pytest.raises(MissionError, match=why):
        build()  # type: ignore[operator]
