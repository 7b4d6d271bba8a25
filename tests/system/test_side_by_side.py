"""Two flights on one machine do not meet."""

from __future__ import annotations

from pathlib import Path

from system.processes import HALFROLL, MISSIONS, Running


def test_two_flights_at_once_both_land(tmp_path: Path) -> None:
    words = [HALFROLL, "fly", MISSIONS / "box.plan", "--scenario", "ideal", "--json", "--out"]
    with Running(*words, tmp_path / "one") as one, Running(*words, tmp_path / "other") as other:
        ended = [one.wait(), other.wait()]
    assert [each.code for each in ended] == [0, 0]
    assert ended[0].json["commands_sha256"] == ended[1].json["commands_sha256"]  # nor does one hear the other
