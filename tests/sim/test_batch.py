"""Many flights at once, snapshots, and the same bits always."""

import random

import numpy as np
import pytest
from flying import airborne, new

from halfroll import _firmware


def hovering(scenario, seed=3):
    autopilot, world = airborne(scenario="nominal")
    other = _firmware.World(_firmware.vehicle_setup("mit-vp").plant, scenario, seed)
    other.place(world.p_WB, world.v_WB, world.q_WB, world.w_WB_B, world.rotor_thrust)
    return autopilot, other


@pytest.mark.parametrize("scenario", ["ideal", "nominal", "windy", "full"])
def test_a_batch_flies_what_each_pair_would_fly_alone(scenario):
    autopilot, world = hovering(scenario)
    alone = [(autopilot.copy(), _copy_with_seed(world, scenario, seed)) for seed in range(6)]
    together = [(a.copy(), w.copy()) for a, w in alone]
    for a, w in alone:
        a.fly(w, 700)
    _firmware.World.run_batch([a for a, _ in together], [w for _, w in together], 700, threads=3)
    for (a, w), (b, v) in zip(alone, together, strict=True):
        assert a.same_state(b)
        assert w.same_state(v)


def _copy_with_seed(world, scenario, seed):
    copy = _firmware.World(_firmware.vehicle_setup("mit-vp").plant, scenario, seed)
    copy.place(world.p_WB, world.v_WB, world.q_WB, world.w_WB_B, world.rotor_thrust)
    return copy


def test_a_batch_refuses_pairs_that_are_none():
    autopilot, world = new()
    with pytest.raises(ValueError, match="1 autopilots for 2 worlds"):
        _firmware.World.run_batch([autopilot], [world, world.copy()], 10)
    with pytest.raises(ValueError, match="listed twice; give copies"):
        _firmware.World.run_batch([autopilot, autopilot], [world, world.copy()], 10)


def test_ten_runs_of_a_seed_are_equal_in_every_bit_and_another_seed_is_not():
    autopilot, world = hovering("full")
    runs = [(autopilot.copy(), world.copy()) for _ in range(10)]
    _firmware.World.run_batch([a for a, _ in runs], [w for _, w in runs], 2000, threads=2)
    for a, w in runs[1:]:
        assert a.same_state(runs[0][0])
        assert w.same_state(runs[0][1])
    other = _copy_with_seed(world, "full", 4)
    autopilot.fly(other, 2000)
    assert not other.same_state(runs[0][1])


def test_a_flight_continued_from_a_snapshot_ends_in_the_same_bits_wherever_it_was_taken():
    autopilot, world = hovering("full")
    whole = (autopilot.copy(), world.copy())
    whole[0].fly(whole[1], 3000)
    draw = random.Random(5)
    for moment in (draw.randrange(1, 3000) for _ in range(20)):
        a, w = autopilot.copy(), world.copy()
        a.fly(w, moment)
        snapshot = a.copy(), w.copy()
        a.fly(w, 3000 - moment)
        assert a.same_state(whole[0])
        assert w.same_state(whole[1])
        a.restore(snapshot[0])
        w.restore(snapshot[1])
        a.fly(w, 3000 - moment)
        assert a.same_state(whole[0])
        assert w.same_state(whole[1])


def test_step_many_is_step_many_times():
    _, world = new()
    other = world.copy()
    thrusts = np.random.default_rng(1).uniform(0.0, 3.0, (50, 4)).astype(np.float32)
    truth = world.step_many(thrusts)
    for thrust in thrusts:
        other.step(thrust)
    assert world.same_state(other)
    assert np.array_equal(truth[-1, :3], other.p_WB)
