"""Mission files: equal missions in different formats are equal, nothing is lost in a round trip, bad files say why."""

from __future__ import annotations

import contextlib
import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halfroll.errors import InputError, MissionError
from halfroll.missions.geodesy import DEFAULT_ORIGIN, GeoPoint
from halfroll.missions.mission import NOT_GIVEN, Fence, Mission, MissionItem, Rules, Yaw
from halfroll.missions.mission_check import check_items
from halfroll.missions.mission_files import load_mission, save_plan, save_waypoints
from halfroll.planner.course import course, with_takeoff_and_landing
from halfroll.planner.plan import COLUMNS

HERE = Path(__file__).parent
MISSIONS = HERE / "missions"
EXAMPLES = HERE.parents[1] / "examples"


@pytest.fixture
def written(tmp_path: Path) -> Callable[[str, str], Path]:
    def write(name: str, text: str) -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


# ---- equal missions


def test_a_plan_and_a_waypoint_list_of_one_mission_give_the_same_items_and_the_same_flown_list() -> None:
    plan, wpl = load_mission(MISSIONS / "patrol.plan"), load_mission(MISSIONS / "patrol.waypoints")
    jump = 5
    assert wpl.items[1 : jump + 1] == plan.items[:jump]
    assert (plan.items[jump].params[0], wpl.items[jump + 1].params[0]) == (2, 3)  # each in its own numbers
    flown = [
        [(point.position, point.yaw, point.hold_s, point.speed_max) for point in course(mission).waypoints]
        for mission in (plan, wpl)
    ]
    assert flown[0] == flown[1]
    assert plan.planned_home == wpl.planned_home == DEFAULT_ORIGIN


def test_sequence_numbers_count_from_0_in_a_plan_and_from_1_after_the_home_line() -> None:
    assert course(load_mission(MISSIONS / "patrol.plan")).first_item == 0
    assert course(load_mission(MISSIONS / "patrol.waypoints")).first_item == 1


@pytest.mark.parametrize("name", ["first_flight.plan", "box.waypoints", "window.toml", "inspection.toml"])
def test_every_example_is_flyable_as_it_is_shipped(name: str) -> None:
    mission, _ = with_takeoff_and_landing(load_mission(EXAMPLES / name))
    assert [str(finding) for finding in check_items(mission.items)] == []
    flown = course(mission)
    assert len(flown.waypoints) >= 5
    assert flown.hands_back_to == len(mission.items) - 1
    for point in flown.waypoints:
        assert math.hypot(*point.position[:2]) < 25
        assert 2.5 <= point.position[2] <= 12


def test_a_survey_is_flown_through_its_stored_items_and_its_jump_names_a_jump_id() -> None:
    mission = load_mission(MISSIONS / "survey.plan")
    assert [item.command for item in mission.items] == [530, 16, 206, 16, 206, 16, 16, 177]
    assert mission.items[7].params[0] == 3  # doJumpId 4
    first = mission.items[0]
    assert (first.x, first.y) == (NOT_GIVEN, NOT_GIVEN)
    assert all(map(math.isnan, (*first.params[2:], first.z)))


def test_rally_points_are_noticed() -> None:
    (warning,) = load_mission(MISSIONS / "survey.plan").warnings
    assert "rally points" in warning


def test_polygons_and_circles_of_a_fence_are_read_and_lie_where_they_were_drawn(
    written: Callable[[str, str], Path],
) -> None:
    raw = json.loads((EXAMPLES / "first_flight.plan").read_text())
    home = raw["mission"]["plannedHomePosition"]
    per_lat, per_lon = 1.0 / 111194.0, 1.0 / (111194.0 * math.cos(math.radians(home[0])))  # degrees a metre, roughly
    square = [[home[0] + n * per_lat, home[1] - w * per_lon] for n, w in ((-5, -5), (40, -5), (40, 40), (-5, 40))]
    circle = {"center": [home[0] + 100 * per_lat, home[1]], "radius": 10.0}
    raw["geoFence"] = {
        "version": 2,
        "polygons": [{"inclusion": True, "polygon": square, "version": 1}],
        "circles": [{"inclusion": False, "circle": circle, "version": 1}],
    }
    mission = load_mission(written("fenced.plan", json.dumps(raw)))
    field, tower = course(mission, GeoPoint(*home)).rules.fences
    assert field.keep_in
    assert np.allclose(field.corners, [(-5, -5), (40, -5), (40, 40), (-5, 40)], atol=0.2)
    assert not tower.keep_in
    assert np.allclose(
        np.linalg.norm(np.subtract(tower.corners, (100, 0)), axis=1), 10.0 / math.cos(math.pi / 32), atol=0.3
    )


def test_a_fence_is_written_back(tmp_path: Path) -> None:
    mission = replace(
        load_mission(EXAMPLES / "first_flight.plan"), rules=Rules((Fence(True, ((0, 0), (30, 0), (0, 30))),))
    )
    save_plan(tmp_path / "again.plan", mission)
    (fence,) = course(load_mission(tmp_path / "again.plan"), mission.planned_home).rules.fences
    assert np.allclose(fence.corners, ((0, 0), (30, 0), (0, 30)), atol=1e-3)


@pytest.mark.parametrize(
    ("fence", "complaint"),
    [
        ({"polygons": 3}, "geoFence.polygons is 3, a list is wanted"),
        ({"polygons": [{"polygon": [[47, 8], [47, 9]]}]}, "fence 1 has 2 corners, a polygon has at least 3"),
        ({"polygons": [{"polygon": [[47, 8], [47], [48, 9]]}]}, "polygon 1 of the fence: a corner is"),
        ({"circles": [{"circle": {"center": [47, 8], "radius": "wide"}}]}, "radius of circle 1 of the fence is 'wide'"),
    ],
)
def test_a_fence_that_cannot_be_read_is_refused_in_words(
    written: Callable[[str, str], Path], fence: dict[str, object], complaint: str
) -> None:
    raw = json.loads((EXAMPLES / "first_flight.plan").read_text())
    with pytest.raises(MissionError, match=re.escape(complaint)):
        load_mission(written("fenced.plan", json.dumps({**raw, "geoFence": fence})))


def test_toml_says_limits_yaw_fence_times_and_free_positions(written: Callable[[str, str], Path]) -> None:
    path = written(
        "m.toml",
        """
        yaw = [5, -2]
        [limits]
        tilt_deg = 40
        floor_m = "off"
        [[fence]]
        keep = "out"
        corners_m = [[1, 1], [2, 1], [2, 2]]
        [[waypoint]]
        position_m = [0, 0, 1]
        [[waypoint]]
        free = ["position"]
        velocity_m_s = [1, 0, 0]
        [[waypoint]]
        position_m = [4, 0, 3]
        free = ["z"]
        time_s = 3.5
        [[waypoint]]
        position_m = [8, 0, 1]
        """,
    )
    mission = load_mission(path)
    assert mission.rules == Rules(
        (Fence(False, ((1, 1), (2, 1), (2, 2)), "fence 1"),),
        (("tilt_deg", 40), ("floor_m", None)),
        Yaw("point", (5, -2)),
    )
    assert mission.waypoints is not None
    assert [point.free for point in mission.waypoints[1:3]] == [(True, True, True), (False, False, True)]
    assert mission.waypoints[1].position == (2.0, 0.0, 2.0)  # between its neighbours, for the stored items
    assert mission.waypoints[2].time_s == 3.5


@pytest.mark.parametrize(
    ("toml", "complaint"),
    [
        ('[[fence]]\nkeep = "in"\ncorners_deg = [[1, 1], [2, 1], [2, 2]]', "fence 1 needs corners_m alone"),
        ('yaw = "sideways"', "yaw"),
        ("[limits]\ntilt_deg = true", "limits tilt_deg"),
    ],
)
def test_rules_in_toml_that_make_no_sense_are_refused(
    written: Callable[[str, str], Path], toml: str, complaint: str
) -> None:
    points = "\n[[waypoint]]\nposition_m = [0, 0, 1]\n[[waypoint]]\nposition_m = [4, 0, 1]\n"
    with pytest.raises(MissionError, match=complaint):
        load_mission(written("m.toml", toml + points))


def test_frame_2_passes_its_fifth_and_sixth_number_unscaled(written: Callable[[str, str], Path]) -> None:
    path = written("m.waypoints", "QGC WPL 110\n0\t1\t2\t201\t0\t0\t0\t0\t7\t-3\t0\t1\n")
    assert (load_mission(path).items[0].x, load_mission(path).items[0].y) == (7, -3)


# ---- round trips

FLOATS = st.just(math.nan) | st.floats(-1e6, 1e6, width=32)
ITEMS = st.builds(
    MissionItem,
    command=st.integers(0, 65535).filter(lambda command: command != 177),
    frame=st.sampled_from([0, 2, 3, 5, 6, 10]),
    params=st.tuples(FLOATS, FLOATS, FLOATS, FLOATS),
    x=st.integers(-900000000, 900000000) | st.sampled_from([NOT_GIVEN, -NOT_GIVEN - 1, 0]),
    y=st.integers(-1800000000, 1800000000) | st.sampled_from([NOT_GIVEN, -NOT_GIVEN - 1, 0]),
    z=FLOATS,
    autocontinue=st.booleans(),
)


@st.composite
def item_lists(draw: st.DrawFn) -> tuple[MissionItem, ...]:
    items = draw(st.lists(ITEMS, min_size=1, max_size=8))
    for _ in range(draw(st.integers(0, 2))):
        target = float(draw(st.integers(0, len(items) - 1)))
        items.append(MissionItem(177, 2, (target, 3.0, 0.0, 0.0), 0, 0, 0.0))
    return tuple(items)


@given(item_lists())
def test_a_saved_plan_loads_as_the_same_items(
    tmp_path_factory: pytest.TempPathFactory, items: tuple[MissionItem, ...]
) -> None:
    path = tmp_path_factory.mktemp("plan") / "m.plan"
    save_plan(path, Mission("m", items))
    assert load_mission(path).items == items


HOME = MissionItem(16, 0, (0.0,) * 4, 473977420, 85455940, 488.0)
TAKEOFF = MissionItem(22, 3, (0.0, 0.0, 0.0, math.nan), 473977420, 85455940, 5.0)


@given(item_lists())
def test_a_saved_waypoint_list_with_a_home_line_loads_as_the_same_items(
    tmp_path_factory: pytest.TempPathFactory, items: tuple[MissionItem, ...]
) -> None:
    path = tmp_path_factory.mktemp("wpl") / "m.waypoints"
    save_waypoints(path, Mission("m", (HOME, TAKEOFF, *items)))
    assert load_mission(path).items == (HOME, TAKEOFF, *items)


def test_a_plan_saved_as_waypoint_list_gets_a_home_line_and_flies_the_same(tmp_path: Path) -> None:
    plan = load_mission(MISSIONS / "patrol.plan")
    save_waypoints(tmp_path / "m.waypoints", plan)
    assert load_mission(tmp_path / "m.waypoints").items == load_mission(MISSIONS / "patrol.waypoints").items


def test_a_mission_whose_home_line_would_be_flown_is_not_saved_as_a_waypoint_list(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match="only before a TAKEOFF"):
        save_waypoints(tmp_path / "m.waypoints", load_mission(MISSIONS / "survey.plan"))


# ---- points


def test_toml_says_velocities_headings_and_holds_in_metres_from_home(written: Callable[[str, str], Path]) -> None:
    path = written(
        "m.toml",
        """name = "a turn"
[[waypoint]]
position_m = [0, 0, 2]
[[waypoint]]
position_m = [5, 1, 3]
velocity_m_s = [2, 0, 0]
yaw_deg = 90
[[waypoint]]
position_m = [0, 0, 4]
hold_s = 1.5
""",
    )
    mission = load_mission(path)
    home = GeoPoint(47.4, 8.5, 500.0)
    start, turn, end = course(mission, home, home).waypoints
    assert (mission.name, turn.velocity, end.hold_s) == ("a turn", (2, 0, 0), 1.5)
    assert turn.yaw == pytest.approx(-math.pi / 2)  # east: clockwise from north
    assert (start.position, turn.position, end.position) == ((0, 0, 2), (5, 1, 3), (0, 0, 4))
    assert [item.command for item in mission.items] == [22, 16, 16]
    by_items = course(Mission("items only", mission.items)).waypoints
    np.testing.assert_allclose([p.position for p in by_items], [(0, 0, 2), (5, 1, 3), (0, 0, 4)], atol=0.01)


def test_geodetic_toml_stays_where_it_is_on_earth_when_home_moves(written: Callable[[str, str], Path]) -> None:
    path = written(
        "m.toml",
        'frame = "geodetic"\n'
        "[[waypoint]]\nlat_deg = 47.3979\nlon_deg = 8.5457\nalt_m = 5\n"
        "[[waypoint]]\nlat_deg = 47.3978\nlon_deg = 8.5456\nalt_m = 6\n",
    )
    mission = load_mission(path)
    by_waypoints = course(mission, home=DEFAULT_ORIGIN._replace(lat_deg=47.3976, alt=490.0))
    by_items = course(Mission("items only", mission.items), home=DEFAULT_ORIGIN._replace(alt=490.0))
    np.testing.assert_allclose(
        [p.position for p in by_waypoints.waypoints], [p.position for p in by_items.waypoints], atol=0.01
    )


def test_csv_and_kml_of_the_same_points_are_the_same_mission(written: Callable[[str, str], Path]) -> None:
    rows = written("m.csv", "lat,lon,alt\n47.3979,8.5457,5\n47.3978,8.5456,6\n")
    path = written(
        "m.kml",
        '<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark><LineString>'
        "<altitudeMode>relativeToGround</altitudeMode><coordinates>8.5457,47.3979,5\n 8.5456,47.3978,6 </coordinates>"
        "</LineString></Placemark><Placemark><Point><coordinates>8,47,1</coordinates></Point></Placemark>"
        "</Document></kml>",
    )
    items_csv, items_kml = load_mission(rows).items, load_mission(path).items
    assert [(i.x, i.y, i.z, i.frame) for i in items_csv] == [(i.x, i.y, i.z, i.frame) for i in items_kml]
    assert [item.z for item in items_csv] == [5, 6]


def test_csv_in_metres_is_north_west_up_from_home(written: Callable[[str, str], Path]) -> None:
    mission = load_mission(written("m.csv", "x_m;y_m;z_m;yaw_deg;colour\n0;0;3;;red\n10;-5;4;90;blue\n"))
    assert [point.position for point in course(mission).waypoints] == [(0, 0, 3), (10, -5, 4)]
    assert mission.items[1].y > mission.items[0].y  # 5 m east
    assert mission.warnings == ("column 'colour' is not used",)


def test_absolute_kml_heights_are_above_sea_level(written: Callable[[str, str], Path]) -> None:
    text = (
        "<kml><Point><altitudeMode>absolute</altitudeMode><coordinates>8.5457,47.3979,493</coordinates></Point></kml>"
    )
    (point,) = course(load_mission(written("m.kml", text))).waypoints
    assert point.position[2] == pytest.approx(5)


# ---- bad files


def plan_text(**changes: Any) -> str:
    plan = json.loads((MISSIONS / "patrol.plan").read_text(encoding="utf-8"))
    for where, value in changes.items():
        holder: Any = plan
        *path, last = (int(key) if key.isdigit() else key for key in where.split("__"))
        for key in path:
            holder = holder[key]
        holder[last] = value
    return json.dumps(plan)


HEADER = "QGC WPL 110\n"
PLACE = "[[waypoint]]\nposition_m = [{}, 0, 5]\n"
TILTED = PLACE.format(0) + PLACE.format(4) + "{}\n" + PLACE.format(8)
ROW = "{}\t0\t3\t16\t0\t0\t0\t0\t47.3978\t8.5456\t10\t1\n"


@pytest.mark.parametrize(
    ("name", "text", "item", "why"),
    [
        ("m.plan", "{\n  oops", None, "line 2, column 3"),
        ("m.plan", "[1]", None, "an object"),
        ("m.plan", "[" * 100000, None, "too deeply|not JSON"),
        ("m.plan", plan_text(fileType="Params"), None, "'Params'"),
        ("m.plan", plan_text(version=2), None, "file version is 2"),
        ("m.plan", plan_text(mission__version=1), None, "mission version is 1"),
        ("m.plan", plan_text(mission=[]), None, "no mission.items"),
        ("m.plan", plan_text(mission__items=[]), None, "no items"),
        ("m.plan", plan_text(mission__items__2__params=[0, 0]), 2, "list of 7 params"),
        ("m.plan", plan_text(mission__items__2__params__4="north"), 2, "param 5 is 'north'"),
        ("m.plan", plan_text(mission__items__2__params__0=True), 2, "param 1 is True"),
        ("m.plan", plan_text(mission__items__2__params__4=math.nan), None, "NaN"),
        ("m.plan", plan_text(mission__items__2__params__4=123456789).replace("123456789", "1e999"), 2, "infinite"),
        ("m.plan", plan_text(mission__items__2__params__4=500.0), 2, "500 is no latitude"),
        ("m.plan", plan_text(mission__items__2__command=16.5), 2, "whole number"),
        ("m.plan", plan_text(mission__items__2__command=None), 2, "command is None"),
        ("m.plan", plan_text(mission__items__5__params__0=40), 5, "doJumpId 40"),
        ("m.plan", plan_text(mission__items__3__type="Magic"), 3, "'Magic'"),
        ("m.plan", plan_text(mission__items__3={"type": "ComplexItem", "complexItemType": "fwLanding"}), 3, "fwLand"),
        ("m.plan", plan_text(mission__items__3=7), 3, "type None"),
        ("m.waypoints", "QGC WPL 120\n", None, "QGC WPL 120"),
        ("m.waypoints", "0 1 2\n", None, '"QGC WPL 110" is wanted'),
        ("m.waypoints", HEADER, None, "no items"),
        ("m.waypoints", HEADER + "0\t1\n", 0, "line 2 has 2 fields"),
        ("m.waypoints", HEADER + ROW.format(0) + ROW.format(2), 1, "index 2, 1 is next"),
        ("m.waypoints", HEADER + ROW.format(0).replace("16", "x"), 0, "line 2"),
        ("m.waypoints", HEADER + ROW.format(0).replace("47.3978", "inf"), 0, "param 5 is infinite"),
        ("m.waypoints", HEADER + ROW.format(0).replace("47.3978", "300"), 0, "x = 3000000000"),
        ("m.toml", "name = ", None, "is not TOML"),
        ("m.toml", "[[waypoint]]\nposition_m = [0, 0, 1]\n", None, "nothing is flown"),
        ("m.toml", "[[waypoint]]\nposition_m = [0, 0]\n" * 2, None, "waypoint 0 position_m"),
        ("m.toml", "[[waypoint]]\nposition_m = [0, 0, inf]\n" * 2, None, "finite"),
        ("m.toml", "[[waypoint]]\nposition_m = [0, 0, 1]\nspin = 2\n" * 2, None, "waypoint 0 spin"),
        ("m.toml", "[[waypoint]]\nposition_m = [0, 0, 1]\n" * 2, None, "where the one before is"),
        ("m.toml", "[[waypoint]]\nlat_deg = 1.0\n" * 2, 0, "position_m alone"),
        ("m.toml", 'frame = "geodetic"\n' + "[[waypoint]]\nlat_deg = 1.0\n" * 2, 0, "lat_deg, lon_deg and alt_m"),
        ("m.toml", "[[waypoint]]\nposition_m = [0, 0, 1]\nvelocity_m_s = [1, 0, 0]\n" * 2, 0, "at rest"),
        ("m.toml", "[[waypoint]]\nposition_m = [0, 0, 1]\nupright = false\n" * 2, 0, "begins upright"),
        ("m.toml", TILTED.format("attitude = {}"), 1, "either roll_deg and pitch_deg or a quaternion"),
        ("m.toml", TILTED.format("attitude = {quaternion = [1, 1, 0, 0]}"), 1, "length 1.41"),
        (
            "m.toml",
            TILTED.format("attitude = {roll_deg = 30}\nacceleration_m_s2 = [0, 0, 1]"),
            1,
            "attitude and acceleration are both given",
        ),
        ("m.toml", TILTED.format("velocity_m_s = [1, 0, 0]\ndirection = [1, 0, 0]"), 1, "direction of velocity"),
        ("m.toml", TILTED.format("attitude = {roll_deg = 30}\nbody_rate_deg_s = [9, 0, 0]"), 1, "give both, too"),
        ("m.toml", TILTED.format("attitude = {roll_deg = 30}\nhold_s = 1"), 1, "moves at the same time"),
        ("m.toml", TILTED.format("") + '[[manoeuvre]]\nat = 3\nkind = "flip"\n', None, "the last one is 2"),
        ("m.toml", TILTED.format("") + '[[manoeuvre]]\nat = 1\nkind = "spin"\n', None, "manoeuvre 0"),
        ("m.toml", TILTED.format("") + '[[manoeuvre]]\nat = 1\nkind = "flip"\nturns = 0.3\n', None, "multiple of 0.5"),
        ("m.toml", "waypoint = 3\n", None, "waypoint"),
        ("m.csv", "", None, "header"),
        ("m.csv", "a,b\n1,2\n", None, "lat,lon,alt or x,y,z"),
        ("m.csv", "x,y,z\n", None, "no points"),
        ("plan.csv", f"{','.join(COLUMNS)}\n{','.join(['0'] * len(COLUMNS))}\n", None, "the samples of a plan"),
        ("m.csv", "x,y,z\n1,2\n", 0, "point 0 has no z"),
        ("m.csv", "x,y,z\n1,2,up\n", 0, "z is 'up'"),
        ("m.csv", "lat,lon,alt\n1,nan,3\n", 0, "lon is nan"),
        ("m.csv", "lat,lon,alt\n1000,2,3\n", 0, "1000 is no latitude"),
        ("m.kml", "<kml>", None, "XML error at line 1"),
        ("m.kml", "<kml/>", None, "no LineString"),
        ("m.kml", "<kml><Point><coordinates>8,47,0</coordinates></Point></kml>", None, "no heights"),
        ("m.kml", "<kml><Point><coordinates>8,b,0</coordinates></Point></kml>", 0, "'8,b,0'"),
        ("m.doc", "hello", None, "no mission format"),
    ],
)
def test_a_bad_file_is_refused_with_its_name_the_item_and_the_reason(
    written: Callable[[str, str], Path], name: str, text: str, item: int | None, why: str
) -> None:
    path = written(name, text)
    with pytest.raises(InputError, match=why) as caught:
        load_mission(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)
    if item is not None:
        assert caught.value.item == item


def test_a_file_that_cannot_be_read_says_so(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        load_mission(tmp_path / "none.plan")
    with pytest.raises(InputError, match="is a folder"):
        load_mission(tmp_path)
    (tmp_path / "m.plan").write_bytes(b"PK\x03\x04\xff\xfe")
    with pytest.raises(InputError, match="not a text file"):
        load_mission(tmp_path / "m.plan")


def test_a_home_line_without_a_takeoff_is_warned_about(written: Callable[[str, str], Path]) -> None:
    mission = load_mission(written("m.txt", HEADER + ROW.format(0).replace("\t3\t", "\t0\t") + ROW.format(1)))
    assert "no TAKEOFF" in mission.warnings[0]


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)


@given(st.data())
def test_whatever_stands_at_some_place_of_a_plan_it_loads_or_is_refused(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    plan = json.loads((MISSIONS / "survey.plan").read_text(encoding="utf-8"))
    holder: Any = plan
    while True:
        key = data.draw(st.sampled_from(sorted(holder) if isinstance(holder, dict) else range(len(holder))))
        deeper = isinstance(holder[key], (dict, list)) and len(holder[key]) > 0
        if not deeper or data.draw(st.booleans()):
            break
        holder = holder[key]
    holder[key] = data.draw(JSON)
    path = tmp_path_factory.mktemp("odd") / "m.plan"
    path.write_text(json.dumps(plan), encoding="utf-8")
    with contextlib.suppress(InputError):
        check_items(load_mission(path).items)


@given(st.binary(max_size=200), st.sampled_from(["plan", "waypoints", "toml", "csv", "kml"]))
def test_no_bytes_bring_down_the_reader(tmp_path_factory: pytest.TempPathFactory, content: bytes, suffix: str) -> None:
    path = tmp_path_factory.mktemp("any") / f"m.{suffix}"
    path.write_bytes(content)
    with contextlib.suppress(InputError):
        load_mission(path)
