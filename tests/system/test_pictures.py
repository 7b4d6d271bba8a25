"""The pictures of the docs are drawn by the code that they are about, and by every change of it."""

import subprocess
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
SCRIPTS = sorted(script.name for script in DOCS.glob("make_*_pictures.py"))


@pytest.mark.long
@pytest.mark.parametrize("script", SCRIPTS)
def test_the_pictures_of_a_page_are_drawn_under_the_names_that_it_shows(script, tmp_path):
    subprocess.run([sys.executable, DOCS / script, tmp_path], check=True, timeout=300)
    drawn = {picture.name for picture in tmp_path.glob("*.png") if picture.stat().st_size > 5000}
    assert drawn
    shown = "".join(page.read_text(encoding="utf-8") for page in DOCS.glob("*.md"))
    assert {name for name in drawn if f"pictures/{name})" in shown} == drawn
