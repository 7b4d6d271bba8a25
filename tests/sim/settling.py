"""The attitude loop from ten thousand random attitudes and rates, for the test and for the picture in docs/world.md."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfroll import _firmware

SETTLED_RAD = np.radians(2.0)
RATE_MOST = 10.0  # rad/s


def settling_times(runs: int, vehicle: str = "mit-vp", seconds: float = 2.0, seed: int = 7) -> NDArray[np.float64]:
    """(runs,) time after which the attitude error stays below 2 degrees [s], NaN where it never does. Rotors with their
    lags and limits; attitudes uniform over all, rates uniform in the ball of 10 rad/s, no thrust wanted."""
    setup = _firmware.vehicle_setup(vehicle)
    world = _firmware.World(setup.plant, "ideal", 0)
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(runs, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    w = rng.normal(size=(runs, 3))
    w *= (RATE_MOST * rng.uniform(size=(runs, 1)) ** (1 / 3)) / np.linalg.norm(w, axis=1, keepdims=True)
    thrust = 4.0 * max(setup.plant.thrust_min, 0.0)
    times = np.full(runs, np.nan)
    steps = round(1000 * seconds)
    for i in range(runs):
        world.place([0.0, 0.0, 1000.0], [0.0, 0.0, 0.0], q[i], w[i], [thrust / 4.0] * 4)
        truth = world.turn_to([1.0, 0.0, 0.0, 0.0], thrust, setup.vehicle, setup.params, steps)
        half = np.linalg.norm(truth[:, 7:10], axis=1)  # of sin(angle / 2), to the identity
        off = np.flatnonzero(2.0 * np.arcsin(np.minimum(half, 1.0)) > SETTLED_RAD)
        last = off[-1] + 1 if len(off) else 0
        if last < steps:
            times[i] = 1e-3 * (last + 1)
    return times
