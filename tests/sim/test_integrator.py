"""The integrator against SciPy, and what the world's step costs in accuracy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from halfroll import _firmware

INERTIA = np.array([0.002, 0.004, 0.007])
RATE = np.array([3.0, 17.0, -5.0])  # rad/s, about as fast as a flip
SUBSTEP = 250e-6


def euler_equations(_, state):
    q, w = state[:4], state[4:]
    vector = q[0] * w + np.cross(q[1:], w)
    return np.concatenate([[-0.5 * q[1:] @ w], 0.5 * vector, -np.cross(w, INERTIA * w) / INERTIA])


def error_after(seconds, h):
    start = np.concatenate([[1.0, 0, 0, 0], RATE])
    exact = solve_ivp(euler_equations, (0, seconds), start, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    q, w = _firmware.free_rotation(INERTIA, [1, 0, 0, 0], RATE, h, round(seconds / h))
    return float(np.linalg.norm(q - exact[:4])), float(np.linalg.norm(w - exact[4:]))


def test_a_second_of_tumbling_agrees_with_scipy_to_the_documented_error():
    attitude, rate = error_after(1.0, SUBSTEP)
    print(f"after 1 s at 250 us: attitude {attitude:.1e}, rate {rate:.1e} rad/s")
    assert attitude < 1e-8
    assert rate < 1e-7


def test_the_order_is_four_over_a_hundredfold_range_of_steps():
    steps = np.array([10e-3, 5e-3, 2e-3, 1e-3, 5e-4])
    errors = np.array([error_after(1.0, h)[0] for h in steps])
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    print(f"order {slope:.2f}; errors {errors}")
    assert slope == pytest.approx(4.0, abs=0.15)


def test_energy_and_angular_momentum_are_kept_for_a_minute():
    q, w = _firmware.free_rotation(INERTIA, [1, 0, 0, 0], RATE, SUBSTEP, 240_000)
    energy = (w @ (INERTIA * w)) / (RATE @ (INERTIA * RATE)) - 1.0
    turned = (
        INERTIA * w + 2.0 * q[0] * np.cross(q[1:], INERTIA * w) + 2.0 * np.cross(q[1:], np.cross(q[1:], INERTIA * w))
    )
    momentum = np.linalg.norm(turned - INERTIA * RATE) / np.linalg.norm(INERTIA * RATE)
    print(f"relative change after 60 s: energy {energy:.1e}, angular momentum {momentum:.1e}")
    assert abs(energy) < 1e-9
    assert momentum < 1e-9
