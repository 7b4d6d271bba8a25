"""Two campaigns side by side: did anything get significantly worse?

Why: a regression gate that cries at noise is switched off, and one that does not say its level means nothing. All tests
together err, where nothing has changed, with a probability of at most LEVEL (Holm).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfroll.campaign.statistics import column
from halfroll.errors import InputError

if TYPE_CHECKING:
    import pyarrow as pa

LEVEL = 0.01
COMPARED = tuple(
    (name, q)
    for name in ("tracking_rms_m", "tracking_max_m", "waypoint_miss_max_m", "rotor_saturated")
    for q in (0.5, 0.95)
)
_RESAMPLED = 2000
_WORTH_TELLING = 1e-6  # relative: below, a difference is arithmetic


@dataclass(frozen=True)
class Difference:
    what: str
    before: float
    now: float
    p: float  # probability of so bad a change where there is none
    worse: bool

    def __str__(self) -> str:
        mark = "worse" if self.worse else "as good"
        return f"{self.what}: {self.before:.4g} before, {self.now:.4g} now (p = {self.p:.2g}), {mark}"


def compared(before: pa.Table, now: pa.Table, level: float = LEVEL) -> tuple[Difference, ...]:
    """Success by Fisher's exact test, quantiles by the bootstrap, one-sided. Raises InputError where a column is not
    there."""
    from scipy.stats import fisher_exact

    for name in ("succeeded", *(name for name, _ in COMPARED)):
        for table in (before, now):
            if name not in table.column_names:
                raise InputError(f"{name} is not a column of both campaigns; was one made by another version?")
    was, is_now = column(before, "succeeded").astype(bool), column(now, "succeeded").astype(bool)
    counts = [[int(is_now.sum()), int((~is_now).sum())], [int(was.sum()), int((~was).sum())]]
    found = [("success", float(was.mean()), float(is_now.mean()), float(fisher_exact(counts, "less").pvalue))]
    rng = np.random.default_rng(0)
    for name, q in COMPARED:
        old, new = (values[np.isfinite(values)] for values in (column(before, name), column(now, name)))
        if len(old) and len(new):
            a, b = float(np.quantile(old, q)), float(np.quantile(new, q))
            found.append((f"{name} {100 * q:g} %", a, b, _p_worse(old, new, q, rng)))
    limits = _holm([p for *_, p in found], level)
    return tuple(
        Difference(what, a, b, p, worse=rejected) for (what, a, b, p), rejected in zip(found, limits, strict=True)
    )


def _p_worse(old: NDArray[np.float64], new: NDArray[np.float64], q: float, rng: np.random.Generator) -> float:
    """That the quantile grew by no more than chance: bootstrap of the difference, Efron's percentile."""
    if np.quantile(new, q) <= np.quantile(old, q) * (1.0 + _WORTH_TELLING):
        return 1.0
    grown = _resampled(new, q, rng) - _resampled(old, q, rng)
    return float((1 + np.count_nonzero(grown <= 0.0)) / (1 + _RESAMPLED))


def _resampled(values: NDArray[np.float64], q: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """The quantile of resamples. The order statistic of a uniform resample is beta distributed: no sample is drawn."""
    ordered, n = np.sort(values), len(values)
    rank = q * (n - 1) + 1.0
    place = rng.beta(rank, n - rank + 1.0, _RESAMPLED) * n - 0.5
    return np.interp(place, np.arange(n), ordered)


def _holm(p: list[float], level: float) -> list[bool]:
    order, rejected = np.argsort(p), [False] * len(p)
    for rank, i in enumerate(order):
        if p[i] > level / (len(p) - rank):
            break
        rejected[int(i)] = True
    return rejected
