"""Each claim of the paper by its name, as `halfroll paper` judges it; and how the command is used."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from halfroll.cli.app import app
from halfroll.paper import claims, paths, reproduction
from halfroll.paper.claims import Claim
from halfroll.vehicle import load_vehicle

CLAIMS = {
    "fig1": ("1", "1.spin", "1.mixer", "1.planner"),
    "fig2": (
        *("2a", "2b", "2b.hold", "2c", "2c.sigma", "2c.hold", "2c.rotors", "2c.durations"),
        *("2d", "2d.attitude", "2d.end", "2d.rate", "2d.faithful", "2d.faithful-end"),
    ),
    "fig3": (
        *("3a", "3a.sigma", "3b", "3b.when", "3b.apex", "3b.force"),
        *("3c", "3c.attitude", "3c.end", "3c.return", "3c.rate", "3c.faithful-end", "3c.faithful"),
    ),
    "fig4": ("4a", "4a.mass", "4b", "4b.likeness"),
    "fig5": (
        *("5a", "5a.mass", "5a.mass-optimum", "5a.order", "5b", "5b.low", "5b.nodes-vp", "5b.nodes-fp"),
        *("5c.single", "5c"),
    ),
    "fig6": ("6a", "6a.position", "6a.no-lead", "6b", "6b.coasting", "6c"),
    "fig7": ("7a", "7b", "7b.170", "7c", "7.inverted", "7.hover", "7.law", "7.printed"),
    "fig8": ("8", "8.inverted"),
    "fig9": ("9", "9.turn"),
    "t1": ("T1", "T1.attitude", "T1.held"),
    "t2": ("T2", "T2.limits", "T2.weight"),
    "t3": ("T3", "T3.gravity", "T3.up"),
    "t4": ("T4", "T4.variable", "T4.fixed", "T4.reversal"),
    "t5": ("T5", "T5.torque"),
}
DOCS = Path(__file__).parents[2] / "docs" / "pictures" / "paper"
EACH = [pytest.param(part, name, id=name) for part, names in CLAIMS.items() for name in names]


@cache
def made(part: str) -> dict[str, Claim]:
    """Flown once, by one seed; the campaigns fly more."""
    return {claim.id: claim for claim in reproduction.part(part, 1).claims}


@pytest.mark.parametrize(("part", "name"), EACH)
def test_the_claim_holds(part, name):
    claim = made(part)[name]
    assert claim.holds, f"{claim.what}: {claims.shown(claim.got)} {claim.unit}, wanted {claim.tolerance}"


def test_every_part_makes_these_claims_and_no_others():
    assert list(CLAIMS) == list(reproduction.PARTS)
    for part, names in CLAIMS.items():
        assert tuple(made(part)) == names


def run(*words):
    return CliRunner().invoke(app, ["paper", *map(str, words)])


def test_the_command_prints_a_table_and_leaves_pictures_and_a_page(tmp_path):
    ended = run("T4", "fig1", "-o", tmp_path / "made")
    assert ended.exit_code == 0, ended.output
    assert "all 8 claims hold" in ended.stdout
    assert ended.stdout.index("1.spin") < ended.stdout.index("T4.fixed")  # in the paper's order
    page = (tmp_path / "made" / "README.md").read_text()
    assert "8 of 8 claims hold" in page
    for name in ("fig1.png", "t4.png"):
        assert (tmp_path / "made" / name).read_bytes().startswith(b"\x89PNG")
        assert f"({name})" in page


def test_for_programs_it_is_one_object_with_every_claim(tmp_path):
    ended = run("t2", "--json", "-o", tmp_path)
    assert ended.exit_code == 0
    (line,) = ended.stdout.splitlines()
    first = json.loads(line)["claims"][0]
    assert first["id"] == "T2"
    assert first["got"] == pytest.approx(6.0 / 2.85)
    assert (first["paper"], first["tolerance"], first["holds"]) == (2.0, "> 2", True)
    assert {"what", "unit", "note"} < set(first)


def test_a_claim_that_fails_is_named_with_its_reason_and_ends_in_1(tmp_path, monkeypatch):
    failing = claims.below("2d", "flown: distance from the plan", 0.5, 0.02, "m", note="worst of 5 flights")
    monkeypatch.setattr(reproduction, "reproduce", lambda *_: [failing])
    ended = run("fig2", "-o", tmp_path)
    assert ended.exit_code == 1
    assert "2d: not within tolerance" in ended.stdout
    assert "worst of 5 flights" in ended.stdout
    assert run("fig2", "--json").exit_code == 1


def test_ctrl_c_ends_it_with_a_word(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(reproduction, "reproduce", interrupted)
    ended = run("-o", tmp_path)
    assert (ended.exit_code, ended.stdout, ended.stderr) == (130, "", "stopped\n")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("fig12",), "'fig12' is no part of the paper; there are fig1 to fig9 and t1 to t5"),
        (("fig1", "2d"), "'2d' is no part of the paper"),
        (("fig1", "-o", "/dev/null/here"), "Not a directory"),
    ],
)
def test_a_wrong_use_is_one_sentence(words, says):
    ended = run(*words)
    assert ended.exit_code == 2
    assert ended.stdout == ""
    assert says in ended.stderr.splitlines()[-1]


def test_tolerances_are_what_they_say():
    assert claims.near("x", "", 1.009, 1.0, share=0.01).holds
    assert not claims.near("x", "", 1.011, 1.0, share=0.01).holds
    assert not claims.near("x", "", [1.0, 2.2], [1.0, 2.0], off=0.1).holds
    assert claims.near("x", "", [1.0, 2.1], [1.0, 2.0], off=0.2).tolerance == "1, 2 ± 0.2"
    assert not claims.near("x", "", float("nan"), 1.0, off=1.0).holds
    assert not claims.between("x", "", [0.5, 3.1], 0.0, 3.0).holds
    assert not claims.below("x", "", 1.0, 1.0).holds
    assert not claims.above("x", "", 1.0, 1.0).holds


def test_the_shortest_climb_cannot_be_shortened():
    """Moving any node time off Fig 5's optimum takes longer: for given shares of the time, acceleration scales with
    1/T², so the shortest T is known in closed form."""
    vehicle = load_vehicle("mit-vp")
    best = paths.shortest_climb(vehicle)
    shares = best.trajectory.times / best.T

    def least_s(shares: np.ndarray) -> float:
        unit = paths.climb(vehicle, shares.tolist()).trajectory
        a = unit.at(np.linspace(0.0, 1.0, 20001), 2)[:, 2]
        up = 4.0 * vehicle.rotor.thrust_max_N / vehicle.mass_kg - 9.81
        down = 9.81 - 4.0 * vehicle.rotor.thrust_min_N / vehicle.mass_kg
        return float(np.sqrt(max(a.max() / up, -a.min() / down)))

    assert least_s(shares) == pytest.approx(best.T, rel=1e-5)
    for node in (1, 2):
        for moved in (-0.01, 0.01):
            other = shares.copy()
            other[node] += moved
            assert least_s(other) > best.T * (1.0 - 5e-5)


@pytest.mark.long
@pytest.mark.parametrize("part", ["fig2", "fig3", "fig6", "fig7"])
def test_fifty_flights_of_fifty_are_within_tolerance(part):
    for claim in reproduction.part(part, 50).claims:
        print(f"{claim.id}: {claim.what} {claims.shown(claim.got)} {claim.unit}, wanted {claim.tolerance}")
        assert claim.holds, claim


@pytest.mark.long
def test_the_docs_show_what_the_command_makes(tmp_path):
    """The page in docs/pictures/paper is the command's own: the same claims with the same verdicts and pictures."""
    ended = run("-o", tmp_path)
    assert ended.exit_code == 0, ended.output
    assert _rows(DOCS / "README.md") == _rows(tmp_path / "README.md")
    pictures = sorted(path.name for path in DOCS.glob("*.png"))
    assert pictures == sorted(path.name for path in tmp_path.glob("*.png"))


def _rows(page: Path) -> list[tuple[str, str]]:
    """Name and verdict of each claim of a page."""
    cells = [line.strip("| ").split(" | ") for line in page.read_text().splitlines() if line.startswith("| ")]
    return [(row[0], row[-1]) for row in cells]
