"""docs/campaigns.md: its tables are flown again in small, its commands run, its arithmetic adds up."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from halfroll.campaign.engines import DASK_BLOCK
from halfroll.campaign.statistics import interval

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "campaigns.md").read_text()
COMMANDS = [
    line.split("#")[0].strip()
    for block in re.findall(r"```\n(.*?)```", PAGE, re.DOTALL)
    for line in block.splitlines()
    if line.startswith("halfroll")
]
AGAIN = 8  # runs of a cell
CERTAIN = 0.999


@pytest.fixture(scope="module")
def study():
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        import make_campaign_pictures
    finally:
        sys.path.pop(0)
    return make_campaign_pictures


def cells_of(name, vehicle, margin):
    """(succeeded, runs) of a row of the page's table."""
    row = re.search(rf"<!-- {name} -->.*?\| `{vehicle}`, margin {margin:.0%}[^|]*\|(.*?)\n", PAGE, re.DOTALL)[1]
    return [(int(a), int(b)) for a, b in re.findall(r"(\d+)/(\d+) \(", row)]


@pytest.mark.long
@pytest.mark.parametrize("number", range(3))
@pytest.mark.parametrize("vehicle", ["mit-vp", "mit-fp"])
def test_other_seeds_succeed_as_often_as_the_tables_say(study, vehicle, number):
    wrong, margin = study.WRONGS[number], 0.2
    told = cells_of(wrong.name, vehicle, margin)
    assert len(told) == len(wrong.levels)
    again = study.flown(study.prepared(vehicle, margin, wrong, seed=2), len(wrong.levels), AGAIN)
    for (succeeded, runs), cell in zip(told, again, strict=True):
        low, high = interval(succeeded, runs, CERTAIN)
        least, most = interval(cell.succeeded, cell.runs, CERTAIN)
        assert least <= high
        assert low <= most


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_of_the_page_is_one(command):
    words = command.split()
    told = subprocess.run(
        [sys.executable, "-m", "halfroll", words[1], "--help"], capture_output=True, text=True, check=True
    )
    for option in (word for word in words[2:] if word.startswith("--")):
        assert option in told.stdout, option
    for file in re.findall(r"examples/[\w.]+", command):
        assert (ROOT / file).exists(), file


def test_the_arithmetic_of_ten_million_flights_adds_up():
    def told(what):
        return float(re.search(rf"\| {what} \| ([\d.]+)", PAGE)[1])

    core_s, flights, cores = told("CPU time of a run, ms") * 1e-3, 1e7, told("cores of a node") * 100
    assert told("core hours") == pytest.approx(core_s * flights / 3600, rel=0.02)
    assert told("hours on 100 nodes") == pytest.approx(core_s * flights / cores / 3600, rel=0.02)
    assert told("data, GB") == pytest.approx(told("bytes of a run, kept") * flights / 1e9, rel=0.02)
    assert told("rows a second from all cores") == pytest.approx(cores / core_s, rel=0.02)
    assert told("blocks a second at the scheduler") == pytest.approx(cores / core_s / DASK_BLOCK, rel=0.02)
