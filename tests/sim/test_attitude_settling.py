"""From any attitude and any rate the attitude loop finds its reference."""

import numpy as np
from settling import settling_times


def test_the_attitude_loop_converges_from_ten_thousand_random_attitudes_and_rates():
    times = settling_times(10_000)
    counts, edges = np.histogram(times, bins=np.arange(0.0, 1.05, 0.1))
    print(
        f"settled to 2 deg: {np.isfinite(times).sum()} of {len(times)}, median {np.median(times):.3f} s, "
        f"95 % {np.quantile(times, 0.95):.3f} s, worst {times.max():.3f} s"
    )
    for low, high, count in zip(edges, edges[1:], counts, strict=False):
        print(f"{low:.1f} to {high:.1f} s {count:6d}")
    assert np.isfinite(times).all()
    assert np.median(times) < 0.6
