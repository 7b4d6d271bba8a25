"""The body's axes in the world. Why: planner, pictures and flights all ask where an attitude points the thrust."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def body_up(q_WB: ArrayLike) -> NDArray[np.float64]:
    """(.., 3) the body's z in W, of attitudes (.., 4) [w, x, y, z]."""
    w, x, y, z = np.moveaxis(np.asarray(q_WB, dtype=np.float64), -1, 0)
    return np.stack([2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)], axis=-1)


def turned(q_WB: ArrayLike, v_B: ArrayLike) -> NDArray[np.float64]:
    """(3,) in W, of a vector (3,) in B and the attitude (4,)."""
    q, v = np.asarray(q_WB, dtype=np.float64), np.asarray(v_B, dtype=np.float64)
    twice = 2.0 * np.cross(q[1:], v)
    return np.asarray(v + q[0] * twice + np.cross(q[1:], twice))
