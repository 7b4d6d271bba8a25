"""Missions that turn over, from the file or the ground station to the landing."""

from __future__ import annotations

from pathlib import Path

import pytest

import halfroll as hr
from halfroll.flight import FlightResult
from halfroll.missions.mission_files import load_mission, save_waypoints
from halfroll.planner.course import flown_waypoints
from halfroll.results.evaluation import FlightFigures, evaluate
from halfroll.results.log import read_log
from system.processes import EXAMPLES, MISSIONS

EXAMPLE = EXAMPLES / "aerobatics.toml"


def figures(flight: FlightResult) -> FlightFigures:
    assert flight.plan is not None
    assert flight.plan_start_s is not None
    return evaluate(flight.plan, flight.plan_start_s, read_log(flight.log_path), flight.vehicle)


@pytest.mark.long
def test_the_example_with_survey_window_and_backflip_is_flown_within_centimetres() -> None:
    assert figures(hr.fly(EXAMPLE, mode="fast", seed=3)).tracking_max_m < 0.05


@pytest.mark.long
def test_flips_as_plain_items_are_stored_read_back_equal_planned_and_flown(tmp_path: Path) -> None:
    """As a ground station would send them: nothing but items."""
    save_waypoints(tmp_path / "flips.waypoints", load_mission(MISSIONS / "flips.toml"))
    mission = load_mission(tmp_path / "flips.waypoints")
    assert mission.waypoints is None
    assert any(not point.upright for point in flown_waypoints(mission.items).waypoints)
    flown = figures(hr.fly(mission, seed=4))
    assert flown.tracking_max_m < 0.05
    assert flown.within_limits
