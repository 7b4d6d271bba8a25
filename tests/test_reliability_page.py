"""docs/reliability.md is what the committed figures say, and a run that shows less is told from one that does not."""

from __future__ import annotations

import runpy
from dataclasses import replace
from pathlib import Path

from figures import Row, read_rows, write_rows

DOCS = Path(__file__).parents[1] / "docs"
MADE = runpy.run_path(str(DOCS / "make_reliability.py"))
LONG, QUICK = Row("Links", "missions complete", 9, 9, long=True), Row("Disks", "nothing lost", 3, 3, long=False)
PAGE = {row.key: row for row in (LONG, QUICK)}


def shortfalls(*shown: Row) -> list[str]:
    found: list[str] = MADE["shortfalls"]({row.key: row for row in shown}, PAGE)
    return found


def test_the_page_is_what_its_figures_say() -> None:
    """If not: make reliability."""
    assert (DOCS / "reliability.md").read_text(encoding="utf-8") == MADE["text"](read_rows(DOCS / "reliability.json"))


def test_a_run_that_shows_as_much_or_more_is_good() -> None:
    assert shortfalls(LONG, QUICK) == []
    assert shortfalls(replace(LONG, held=12, of=12), QUICK) == []


def test_a_quick_run_is_not_asked_for_what_takes_long() -> None:
    assert shortfalls(QUICK) == []


def test_a_case_that_does_not_hold_is_told() -> None:
    assert shortfalls(replace(LONG, held=8), QUICK) == ["Links / missions complete: 8 of 9 held, the page says 9 of 9"]


def test_fewer_cases_and_claims_that_were_not_made_are_told() -> None:
    assert len(shortfalls(replace(LONG, held=5, of=5), QUICK)) == 1
    assert shortfalls(LONG) == []  # nothing quick was run
    assert shortfalls(LONG, QUICK, Row("Links", "another", 1, 1, long=True)) == ["Links / another: not on the page"]
    assert shortfalls(replace(QUICK, claim="other"), LONG) == [
        "Disks / nothing lost: not shown",
        "Disks / other: not on the page",
    ]


def test_rows_come_back_as_they_were_written(tmp_path: Path) -> None:
    rows = {LONG.key: replace(LONG, outcomes={"complete": 7, "failsafe": 2}), QUICK.key: QUICK}
    write_rows(tmp_path / "rows.json", rows)
    assert read_rows(tmp_path / "rows.json") == rows


def test_cases_of_one_claim_add_up() -> None:
    assert replace(LONG, outcomes={"a": 1}) + replace(LONG, held=0, of=1, outcomes={"a": 1, "b": 1}) == replace(
        LONG, held=9, of=10, outcomes={"a": 2, "b": 1}
    )
