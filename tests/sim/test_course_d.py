"""Course D: a hundred of a hundred flown, close to every waypoint; what wind and a weak rotor make of it is printed."""

import numpy as np
import pytest
from course_d import WINDY_AND_WEAK, campaign, summary


def figures(mode, scenario, settings, seeds):
    flown = campaign("mit-vp", mode, scenario, settings, seeds)
    print(summary(f"course D, mit-vp, {mode}, {scenario}{', weak rotor' if settings else ''}", flown))
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
@pytest.mark.parametrize(("mode", "least"), [("paper", 100), ("fast", 70)])
def test_course_d_in_wind_with_a_weak_rotor_is_survived(mode, least):
    """A plan near the least time keeps a tenth of every rotor, less than this one has lost: it arrives late, farther
    off than half a metre where the stream ends, but flying."""
    flown = figures(mode, "windy", WINDY_AND_WEAK, 100)
    assert not any(np.isnan(f.miss_m) for f in flown)
    assert sum(f.complete for f in flown) >= least
