"""Contract, section 9: which mission items are taken, each error by its number, and what is returned."""

from __future__ import annotations

import pytest

from system.contract.aircraft import INF, INT32_MAX, NAN, Client, Item
from system.contract.missions import FLIP, LINE, SKIPPED, TAKEOFF_ITEM, away, bits, item, waypoint

INT32_MIN = -(2**31)
OK, FRAME, COMMAND = 0, 2, 3
P1, P2, P3, P4, X, Y, Z = range(6, 13)  # MAV_MISSION_INVALID_PARAM...

PLACED = [16, 82, 31000, 17, 19]
OPTIONALLY_PLACED = [22, 21]
UNPLACED = [20, 93, 112, 115, 189, 210]
NO_SUCH = [0, 18, 31, 84, 85, 92, 184, 200, 222, 400, 3000, 5000, 5001, 5100, 42600, 65535]


def verdict(client: Client, *items: Item) -> int:
    """The result of uploading an item, after a takeoff so that item 0 is nothing special."""
    return client.upload([TAKEOFF_ITEM, *items])


@pytest.mark.parametrize("command", [*PLACED, *OPTIONALLY_PLACED])
@pytest.mark.parametrize("frame", [0, 5, 3, 6])
def test_a_position_is_taken_in_each_global_frame(gcs: Client, command: int, frame: int) -> None:
    assert verdict(gcs, item(command, frame=frame)) == OK


@pytest.mark.parametrize("command", PLACED + OPTIONALLY_PLACED)
@pytest.mark.parametrize("frame", [1, 2, 4, 7, 8, 10, 12, 21, 255])
def test_a_position_is_refused_in_any_other_frame(gcs: Client, command: int, frame: int) -> None:
    assert verdict(gcs, item(command, frame=frame)) == FRAME


@pytest.mark.parametrize("command", [*UNPLACED, *SKIPPED])
def test_an_item_without_a_position_has_frame_2(gcs: Client, command: int) -> None:
    assert verdict(gcs, away(command)) == OK


@pytest.mark.parametrize("command", NO_SUCH)
def test_any_other_command_is_unsupported_before_anything_else(gcs: Client, command: int) -> None:
    assert verdict(gcs, item(command, INF, frame=99)) == COMMAND


def test_a_frame_is_judged_before_parameters(gcs: Client) -> None:
    assert verdict(gcs, item(16, INF, frame=99)) == FRAME


@pytest.mark.parametrize("which", range(4))
@pytest.mark.parametrize("command", [*PLACED, *OPTIONALLY_PLACED, *UNPLACED, *SKIPPED])
def test_an_infinite_parameter_is_named(gcs: Client, command: int, which: int) -> None:
    params = [0.0] * 4
    params[which] = INF
    frame = 2 if command in UNPLACED + SKIPPED else 3
    assert (
        verdict(gcs, item(command, *params, frame=frame, x=0 if frame == 2 else None, y=0 if frame == 2 else None))
        == P1 + which
    )


TAKEN = {
    "waypoint holds": item(16, 3.5),
    "waypoint radius": item(16, 0, 1.5),
    "waypoint p3 NaN": item(16, 0, 0, NAN),
    "waypoint yaw": item(16, 0, 0, 0, -170),
    "waypoint yaw open": item(16, 0, 0, 0, NAN),
    "spline": item(82, 1),
    "attitude": item(31000, -180, 90, 3.0, 10),
    "attitude free": item(31000, NAN, NAN, NAN, NAN),
    "loiter radius": item(17, 0, 0, 50, NAN),
    "loiter time": item(19, 4, 0, -50, NAN),
    "takeoff open": item(22, NAN, NAN, NAN, NAN, x=INT32_MAX, y=INT32_MAX, z=NAN),
    "takeoff here": item(22, 15, x=0, y=0),
    "takeoff int min": item(22, x=INT32_MIN, y=INT32_MIN),
    "land here": item(21, 0, 2, NAN, NAN, x=0, y=0, z=NAN),
    "land deep": item(21, z=-4000.0),
    "return open": away(20, NAN, NAN, NAN, NAN),
    "return anywhere": item(20, frame=2, x=123, y=456, z=NAN),
    "return in a global frame": item(20, frame=3, x=0, y=0, z=0),
    "delay": away(93, 2.5),
    "delay till a time of day": away(93, -1, 12, 30, 15),
    "delay open": away(93, 1, NAN, NAN, NAN),
    "condition delay": away(112, 3),
    "turn": away(115, 90, 0, 1, 0),
    "jump": away(177, 0, 2),
    "jump for ever over a place": away(177, 0, -1),
    "speed": away(178, 1, 5, -1, NAN),
    "speed kept": away(178, 0, -1),
    "speed z NaN": item(178, 1, 5, frame=2, x=0, y=0, z=NAN),
    "home here": away(179, 1),
    "home there": item(179, 0, frame=0, z=490.0),
    "inverted": away(210, 1),
    "flip": away(31010, 2, -1.5, 5, 3),
    "flip open": FLIP,
    "camera z NaN": item(2000, 0, 2, 5, NAN, frame=2, x=0, y=0, z=NAN),
    "gimbal of MAVSDK": item(1000, -2, -2, NAN, NAN, frame=2, x=0, y=0, z=NAN),
}


@pytest.mark.parametrize("name", TAKEN)
def test_an_item_is_taken_and_returned_in_every_bit(gcs: Client, name: str) -> None:
    mission = [TAKEOFF_ITEM, waypoint(5.0), TAKEN[name]]
    assert gcs.upload(mission) == OK
    assert [bits(i) for i in gcs.download()] == [bits(i) for i in mission]


def test_autocontinue_is_returned(gcs: Client) -> None:
    frame, command, _, *rest = waypoint(5.0)
    mission = [TAKEOFF_ITEM, (frame, command, 0, *rest)]
    assert gcs.upload(mission) == OK  # type: ignore[arg-type]
    assert [i[2] for i in gcs.download()] == [1, 0]


REFUSED = [
    *(
        ("negative time", item(16, -1), P1),
        ("negative radius", item(16, 0, -1), P2),
        ("p3 used", item(16, 0, 0, 1), P3),
    ),
    *(("time NaN", item(16, NAN), P1), ("radius NaN", item(16, 0, NAN), P2)),
    *(("spline p2", item(82, 0, 1), P2), ("spline p3", item(82, 0, 0, 1), P3), ("spline p4", item(82, 0, 0, 0, 1), P4)),
    *(("roll", item(31000, 181, 0), P1), ("pitch", item(31000, 0, 91), P2), ("speed", item(31000, 0, 0, -1), P3)),
    *(("roll alone free", item(31000, NAN, 0), P1), ("pitch alone free", item(31000, 0, NAN), P2)),
    *(("loiter time", item(19, -1), P1), ("loiter NaN", item(19, NAN), P1)),
    *(("takeoff p2", item(22, 0, 1), P2), ("takeoff p3", item(22, 0, 0, 1), P3)),
    *(("land mode", item(21, 0, 3), P2), ("land p3", item(21, 0, 0, 1), P3)),
    *((f"return p{i + 1}", away(20, *[0.0] * i, 1), P1 + i) for i in range(4)),
    *(("delay", away(93, -2), P1), ("delay NaN", away(93, NAN), P1), ("delay x", item(93, frame=2, x=1, y=0), X)),
    ("delay y", item(93, frame=2, x=0, y=1), Y),
    *(("condition", away(112, -1), P1), ("condition NaN", away(112, NAN), P1), ("turn NaN", away(115, NAN), P1)),
    *(("jump below", away(177, -1), P1), ("jump repeats", away(177, 0, -2), P2), ("jump NaN", away(177, NAN, 1), P1)),
    *(("jump fraction", away(177, 0.5, 1), P1), ("jump beyond", away(177, 2, 1), P1)),
    *(("speed kind", away(178, 4, 5), P1), ("speed 0", away(178, 1, 0), P2), ("speed NaN", away(178, 1, NAN), P2)),
    *(("inverted", away(210, 2), P1), ("inverted NaN", away(210, NAN), P1), ("home kind", away(179, 2), P1)),
    *(
        ("flip axis", away(31010, 3, 1), P1),
        ("flip turns", away(31010, 1, 0), P2),
        ("flip part", away(31010, 1, 0.3), P2),
    ),
    *(("flip many", away(31010, 1, 5.5), P2), ("flip time", away(31010, 1, 1, NAN, -1), P4)),
    *((f"{c} at 0,0", item(c, x=0, y=0), X) for c in PLACED),
    *((f"{c} lat", item(c, x=900000001), X) for c in PLACED + OPTIONALLY_PLACED),
    *((f"{c} lon", item(c, y=-1800000001), Y) for c in PLACED + OPTIONALLY_PLACED),
    *((f"{c} z NaN", item(c, z=NAN), Z) for c in PLACED),
    *((f"{c} high", item(c, z=500.5), Z) for c in [*PLACED, 22]),
    *((f"{c} low", item(c, z=-101.0), Z) for c in [*PLACED, 22]),
]


@pytest.mark.parametrize(("name", "refused", "result"), REFUSED, ids=[name for name, _, _ in REFUSED])
def test_an_item_is_refused_by_its_number(gcs: Client, name: str, refused: Item, result: int) -> None:
    assert gcs.upload(LINE) == OK
    assert verdict(gcs, refused) == result
    assert len(gcs.download()) == len(LINE)  # the old mission is kept


def test_a_height_above_the_sea_has_no_limit_at_upload(gcs: Client) -> None:
    assert verdict(gcs, item(16, frame=0, z=9000.0)) == OK


def test_heights_are_limited_by_a_parameter(gcs: Client) -> None:
    gcs.set_param("MIS_ALT_MAX", 50.0)
    assert verdict(gcs, waypoint(5.0, z=51.0)) == Z


def test_the_first_error_in_order_is_the_one_reported(gcs: Client) -> None:
    assert verdict(gcs, item(16, INF, INF, INF, INF, x=900000001, y=1800000001, z=NAN)) == P1
    assert verdict(gcs, item(16, 0, 0, 0, 0, x=900000001, y=1800000001, z=NAN)) == X
    assert verdict(gcs, item(16, 0, 0, 0, 0, y=1800000001, z=NAN)) == Y


def test_only_the_current_item_says_so_when_downloaded(gcs: Client) -> None:
    assert gcs.upload(LINE) == OK
    gcs.ask(gcs.encode.mission_set_current_encode(1, 1, 2))
    current = [
        gcs.only("MISSION_ITEM_INT", gcs.encode.mission_request_int_encode(1, 1, seq)).current
        for seq in range(len(LINE))
    ]
    assert current == [0, 0, 1, 0, 0]
