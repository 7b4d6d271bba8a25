"""Flying a campaign: from a space to a full archive.

Why: the only loop over runs. What is kept already is not flown; what stops it (an error, Ctrl-C, the end of the
machine) leaves an archive to go on with.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from halfroll.campaign.archive import PART_RUNS, Archive, open_archive
from halfroll.campaign.engines import Engine, Row
from halfroll.campaign.prepared import Prepared
from halfroll.campaign.statistics import interval
from halfroll.errors import InputError

_FLUSH_EVERY = 5 * PART_RUNS  # rows: what a sudden end can cost, at most, beside the parts under way


@dataclass(frozen=True)
class StopRule:
    """Enough is known: the interval of the success rate is narrower, to each side, than this."""

    half_width: float

    @classmethod
    def parsed(cls, words: str) -> StopRule:
        """From `ci<0.005`. Raises InputError."""
        found = re.fullmatch(r"\s*ci\s*<\s*(0?\.\d+)\s*", words)
        if not found or not 0.0 < float(found[1]) < 0.5:
            raise InputError(
                f"--stop-when {words}: ci<SHARE is wanted, like ci<0.005 (half the width of the 95 % interval)"
            )
        return cls(float(found[1]))

    def holds(self, succeeded: int, runs: int) -> bool:
        low, high = interval(succeeded, runs)
        return (high - low) / 2.0 < self.half_width


@dataclass(frozen=True)
class Progress:
    done: int  # runs that are kept
    flown: int  # of these, since it began or went on
    flown_s: float  # vehicle time of those


def fly_campaign(
    prepared: Prepared,
    engine: Engine,
    folder: Path,
    runs: int,
    stop: StopRule | None = None,
    progress: Callable[[Progress], None] = lambda _: None,
) -> Archive:
    """All of the first `runs` that the folder does not hold yet; fewer once `stop` holds for the complete parts in
    order, the same number whoever flies. Raises what the engine does."""
    archive = open_archive(folder, prepared.space)
    enough = _Enough(stop, archive)
    archive_runs = enough.runs or runs
    flown, flown_s = 0, 0.0
    rows: Iterator[Row] = iter(())
    try:
        if enough.runs is None:
            rows = engine.fly_runs(prepared, archive.missing(runs))
        for row in rows:
            archive.keep(row)
            flown, flown_s = flown + 1, flown_s + row["flight_s"]
            progress(Progress(archive.kept, flown, flown_s))
            if flown % _FLUSH_EVERY == 0:
                archive.flush()
            if stop and (reached := enough.after(row)) is not None:
                archive_runs = reached
                break
    finally:
        if (close := getattr(rows, "close", None)) is not None:
            close()
        archive.flush()
    if archive_runs < runs:
        archive.cut(archive_runs)
    return archive


class _Enough:
    """Watches the complete parts, in their order."""

    def __init__(self, stop: StopRule | None, archive: Archive) -> None:
        self._stop, self._part, self._succeeded = stop, 0, 0
        self._waiting: dict[int, list[bool]] = {}
        self.runs: int | None = None
        if stop:
            for table in archive.tables():
                for run, good in zip(table["run"].to_pylist(), table["succeeded"].to_pylist(), strict=True):
                    self.runs = self.runs or self._add(run, good)

    def after(self, row: Row) -> int | None:
        return self._add(row["run"], row["succeeded"])

    def _add(self, run: int, good: bool) -> int | None:
        """The number of runs that is enough, if it is now."""
        self._waiting.setdefault(run // PART_RUNS, []).append(good)
        while len(self._waiting.get(self._part, ())) == PART_RUNS:
            self._succeeded += sum(self._waiting.pop(self._part))
            self._part += 1
            if self._stop and self._stop.holds(self._succeeded, self._part * PART_RUNS):
                return self._part * PART_RUNS
        return None
