"""A near-optimal plan is flown like any other: it asks of the rotors only what they can follow."""

from __future__ import annotations

from pathlib import Path

import pytest

from system.processes import EXAMPLES, Ended, halfroll


def _fly(mode: str, vehicle: str, folder: Path) -> Ended:
    mission = EXAMPLES / "first_flight.plan"
    given = ("--mode", mode, "--vehicle", vehicle, "--scenario", "ideal")
    return halfroll("fly", mission, *given, "--json", "--out", folder / f"{mode}-{vehicle}")


@pytest.fixture(scope="module")
def fast(tmp_path_factory: pytest.TempPathFactory) -> Ended:
    return _fly("fast", "mit-vp", tmp_path_factory.mktemp("near-optimal"))


def test_it_is_tracked_to_centimetres_and_within_limits(fast: Ended) -> None:
    assert fast.code == 0, fast.err
    flown = fast.json
    assert flown["tracking_rms_m"] < 0.03
    assert flown["waypoint_miss_max_m"] < 0.05


def test_it_takes_a_fifth_less_time_than_the_papers_form(fast: Ended) -> None:
    planned = halfroll("plan", EXAMPLES / "first_flight.plan", "--json").json
    assert fast.json["T_flown_s"] < 0.8 * planned["T_s"]


def test_slow_motors_follow_too(tmp_path: Path) -> None:
    ended = _fly("fast", "mit-fp", tmp_path)
    assert ended.code == 0, ended.err
    assert ended.json["tracking_rms_m"] < 0.03
    assert ended.json["rotor_saturated"] < 0.02
