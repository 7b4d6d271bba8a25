"""What a terminal shows of a flight while it flies, and what the crew tells for it."""

from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from halfroll.console_flight import Dashboard, rotor_bar, watched_flight
from halfroll.station.record import Event, Glance

GLANCE = Glance(
    mode="OFFBOARD",
    armed=True,
    item=3,
    items=9,
    speed_m_s=7.25,
    error_m=0.0123,
    rotors=(0.5, -0.25, 1.0, 0.0),
    link_rate_Hz=100.0,
    vehicle_rate=1.0,
)


def drawn(board: Dashboard) -> str:
    out = Console(file=io.StringIO(), width=100, force_terminal=False)
    out.print(board)
    return out.file.getvalue()  # type: ignore[attr-defined]


def test_mode_item_speed_error_link_and_rotors_are_seen_at_one_look():
    board = Dashboard("box.plan · mit-vp")
    board.said("fly the plan", 0.5)
    board.report(Event("time", 12.5, "", item=3, glance=GLANCE))
    board.report(Event("text", 12.6, "Mission: plan ready, 16.51 s"))
    seen = drawn(board)
    for words in (
        "box.plan",
        "fly the plan",
        "12.60 s",
        "OFFBOARD",
        "3 of 8",
        "7.25 m/s",
        "12 mm",
        "100/s",
        "plan ready",
    ):
        assert words in seen, words
    for rotor in ("left", "rear", "right", "front"):
        assert rotor in seen


def test_before_anything_was_heard_there_is_nothing_to_be_wrong_about():
    assert "–" not in drawn(Dashboard("box.plan"))


@given(st.floats(-1.5, 1.5))
def test_a_bar_grows_to_the_right_when_a_rotor_pushes_and_to_the_left_when_it_pulls(share):
    bar = rotor_bar("left", share).plain
    left, right = bar.split("│")
    assert left.count("█") == (0 if share >= 0.0 else min(round(-12 * share), 12))
    assert right.count("█") == (min(round(12 * share), 12) if share >= 0.0 else 0)
    assert len(bar) == len(rotor_bar("rear", -share).plain)


def test_where_there_is_no_terminal_a_phase_is_one_plain_line(capsys: pytest.CaptureFixture[str]):
    with watched_flight("box.plan") as (said, report):
        said("take off", None)
        said("fly the plan", 0.1)
        report(Event("time", 1.0, "", glance=GLANCE))
        said("fly the plan", 0.9)
    assert capsys.readouterr().err == "take off\nfly the plan\n"
