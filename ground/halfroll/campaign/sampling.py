"""Sampling: the numbers of run i, from (space, seed, i) alone.

Why: whoever flies a run, wherever, whenever again, flies the same. Blocks of runs are drawn at once because a point of
a low-discrepancy sequence costs little beside its neighbours and much alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import groupby
from math import prod
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfroll.campaign.space import MOST_RUNS, SpaceError

if TYPE_CHECKING:
    from halfroll.campaign.axes import Value
    from halfroll.campaign.space import Space

Shares = NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    index: int
    seed: int  # of everything random in its flight
    values: dict[str, Value] = field(default_factory=dict)


def runs_of(space: Space, start: int, count: int) -> list[Run]:
    """Runs start, start + 1, ... Raises SpaceError beyond the last of them."""
    if start + count > MOST_RUNS:
        raise SpaceError(f"run {start + count - 1} is beyond the last that a campaign can have, {MOST_RUNS - 1}")
    shares = _shares(space, start, count)
    columns = [axis.values(shares[:, i]) for i, axis in enumerate(space.axes.values())]
    rows = zip(*columns, strict=True) if columns else [()] * count
    return [
        Run(index, _seed(space, index), dict(zip(space.axes, row, strict=True)))
        for index, row in enumerate(rows, start=start)
    ]


def blocks(space: Space, indices: Iterable[int], size: int) -> Iterator[list[Run]]:
    """The runs with these indices, rising, in blocks of neighbours."""
    for _, group in groupby(indices, lambda index: index // size):
        wanted = list(group)
        drawn = runs_of(space, wanted[0], wanted[-1] - wanted[0] + 1)
        yield [drawn[index - wanted[0]] for index in wanted]


def saltelli_row(space: Space, index: int) -> tuple[int, int]:
    """Of a run of sampling saltelli: its base sample, and which of A, B, AB_0, AB_1, ... it is."""
    return divmod(index, len(space.axes) + 2)


def grid_size(space: Space) -> int:
    return prod(len(axis.levels or ()) for axis in space.axes.values())


def _seed(space: Space, index: int) -> int:
    """One for each run; of one base sample all runs share theirs, lest noise look like sensitivity."""
    if space.told.sampling == "saltelli":
        index = saltelli_row(space, index)[0]
    drawn = np.random.SeedSequence([space.told.seed, index]).generate_state(1, np.uint64)[0]
    return int(drawn >> np.uint64(11))  # below 2^53: exact wherever numbers are doubles


def _shares(space: Space, start: int, count: int) -> Shares:
    """(count, axes) between 0 and 1."""
    size, told = len(space.axes), space.told
    if size == 0:
        return np.zeros((count, 0))
    if told.sampling == "random":
        rows = [np.random.default_rng([told.seed, 1, index]).random(size) for index in range(start, start + count)]
        return np.array(rows)
    if told.sampling == "lhs":
        if start + count > told.runs:
            raise SpaceError(
                f"run {start + count - 1} of {told.runs}: a latin hypercube has as many runs as it was made for"
            )
        return _latin(size, told.runs, told.seed)[start : start + count]
    if told.sampling == "grid":
        return _grid(space, start, count)
    if told.sampling == "saltelli":
        return _saltelli(space, start, count)
    return _sobol(size, told.seed, start, count)


def _sobol(size: int, seed: int, start: int, count: int) -> Shares:
    from scipy.stats import qmc

    sequence = qmc.Sobol(size, scramble=True, rng=np.random.default_rng(seed))
    if start > 0:
        sequence.fast_forward(start)
    first = sequence.random(1)  # alone: of a first block SciPy wants a power of two, and warns
    return np.vstack([first, sequence.random(count - 1)]) if count > 1 else np.asarray(first)


@lru_cache(2)
def _latin(size: int, runs: int, seed: int) -> Shares:
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(size, rng=np.random.default_rng(seed)).random(runs))


def _grid(space: Space, start: int, count: int) -> Shares:
    """Every combination, the last axis fastest; beyond them all again, with other seeds."""
    sizes = [len(axis.levels or ()) for axis in space.axes.values()]
    places = np.unravel_index(np.arange(start, start + count) % grid_size(space), sizes)
    return np.stack([(place + 0.5) / size for place, size in zip(places, sizes, strict=True)], axis=1)


def _saltelli(space: Space, start: int, count: int) -> Shares:
    """Base sample n is row n of a Sobol sequence of twice the axes, A beside B; AB_i is A with axis i from B."""
    size = len(space.axes)
    first, last = saltelli_row(space, start)[0], saltelli_row(space, start + count - 1)[0]
    base = _sobol(2 * size, space.told.seed, first, last - first + 1)
    rows = np.empty((count, size))
    for row in range(count):
        sample, which = saltelli_row(space, start + row)
        a, b = np.split(base[sample - first], 2)
        rows[row] = b if which == 1 else a
        if which >= 2:
            rows[row, which - 2] = b[which - 2]
    return rows
