"""The parameter table, as the firmware carries it."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from halfroll import _firmware

DOCS = Path(__file__).parents[2] / "docs"


def test_the_page_of_parameters_is_what_the_firmware_carries() -> None:
    made = runpy.run_path(str(DOCS / "make_parameters.py"))["text"]()
    assert (DOCS / "parameters.md").read_text() == made


def test_parameters_are_read_and_set_by_name_and_inside_their_range() -> None:
    params = _firmware.Params()
    params["ATT_WN"] = 12.5
    assert params["ATT_WN"] == 12.5
    with pytest.raises(ValueError, match="ATT_WN must be between"):
        params["ATT_WN"] = 1000.0
    with pytest.raises(KeyError, match="NO_SUCH"):
        params["NO_SUCH"]
