"""Missions as ground control stations write them: how each ends, and what is refused at its start."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from halfroll.results.log import read_log
from system.processes import MISSIONS, Ended, halfroll


def fly(name: str, folder: Path) -> Ended:
    return halfroll("fly", MISSIONS / name, "--scenario", "ideal", "--json", "--out", folder)


@pytest.fixture(scope="module")
def returned(tmp_path_factory: pytest.TempPathFactory) -> Ended:
    """Ends with a return to launch, 15 m from home."""
    return fly("photo_and_return.plan", tmp_path_factory.mktemp("returned"))


@pytest.fixture(scope="module")
def surveyed(tmp_path_factory: pytest.TempPathFactory) -> Ended:
    """A survey as it is drawn, without takeoff and landing."""
    return fly("survey.plan", tmp_path_factory.mktemp("surveyed"))


def test_a_mission_that_ends_with_a_return_lands_at_home(returned: Ended) -> None:
    assert returned.code == 0, returned.err
    truth = read_log(returned.json["log"])["vehicle_truth"]
    assert np.linalg.norm(truth["p"][-1]) < 0.3
    assert np.linalg.norm(truth["p"][:, :2], axis=1).max() > 20.0


def test_a_return_from_afar_climbs_first(returned: Ended) -> None:
    assert read_log(returned.json["log"])["vehicle_truth"]["p"][:, 2].max() == pytest.approx(30.0, abs=0.5)


def test_a_photo_is_an_item_of_no_flight_time(returned: Ended) -> None:
    assert len(returned.json["waypoint_miss_m"]) == 4  # takeoff and three positions


def test_a_survey_without_takeoff_gets_one_and_is_flown(surveyed: Ended) -> None:
    assert surveyed.code == 0, surveyed.err
    assert any("takeoff" in note.lower() for note in surveyed.json["notes"])
    assert surveyed.json["waypoint_miss_max_m"] <= 0.05
    assert len(surveyed.json["waypoint_miss_m"]) == 7  # the takeoff's and six


def test_a_survey_without_landing_is_brought_down_again(surveyed: Ended) -> None:
    log = read_log(surveyed.json["log"])
    assert log["vehicle_truth"]["p"][-1, 2] == pytest.approx(0.0, abs=0.05)
    assert not log["vehicle_state"]["armed"][-1]


def test_a_mission_of_another_continent_is_refused_at_its_start_with_the_item_named(tmp_path: Path) -> None:
    ended = fly("far_below_its_home.waypoints", tmp_path)
    error = ended.json["error"]
    assert (ended.code, error["kind"], error["item"]) == (2, "mission", 1)
    assert "item 1" in error["message"]
    assert "km away" in error["message"]
    assert ended.sentences == [error["message"]]


def test_a_mission_below_the_ground_is_refused_at_its_start_with_the_item_named(tmp_path: Path) -> None:
    ended = fly("below_ground.waypoints", tmp_path)
    error = ended.json["error"]
    assert (ended.code, error["kind"], error["item"]) == (2, "mission", 2)
    assert "item 2" in error["message"]
    assert ended.sentences == [error["message"]]
