"""Limits and margins: the defaults, and that the check finds the true extrema, between samples too."""

import numpy as np
import pytest

from halfroll.planner.limits import Limits, margins
from halfroll.planner.segments import node, rest, solve
from halfroll.vehicle import GRAVITY, load_vehicle

VP, FP = load_vehicle("mit-vp"), load_vehicle("mit-fp")


def climb(T):
    return solve([rest([0, 0, 1, 0]), rest([0, 0, 2, 0])], [T])


def bend(T=1.2):
    return solve([rest([0, 0, 1, 0]), node([2, 1, 2, 0.5]), rest([4, 0, 1, 0])], [T, T])


def test_mission_limits_keep_a_tenth_of_the_thrust_free():
    limits = Limits.of(VP)
    assert (limits.rotor_min, limits.rotor_max) == pytest.approx((-2.7, 2.7))
    assert limits.speed_max == VP.speed_max_m_s
    assert limits.floor == 0.5
    assert limits.body_rate_max == VP.body_rate_max_rad_s


def test_rotor_limits_are_the_rotors_own():
    limits = Limits.of(FP, "rotors")
    assert (limits.rotor_min, limits.rotor_max) == (0.15, 3.0)
    assert limits.speed_max is limits.floor is limits.body_rate_max is None


def test_fixed_pitch_missions_stay_above_half_the_weight_where_the_outer_loop_clamps():
    assert Limits.of(FP).force_z_min == pytest.approx(0.65 * FP.weight)


def test_what_fixed_pitch_may_do_variable_pitch_of_the_same_mass_may_do():
    for kind in ("mission", "rotors"):
        fixed, variable = Limits.of(FP, kind), Limits.of(VP, kind)
        assert variable.rotor_min < fixed.rotor_min
        assert variable.rotor_max == fixed.rotor_max
        assert variable.force_z_min < fixed.force_z_min


@pytest.mark.parametrize("name", ["mit-vp", "mit-fp", "race-5in"])
@pytest.mark.parametrize("margin", [0.0, 0.1, 0.3])
def test_hover_is_always_inside_the_limits(name, margin):
    vehicle = load_vehicle(name)
    limits = Limits.of(vehicle, "mission", margin)
    assert limits.rotor_min < vehicle.weight / 4.0 < limits.rotor_max
    assert limits.force_z_min < vehicle.weight


def test_the_extreme_of_a_vertical_climb_is_found_to_rounding():
    found = margins(climb(1.0), VP, Limits.of(VP, "rotors"), samples_per_segment=50)
    acceleration = np.polynomial.Polynomial([0, 0, 0, 0, 0, 126, -420, 540, -315, 70]).deriv(2)
    peak = VP.mass_kg * (GRAVITY + max(acceleration(x.real) for x in acceleration.deriv().roots())) / 4.0
    assert found.rotor_max == pytest.approx([peak] * 4, abs=1e-6)
    worst = found.worst
    assert (worst.limit, worst.segment) == ("rotor_max", 0)
    assert worst.margin == pytest.approx(3.0 - peak, abs=1e-6)


def test_coarse_sampling_with_refinement_equals_a_very_dense_one():
    limits = Limits.of(VP)
    coarse, dense = (margins(bend(), VP, limits, samples) for samples in (200, 20000))
    for one, other in zip(coarse.extremes, dense.extremes, strict=True):
        assert one.quantity == pytest.approx(other.quantity, abs=1e-6), one.limit
    assert coarse.by_segment.shape == (len(coarse.extremes), 2)


def test_the_worst_offender_is_named():
    found = margins(bend(0.6), VP, Limits.of(VP))
    assert not found.checked
    assert found.worst.relative < 0.0
    assert found.worst.rotor in (1, 2, 3, 4)
    assert found.violation == pytest.approx(max(*found.rotor_max, *(-f for f in found.rotor_min)) - 2.7)


def test_a_violation_of_no_rotor_is_not_one_in_newtons():
    found = margins(solve([rest([0, 0, 1, 0]), rest([60, 0, 1, 0])], [9.0]), VP, Limits.of(VP))
    assert found.worst.limit == "speed"
    assert found.worst.quantity == pytest.approx(2.4609375 * 60 / 9, rel=1e-6)
    assert not found.checked
    assert found.violation == 0.0


def test_the_speed_limit_of_a_segment_counts_where_it_is_lower():
    path, limits = bend(3.0), Limits.of(VP)
    assert margins(path, VP, limits).checked
    slow = margins(path, VP, limits, segment_speed_max=[np.inf, 0.5]).worst
    assert (slow.limit, slow.segment, slow.allowed) == ("speed", 1, 0.5)


def test_low_height_fast_turning_and_little_force_are_seen():
    limits = Limits(-9.0, 9.0, floor=1.1, body_rate_max=1.0, force_z_min=5.0, force_min=5.5)
    quantity = {extreme.limit: extreme.quantity for extreme in margins(bend(), VP, limits).extremes}
    assert quantity["floor"] <= 1.0 + 1e-9
    assert quantity["body_rate"] > 1.0
    assert quantity["force_z"] < 5.0
    assert quantity["force_z"] <= quantity["force"]


def test_pushing_straight_down_is_free_for_variable_pitch_only():
    path = solve([rest([0, 0, 2, 0]), rest([0, 0, 1, 0])], [0.7])
    assert margins(path, VP, Limits.of(VP, "rotors")).worst.limit == "rotor_max"
    assert "force_z" in {e.limit for e in margins(path, FP, Limits.of(FP, "rotors")).extremes if e.relative < 0}
