"""An error-state Kalman filter in double that waits for its poses, with Jacobians by finite differences.

Why: the judge of the firmware's estimator. It lives at the time of the latest pose and runs the inertial samples since
again for every answer, so it makes none of the firmware's shortcuts for late measurements; nothing is derived by hand.
"""

from __future__ import annotations

import itertools

import numpy as np
from scipy.spatial.transform import Rotation

GRAVITY = np.array([0.0, 0.0, 9.81])
STEP = 1e-3


class Motion:
    """A batch of motions: attitudes (n), velocities (n, 3), positions (n, 3), biases (n, 3)."""

    def __init__(self, attitude: Rotation, v, p, gyro_bias, accelerometer_bias) -> None:
        self.attitude, self.v, self.p = attitude, v, p
        self.gyro_bias, self.accelerometer_bias = gyro_bias, accelerometer_bias

    @classmethod
    def at_rest(cls, attitude: Rotation, p) -> Motion:
        zero = np.zeros((1, 3))
        return cls(Rotation.concatenate([attitude]), zero, np.array([p], dtype=float), zero, zero)

    def off_by(self, errors) -> Motion:
        """Motions whose errors against this one are the rows (n, 15): attitude in world axes, the rest added."""
        e = np.atleast_2d(errors)
        return Motion(
            Rotation.from_rotvec(e[:, :3]) * self.attitude,
            self.v + e[:, 3:6],
            self.p + e[:, 6:9],
            self.gyro_bias + e[:, 9:12],
            self.accelerometer_bias + e[:, 12:15],
        )

    def errors_against(self, other: Motion):
        """(n, 15), the inverse of off_by."""
        n = len(self.v)
        return np.column_stack(
            [
                (self.attitude * other.attitude.inv()).as_rotvec(),
                self.v - other.v,
                self.p - other.p,
                np.broadcast_to(self.gyro_bias - other.gyro_bias, (n, 3)),
                np.broadcast_to(self.accelerometer_bias - other.accelerometer_bias, (n, 3)),
            ]
        )

    def later(self, imu, step: float = STEP) -> Motion:
        """imu (m + 1, 6): rates and specific forces at the ends of m steps."""
        attitude, v, p = self.attitude, self.v, self.p
        for before, after in itertools.pairwise(imu):
            w = 0.5 * (before[:3] + after[:3]) - self.gyro_bias
            turned = attitude * Rotation.from_rotvec(w * step)
            f0 = attitude.apply(before[3:] - self.accelerometer_bias)
            f1 = turned.apply(after[3:] - self.accelerometer_bias)
            a = 0.5 * (f0 + f1) - GRAVITY
            attitude, v, p = turned, v + a * step, p + v * step + 0.5 * a * step**2
        return Motion(attitude, v, p, self.gyro_bias, self.accelerometer_bias)


class WaitingFilter:
    """noise: gyro and accelerometer per sample, their walks per root second (the firmware's EST_ parameters)."""

    def __init__(self, motion: Motion, covariance, noise: dict[str, float]) -> None:
        self.motion, self.covariance, self._noise = motion, np.array(covariance), noise

    def predicted(self, imu) -> tuple[Motion, np.ndarray]:
        """Motion and covariance after the samples."""
        h = 1e-4
        off = np.vstack([np.zeros(15), h * np.eye(15), -h * np.eye(15)])
        ends = self.motion.off_by(off).later(imu)
        middle = Motion(
            ends.attitude[:1], ends.v[:1], ends.p[:1], self.motion.gyro_bias, self.motion.accelerometer_bias
        )
        errors = ends.errors_against(middle)
        phi = ((errors[1:16] - errors[16:]) / (2.0 * h)).T
        seconds = (len(imu) - 1) * STEP
        rate = np.zeros(15)
        rate[0:3] = self._noise["gyro"] ** 2 * STEP
        rate[3:6] = self._noise["accelerometer"] ** 2 * STEP
        rate[9:12], rate[12:15] = self._noise["gyro_walk"] ** 2, self._noise["accelerometer_walk"] ** 2
        spread = np.diag(rate * seconds)
        # Half of it from the beginning on, half from the end: the trapezoid of the integral of Phi Q Phi^T.
        return middle, phi @ (self.covariance + 0.5 * spread) @ phi.T + 0.5 * spread

    def see(self, imu, attitude: Rotation, p, attitude_deviation: float, position_deviation: float) -> None:
        """To the end of the samples, where a pose was taken; then the pose."""
        if len(imu) > 1:
            self.motion, self.covariance = self.predicted(imu)
        h = np.zeros((6, 15))
        h[:3, :3], h[3:, 6:9] = np.eye(3), np.eye(3)
        innovation = np.concatenate([(attitude * self.motion.attitude[0].inv()).as_rotvec(), p - self.motion.p[0]])
        r = np.diag([attitude_deviation**2] * 3 + [position_deviation**2] * 3)
        gain = np.linalg.solve(h @ self.covariance @ h.T + r, h @ self.covariance).T
        keep = np.eye(15) - gain @ h
        self.motion = self.motion.off_by(gain @ innovation)
        self.covariance = keep @ self.covariance @ keep.T + gain @ r @ gain.T
