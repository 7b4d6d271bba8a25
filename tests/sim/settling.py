"""The attitude loop from ten thousand random attitudes and rates, for the test and for the picture in docs/world.md."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfroll import _firmware

SETTLED_RAD = np.radians(2.0)
RATE_MOST = 10.0  # rad/s


PIECE_MS, CALM_MS, LONGEST_S = 1000, 400, 10


def settling_times(runs: int, vehicle: str = "mit-vp", seed: int = 7) -> NDArray[np.float64]:
    """(runs,) time after which the attitude error stays below 2 degrees [s], NaN where it does not within 10 s. Rotors
    with their lags and limits; attitudes uniform over all, rates uniform in the ball of 10 rad/s; no thrust wanted of
    rotors that push both ways, the weight of others."""
    setup = _firmware.vehicle_setup(vehicle)
    world = _firmware.World(setup.plant, "ideal", 0)
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(runs, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    w = rng.normal(size=(runs, 3))
    w *= (RATE_MOST * rng.uniform(size=(runs, 1)) ** (1 / 3)) / np.linalg.norm(w, axis=1, keepdims=True)
    push_both_ways = setup.plant.thrust_min < 0.0
    thrust = 0.0 if push_both_ways else setup.plant.mass * setup.plant.gravity  # one-way rotors need some to turn with
    times = np.full(runs, np.nan)
    for i in range(runs):
        world.place([0.0, 0.0, 1000.0], [0.0, 0.0, 0.0], q[i], w[i], [thrust / 4.0] * 4)
        last = 0
        for piece in range(LONGEST_S):
            truth = world.turn_to([1.0, 0.0, 0.0, 0.0], thrust, setup.vehicle, setup.params, PIECE_MS)
            half = np.linalg.norm(truth[:, 7:10], axis=1)  # sine of half the angle to the identity
            off = np.flatnonzero(2.0 * np.arcsin(np.minimum(half, 1.0)) > SETTLED_RAD)
            if len(off):
                last = piece * PIECE_MS + int(off[-1]) + 1
            if last <= (piece + 1) * PIECE_MS - CALM_MS and np.linalg.norm(truth[-1, 10:]) < SETTLED_RAD:
                times[i] = 1e-3 * last
                break
    return times
