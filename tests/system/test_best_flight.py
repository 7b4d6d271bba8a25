"""The best plans are flown, not only planned: whatever is asked of the rotors, they can follow."""

from __future__ import annotations

from pathlib import Path

import pytest

from system.processes import Ended, halfroll

COURSES = {
    "square": [(0, 0, 1), (4, 0, 1), (4, 4, 1), (0, 4, 1), (0, 0, 1)],
    "zigzag": [(0, 0, 1), (2, 1, 2), (4, -1, 1), (6, 1, 2.5), (8, -1, 1), (10, 0, 1.5)],
}


def flown(course: str, vehicle: str, mode: str, folder: Path) -> Ended:
    mission = folder / f"{course}.toml"
    mission.write_text("".join(f"[[waypoint]]\nposition_m = {list(point)}\n" for point in COURSES[course]))
    given = ("--mode", mode, "--vehicle", vehicle, "--scenario", "ideal", "--margin", "0.1")
    return halfroll("fly", mission, *given, "--json", "--out", folder / f"{course}-{vehicle}")


@pytest.mark.long
@pytest.mark.parametrize("vehicle", ["mit-vp", "mit-fp"])
@pytest.mark.parametrize("course", COURSES)
def test_the_best_plan_is_tracked_to_centimetres_and_leaves_the_rotors_room(
    course: str, vehicle: str, tmp_path: Path
) -> None:
    ended = flown(course, vehicle, "best", tmp_path)
    assert ended.code == 0, ended.err
    assert ended.json["tracking_rms_m"] <= 0.03
    assert ended.json["waypoint_miss_max_m"] <= 0.05
    assert ended.json["rotor_saturated"] <= 0.02
