"""docs/robustness.md says what was flown, and what was flown is what this code flies."""

import importlib.util
import json
import sys
from pathlib import Path

import pytest

from halfroll.campaign.flights import fly_run
from halfroll.campaign.sampling import runs_of

DOCS = Path(__file__).parents[2] / "docs"
spec = importlib.util.spec_from_file_location("make_robustness_pictures", DOCS / "make_robustness_pictures.py")
study = sys.modules.setdefault(spec.name, importlib.util.module_from_spec(spec))  # dataclasses look there
spec.loader.exec_module(study)
FLOWN = json.loads(study.FLOWN.read_text())
CELLS = list(study.cells())


def test_the_tables_of_the_page_are_those_of_the_flights():
    page = study.PAGE.read_text()
    assert study.with_tables(page, FLOWN) == page
    assert set(FLOWN) == {cell.name for cell in CELLS}
    assert all(text in page for text in study.tables(FLOWN).values())


@pytest.mark.parametrize("who", study.CONTENDERS, ids=lambda who: who.name)
def test_one_run_of_each_cell_comes_out_as_the_page_counts_it(who):
    """The runs differ from cell to cell; where one comes out otherwise, `make_robustness_pictures.py --fly` is due."""
    for i, cell in enumerate(CELLS):
        if cell.contender == who:
            chosen, index = study.prepared(cell), 37 * i % study.RUNS
            row = fly_run(chosen, *runs_of(chosen.space, index, 1))
            assert row["T_planned_s"] == pytest.approx(FLOWN[cell.name]["T_s"], abs=0.002)
            assert row["succeeded"] != (index in FLOWN[cell.name]["failed"]), f"{cell.name}: run {index}, {row['why']}"
