"""Files that people send each other, changed in any way: each gives a value or a sentence, and opens nothing else.

The seeds are the project's own files. What changes them are bytes that flip, pieces that vanish, double and move, and
words that have broken readers before.
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ground.conftest import TOPICS, ulog_bytes
from halfroll.errors import HalfrollError, InputError
from halfroll.missions.mission_files import load_mission
from halfroll.param_files import read_params, write_params
from halfroll.planner.course import course
from halfroll.planner.plan import Plan
from halfroll.planner.segments import PiecewisePolynomial, standing
from halfroll.results.log import read_log
from halfroll.scenario import load_scenario
from halfroll.vehicle import load_vehicle

ROOT = Path(__file__).parents[2]
SHIPPED = ROOT / "ground" / "halfroll"
EXAMPLES = 60  # for each kind of file; a long run has fifty times as many
LINE = """<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"><Placemark><LineString>
<altitudeMode>relativeToGround</altitudeMode><coordinates>8.5455,47.3977,5 8.5457,47.3979,9</coordinates>
</LineString></Placemark></kml>"""
POINTS = "lat_deg,lon_deg,alt_m,yaw_deg,hold_s\n47.3977,8.5455,5,90,1\n47.3979,8.5457,9,,\n"
WORDS = [
    *("NaN", "nan", "inf", "-Infinity", "1e999", "-1e999", "1e-320", "0x10", "1_0", "9" * 5000, "-0", f"{2**64}"),
    *("null", "true", '""', "{}", "[]", "[" * 3000, "{" * 3000, '{"a":' * 2000, "<a>" * 3000, '"', "'''", "\\u0000"),
    *("\0", "\ufeff", "\u202e", "\x1b[2J", "é", "\r", "\n", "\t", ",", ";", "#", "]]>", "<!--", "&amp;", "&x;"),
    '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
    *("../../../../etc/passwd", "/etc/passwd", "file:///etc/passwd", "like = '../mit-vp'", "!!python/object:os.system"),
]  # fmt: skip


def texts(*files: str) -> list[bytes]:
    return [(ROOT / file).read_bytes() for file in files]


@cache
def seeds(kind: str) -> list[bytes]:
    if kind == ".plan":
        return texts("examples/first_flight.plan", "tests/ground/missions/survey.plan")
    if kind == ".waypoints":
        return texts("examples/box.waypoints", "tests/ground/missions/patrol.waypoints")
    if kind == ".toml":
        return texts("examples/window.toml", "examples/inspection.toml", "examples/aerobatics.toml")
    if kind in (".kml", ".csv"):
        return [LINE.encode() if kind == ".kml" else POINTS.encode()]
    if kind == "vehicle":
        return [(SHIPPED / "vehicles" / name).read_bytes() for name in ("mit-fp.toml", "paper-plan.toml")]
    if kind == "scenario":
        return [(SHIPPED / "scenarios" / name).read_bytes() for name in ("full.toml", "windy.toml")]
    with tempfile.TemporaryDirectory() as folder:
        if kind == ".params":
            write_params(Path(folder, "v.params"), {"ATT_WN": 14.0, "MIS_TAKEOFF_ALT": 2.5})
            return [Path(folder, "v.params").read_bytes()]
        if kind in (".npz", ".json"):
            standing([0.0, 0.0, 1.0, 0.0], 2.0).save(Path(folder, "t" + kind))
            return [Path(folder, "t" + kind).read_bytes()]
    rows = {name: [(1000 * (n + 1), *[0.5] * (columns_of(name) - 1)) for n in range(3)] for name in TOPICS}
    return [ulog_bytes({**rows, "vehicle_state": [(1000, 2, 1), (2000, 2, 1)]}, {"vehicle": "mit-vp"})]


def columns_of(topic: str) -> int:
    return {"vehicle_truth": 18, "rotor_commands": 5, "attitude_reference": 9, "vehicle_state": 3}[topic]


def flown(path: Path) -> Any:
    return course(load_mission(path))


READERS: dict[str, tuple[str, Callable[[Path], Any]]] = {
    ".plan": (".plan", flown),
    ".waypoints": (".waypoints", flown),
    ".toml": (".toml", flown),
    ".kml": (".kml", flown),
    ".csv": (".csv", flown),
    "vehicle": (".toml", lambda path: load_vehicle(path).numbers()),
    "scenario": (".toml", lambda path: load_scenario(path).numbers()),
    ".params": (".params", read_params),
    ".ulg": (".ulg", read_log),
    ".npz": (".npz", PiecewisePolynomial.load),
    ".json": (".json", PiecewisePolynomial.load),
    "plan": (".json", Plan.load),
}


@st.composite
def changed(draw: st.DrawFn, kind: str) -> bytes:
    """A seed after up to six changes."""
    data = bytearray(draw(st.sampled_from(seeds(".json" if kind == "plan" else kind))))
    for _ in range(draw(st.integers(1, 6))):
        start = draw(st.integers(0, len(data)))
        end = min(len(data), start + draw(st.integers(0, 40)))
        change = draw(st.integers(0, 5))
        if change == 0:
            data[start:end] = draw(st.binary(max_size=8))
        elif change == 1:
            data[start:start] = draw(st.sampled_from(WORDS)).encode()
        elif change == 2:
            data[start:end] = draw(st.sampled_from(WORDS)).encode()
        elif change == 3:
            data[start:start] = data[start:end] * draw(st.integers(1, 50))
        elif change == 4:
            del data[start : draw(st.sampled_from([end, len(data)]))]
        elif start < len(data):
            data[start] ^= 1 << draw(st.integers(0, 7))
    return bytes(data)


opened: list[str] | None = None


def note(event: str, arguments: tuple[Any, ...]) -> None:
    if opened is not None and event == "open" and isinstance(arguments[0], (str, bytes, os.PathLike)):
        opened.append(os.path.realpath(os.fsdecode(arguments[0])))


sys.addaudithook(note)


@contextmanager
def opening_only(path: Path) -> Iterator[None]:
    """Fails if any file is opened but this one and what is part of Python and halfroll."""
    global opened
    opened = []
    try:
        yield
    finally:
        ours = (str(SHIPPED), sys.prefix, sys.base_prefix)
        strange = [file for file in opened if file != os.path.realpath(path) and not file.startswith(ours)]
        opened = None
    assert not strange


def read(kind: str, content: bytes, folder: Path) -> None:
    suffix, reader = READERS[kind]
    path = folder / f"file{suffix}"
    path.write_bytes(content)
    try:
        with opening_only(path):
            reader(path)
    except HalfrollError as refused:
        sentence = str(refused)
        assert sentence, "a refusal without a word"
        assert len(sentence) < 2000, "a refusal longer than anybody reads"
        assert sentence.replace("\n", "").isprintable(), "a refusal that commands a terminal"


def prove(kind: str, folder: Path, examples: int) -> None:
    @settings(
        max_examples=examples, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck)
    )
    @given(changed(kind))
    def value_or_sentence(content: bytes) -> None:
        read(kind, content, folder)

    value_or_sentence()


@pytest.mark.parametrize("kind", READERS)
def test_a_file_changed_in_any_way_gives_a_value_or_a_sentence(kind: str, tmp_path: Path) -> None:
    prove(kind, tmp_path, EXAMPLES)


@pytest.mark.long
@pytest.mark.parametrize("kind", READERS)
def test_and_so_do_thousands(kind: str, tmp_path: Path) -> None:
    prove(kind, tmp_path, 50 * EXAMPLES)


@pytest.mark.parametrize("kind", READERS)
def test_the_seeds_themselves_are_read(kind: str, tmp_path: Path) -> None:
    suffix, reader = READERS[kind]
    for number, content in enumerate(seeds(".json" if kind == "plan" else kind)):
        path = tmp_path / f"{number}{suffix}"
        path.write_bytes(content)
        if kind == "plan":  # a trajectory alone is no plan
            with pytest.raises(InputError, match="is not a plan"):
                reader(path)
        else:
            reader(path)


@pytest.mark.parametrize("kind", READERS)
@pytest.mark.parametrize("what", ["pipe", "device", "folder", "nothing", "link to nothing", "gigabytes"])
def test_what_is_no_file_of_ours_is_refused_at_once(kind: str, what: str, tmp_path: Path) -> None:
    suffix, reader = READERS[kind]
    path = tmp_path / f"it{suffix}"
    if what == "pipe":
        os.mkfifo(path)
    elif what == "device":
        path.symlink_to("/dev/zero")
    elif what == "folder":
        path.mkdir()
    elif what == "link to nothing":
        path.symlink_to(tmp_path / "nothing")
    elif what == "gigabytes":
        with path.open("wb") as file:
            file.truncate(3 * 2**30)
    if kind == ".ulg" and what == "gigabytes":
        return  # a log may be as long as the flight
    with pytest.raises(InputError):
        reader(path)


def growing(kind: str) -> str:
    """An entity of ten entities of ten entities …, or one long one used often."""
    if kind == "exponential":
        levels = [f'<!ENTITY a{n + 1} "{f"&a{n};" * 10}">' for n in range(12)]
        return f'<!DOCTYPE kml [<!ENTITY a0 "0123456789">{"".join(levels)}]><kml>&a12;</kml>'
    return f'<!DOCTYPE kml [<!ENTITY a "{"8.5,47.3,5 " * 50000}">]><kml>{"&a;" * 20000}</kml>'


@contextmanager
def address_space(grown: int) -> Iterator[None]:
    """Whatever runs inside may take so much more memory [bytes]."""
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (taken + grown, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


@pytest.mark.parametrize("kind", ["exponential", "quadratic"])
def test_a_kml_that_grows_while_it_is_read_is_refused_before_it_does(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "bomb.kml"
    path.write_text(growing(kind))
    with address_space(100 * 2**20), pytest.raises(InputError, match="DOCTYPE"):
        load_mission(path)


def test_an_archive_that_grows_while_it_is_unpacked_is_refused_before_it_does(tmp_path: Path) -> None:
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("times.npy", "w") as member:
        np.lib.format.write_array_header_1_0(member, {"descr": "<f8", "fortran_order": False, "shape": (2**27,)})
        for _ in range(2**10):
            member.write(bytes(2**20))
    with address_space(300 * 2**20), pytest.raises(InputError, match="unpacked it has 1024 MB"):
        PiecewisePolynomial.load(path)


def test_an_array_that_only_says_it_is_large_takes_no_memory(tmp_path: Path) -> None:
    path = tmp_path / "liar.npz"
    with zipfile.ZipFile(path, "w") as archive, archive.open("times.npy", "w") as member:
        np.lib.format.write_array_header_1_0(member, {"descr": "<f8", "fortran_order": False, "shape": (2**35,)})
    with address_space(300 * 2**20), pytest.raises(InputError, match="is not a trajectory"):
        PiecewisePolynomial.load(path)


def test_a_pickled_object_is_not_unpickled(tmp_path: Path) -> None:
    path = tmp_path / "pickled.npz"
    np.savez(path, times=np.array([{"a": 1}], dtype=object), coefficients=np.zeros(1))
    with pytest.raises(InputError, match="allow_pickle"):
        PiecewisePolynomial.load(path)


def test_a_vehicle_is_like_a_shipped_one_and_like_no_other_file(tmp_path: Path) -> None:
    (tmp_path / "other.toml").write_text('like = "mit-vp"\n')
    path = tmp_path / "mine.toml"
    for other in ("other", "./other.toml", "../halfroll/vehicles/mit-vp.toml", str(tmp_path / "other.toml")):
        path.write_text(f'like = "{other}"\n')
        with opening_only(path), pytest.raises(InputError, match="not shipped"):
            load_vehicle(path)
