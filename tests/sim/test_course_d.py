"""Course D: a hundred of a hundred flown, close to every waypoint; what wind and a weak rotor make of it is printed."""

import numpy as np
import pytest
from course_d import MARGIN, WINDY_AND_WEAK, campaign, plan, summary

LEFT_N = 0.85 * 3.0  # of the weak rotor


def figures(mode, scenario, settings, seeds, margin=MARGIN):
    flown = campaign("mit-vp", mode, scenario, settings, seeds, margin)
    with_what = f"{scenario}{', weak rotor' if settings else ''}, margin {margin:.0%}"
    print(summary(f"course D, mit-vp, {mode}, {with_what}", flown))
    return flown


def test_a_few_seeds_of_course_d_are_flown_close_to_every_waypoint():
    for flown in figures("fast", "nominal", (), 4):
        assert flown.complete
        assert flown.miss_m < 0.15


@pytest.mark.long
@pytest.mark.parametrize("mode", ["paper", "fast"])
def test_course_d_is_flown_by_a_hundred_of_a_hundred_seeds(mode):
    flown = figures(mode, "nominal", (), 100)
    assert all(f.complete for f in flown)
    assert np.quantile([f.miss_m for f in flown], 0.95) <= 0.15


@pytest.mark.long
@pytest.mark.parametrize(("mode", "margin", "least"), [("paper", 0.1, 100), ("fast", 0.1, 90), ("fast", 0.2, 95)])
def test_course_d_in_wind_with_a_weak_rotor_is_survived(mode, margin, least):
    """A plan near the least time asks more than 85 % of each rotor for more than half of the flight if a tenth is its
    margin. One that has lost 15 % cannot give that: the vehicle falls behind by a metre, and arrives all the same."""
    asked = np.array([plan("mit-vp", mode, margin).sample()[f"f{i}_N"] for i in range(1, 5)])
    if mode == "fast":
        assert (np.mean(asked > LEFT_N) > 0.5) == (margin < 0.15)
    flown = figures(mode, "windy", WINDY_AND_WEAK, 100, margin)
    assert not any(np.isnan(f.miss_m) for f in flown)
    assert sum(f.complete for f in flown) >= least
