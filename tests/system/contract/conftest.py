"""Aircraft in the situations the contract speaks of, made once and copied for each test; and the count of its lines."""

from __future__ import annotations

import re
from collections import Counter

import pytest

from system.contract.aircraft import ACCEPTED, MISSION, Aircraft, Client
from system.contract.missions import LINE

_SECTION = re.compile(r"contract/test_(\d\d)_")
_HOLDING: Counter[int] = Counter()  # lines by section


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    section = _SECTION.search(report.nodeid)
    if section and report.when == "call" and report.passed:
        _HOLDING[int(section[1])] += 1


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    if _HOLDING:
        counts = ", ".join(f"{section}: {n}" for section, n in sorted(_HOLDING.items()))
        terminalreporter.write_line(f"MAVLink contract: {sum(_HOLDING.values())} lines hold (by section {counts})")


@pytest.fixture(scope="session")
def _booted() -> Aircraft:
    aircraft = Aircraft.new()
    aircraft.fly(1.5)
    return aircraft


@pytest.fixture(scope="session")
def _hovering(_booted: Aircraft) -> Aircraft:
    aircraft = _booted.copy()
    client = aircraft.client()
    assert client.command(22, 0, 0, 0, 0, 0, 0, 12.0) == ACCEPTED
    assert client.command(400, 1) == ACCEPTED
    aircraft.fly(15.0)
    assert aircraft.autopilot.mode == "Hold"
    return aircraft


@pytest.fixture(scope="session")
def _on_mission(_booted: Aircraft) -> Aircraft:
    """Between its first and second waypoint."""
    aircraft = _booted.copy()
    client = aircraft.client()
    assert client.upload(LINE) == 0
    assert client.set_mode(MISSION) == ACCEPTED
    assert client.command(400, 1) == ACCEPTED
    while aircraft.world.p_WB[0] < 25.0:
        aircraft.fly(0.1)
    return aircraft


@pytest.fixture
def grounded(_booted: Aircraft) -> Aircraft:
    """On the ground, disarmed, its position known."""
    return _booted.copy()


@pytest.fixture
def hovering(_hovering: Aircraft) -> Aircraft:
    """In HOLD at 12 m."""
    return _hovering.copy()


@pytest.fixture
def on_mission(_on_mission: Aircraft) -> Aircraft:
    return _on_mission.copy()


@pytest.fixture
def gcs(grounded: Aircraft) -> Client:
    """A ground control station of the vehicle on the ground."""
    return grounded.client()


@pytest.fixture
def pilot(hovering: Aircraft) -> Client:
    """A ground control station of the hovering vehicle."""
    return hovering.client()
