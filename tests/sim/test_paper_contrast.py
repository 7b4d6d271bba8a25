"""The world's rotors give the contrast of the paper's Fig 6: variable pitch stops where it should, fixed pitch shoots
over. Flown over the 100 Hz split with nominal noise."""

import numpy as np
import pytest
from streamed import StreamedFlight

from halfroll.planner import segments
from halfroll.station.references import Path

DURATION_S = 0.7826
NODE_TIMES_S = np.array([0.0, 0.2993, 0.5199, 0.6666]) * DURATION_S / 0.6666  # docs/paper.md, Fig 5's optimum stretched
HEIGHTS_M = (0.0, 0.25, 0.90, 1.0)


def one_metre_up(start_m):
    """Fig 6's path, with a second of hover before it and three after."""
    nodes = [segments.rest([0.0, 0.0, start_m, 0.0])]
    nodes += [segments.node([0.0, 0.0, start_m + z, 0.0]) for z in HEIGHTS_M[1:-1]]
    nodes += [segments.rest([0.0, 0.0, start_m + 1.0, 0.0])]
    path = segments.solve(nodes, list(np.diff(NODE_TIMES_S)))
    moving = path.derivatives(np.arange(0.0, DURATION_S, 0.001), 5)
    before, after = np.zeros((1000, 5, 4)), np.zeros((3000, 5, 4))
    before[:, 0, 2], after[:, 0, 2] = start_m, start_m + 1.0
    table = np.concatenate([before, moving, after])
    return Path(table, np.zeros((len(table), 3)))


def overshoot(vehicle, seed, settings=()):
    flight = StreamedFlight(vehicle, "nominal", seed=seed, vehicle_settings=settings)
    flight.take_off(1.0)
    _, positions = flight.follow(one_metre_up(1.0), 4.5)
    return positions[:, 2].max() - 2.0


def test_variable_pitch_overshoots_by_a_per_cent_and_fixed_pitch_by_tens():
    vp = [overshoot("mit-vp", seed) for seed in range(4)]
    fp = [overshoot("mit-fp", seed, ["params.ACT_LEAD=0"]) for seed in range(4)]
    print(f"overshoot of 1 m: variable pitch {max(vp):.3f} m at most, fixed pitch {np.median(fp):.3f} m (median of 4)")
    assert max(vp) < 0.02
    assert 0.45 < np.median(fp) < 0.70
    assert np.median(fp) / max(np.median(vp), 1e-3) > 5.0


@pytest.mark.parametrize(("lag_down", "least", "most"), [("0.14", 0.5, 0.75), ("0.25", 0.8, 1.4)])
def test_a_rotor_that_coasts_longer_overshoots_more(lag_down, least, most):
    found = overshoot("mit-fp", 1, ["params.ACT_LEAD=0", f"rotor.lag_down_s={lag_down}"])
    assert least < found < most
