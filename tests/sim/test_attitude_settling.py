"""From any attitude and any rate the attitude loop finds its reference."""

import numpy as np
import pytest
from settling import settling_times


def converges(runs, vehicle):
    times = settling_times(runs, vehicle)
    print(
        f"{vehicle}, settled to 2 deg: {np.isfinite(times).sum()} of {runs}, median {np.median(times):.3f} s, "
        f"95 % {np.quantile(times, 0.95):.3f} s, worst {times.max():.3f} s"
    )
    counts, edges = np.histogram(times, bins=np.arange(0.0, 4.05, 0.2))
    for low, high, count in zip(edges, edges[1:], counts, strict=False):
        print(f"{low:.1f} to {high:.1f} s {count:6d}")
    assert np.isfinite(times).all()


def test_the_attitude_loop_converges_from_random_attitudes_and_rates():
    converges(500, "mit-vp")


@pytest.mark.long
@pytest.mark.parametrize("vehicle", ["mit-vp", "race-5in"])
def test_the_attitude_loop_converges_from_ten_thousand_random_attitudes_and_rates(vehicle):
    converges(10_000, vehicle)
