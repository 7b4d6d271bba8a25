"""What the reliability tests have shown, kept for docs/reliability.md: how many of how many cases held.

Why: a page of figures that nobody can forget to renew. A test marked `reliability(section, claim)` is one case of that
claim, held if it passes; what it records as "outcome" is counted, too, or as "outcomes", how many of each. Workers send
all with their reports, and the controller adds them up.
"""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import asdict, dataclass, field
from pathlib import Path

import pytest

FILE = Path(__file__).parents[1] / "build" / "reliability.json"
_CASE, _OUTCOME, _OUTCOMES = "reliability", "outcome", "outcomes"  # among a test's user_properties


@dataclass(frozen=True)
class Row:
    section: str
    claim: str
    held: int
    of: int
    long: bool  # by make test-long, else by make test
    outcomes: dict[str, int] = field(default_factory=dict)

    @property
    def key(self) -> tuple[str, str]:
        return self.section, self.claim

    def __add__(self, other: Row) -> Row:
        outcomes = Counter(self.outcomes) + Counter(other.outcomes)
        return Row(self.section, self.claim, self.held + other.held, self.of + other.of, self.long, dict(outcomes))


Rows = dict[tuple[str, str], Row]


def read_rows(file: Path) -> Rows:
    rows = [Row(**row) for row in json.loads(file.read_text(encoding="utf-8"))] if file.is_file() else []
    return {row.key: row for row in rows}


def write_rows(file: Path, rows: Rows) -> None:
    file.parent.mkdir(exist_ok=True)
    lines = ",\n".join(json.dumps(asdict(row), ensure_ascii=False) for row in rows.values())
    file.write_text(f"[\n{lines}\n]\n", encoding="utf-8")


class Collector:
    """A pytest plugin; every session leaves the rows that it has shown, beside those of sessions before."""

    def __init__(self) -> None:
        self._rows: Rows = {}

    def pytest_configure(self, config: pytest.Config) -> None:
        config.addinivalue_line("markers", "reliability(section, claim): a case of a row of docs/reliability.md")

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        for item in items:
            long = item.get_closest_marker("long") is not None
            mark = item.get_closest_marker(_CASE)
            item.user_properties += [] if mark is None else [(_CASE, (*mark.args, long))]

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when != "call" and report.passed:
            return
        outcomes = Counter(str(said) for name, said in report.user_properties if name == _OUTCOME)
        for name, counted in report.user_properties:
            if name == _OUTCOMES:
                outcomes.update(counted)
        for name, case in report.user_properties:
            if name == _CASE:
                section, claim, long = case
                row = Row(section, claim, int(report.passed), 1, long, dict(outcomes))
                self._rows[row.key] = self._rows[row.key] + row if row.key in self._rows else row

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if self._rows and not hasattr(session.config, "workerinput"):
            write_rows(FILE, dict(sorted((read_rows(FILE) | self._rows).items())))
