"""The shipped mission, flown end to end by both vehicles in the ideal world."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from halfroll.results.log import Log, read_log
from system.processes import EXAMPLES, Ended, halfroll

FIGURES = (
    "T_planned_s",
    "T_flown_s",
    "flight_s",
    "tracking_rms_m",
    "tracking_max_m",
    "waypoint_miss_max_m",
    "reference_rate_Hz",
)
RMS_M = {"mit-vp": 0.03, "mit-fp": 0.15}
MISS_M = 0.05


@pytest.fixture(scope="module")
def flights(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Ended]:
    """Vehicle to its flight."""
    folder = tmp_path_factory.mktemp("first")
    return {name: _fly(name, folder / name) for name in RMS_M}


def _fly(vehicle: str, folder: Path) -> Ended:
    mission = EXAMPLES / "first_flight.plan"
    return halfroll("fly", mission, "--vehicle", vehicle, "--scenario", "ideal", "--json", "--out", folder)


@pytest.fixture(scope="module", params=list(RMS_M))
def flown(request: pytest.FixtureRequest, flights: dict[str, Ended]) -> tuple[str, Ended]:
    return request.param, flights[request.param]


@pytest.fixture(scope="module")
def log(flown: tuple[str, Ended]) -> Log:
    return read_log(flown[1].json["log"])


def test_it_is_flown_within_limits(flown: tuple[str, Ended]) -> None:
    _, ended = flown
    assert (ended.code, ended.json["result"]) == (0, "flown")


def test_its_figures_have_the_names_and_types_that_programs_rely_on(flown: tuple[str, Ended]) -> None:
    result = flown[1].json
    assert all(isinstance(result[name], float) and math.isfinite(result[name]) for name in FIGURES)
    assert all(len(result[name]) == 4 for name in ("rotor_min_N", "rotor_max_N"))
    assert isinstance(result["references_sent"], int)
    assert len(bytes.fromhex(result["commands_sha256"])) == 32
    assert all(Path(result[name]).is_file() for name in ("log", "report"))


def test_it_follows_the_plan(flown: tuple[str, Ended]) -> None:
    vehicle, ended = flown
    assert ended.json["tracking_rms_m"] <= RMS_M[vehicle]
    assert ended.json["T_flown_s"] == pytest.approx(ended.json["T_planned_s"], abs=0.02)


def test_it_passes_every_waypoint_when_it_is_due(flights: dict[str, Ended]) -> None:
    assert flights["mit-vp"].json["waypoint_miss_max_m"] <= MISS_M
    assert len(flights["mit-vp"].json["waypoint_miss_m"]) == 8


def test_references_go_out_exactly_100_times_per_second_of_the_vehicle(flown: tuple[str, Ended]) -> None:
    result = flown[1].json
    assert result["reference_rate_Hz"] == pytest.approx(100.0, abs=1e-6)
    assert result["references_sent"] >= 100 * result["T_planned_s"]


def test_rotors_that_push_both_ways_are_never_slower(flights: dict[str, Ended]) -> None:
    assert flights["mit-vp"].json["T_planned_s"] <= flights["mit-fp"].json["T_planned_s"]


def test_at_the_end_it_rests_disarmed_on_the_ground(log: Log) -> None:
    truth, state = log["vehicle_truth"], log["vehicle_state"]
    assert not state["armed"][-1]
    assert abs(truth["p"][-1, 2]) < 0.05
    assert np.linalg.norm(truth["v"][-1]) < 0.01
    assert np.linalg.norm(truth["p"][-1, :2]) < 0.3  # it took off from the origin, and the mission ends above it
    assert log["rotor_commands"]["thrust"][-1] == pytest.approx([0, 0, 0, 0])


def test_the_log_names_its_commands_by_the_same_hash(flown: tuple[str, Ended], log: Log) -> None:
    assert log.info["commands_sha256"] == flown[1].json["commands_sha256"]


def test_the_phases_are_told_on_standard_error(flown: tuple[str, Ended]) -> None:
    told = flown[1].err.splitlines()
    assert told.index("plan") < told.index("take off") < told.index("fly the plan") < told.index("end the mission")


def test_the_report_stands_by_itself(flown: tuple[str, Ended]) -> None:
    page = Path(flown[1].json["report"]).read_text(encoding="utf-8")
    assert page.lstrip().lower().startswith("<!doctype html")
    assert 'src="http' not in page
    assert "first_flight" in page
