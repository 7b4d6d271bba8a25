"""The page of the MAVLink contract is what the firmware does."""

from __future__ import annotations

import runpy
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def test_the_page_of_mavlink_is_what_the_firmware_carries() -> None:
    """If not: python docs/make_mavlink.py."""
    made = runpy.run_path(str(DOCS / "make_mavlink.py"))["text"]()
    assert (DOCS / "mavlink.md").read_text() == made
