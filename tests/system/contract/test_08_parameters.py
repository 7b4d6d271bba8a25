"""Contract, section 8: the parameter service."""

from __future__ import annotations

import math

import pytest

from halfroll import _firmware
from system.contract.aircraft import ACCEPTED, A, Aircraft, Client

TABLE = _firmware.parameter_table()
NAMES = [row.id for row in TABLE]
READ_ONLY, WHOLE, LOCKED = 4, 1, 2


def listed(client: Client, wall_s: float = 3.0) -> list[object]:
    since = len(client.heard)
    client.ask(client.encode.param_request_list_encode(1, 1))
    client.aircraft.stand(wall_s)
    return [m for _, m in client.heard[since:] if m.get_type() == "PARAM_VALUE"]


def test_the_list_is_whole_and_in_name_order(gcs: Client) -> None:
    values = listed(gcs)
    assert [m.param_id for m in values] == sorted(NAMES)  # type: ignore[attr-defined]
    assert [m.param_index for m in values] == list(range(len(NAMES)))  # type: ignore[attr-defined]


def test_the_count_is_the_same_in_each_value(gcs: Client) -> None:
    assert {m.param_count for m in listed(gcs)} == {len(NAMES)}  # type: ignore[attr-defined]


def test_every_value_is_a_real32(gcs: Client) -> None:
    assert {m.param_type for m in listed(gcs)} == {9}  # type: ignore[attr-defined]


def test_the_list_comes_at_100_to_400_a_second_of_wall_time(gcs: Client) -> None:
    assert 20 <= len(listed(gcs, wall_s=0.2)) <= 80


def test_a_new_request_restarts_the_list(gcs: Client) -> None:
    gcs.ask(gcs.encode.param_request_list_encode(1, 1))
    gcs.aircraft.stand(0.1)
    assert [m.param_index for m in listed(gcs)] == list(range(len(NAMES)))  # type: ignore[attr-defined]


def test_reads_and_writes_are_answered_during_the_list(gcs: Client) -> None:
    gcs.ask(gcs.encode.param_request_list_encode(1, 1))
    assert gcs.read_param("MIS_TAKEOFF_ALT") == 2.5
    assert gcs.set_param("MIS_TAKEOFF_ALT", 3.0)[0].param_value == 3.0


@pytest.mark.parametrize("name", NAMES)
def test_a_parameter_is_read_by_name_and_by_index(gcs: Client, name: str) -> None:
    by_name = gcs.only("PARAM_VALUE", gcs.encode.param_request_read_encode(1, 1, name.encode(), -1))
    by_index = gcs.only("PARAM_VALUE", gcs.encode.param_request_read_encode(1, 1, b"", by_name.param_index))
    assert by_index.param_id == by_name.param_id == name
    assert by_index.param_value == by_name.param_value


def test_names_are_at_most_16_characters(gcs: Client) -> None:
    assert max(len(name) for name in NAMES) <= 16


@pytest.mark.parametrize("row", [row for row in TABLE if not row.flags & READ_ONLY], ids=lambda row: row.id)
def test_a_parameter_takes_both_ends_of_its_range_and_nothing_beyond(gcs: Client, row: _firmware.ParamInfo) -> None:
    for value in (row.least, row.most):
        if row.id == "MAV_SYS_ID" and value != 1.0:
            continue
        (answer,) = gcs.set_param(row.id, value)
        assert answer.param_value == pytest.approx(value, rel=1e-6)
    for value in (row.least - 1.0, row.most * 2 + 1.0, math.nan, math.inf, -math.inf):
        error, answer = gcs.set_param(row.id, value)
        assert (error.get_type(), error.error, error.param_id) == ("PARAM_ERROR", 2, row.id)
        assert answer.param_value == gcs.read_param(row.id)


@pytest.mark.parametrize("row", [row for row in TABLE if row.flags & READ_ONLY], ids=lambda row: row.id)
def test_a_read_only_parameter_is_refused_with_its_value(gcs: Client, row: _firmware.ParamInfo) -> None:
    before = gcs.read_param(row.id)
    error, answer = gcs.set_param(row.id, before)
    assert (error.error, answer.param_value) == (5, before)


@pytest.mark.parametrize(
    "row",
    [row for row in TABLE if row.flags & WHOLE and not row.flags & READ_ONLY and row.id != "MAV_SYS_ID"],
    ids=lambda row: row.id,
)
def test_a_whole_number_parameter_takes_no_fraction(gcs: Client, row: _firmware.ParamInfo) -> None:
    error, answer = gcs.set_param(row.id, row.least + 0.5)
    assert error.error == 2
    assert answer.param_value == row.default


@pytest.mark.parametrize("row", [row for row in TABLE if row.flags & LOCKED], ids=lambda row: row.id)
def test_a_parameter_locked_while_armed(gcs: Client, row: _firmware.ParamInfo) -> None:
    assert gcs.command(400, 1) == ACCEPTED
    error, answer = gcs.set_param(row.id, row.least)
    assert (error.error, answer.param_value) == (3, row.default)


def test_an_unknown_name_is_an_error_of_its_own(gcs: Client) -> None:
    for ask in (
        gcs.encode.param_set_encode(1, 1, b"NO_SUCH", 1.0, 9),
        gcs.encode.param_request_read_encode(1, 1, b"NO_SUCH", -1),
    ):
        (error,) = gcs.ask(ask)
        assert (error.get_type(), error.error, error.param_id) == ("PARAM_ERROR", 1, "NO_SUCH")


def test_the_hash_of_all_is_no_parameter(gcs: Client) -> None:
    (error,) = gcs.ask(gcs.encode.param_request_read_encode(1, 1, b"_HASH_CHECK", -1))
    assert error.error == 1


@pytest.mark.parametrize("index", [len(NAMES), 30000, -2])
def test_an_index_outside_the_table_is_an_error(gcs: Client, index: int) -> None:
    (error,) = gcs.ask(gcs.encode.param_request_read_encode(1, 1, b"MIS_TAKEOFF_ALT", index))
    assert (error.error, error.param_index) == (1, index)


@pytest.mark.parametrize("kind", [1, 2, 3, 4, 5, 6, 7, 8, 10])
def test_another_type_than_real32_is_refused(gcs: Client, kind: int) -> None:
    error, answer = gcs.set_param("MIS_TAKEOFF_ALT", 3.0, kind)
    assert (error.error, answer.param_value) == (7, 2.5)


def test_the_error_comes_before_the_value(gcs: Client) -> None:
    answers = gcs.set_param("MIS_TAKEOFF_ALT", 1000.0)
    assert [m.get_type() for m in answers] == ["PARAM_ERROR", "PARAM_VALUE"]


def test_an_error_goes_to_the_asker_alone_and_a_change_to_all(grounded: Aircraft) -> None:
    asker, other = grounded.client(), grounded.client(A)
    asker.set_param("MIS_TAKEOFF_ALT", 1000.0)
    assert other.heard == []
    asker.set_param("MIS_TAKEOFF_ALT", 10.0)
    assert [m.param_value for m in other.all("PARAM_VALUE")] == [10.0]


def test_extended_parameters_and_maps_are_ignored(gcs: Client) -> None:
    assert gcs.ask(gcs.encode.param_ext_request_list_encode(1, 1)) == []
    assert gcs.ask(gcs.encode.param_ext_request_read_encode(1, 1, b"MIS_TAKEOFF_ALT", -1)) == []
    assert gcs.ask(gcs.encode.param_map_rc_encode(1, 1, b"MIS_TAKEOFF_ALT", -1, 0, 1.0, 1.0, 0.0, 2.0)) == []
    assert gcs.read_param("MIS_TAKEOFF_ALT") == 2.5


CLIENTS_LOOK_FOR = {
    "MAV_SYS_ID": 1,
    "MIS_TAKEOFF_ALT": 2.5,
    "RTL_RETURN_ALT": 30,
    "MPC_XY_CRUISE": 5,
    "MPC_XY_VEL_MAX": 12,
    "NAV_ACC_RAD": 2,
    "COM_DISARM_LAND": 2,
    "COM_DISARM_PRFLT": 10,
    "BAT_LOW_THR": 0.2,
    "BAT_CRIT_THR": 0.1,
    "OFB_RATE_T": 0.03,
    "OFB_HOLD_T": 0.15,
    "OFB_LOSS_T": 0.5,
    "OFB_START_T": 1.0,
    "OFB_LOSS_ACT": 0,
    "MIS_SEQ0_HOME": 2,
    "MIS_DIST_1WP": 5000,
    "MIS_ALT_MAX": 500,
    "SIM_SPEED": 1,
    "VEH_T_REF": 12,
}


@pytest.mark.parametrize("name", CLIENTS_LOOK_FOR)
def test_a_parameter_that_clients_look_for_has_its_default(gcs: Client, name: str) -> None:
    assert gcs.read_param(name) == pytest.approx(CLIENTS_LOOK_FOR[name])


def test_the_takeoff_height_has_the_range_that_clients_try(gcs: Client) -> None:
    (row,) = (row for row in TABLE if row.id == "MIS_TAKEOFF_ALT")
    assert (row.least, row.most) == (0.5, 100.0)
