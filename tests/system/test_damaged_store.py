"""A store that was torn or corrupted: the last good copy is used, and somebody is told."""

from __future__ import annotations

from pathlib import Path

from system.gcs import ACCEPTED, Gcs
from system.processes import Running, simulator
from system.test_stored_missions import OPEN

ARM, SAVE, TEMPORARILY_REJECTED = 400, 245, 1
OTHER_COPY = "Params: a copy was damaged, last good one in use"
LOST = "Params: stored file damaged, defaults in use"


def set_radius(gcs: Gcs, value: float) -> None:
    ask = gcs._codec.param_set_encode(*gcs._target, b"NAV_ACC_RAD", value, 9)
    gcs.until(lambda m: m.get_type() == "PARAM_VALUE" and m.param_value == value, ask)


def radius(gcs: Gcs) -> float:
    ask = gcs._codec.param_request_read_encode(*gcs._target, b"NAV_ACC_RAD", -1)
    return float(gcs.until(lambda m: m.get_type() == "PARAM_VALUE", ask).param_value)


def kill(running: Running) -> None:
    running.process.kill()
    running.wait()


def spoil(file: Path) -> None:
    content = bytearray(file.read_bytes())
    content[-1] ^= 0xFF
    file.write_bytes(content)


def newest(folder: Path, kind: str) -> Path:
    """The copy with the greater sequence number, the third word of its header."""
    return max(folder.glob(f"{kind}.*.bin"), key=lambda f: int.from_bytes(f.read_bytes()[8:12], "little"))


def store_two_radii(folder: Path) -> None:
    with simulator("--storage", folder) as (running, instance), Gcs(instance) as gcs:
        for value in (1.5, 2.5):
            set_radius(gcs, value)
            assert gcs.command(SAVE, 1) == ACCEPTED  # answered when it is written
        kill(running)


def texts_on_meeting(gcs: Gcs) -> list[str]:
    gcs.send(gcs._codec.heartbeat_encode(6, 8, 0, 0, 0))
    gcs.until(lambda m: m.get_type() == "STATUSTEXT")
    return gcs.texts


def test_with_the_newer_copy_corrupt_the_older_one_is_used_and_told(tmp_path: Path) -> None:
    store_two_radii(tmp_path)
    spoil(newest(tmp_path, "params"))
    with simulator("--storage", tmp_path) as (_, instance), Gcs(instance) as gcs:
        assert texts_on_meeting(gcs) == [OTHER_COPY]
        assert radius(gcs) == 1.5
        gcs.arm()


def test_with_both_copies_corrupt_defaults_are_used_and_it_does_not_arm(tmp_path: Path) -> None:
    store_two_radii(tmp_path)
    for file in tmp_path.glob("params.*.bin"):
        spoil(file)
    with simulator("--storage", tmp_path) as (_, instance), Gcs(instance) as gcs:
        assert texts_on_meeting(gcs) == [LOST]
        assert radius(gcs) == 2.0
        gcs.until(lambda m: m.get_type() == "HOME_POSITION")
        assert gcs.command(ARM, 1) == TEMPORARILY_REJECTED
        assert gcs.texts[-1] == "Arming denied: parameter file damaged"
        assert gcs.command(SAVE, 1) == ACCEPTED  # so be it
        gcs.arm()


def test_a_corrupt_mission_gives_way_to_the_one_before(tmp_path: Path) -> None:
    with simulator("--storage", tmp_path) as (running, instance), Gcs(instance) as gcs:
        assert gcs.upload(OPEN[:3]) == ACCEPTED
        assert gcs.upload(OPEN) == ACCEPTED
        kill(running)
    spoil(newest(tmp_path, "mission"))
    with simulator("--storage", tmp_path) as (_, instance), Gcs(instance) as gcs:
        assert texts_on_meeting(gcs) == ["Mission: a copy was damaged, last good one in use"]
        assert len(gcs.download()) == 3
