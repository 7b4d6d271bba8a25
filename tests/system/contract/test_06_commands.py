"""Contract, section 6: each command, its effect and each way it is refused."""

from __future__ import annotations

import pytest

from system.contract.aircraft import (
    ACCEPTED,
    DENIED,
    INF,
    NAN,
    NOT_NOW,
    UNSUPPORTED,
    Aircraft,
    B,
    Client,
)
from system.contract.missions import LINE

Params = tuple[float, ...]


def situation(name: str, grounded: Aircraft, hovering: Aircraft, on_mission: Aircraft) -> Client:
    """A ground control station of a vehicle in some situation."""
    aircraft = {"hover": hovering, "mission": on_mission}.get(name, grounded)
    client = aircraft.client()
    if name == "armed":
        assert client.command(400, 1) == ACCEPTED
    if name == "stored":
        assert client.upload(LINE) == 0
    return client


# command, params, where, result
ROWS: list[tuple[int, Params, str, int]] = [
    # COMPONENT_ARM_DISARM
    (400, (1,), "ground", ACCEPTED),
    (400, (1,), "armed", ACCEPTED),
    (400, (0,), "ground", ACCEPTED),
    (400, (0,), "armed", ACCEPTED),
    (400, (0,), "hover", NOT_NOW),
    (400, (0, 21196), "hover", ACCEPTED),
    (400, (1, 21196), "ground", ACCEPTED),
    (400, (1, 2989), "ground", ACCEPTED),
    (400, (0, 2989), "hover", DENIED),
    (400, (1, NAN, NAN, NAN, NAN, NAN, NAN), "ground", ACCEPTED),
    *((400, (p,), "ground", DENIED) for p in (2, -1, 0.5, NAN, INF)),
    (400, (1, 5), "ground", DENIED),
    *((400, (1, 0, *[0.0] * i, 1), "ground", DENIED) for i in range(5)),
    # NAV_TAKEOFF
    (22, (0, 0, 0, 0, 0, 0, 5), "ground", ACCEPTED),
    (22, (0, 0, 0, NAN, NAN, NAN, NAN), "ground", ACCEPTED),
    (22, (0, 0, 0, 0, 0, 0, 5), "hover", NOT_NOW),
    *((22, (0, 0, 0, 0, 0, 0, z), "ground", DENIED) for z in (0.4, 501, -5, INF)),
    # NAV_LAND
    (21, (), "hover", ACCEPTED),
    (21, (0, 0, 0, NAN, NAN, NAN, NAN), "hover", ACCEPTED),
    (21, (), "ground", NOT_NOW),
    (21, (), "armed", NOT_NOW),
    # NAV_RETURN_TO_LAUNCH
    (20, (), "hover", ACCEPTED),
    (20, (NAN,) * 7, "hover", ACCEPTED),
    (20, (), "ground", NOT_NOW),
    *((20, (*[0.0] * i, 1), "hover", DENIED) for i in range(7)),
    # MISSION_START
    (300, (), "stored", ACCEPTED),
    (300, (NAN, NAN), "stored", ACCEPTED),
    (300, (2,), "stored", ACCEPTED),
    (300, (), "ground", NOT_NOW),
    (300, (5,), "stored", DENIED),
    (300, (-1,), "stored", DENIED),
    # DO_PAUSE_CONTINUE
    (193, (0,), "mission", ACCEPTED),
    (193, (1,), "mission", ACCEPTED),
    (193, (0,), "stored", NOT_NOW),
    (193, (1,), "ground", NOT_NOW),
    *((193, (p,), "mission", DENIED) for p in (2, -1, 0.5, NAN)),
    # DO_SET_MISSION_CURRENT
    (224, (2,), "stored", ACCEPTED),
    (224, (-1,), "stored", ACCEPTED),
    (224, (-1, 1), "stored", ACCEPTED),
    (224, (0,), "ground", NOT_NOW),
    *((224, (p,), "stored", DENIED) for p in (5, -2, NAN, 0.5)),
    (224, (0, 2), "stored", DENIED),
    # DO_REPOSITION: position and altitude by COMMAND_LONG are degrees and above sea level
    (192, (-1, 1, 0, NAN, NAN, NAN, NAN), "hover", ACCEPTED),
    (192, (-1, 0, 0, NAN, NAN, NAN, 510), "hover", ACCEPTED),
    (192, (3, 1, 0, 1.5, 47.3978, 8.5457, 500), "hover", ACCEPTED),
    (192, (-1, 1, 0, NAN, NAN, NAN, 500), "ground", NOT_NOW),
    (192, (-1, 0, 0, NAN, NAN, NAN, 500), "mission", NOT_NOW),
    (192, (-1, 1, 0, NAN, 47.6, 8.5457, 500), "hover", DENIED),
    (192, (-1, 1, 0, NAN, NAN, NAN, 480), "hover", DENIED),
    # DO_CHANGE_SPEED
    *((178, (kind, 4), "hover", ACCEPTED) for kind in range(4)),
    *((178, (1, speed), "hover", ACCEPTED) for speed in (-1, -2)),
    *((178, (1, speed), "hover", DENIED) for speed in (0, -3, -1.5, NAN, INF)),
    *((178, (kind, 4), "hover", DENIED) for kind in (4, -1, 0.5, NAN)),
    # CONDITION_YAW
    (115, (90, 0, 1, 0), "hover", ACCEPTED),
    (115, (90, 0, -1, 1), "hover", ACCEPTED),
    (115, (90,), "ground", NOT_NOW),
    (115, (90,), "mission", NOT_NOW),
    (115, (NAN,), "hover", DENIED),
    # DO_SET_HOME
    (179, (1,), "ground", ACCEPTED),
    (179, (0, 0, 0, 0, 47.398, 8.546, 490), "ground", ACCEPTED),
    (179, (0, 0, 0, 0, 91, 8.546, 490), "ground", DENIED),
    (179, (0, 0, 0, 0, 47.398, 181, 490), "ground", DENIED),
    (179, (0, 0, 0, 0, NAN, NAN, 490), "ground", DENIED),
    (179, (0, 0, 0, 0, 47.398, 8.546, NAN), "ground", DENIED),
    (179, (2,), "ground", DENIED),
    # DO_SET_GLOBAL_ORIGIN
    (611, (0, 0, 0, 0, 47.0, 8.0, 400), "ground", ACCEPTED),
    (611, (0, 0, 0, 0, 47.0, 8.0, 400), "armed", NOT_NOW),
    (611, (0, 0, 0, 0, 91.0, 8.0, 400), "ground", DENIED),
    (611, (0, 0, 0, 0, NAN, 8.0, 400), "ground", DENIED),
    (611, (0, 0, 0, 0, 47.0, 8.0, NAN), "ground", DENIED),
    # SET_ and GET_MESSAGE_INTERVAL, REQUEST_MESSAGE
    (511, (30, 50000), "ground", ACCEPTED),
    (511, (4, 50000), "ground", DENIED),
    (511, (NAN, 50000), "ground", DENIED),
    (510, (30,), "ground", ACCEPTED),
    (510, (4,), "ground", DENIED),
    (510, (NAN,), "ground", DENIED),
    (512, (148,), "ground", ACCEPTED),
    (512, (4,), "ground", DENIED),
    (512, (435, 7), "ground", DENIED),
    (512, (300,), "ground", DENIED),
    (512, (395,), "ground", DENIED),
    (512, (397,), "ground", DENIED),
    # old requests
    (520, (1,), "ground", ACCEPTED),
    (410, (), "ground", ACCEPTED),
    # PREFLIGHT_REBOOT_SHUTDOWN
    (246, (0,), "armed", ACCEPTED),
    (246, (1,), "ground", ACCEPTED),
    (246, (2,), "ground", ACCEPTED),
    (246, (1,), "armed", NOT_NOW),
    *((246, (p,), "ground", DENIED) for p in (3, 4, 0.5, NAN)),
    # PREFLIGHT_STORAGE
    *((245, (p,), "ground", ACCEPTED) for p in (0, 1, 2, -1)),
    *((245, (p,), "armed", NOT_NOW) for p in (0, 2)),
    (245, (1,), "armed", ACCEPTED),
    (245, (3,), "ground", DENIED),
    # PREFLIGHT_CALIBRATION, RUN_PREARM_CHECKS
    (241, (1,), "ground", ACCEPTED),
    (241, (1,), "armed", NOT_NOW),
    (401, (), "ground", ACCEPTED),
    (401, (), "armed", NOT_NOW),
    # DO_FLIGHTTERMINATION
    (185, (0,), "hover", ACCEPTED),
    (185, (0.5,), "hover", ACCEPTED),
    (185, (1,), "hover", ACCEPTED),
    *((185, (p,), "hover", DENIED) for p in (0.4, -1, NAN, INF)),
    # DO_INVERTED_FLIGHT and flips: the state in which they are refused, and encodings that are none
    (210, (1,), "ground", NOT_NOW),
    (210, (1,), "mission", NOT_NOW),
    *((210, (p,), "hover", DENIED) for p in (2, -1, 0.5, NAN)),
    (31010, (1, 1, NAN, NAN), "ground", NOT_NOW),
    (31010, (1, 1, NAN, NAN), "mission", NOT_NOW),
    *((31010, p, "hover", DENIED) for p in ((3, 1), (0, 1), (1, 0), (1, 0.3), (1, 5.5), (NAN, 1), (1, NAN))),
    # only in missions
    *((number, (), "ground", DENIED) for number in (16, 17, 19, 82, 93, 112, 177, 31000)),
    # none fitted, or unknown
    *(
        (n, (), "ground", UNSUPPORTED)
        for n in (183, 184, 195, 203, 205, 207, 208, 1000, 2000, 2500, 3000, 84, 42000, 60000)
    ),
]


@pytest.mark.parametrize(("number", "params", "where", "result"), ROWS, ids=str)
def test_a_command_has_its_result(
    grounded: Aircraft,
    hovering: Aircraft,
    on_mission: Aircraft,
    number: int,
    params: Params,
    where: str,
    result: int,
) -> None:
    assert situation(where, grounded, hovering, on_mission).command(number, *params) == result


@pytest.mark.parametrize("number", [400, 176, 22, 300, 511, 512, 410, 4242, 185])
def test_a_command_sent_again_is_acknowledged_again(gcs: Client, number: int) -> None:
    message = gcs.encode.command_long_encode(1, 1, number, 0, 0, 0, 0, 0, 0, 0, 5)
    results = {gcs.acknowledged(message) for _ in range(5)}
    assert len(results) == 1


def test_the_acknowledgement_names_command_and_sender(grounded: Aircraft) -> None:
    client = grounded.client(B, 3, system=200, component=50)
    ack = client.only("COMMAND_ACK", client.encode.command_long_encode(1, 1, 241, 0, 1, 0, 0, 0, 0, 0, 0))
    assert (ack.command, ack.target_system, ack.target_component) == (241, 200, 50)


def test_no_result_is_above_6(gcs: Client) -> None:
    results = {gcs.command(number) for number in range(1000)}
    assert results <= {0, 1, 2, 3, 4}
