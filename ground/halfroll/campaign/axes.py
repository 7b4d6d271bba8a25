"""Axes of a scenario space: how one number varies.

Why: every sampler deals in shares between 0 and 1; an axis is the one place where a share becomes a value.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from halfroll.tables import Table

Value = float | str
Pair = tuple[float, float]
_KINDS = ("uniform", "normal", "loguniform", "choice", "grid")


class Axis(Table):
    """One of: uniform = [low, high], normal = [mean, deviation] cut at low and high, loguniform = [low, high],
    choice = [...] (each as likely), grid = [first, last, count]. times: the values multiply what they change."""

    uniform: Pair | None = None
    normal: Pair | None = None
    loguniform: Pair | None = None
    choice: Annotated[tuple[Value, ...], Field(min_length=1)] | None = None
    grid: tuple[float, float, Annotated[int, Field(ge=1, le=10_000)]] | None = None
    low: float | None = None
    high: float | None = None
    times: bool = False

    @model_validator(mode="after")
    def _is_one(self) -> Axis:
        given = [kind for kind in _KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            said = " and ".join(given) or "nothing"
            raise ValueError(f"says {said}; give one of {', '.join(_KINDS)}")
        for kind in ("uniform", "loguniform"):
            pair = getattr(self, kind)
            if pair and not pair[0] < pair[1]:
                raise ValueError(f"{kind} goes from {pair[0]:g} to {pair[1]:g}; the first is the smaller one")
        if self.loguniform and self.loguniform[0] <= 0.0:
            raise ValueError(f"loguniform begins at {self.loguniform[0]:g}; its numbers are above 0")
        if self.normal:
            if self.low is None or self.high is None or not self.low < self.high:
                raise ValueError("normal is cut off: give low and high, the first the smaller one")
            if self.normal[1] <= 0.0:
                raise ValueError(f"normal has deviation {self.normal[1]:g}; it is above 0")
        elif self.low is not None or self.high is not None:
            raise ValueError("low and high belong to normal")
        if self.times and self.choice and not all(isinstance(value, float) for value in self.choice):
            raise ValueError("times multiplies numbers, and choice has a word")
        return self

    @property
    def levels(self) -> tuple[Value, ...] | None:
        """The values of an axis that has so many."""
        if self.choice:
            return self.choice
        if self.grid:
            first, last, count = self.grid
            return tuple(float(x) for x in np.linspace(first, last, count))
        return None

    @property
    def extremes(self) -> tuple[Value, ...]:
        """What has to be valid for all between to be; of a choice, each."""
        if self.levels:
            return tuple(dict.fromkeys(self.levels)) if self.choice else (self.levels[0], self.levels[-1])
        if self.normal:
            assert self.low is not None
            assert self.high is not None
            return self.low, self.high
        pair = self.uniform or self.loguniform
        assert pair is not None
        return pair

    @property
    def is_numeric(self) -> bool:
        return all(isinstance(value, float) for value in self.extremes)

    def values(self, shares: NDArray[np.float64]) -> list[Value]:
        """The quantile at each share, 0 to 1."""
        if self.levels:
            last = len(self.levels) - 1
            return [self.levels[min(int(share * (last + 1)), last)] for share in shares]
        return [float(x) for x in self._quantiles(shares)]

    def _quantiles(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        low, high = (float(value) for value in self.extremes)
        if self.loguniform:
            return np.asarray(np.exp(np.log(low) + shares * (np.log(high) - np.log(low))))
        if self.normal:
            from scipy.special import ndtr, ndtri

            mean, deviation = self.normal
            begin, end = ndtr((low - mean) / deviation), ndtr((high - mean) / deviation)
            return np.asarray(np.clip(mean + deviation * ndtri(begin + shares * (end - begin)), low, high))
        return np.asarray(low + shares * (high - low))
