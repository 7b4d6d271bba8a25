"""By the wall clock: nobody waits for the ground station, and its references still come in time."""

from __future__ import annotations

from pathlib import Path

import pytest

from system.processes import MISSIONS, Ended, halfroll

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> tuple[Ended, Path]:
    folder = tmp_path_factory.mktemp("real_time")
    return halfroll("fly", MISSIONS / "box.plan", "--real-time", "--out", folder), folder


def test_a_flight_in_real_time_is_within_limits(flown: tuple[Ended, Path]) -> None:
    assert flown[0].code == 0, flown[0].err + flown[0].out


def test_rate_and_99th_percentile_of_the_interval_are_printed(flown: tuple[Ended, Path]) -> None:
    assert "per second" in flown[0].out
    assert "99" in flown[0].out


def test_everything_a_flight_leaves_lies_in_its_folder(flown: tuple[Ended, Path]) -> None:
    names = {path.name for path in flown[1].iterdir()}
    assert names == {"flight.ulg", "flight.png", "flight.tlog", "plan.csv", "plan.json", "report.html", "result.json"}
