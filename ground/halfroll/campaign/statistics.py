"""What a campaign's runs say: success with its interval, quantiles, the worst, and whether others did better.

Why: a share of successes without an interval is an anecdote, and a difference without a level an opinion.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pyarrow as pa

QUANTILES = (0.5, 0.9, 0.95, 0.99, 1.0)
SUMMED_UP = ("tracking_rms_m", "tracking_max_m", "waypoint_miss_max_m", "rotor_saturated", "flight_s")
WORST, LISTED = 10, 10_000
CONFIDENCE = 0.95
_MEASURED = re.compile(r" [+-]?\d+(\.\d+)?( m\b)?")


def interval(succeeded: int, runs: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Clopper and Pearson's exact interval of a success rate."""
    from scipy.stats import beta

    tail = (1.0 - confidence) / 2.0
    low = 0.0 if succeeded == 0 else float(beta.ppf(tail, succeeded, runs - succeeded + 1))
    high = 1.0 if succeeded == runs else float(beta.ppf(1.0 - tail, succeeded + 1, runs - succeeded))
    return low, high


@dataclass(frozen=True)
class Failure:
    run: int
    seed: int
    why: str


@dataclass(frozen=True)
class Summary:
    """Figures of all runs. Quantiles are over runs that began the plan, failed or not."""

    runs: int
    succeeded: int
    confidence: tuple[float, float]
    quantiles: Mapping[str, Mapping[str, float]]  # figure -> quantile -> value
    failed: tuple[Failure, ...]  # the first LISTED
    reasons: tuple[tuple[str, int], ...]  # why runs failed, numbers left out, the most frequent first
    worst: tuple[tuple[int, float], ...]  # run and its largest waypoint miss, the worst first
    flight_s: float  # vehicle time of all

    @property
    def rate(self) -> float:
        return self.succeeded / self.runs if self.runs else 0.0

    def as_json(self, replay: str) -> dict[str, Any]:
        """replay: the command of one run, {run} in it."""
        return {
            "runs": self.runs,
            "succeeded": self.succeeded,
            "success": {"rate": self.rate, "low": self.confidence[0], "high": self.confidence[1], "level": CONFIDENCE},
            "failed": [vars(failure) for failure in self.failed],
            "quantiles": {name: dict(values) for name, values in self.quantiles.items()},
            "worst": [
                {"run": run, "waypoint_miss_max_m": miss, "replay": replay.format(run=run)} for run, miss in self.worst
            ],
            "flown_s": self.flight_s,
        }


def kind_of(why: str) -> str:
    """`waypoint miss 0.612 m, allowed 0.5` is a waypoint miss."""
    return " ".join(_MEASURED.sub(" ", why.split(",")[0].split(":")[0]).split())


def summary_of(runs: pa.Table) -> Summary:
    good = column(runs, "succeeded").astype(bool)
    numbers, seeds = column(runs, "run"), column(runs, "seed")
    bad = np.flatnonzero(~good)
    failed = tuple(Failure(int(numbers[i]), int(seeds[i]), runs["why"][int(i)].as_py()) for i in bad[:LISTED])
    reasons = Counter[str]()
    for counted in runs["why"].value_counts().to_pylist():
        if counted["values"]:
            reasons[kind_of(counted["values"])] += counted["counts"]
    quantiles = {}
    for name in SUMMED_UP:
        values = column(runs, name)
        values = values[np.isfinite(values)]
        if len(values):
            quantiles[name] = {f"{q:g}": float(np.quantile(values, q)) for q in QUANTILES}
    miss = column(runs, "waypoint_miss_max_m")
    order = np.argsort(np.where(good, 0.0, 1.0) * 1e6 + np.nan_to_num(miss, nan=1e3), kind="stable")[::-1][:WORST]
    return Summary(
        runs=len(good),
        succeeded=int(good.sum()),
        confidence=interval(int(good.sum()), len(good)),
        quantiles=quantiles,
        failed=failed,
        reasons=tuple(reasons.most_common()),
        worst=tuple((int(numbers[i]), float(miss[i])) for i in order),
        flight_s=float(column(runs, "flight_s").sum()),
    )


def in_words(miss_m: float) -> str:
    """A largest waypoint miss; there is none where the plan was never begun."""
    return f"{miss_m:.3f} m from a waypoint" if isfinite(miss_m) else "never came to the plan"


def column(runs: pa.Table, name: str) -> NDArray[Any]:
    return np.asarray(runs[name].to_numpy())
