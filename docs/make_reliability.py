"""Write docs/reliability.md from what the tests have shown, or with --check say where a run shows less than the page.

`make reliability` runs the tests and this. The figures are kept in docs/reliability.json.
"""

from __future__ import annotations

import json
import sys
from itertools import groupby
from pathlib import Path
from typing import Any

from figures import FILE, Row, Rows, read_rows, write_rows

DOCS = Path(__file__).parent
PAGE, FIGURES = DOCS / "reliability.md", DOCS / "reliability.json"
CAMPAIGN = DOCS.parent / "tests" / "fuzz" / "campaign.json"
HEAD = """# Reliability

Made by `make reliability` from a run of the tests; `make test-long` fails when a run shows less than this page. Each
row is a claim that was put to so many cases; where a case does not hold, its test says which and why.
"""
SECTIONS = {
    "Link faults": """\
Missions from upload to landing over links that lose up to 20 %, delay by up to 60 ms, jitter by up to 30 ms, fall
silent for up to 400 ms, reorder, repeat, spoil and throttle, both ways and for ground station and ground control
station, in vehicle time, by seed ([each fault](../tests/system/links/test_link_faults.py)).
""",
    "Ground station killed": """\
At moments drawn from the whole flight, from arming to landing. The next one knows only what the autopilot has stored;
the user continues once the rest is planned.
""",
    "Extreme values": """\
NaN, infinities, denormal and huge numbers in every field of every accepted message, each sent alone to a vehicle in
flight: the flight and the answers are those of silence, of zero or of the same message without the field, or the value
is refused aloud; the few that are numbers like any other, and the fields that mean nothing where they are, are
[listed](../tests/system/contract/test_extremes.py).
""",
    "Starved": "A full disk, a folder that takes nothing, no memory, a time of day that jumps by hours.\n",
    "Sanitizers": """\
Addresses, undefined behaviour and casts; of firmware and simulator also integers that wrap or change where that is not
[meant](../cmake/modular.txt) (Clang's sanitizers, every report ends the process); data races between vehicles that fly
in threads of one process.
""",
}
FUZZED = """
## Fuzzing

By libFuzzer, each input under address and undefined-behaviour sanitizers and checked for broken invariants after every
millisecond; what the corpus keeps is played in every run of the tests. {lines} % of the lines of link and mission code
are reached.

| | executions | processor time | crashes left |
|---|---|---|---|
"""


def text(rows: Rows) -> str:
    parts = [HEAD]
    for section, members in groupby(sorted(rows.values(), key=lambda row: _place(row)), lambda row: row.section):
        parts += [
            f"\n## {section}\n",
            f"{SECTIONS[section]}\n" if section in SECTIONS else "",
            "| | held | of |\n|---|---|---|",
        ]
        parts += [f"| {row.claim}{_outcomes(row)} | {row.held} | {row.of} |" for row in members]
    return "\n".join(part for part in parts if part) + "\n" + fuzzed(json.loads(CAMPAIGN.read_text(encoding="utf-8")))


def fuzzed(campaign: dict[str, Any]) -> str:
    section = FUZZED.format(lines=campaign["lines_reached_percent"]["all"])
    for name, row in campaign["targets"].items():
        spent = f"{row['cpu_s'] / 60:.0f} min"
        section += f"| [{name}](../tests/fuzz/{name}.cpp) | {row['executions']} | {spent} | {row['crashes']} |\n"
    return section


def _place(row: Row) -> tuple[int, str, str]:
    order = list(SECTIONS)
    return (order.index(row.section) if row.section in order else len(order), row.section, row.claim)


def _outcomes(row: Row) -> str:
    return f" ({', '.join(f'{n} {said}' for said, n in sorted(row.outcomes.items()))})" if row.outcomes else ""


def shortfalls(shown: Rows, claimed: Rows) -> list[str]:
    """What the page claims and the run did not show, of the rows that this kind of run makes; and the reverse."""
    kinds = {row.long for row in shown.values()}
    found = []
    for key, row in claimed.items():
        name, here = " / ".join(key), shown.get(key)
        if here is None and row.long in kinds:
            found.append(f"{name}: not shown")
        elif here is not None and (here.of < row.of or here.of - here.held > row.of - row.held):
            found.append(f"{name}: {here.held} of {here.of} held, the page says {row.held} of {row.of}")
    return found + [f"{' / '.join(key)}: not on the page" for key in shown if key not in claimed]


def main() -> int:
    shown = read_rows(FILE)
    if "--check" in sys.argv:
        found = shortfalls(shown, read_rows(FIGURES))
        print("\n".join(found) or f"docs/reliability.md: {len(shown)} rows shown, none shows less")
        if found:
            print("make reliability writes the page anew")
        return int(bool(found))
    write_rows(FIGURES, shown)
    PAGE.write_text(text(shown), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
