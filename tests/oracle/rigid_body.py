"""A rigid body driven open loop by four rotor thrusts, integrated by SciPy to near rounding.

Why: the independent judge of the inverse dynamics: thrusts that are right reproduce the path with no feedback at all.
"""

import itertools

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY = 9.81


def rotation(q):
    """Body to world, from a Hamilton quaternion [w, x, y, z]."""
    w, v = q[0], q[1:]
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * cross


def fly_open_loop(thrusts_at, breaks, start, *, mass, inertia, arm, yaw_coefficient, rtol=1e-12):
    """Positions (K, 3) and quaternions (K, 4) at the break times (K,).

    thrusts_at(t) -> (4,): rotors left, back, right, front; smooth between the breaks, where integration restarts.
    start: position, velocity, quaternion, body rate as one array of 13.
    """
    inertia = np.asarray(inertia)

    def slope(t, state):
        q, w = state[6:10], state[10:]
        f1, f2, f3, f4 = thrusts_at(t)
        torque = np.array([arm * (f1 - f3), arm * (f2 - f4), yaw_coefficient * (-f1 + f2 - f3 + f4)])
        force = rotation(q / np.linalg.norm(q))[:, 2] * (f1 + f2 + f3 + f4)
        dq = 0.5 * np.array(
            [
                -q[1] * w[0] - q[2] * w[1] - q[3] * w[2],
                q[0] * w[0] + q[2] * w[2] - q[3] * w[1],
                q[0] * w[1] + q[3] * w[0] - q[1] * w[2],
                q[0] * w[2] + q[1] * w[1] - q[2] * w[0],
            ]
        )
        dw = (torque - np.cross(w, inertia * w)) / inertia
        return np.concatenate([state[3:6], force / mass - [0, 0, GRAVITY], dq, dw])

    states = [np.asarray(start, dtype=float)]
    for begin, end in itertools.pairwise(breaks):
        run = solve_ivp(slope, (begin, end), states[-1], method="DOP853", rtol=rtol, atol=0.1 * rtol)
        assert run.success, run.message
        states.append(run.y[:, -1])
    states = np.array(states)
    return states[:, :3], states[:, 6:10]
