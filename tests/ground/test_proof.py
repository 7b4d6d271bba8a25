"""Mode paper is held to the same proof as every other plan, and what is not proven is named."""

from dataclasses import replace

import numpy as np
import pytest

from halfroll.missions.mission import PlanOptions, Waypoint
from halfroll.planner.limits import Limits
from halfroll.planner.near_optimal import plan_in_mode
from halfroll.planner.plan import plan_course
from halfroll.planner.proof import proven
from halfroll.vehicle import load_vehicle

VP, FP = load_vehicle("mit-vp"), load_vehicle("mit-fp")
COURSES = {
    "climb": [(0, 0, 1), (0, 0, 2)],
    "zigzag": [(0, 0, 1), (2, 1, 2), (4, -1, 1), (6, 1, 2.5), (8, -1, 1), (10, 0, 1.5)],
}


def points(positions, **holds):
    return [Waypoint(tuple(map(float, p)), item=i, hold_s=holds.get(f"at_{i}", 0.0)) for i, p in enumerate(positions)]


@pytest.mark.parametrize("kind", ["rotors", "mission"])
@pytest.mark.parametrize("vehicle", [VP, FP], ids=lambda vehicle: vehicle.name)
@pytest.mark.parametrize("course", COURSES.values(), ids=COURSES.keys())
def test_what_the_paper_s_form_plans_is_proven(course, vehicle, kind):
    plan = plan_in_mode(points(course), vehicle, PlanOptions(mode="paper", limits=kind))
    assert plan.certified
    assert not plan.warnings


def test_a_millinewton_too_much_is_named_with_its_leg_wherever_the_flight_waits():
    course = points(COURSES["zigzag"], at_0=0.5, at_2=1.0)
    limits = Limits.of(VP)
    plan = plan_course(course, VP, limits)
    assert proven(plan, course, limits).certified
    sampled = plan.sample(2000.0)
    rotors = np.stack([sampled[f"f{i}_N"] for i in range(1, 5)])
    stricter = replace(limits, rotor_max=float(rotors.max()) - 1e-3)
    refused = proven(plan, course, stricter)
    assert not refused.certified
    at = sampled["t_s"][rotors.max(axis=0).argmax()]
    leg = int(np.searchsorted(plan.times_s, at))
    assert f"from item {leg - 1} to item {leg}: rotor" in " ".join(refused.warnings)


def test_a_speed_limit_of_one_leg_is_proven_on_that_leg():
    course = points(COURSES["zigzag"])
    course[1] = replace(course[1], speed_max=2.0)
    plan = plan_course(course, FP)
    assert proven(plan, course, Limits.of(FP)).certified
    course[1] = replace(course[1], speed_max=1.0)
    refused = proven(plan, course, Limits.of(FP))
    assert not refused.certified
    assert "from item 1 to item 2: speed would exceed 1 m/s by" in refused.warnings[0]
