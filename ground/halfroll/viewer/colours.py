"""Colours of the page. Why: after Okabe and Ito, so that nobody needs to tell red from green; and a ramp that is one of
lightness, too.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Colour = tuple[int, int, int]
Array = NDArray[np.float64]

FLOWN: Colour = (0, 114, 178)
PLANNED: Colour = (128, 128, 128)
PUSHES: Colour = (230, 159, 0)  # a rotor along body up
PULLS: Colour = (86, 180, 233)  # against it
AT_LIMIT: Colour = (213, 94, 0)
NOSE: Colour = (213, 94, 0)
BODY: Colour = (70, 78, 92)
GATE: Colour = (204, 121, 167)
SERIES = ("#0072B2", "#E69F00", "#009E73", "#CC79A7")  # of a panel
LIMIT = "#D55E00"

# viridis at five places
_RAMP = np.array([(68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37)], dtype=np.float64)


def ramp(shares: Array) -> NDArray[np.uint8]:
    """(N, 3) colours of N shares, 0 dark and 1 bright."""
    at = np.clip(shares, 0.0, 1.0) * (len(_RAMP) - 1)
    below = np.minimum(at.astype(int), len(_RAMP) - 2)
    part = (at - below)[:, None]
    return np.asarray(np.round(_RAMP[below] * (1.0 - part) + _RAMP[below + 1] * part), dtype=np.uint8)
