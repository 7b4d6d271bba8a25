"""Which of the numbers that vary matters.

Why: a campaign says that something breaks; this says what to look at. Where the sampling was made for it (saltelli),
Sobol's indices; else a smooth model of what was flown, and how much worse it guesses when one column is shuffled.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from halfroll.campaign.sampling import saltelli_row
from halfroll.campaign.statistics import column

if TYPE_CHECKING:
    import pyarrow as pa

    from halfroll.campaign.space import Space

Array = NDArray[np.float64]
OUTPUTS = ("tracking_rms_m", "waypoint_miss_max_m", "rotor_saturated")
_LEAST_RUNS = 50
_SHUFFLES = 10


@dataclass(frozen=True)
class Sensitivity:
    """Of one figure. shares: of its variance, by axis; first: without the axis' interactions (Sobol only).
    explained: share of the variance, in runs it has not seen, that the model explains (permutation only)."""

    output: str
    method: Literal["sobol", "permutation"]
    shares: dict[str, float]
    first: dict[str, float] | None = None
    explained: float | None = None


def sensitivities(space: Space, runs: pa.Table) -> tuple[Sensitivity, ...]:
    """For each output; none where fewer than 50 runs or no numeric axis tell anything."""
    axes = [key for key, axis in space.axes.items() if axis.is_numeric]
    if not axes or runs.num_rows < _LEAST_RUNS:
        return ()
    found = []
    for output in OUTPUTS:
        y = column(runs, output)
        if np.nanstd(y) > 0.0:
            found.append(_sobol(space, runs, output) or _permutation(runs, axes, output))
    return tuple(each for each in found if each)


def _sobol(space: Space, runs: pa.Table, output: str) -> Sensitivity | None:
    """From the complete base samples, a power of two of them."""
    if space.told.sampling != "saltelli":
        return None
    from scipy.stats import sobol_indices

    width = len(space.axes) + 2
    y, numbers = column(runs, output), column(runs, "run")
    whole = int(saltelli_row(space, len(numbers))[0])
    if whole < 8 or not np.array_equal(numbers, np.arange(len(numbers))):
        return None
    count = 1 << (whole.bit_length() - 1)
    table = y[: count * width].reshape(count, width)
    table = np.where(np.isfinite(table), table, np.nanmax(table))  # what was never begun counts as the worst
    evaluations = {"f_A": table[:, :1].T, "f_B": table[:, 1:2].T, "f_AB": table[:, 2:].T[:, None, :]}
    indices = sobol_indices(func=evaluations, n=count)
    first, total = np.ravel(indices.first_order), np.ravel(indices.total_order)
    keys = list(space.axes)
    return Sensitivity(
        output,
        "sobol",
        dict(zip(keys, map(float, total), strict=True)),
        dict(zip(keys, map(float, first), strict=True)),
    )


def _permutation(runs: pa.Table, axes: list[str], output: str) -> Sensitivity | None:
    x, y = np.stack([column(runs, key) for key in axes], axis=1).astype(np.float64), column(runs, output)
    known = np.isfinite(y)
    x, y = x[known], y[known]
    spread = x.std(axis=0)
    if len(y) < max(_LEAST_RUNS, 3 * len(axes)) or y.std() == 0.0:
        return None
    x = (x - x.mean(axis=0)) / np.where(spread > 0.0, spread, 1.0)
    train = np.arange(len(y)) % 4 != 0
    model = _fitted(x[train], y[train])
    seen, truth = x[~train], y[~train]
    variance = float(np.mean((truth - truth.mean()) ** 2)) or 1.0
    residual = float(np.mean((truth - model(seen)) ** 2))
    rng = np.random.default_rng(0)
    shares = {}
    for i, key in enumerate(axes):
        worse = 0.0
        for _ in range(_SHUFFLES):
            shuffled = seen.copy()
            shuffled[:, i] = rng.permutation(shuffled[:, i])
            worse += float(np.mean((truth - model(shuffled)) ** 2)) - residual
        shares[key] = max(worse / _SHUFFLES / variance / 2.0, 0.0)  # a shuffled column costs twice its variance
    return Sensitivity(output, "permutation", shares, explained=1.0 - residual / variance)


def _fitted(x: Array, y: Array) -> Callable[[Array], Array]:
    """A quadratic in all axes by ridge regression."""
    basis = _quadratic(x)
    penalty = 1e-3 * len(y) * np.eye(basis.shape[1])
    penalty[0, 0] = 0.0
    weights = np.linalg.solve(basis.T @ basis + penalty, basis.T @ y)
    return lambda z: _quadratic(z) @ weights


def _quadratic(x: Array) -> Array:
    pairs = [x[:, i] * x[:, j] for i, j in combinations_with_replacement(range(x.shape[1]), 2)]
    return np.stack([np.ones(len(x)), *x.T, *pairs], axis=1)
