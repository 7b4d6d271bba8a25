"""The table of budgets in docs/hil.md says what is measured."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from halfroll.boards import EMULATED
from hil.flights import Report, sizes
from hil.stack_depth import deepest_chain

PAGE = Path(__file__).parents[2] / "docs" / "hil.md"
COLUMNS = ("flash", "ram", "stack", "chain", "median", "p999", "worst")
TICK = 125000  # instructions of the emulated processor in a millisecond


def documented(board: str) -> dict[str, float]:
    row = re.search(rf"^\| {board} \|(.*)\|$", PAGE.read_text(), re.MULTILINE)
    assert row is not None
    return dict(
        zip(COLUMNS, (math.nan if cell.strip() == "–" else float(cell) for cell in row[1].split("|")), strict=True)
    )


@pytest.mark.parametrize("board", ["qemu-m4", pytest.param("qemu-m7", marks=pytest.mark.long)])
def test_flash_and_ram_are_those_of_the_table(board: str) -> None:
    table, image = documented(board), sizes(board)
    assert image["flash_bytes"] / 1024 == pytest.approx(table["flash"], rel=0.1)
    assert image["ram_bytes"] / 1024 == pytest.approx(table["ram"], rel=0.1)


def test_a_step_takes_what_the_table_says(short_flip: Report) -> None:
    table, measured = documented("qemu-m4"), short_flip.figures
    assert measured["median_instructions"] == pytest.approx(table["median"], rel=0.25)
    assert measured["p999_instructions"] <= 1.1 * table["p999"]
    assert measured["worst_instructions"] <= 1.1 * table["worst"]


def test_the_stack_never_comes_near_its_end(short_flip: Report) -> None:
    used = short_flip.figures["stack_bytes"]
    assert 0 < used <= 1.1 * documented("qemu-m4")["stack"]
    deepest, chain = deepest_chain(EMULATED["qemu-m4"].image.parent)
    assert deepest == pytest.approx(documented("qemu-m4")["chain"], rel=0.25), chain
    assert used + deepest < sizes("qemu-m4")["stack_reserved_bytes"]


def test_every_step_ends_within_its_millisecond(short_flip: Report) -> None:
    assert short_flip.figures["worst_instructions"] < TICK
    assert short_flip.figures["late_steps"] == 0
