"""What a flight makes of faults: a weak rotor is flown with, two dead ones end in a crash that is noticed."""

import numpy as np
from streamed import StreamedFlight


def hovering(*settings):
    flight = StreamedFlight("mit-vp", "nominal", settings, seed=2)
    flight.take_off(3.0)
    return flight


def test_a_weak_rotor_is_held_against_by_the_position_loop():
    flight = hovering("fault.0.kind=weak-rotor", "fault.0.at_s=12", "fault.0.rotor=2", "fault.0.share=0.85")
    before = np.array(flight.world.p_WB)
    flight.fly(8000)
    assert not flight.world.crashed
    assert np.linalg.norm(flight.world.p_WB - before) < 0.3


def test_two_dead_rotors_bring_it_down_and_the_world_says_so():
    dead = [f"fault.{n}.{key}" for n in (0, 1) for key in ("kind=dead-rotor", "at_s=12", f"rotor={n + 1}")]
    flight = hovering(*dead)
    flight.fly(500)
    assert not flight.world.crashed
    flight.fly(5000)
    assert flight.world.crashed


def test_a_third_of_a_second_without_motion_capture_is_survived():
    flight = hovering("fault.0.kind=mocap-lost", "fault.0.at_s=12", "fault.0.until_s=12.3")
    before = np.array(flight.world.p_WB)
    flight.fly(3000)
    assert not flight.world.crashed
    assert np.linalg.norm(flight.world.p_WB - before) < 0.3
