"""Inverted hold and flips, flown by the autopilot alone on the variable-pitch vehicle."""

from __future__ import annotations

import math

import numpy as np
import pytest
from session import Session, hovering

INVERTED, FLIP = 210, 31010
ACCEPTED, NOT_NOW, DENIED = 0, 1, 2
NAN = math.nan
ROLL, PITCH = 1, 2


@pytest.fixture(scope="module")
def high() -> Session:
    return hovering(scenario="nominal", height=12.0)


@pytest.fixture(scope="module")
def inverted(high: Session) -> Session:
    flight = high.copy()
    assert flight.command(INVERTED, 1) == ACCEPTED
    flight.run(6000)
    return flight


def positions(flight: Session, ms: int) -> np.ndarray:
    out = []
    for _ in range(ms):
        flight.step()
        out.append(flight.world.p_WB)
    return np.array(out)


def test_it_rolls_over_and_hovers_upside_down_for_half_a_minute(inverted: Session) -> None:
    flight = inverted.copy()
    path = positions(flight, 30000)
    assert flight.up < -0.999
    assert np.ptp(path, axis=0).max() < 0.1
    assert np.linalg.norm(path.mean(axis=0) - [0.0, 0.0, 12.0]) < 0.1
    assert flight.texts() == []
    assert flight.autopilot.mode == "Hold"


def test_it_comes_back_upright_where_it_was(inverted: Session) -> None:
    flight = inverted.copy()
    assert flight.command(INVERTED, 0) == ACCEPTED
    path = positions(flight, 6000)
    assert flight.up > 0.999
    assert path[:, 2].min() > 11.0
    assert np.linalg.norm(path[-1] - [0.0, 0.0, 12.0]) < 0.1


def test_rolling_over_costs_less_than_a_metre_of_height(high: Session) -> None:
    flight = high.copy()
    flight.command(INVERTED, 1)
    path = positions(flight, 4000)
    assert path[:, 2].min() > 11.0
    assert np.abs(path[:, :2]).max() < 1.0


@pytest.mark.parametrize(
    ("axis", "turns"), [(ROLL, 1.0), (ROLL, -1.0), (PITCH, 1.0), (PITCH, -1.0), (ROLL, 2.0), (PITCH, 5.0)]
)
def test_a_flip_returns_to_hover_near_where_it_began(high: Session, axis: int, turns: float) -> None:
    flight = high.copy()
    assert flight.command(FLIP, axis, turns, NAN, NAN) == ACCEPTED
    ups, path = [], []
    for _ in range(6000 + int(2000 * abs(turns))):
        flight.step()
        ups.append(flight.up)
        path.append(flight.world.p_WB)
    lowest = min(p[2] for p in path)
    assert min(ups) < -0.99
    crossings = int(np.sum(np.diff(np.sign(ups)) != 0))
    assert crossings == 2 * abs(turns)
    assert flight.up > 0.999
    assert np.linalg.norm(flight.world.v_WB) < 0.05
    assert np.linalg.norm(flight.world.p_WB - [0.0, 0.0, 12.0]) < 0.15
    assert lowest > 12.0 - (0.5 + 0.3 * abs(turns))  # what the autopilot promises
    assert flight.texts() == []


def test_half_a_flip_more_ends_upside_down(high: Session) -> None:
    flight = high.copy()
    assert flight.command(FLIP, ROLL, 1.5, NAN, NAN) == ACCEPTED
    flight.run(6000)
    assert flight.up < -0.999
    assert flight.command(INVERTED, 1) == ACCEPTED  # it is
    assert flight.command(FLIP, PITCH, -0.5, NAN, NAN) == ACCEPTED
    flight.run(6000)
    assert flight.up > 0.999


def test_the_sense_of_a_roll_flip_is_right_wing_down(high: Session) -> None:
    flight = high.copy()
    flight.command(FLIP, ROLL, 1.0, NAN, NAN)
    flight.run(400)
    assert flight.world.w_WB_B[0] > 1.0
    flight = high.copy()
    flight.command(FLIP, PITCH, 1.0, NAN, NAN)
    flight.run(400)
    assert flight.world.w_WB_B[1] < -1.0  # nose up


def test_what_cannot_be_flown_is_refused_with_its_reason() -> None:
    low = hovering(height=3.0)
    assert low.command(INVERTED, 1) == NOT_NOW
    assert low.texts()[-1][2] == "Command: below INV_MIN_ALT, 5 m above home"
    assert low.command(FLIP, ROLL, 1.0, NAN, NAN) == NOT_NOW
    assert low.texts()[-1][2] == "Command: below FLIP_MIN_ALT, 8 m above home"
    assert low.mode(4, 6) == ACCEPTED
    assert low.command(INVERTED, 1) == NOT_NOW
    assert low.texts()[-1][2] == "Command: only while holding"
    fixed = hovering("mit-fp", height=10.0)
    assert fixed.command(INVERTED, 1) == NOT_NOW
    assert fixed.texts()[-1][2] == "Command: rotors of fixed pitch cannot fly inverted"
    assert fixed.command(FLIP, ROLL, 1.0, NAN, NAN) == NOT_NOW


def test_a_flip_keeps_to_the_height_and_time_it_is_given(high: Session) -> None:
    flight = high.copy()
    assert flight.command(FLIP, ROLL, 1.0, 11.5, NAN) == NOT_NOW
    assert flight.texts()[-1][2] == "Command: the flip may lose 1 m"
    assert flight.command(FLIP, ROLL, 1.0, 8.0, 0.5) == NOT_NOW
    assert flight.texts()[-1][2].startswith("Command: the flip takes ")
    assert flight.command(FLIP, ROLL, 0.3, NAN, NAN) == DENIED
    assert flight.command(FLIP, ROLL, 1.0, 8.0, 3.0) == ACCEPTED


@pytest.mark.parametrize(("main", "sub", "mode"), [(4, 5, "Return"), (4, 6, "Land"), (6, 0, "Offboard")])
def test_another_mode_from_inverted_hold_begins_with_rolling_upright(
    inverted: Session, main: int, sub: int, mode: str
) -> None:
    flight = inverted.copy()
    assert flight.mode(main, sub) == ACCEPTED
    path = positions(flight, 900)
    assert flight.autopilot.mode == mode
    assert flight.up > 0.98
    assert path[:, 2].min() > 11.0


@pytest.mark.parametrize("ms", range(100, 1300, 150))
def test_a_flip_that_is_broken_off_at_any_moment_ends_upright(high: Session, ms: int) -> None:
    flight = high.copy()
    flight.command(FLIP, ROLL, 1.0, NAN, NAN)
    flight.run(ms)
    assert flight.mode(6) == ACCEPTED  # where nobody streams: it holds, then gives up
    path = positions(flight, 3000)
    assert flight.autopilot.mode == "Hold"
    assert flight.up > 0.95
    assert path[:, 2].min() > 9.0


def test_a_flip_that_does_not_turn_is_given_up(high: Session) -> None:
    flight = high.copy()
    flight.command(FLIP, ROLL, 2.0, NAN, NAN)
    flight.effectiveness[0] = flight.effectiveness[2] = 0.0  # nothing that could roll it
    flight.run(900)
    flight.effectiveness = [1.0] * 4
    flight.run(3000)
    assert "Command: manoeuvre failed, recovering" in [text for _, _, text in flight.texts()]
    assert flight.up > 0.99
