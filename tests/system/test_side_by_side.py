"""Two flights on one machine do not meet; two clients of one vehicle have a link each."""

from __future__ import annotations

from pathlib import Path

from system.gcs import ACCEPTED, Gcs
from system.processes import HALFROLL, MISSIONS, Running, simulator


def test_two_flights_at_once_both_land(tmp_path: Path) -> None:
    words = [HALFROLL, "fly", MISSIONS / "box.plan", "--scenario", "ideal", "--json", "--out"]
    with Running(*words, tmp_path / "one") as one, Running(*words, tmp_path / "other") as other:
        ended = [one.wait(), other.wait()]
    assert [each.code for each in ended] == [0, 0]
    assert ended[0].json["commands_sha256"] == ended[1].json["commands_sha256"]  # nor does one hear the other


def test_a_companion_computer_and_a_ground_control_station_have_a_link_each() -> None:
    with (
        simulator("--scenario", "ideal") as (_, instance),
        Gcs(instance) as gcs,
        Gcs(instance, ours=14030, theirs=14280) as companion,
    ):
        for client in (gcs, companion):
            client.until(lambda m: m.get_type() == "HEARTBEAT")
            assert client.command(520) == ACCEPTED
        assert companion.command(511, 30, 20000) == ACCEPTED  # ATTITUDE, to itself alone
        companion.until(lambda m: m.get_type() == "ATTITUDE")
        gcs.until(lambda m: m.get_type() == "VFR_HUD")
        assert "VFR_HUD" not in companion.last
