"""A person interferes: pause and continue, or another mode, while the ground station flies the plan."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import pytest

from system.gcs import ACCEPTED, Gcs, Item
from system.processes import HALFROLL, MISSIONS, Running, free_instance, simulator
from system.test_stored_missions import items_of

SET_MODE, PAUSE_CONTINUE = 176, 193
HOLD, MISSION, RTL, OFFBOARD = 4 << 16 | 3 << 24, 4 << 16 | 4 << 24, 4 << 16 | 5 << 24, 6 << 16
ACTIVE, PAUSED, COMPLETE = 3, 4, 5


@pytest.fixture
def gcs() -> Iterator[Gcs]:
    """Beside simulator and ground station, as soon as the box is flown by its plan."""
    instance = free_instance()
    with contextlib.ExitStack() as stack:
        ground = stack.enter_context(Running(HALFROLL, "ground", "--instance", str(instance)))
        ground.until_it_says("waiting for an autopilot")
        words = ("--scenario", "ideal", "--lockstep", "--speed", "3")
        stack.enter_context(simulator(*words, instance=instance))
        gcs = stack.enter_context(Gcs(instance))
        box: list[Item] = items_of(MISSIONS / "box.plan")
        assert gcs.upload(box) == ACCEPTED
        until_text(gcs, "plan ready")
        assert gcs.command(SET_MODE, 1, 4, 4) == ACCEPTED
        gcs.arm()
        until_mode(gcs, OFFBOARD)
        gcs.until(lambda m: m.get_type() == "MISSION_CURRENT" and m.seq == 2)
        yield gcs


def until_mode(gcs: Gcs, mode: int) -> None:
    gcs.until(lambda m: m.get_type() == "HEARTBEAT" and m.get_srcComponent() == 1 and m.custom_mode == mode)


def until_text(gcs: Gcs, words: str) -> None:
    gcs.until(lambda m: m.get_type() == "STATUSTEXT" and words in m.text)


def until_state(gcs: Gcs, state: int) -> None:
    gcs.until(lambda m: m.get_type() == "MISSION_CURRENT" and m.mission_state == state)


def test_a_paused_mission_is_planned_anew_from_where_it_hovers_and_flown_to_its_end(gcs: Gcs) -> None:
    assert gcs.command(PAUSE_CONTINUE, 0) == ACCEPTED
    until_mode(gcs, HOLD)
    until_state(gcs, PAUSED)
    until_text(gcs, "plan ready")
    assert gcs.command(PAUSE_CONTINUE, 1) == ACCEPTED
    until_mode(gcs, OFFBOARD)
    until_state(gcs, ACTIVE)
    gcs.until_landed()
    assert gcs.mission_current().mission_state == COMPLETE


def test_a_return_asked_for_on_the_way_ends_the_plan(gcs: Gcs) -> None:
    since = len(gcs.texts)
    assert gcs.command(SET_MODE, 1, 4, 5) == ACCEPTED
    until_mode(gcs, RTL)
    gcs.until_landed()
    assert not any("Failsafe" in text for text in gcs.texts[since:])
    assert gcs.mission_current().mission_state != COMPLETE
