"""docs/campaigns.md: its commands are ones, its arithmetic adds up."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from halfroll.campaign.engines import DASK_BLOCK
from halfroll.campaign.gains import Trial, Tuned

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "campaigns.md").read_text()
COMMANDS = [
    line.split("#")[0].strip()
    for block in PAGE.split("```")[1::2]
    for line in block.splitlines()
    if line.startswith("halfroll")
]


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


def test_the_runs_that_prove_a_share_are_as_many_as_the_page_says():
    needed = re.search(
        r"For ([\d.]+) % that takes\s(\d+)\s+runs without a failure, (\d+) with one, (\d+) with two", PAGE
    )
    share = float(needed[1]) / 100.0
    for failures, runs in enumerate(map(int, needed.groups()[1:])):
        for count, proven in ((runs, True), (runs - 1, False)):
            proof = Trial({}, 0.0, count - failures, count, 1.0)
            assert Tuned(proof, proof, proof, share, ()).is_proven == proven
