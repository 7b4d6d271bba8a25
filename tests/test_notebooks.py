"""The notebooks among the examples run from top to bottom, and show what they say."""

from __future__ import annotations

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

EXAMPLES = Path(__file__).parents[1] / "examples"
SHOWS = {"plan_and_look": 2, "fly_and_look": 1}  # pictures besides the flight in space


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of Jupyter's own
@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("*.ipynb")))
def test_a_notebook_runs_and_shows_cards_pictures_and_the_flight(name: str) -> None:
    notebook = nbformat.read(EXAMPLES / f"{name}.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "outputs are not kept in git"
    NotebookClient(
        notebook, timeout=300, startup_timeout=300, resources={"metadata": {"path": str(EXAMPLES)}}
    ).execute()
    shown = [
        output["data"]["text/html"]
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if "text/html" in output.get("data", {})
    ]
    assert sum('src="data:image/png' in each for each in shown) >= 1
    assert len(shown) > SHOWS[name]
    assert shown[-1].startswith("<iframe srcdoc=")
    assert "__VISER_EMBED_DATA__" in shown[-1]
