"""The pilot flies a mission through the door of any ground control station."""

from __future__ import annotations

import numpy as np
import pytest
from fake_autopilot import HOLD
from station_scene import Scene

from halfroll.errors import FlightError, MissionError
from halfroll.station.station import State
from halfroll.wire import messages as wire


def test_the_pilot_flies_a_mission_through_the_door_of_any_ground_control_station():
    scene = Scene(pilot=True)
    scene.fly(until=lambda: scene.world.armed)
    scene.world.mission_state = 3
    scene.world.position = np.array([0.0, 0.0, -2.0])
    scene.fly(0.1)
    scene.world.reach(0)
    scene.fly(until=lambda: scene.station.following is not None and scene.station.following.done)
    scene.world.mission_state, scene.world.armed = 5, False
    scene.world.set_mode(HOLD)
    scene.fly(until=lambda: scene.pilot.done)
    numbers = [command[0] for command in scene.world.commands()]
    assert [n for n in numbers if n in (176, 400, 246)] == [176, 400, 176, 176, 246]  # start, arm, take over, back, off
    kinds = scene.kinds()
    told = ("uploaded", "planned", "armed", "approach", "flying", "handed-back", "landed")
    assert [kinds.index(kind) for kind in told] == sorted(kinds.index(kind) for kind in told)


def test_the_pilot_does_not_start_before_the_mission_is_planned():
    scene = Scene(pilot=True)
    scene.planner.patience = 10**9
    scene.fly(until=lambda: scene.station.state is State.PLANNING)
    for _ in range(300):
        scene.world.tick()
        scene.turn()
    assert 400 not in [command[0] for command in scene.world.commands()]


def test_an_item_that_the_autopilot_refuses_at_start_is_named():
    scene = Scene(pilot=True)
    scene.world.refuse[400] = wire.TEMPORARILY_REJECTED
    scene.fly(until=lambda: scene.station.outcome is not None)
    scene.world.send("statustext", 4, b"Arming denied: item 2 is below ground")
    with pytest.raises(MissionError, match="item 2 is below ground") as caught:
        scene.fly(30.0)
    assert (caught.value.item, caught.value.exit_code) == (2, 2)


def test_arming_is_tried_again_until_the_autopilot_is_ready():
    scene = Scene(pilot=True)
    scene.world.refuse[400] = wire.TEMPORARILY_REJECTED
    scene.fly(5.0)
    assert not scene.world.armed
    del scene.world.refuse[400]
    scene.fly(until=lambda: scene.world.armed)
    assert [command[0] for command in scene.world.commands()].count(400) > 5


def test_a_vehicle_that_will_not_arm_ends_the_flight_with_its_own_words():
    scene = Scene(pilot=True)
    scene.world.refuse[400] = wire.TEMPORARILY_REJECTED
    scene.fly(until=lambda: scene.station.outcome is not None)
    scene.world.send("statustext", 4, b"Arming denied: battery low")
    with pytest.raises(FlightError, match="battery low"):
        scene.fly(30.0)


def test_a_landing_before_the_mission_is_complete_is_a_failed_flight():
    scene = Scene(pilot=True)
    scene.fly(until=lambda: scene.world.armed)
    scene.fly(1.0)
    scene.world.armed = False
    scene.world.set_mode(HOLD)
    with pytest.raises(FlightError, match="before the mission was complete") as caught:
        scene.fly(3.0)
    assert caught.value.exit_code == 1


def test_a_vehicle_that_never_takes_off_ends_the_flight(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("halfroll.station.pilot.TAKEOFF_PATIENCE_S", 0.05)
    scene = Scene(pilot=True)
    with pytest.raises(FlightError, match="did not take off within"):
        scene.fly(30.0)
