"""The log of a flip mission: what other people's tools read in it, and that it flies again."""

from __future__ import annotations

import re
import struct
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest
from pymavlink import mavutil
from pyulog import ULog
from pyulog.px4 import PX4ULog

from halfroll.results.log import Log, read_log
from system.gcs import Gcs
from system.processes import EXAMPLES, MISSIONS, Ended, halfroll, simulator

LOGS_PAGE = (Path(__file__).parents[2] / "docs" / "logs.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Ended:
    ended = halfroll("fly", EXAMPLES / "aerobatics.toml", "--json", "--out", tmp_path_factory.mktemp("flips"))
    assert ended.code == 0, ended.err
    return ended


@pytest.fixture(scope="module")
def path(flown: Ended) -> Path:
    return Path(flown.json["log"])


@pytest.fixture(scope="module")
def log(path: Path) -> Log:
    return read_log(path)


@pytest.fixture(scope="module")
def ulog(path: Path) -> ULog:
    return ULog(str(path))


def test_pyulog_finds_no_corruption_and_no_drop(ulog: ULog) -> None:
    assert not ulog.file_corruption
    assert ulog.dropouts == []
    assert ulog.start_timestamp == 0


def documented() -> dict[str, float | None]:
    """Topic to rate, as docs/logs.md has it."""
    rows = re.findall(r"^\| `(\w+)` \| (\d+|–) \|", LOGS_PAGE, re.MULTILINE)
    return {name: None if rate == "–" else float(rate) for name, rate in rows}


def test_the_topics_and_their_rates_are_those_of_the_page(ulog: ULog) -> None:
    topics = {topic.name: topic.data["timestamp"] for topic in ulog.data_list}
    rates = documented()
    assert set(topics) - {"stored_image"} == set(rates) - {"stored_image"}  # nothing is stored before the first flight
    for name, rate in rates.items():
        if rate is not None:
            between = np.diff(topics[name])
            assert np.median(between) == pytest.approx(1e6 / rate), name
            assert between.max() <= 1e6 / rate, name  # no gap, however the vehicle turns


def test_the_whole_page_of_words_is_in_it(log: Log) -> None:
    texts = LOGS_PAGE[LOGS_PAGE.index("as information") :]
    informed, kept = texts.split("Kept whole")
    assert set(re.findall(r"`(\w+)`", informed)) <= set(log.info)
    assert set(re.findall(r"`(\w+)`", kept)) == set(log.embedded)
    assert log.embedded["mission_file"] == (EXAMPLES / "aerobatics.toml").read_text(encoding="utf-8")


# What PX4's Flight Review plots, by the names it asks pyulog for (its plots, tables and pid analysis).
FLIGHT_REVIEW: dict[str, tuple[str, ...]] = {
    "vehicle_local_position": ("x", "y", "z", "vx", "vy", "vz", "xy_valid", "z_valid", "v_xy_valid", "v_z_valid"),
    "vehicle_local_position_setpoint": ("x", "y", "z", "vx", "vy", "vz"),
    "vehicle_local_position_groundtruth": ("x", "y"),
    "vehicle_global_position": ("lat", "lon", "alt"),
    "vehicle_attitude": ("roll", "pitch", "yaw"),
    "vehicle_attitude_setpoint": ("roll_d", "pitch_d", "yaw_d", "yaw_sp_move_rate"),
    "vehicle_attitude_groundtruth": ("roll", "pitch", "yaw"),
    "vehicle_angular_velocity": ("xyz[0]", "xyz[1]", "xyz[2]"),
    "vehicle_angular_velocity_groundtruth": ("xyz[0]", "xyz[1]", "xyz[2]"),
    "vehicle_rates_setpoint": ("roll", "pitch", "yaw", "thrust_body[2]"),
    "actuator_outputs": ("noutputs", *(f"output[{i}]" for i in range(16))),
    "actuator_motors": tuple(f"control[{i}]" for i in range(12)),
    "sensor_combined": (*(f"gyro_rad[{i}]" for i in range(3)), *(f"accelerometer_m_s2[{i}]" for i in range(3))),
    "battery_status": ("voltage_v", "voltage_filtered_v", "current_a", "discharged_mah", "remaining"),
    "vehicle_status": ("nav_state", "arming_state", "is_vtol", "vehicle_type"),
}


def test_flight_review_finds_every_field_that_it_plots(path: Path) -> None:
    reviewed = ULog(str(path), list(FLIGHT_REVIEW), disable_str_exceptions=True)
    px4 = PX4ULog(reviewed)
    px4.add_roll_pitch_yaw()
    assert px4.get_mav_type() == "Quadrotor"
    assert px4.get_estimator()
    for name, fields in FLIGHT_REVIEW.items():
        found = reviewed.get_dataset(name).data
        assert set(fields) <= set(found), name
    modes = [mode for _, mode in reviewed.get_dataset("vehicle_status").list_value_changes("nav_state")]
    assert 14 in modes  # offboard
    assert 3 in modes  # mission


SIZES = {
    "float": 4,
    "double": 8,
    "bool": 1,
    "char": 1,
    **{f"{u}int{8 * n}_t": n for u in ("", "u") for n in (1, 2, 4, 8)},
}


def test_every_record_is_as_long_as_its_definition_for_readers_that_do_not_look(path: Path) -> None:
    """PlotJuggler's reader takes flag bits of 40 bytes, parameters before the first subscription, one `timestamp` of 64
    bits in a topic, and believes that a sample is as long as the definition says."""
    whole, at = path.read_bytes(), 16
    sizes: dict[str, int] = {}
    subscribed: dict[int, str] = {}
    kinds = []
    while at < len(whole):
        size, kind = struct.unpack_from("<HB", whole, at)
        body, at = whole[at + 3 : at + 3 + size], at + 3 + size
        kinds.append(chr(kind))
        if kinds[-1] == "B":
            assert len(body) == 40
        elif kinds[-1] == "F":
            name, _, fields = body.decode().partition(":")
            typed = re.findall(r"(\w+?)(?:\[(\d+)\])? (\w+);", fields)
            assert [kind for kind, _, field in typed if field == "timestamp"] == ["uint64_t"], name
            sizes[name] = sum(SIZES[kind] * int(length or 1) for kind, length, _ in typed)
        elif kinds[-1] == "A":
            number = int.from_bytes(body[1:3], "little")
            assert body[0] == 0
            assert number not in subscribed
            subscribed[number] = body[3:].decode()
        elif kinds[-1] == "D":
            assert len(body) - 2 == sizes[subscribed[int.from_bytes(body[:2], "little")]]
        elif kinds[-1] == "P":
            assert re.fullmatch(rb"(float|int32_t) \w+", body[1 : 1 + body[0]])
            assert len(body) == 1 + body[0] + 4
    assert at == len(whole)
    assert kinds[0] == "B"
    assert "P" in kinds[: kinds.index("A")]
    assert "F" not in kinds[kinds.index("A") :]


def test_pyulogs_own_programs_tell_what_is_in_it(path: Path, log: Log, tmp_path: Path) -> None:
    told = {name: tool(name, path) for name in ("ulog_info", "ulog_messages", "ulog_params")}
    assert "No Dropouts" in told["ulog_info"]
    assert all(re.search(rf"^ *{topic} \(", told["ulog_info"], re.MULTILINE) for topic in log)
    assert "ground: flying the plan" in told["ulog_messages"]
    assert {line.partition(",")[0] for line in told["ulog_params"].splitlines()} == set(log.parameters)
    tool("ulog2csv", "-o", tmp_path, "-m", "vehicle_attitude", path)
    (table,) = tmp_path.glob("*vehicle_attitude_0.csv")
    assert len(table.read_text().splitlines()) == 1 + len(log["vehicle_attitude"])


def tool(name: str, *words: str | Path) -> str:
    """What a program of the environment prints."""
    ran = subprocess.run([Path(sys.executable).with_name(name), *words], capture_output=True, text=True, check=True)
    return ran.stdout


def px4(ulog: ULog, topic: str, *fields: str) -> Any:
    data = ulog.get_dataset(topic).data
    return np.stack([data[field] for field in fields], axis=1)


def test_px4s_topics_are_the_truth_turned_by_half_a_turn_about_north(ulog: ULog, log: Log) -> None:
    turn = np.array([1.0, -1.0, -1.0])
    p = px4(ulog, "vehicle_local_position_groundtruth", "x", "y", "z")
    assert p == pytest.approx(log["vehicle_truth"]["p"][::10] * turn)
    q = px4(ulog, "vehicle_attitude_groundtruth", *(f"q[{i}]" for i in range(4)))
    assert q == pytest.approx(log["vehicle_truth"]["q"][::4] * np.array([1.0, 1.0, -1.0, -1.0]))
    w = px4(ulog, "vehicle_angular_velocity_groundtruth", *(f"xyz[{i}]" for i in range(3)))
    assert w == pytest.approx(log["vehicle_truth"]["w"][::4] * turn)
    assert -p[:, 2].min() > 1.0  # up is negative


def test_the_reference_in_the_log_is_the_plan_and_was_flown(log: Log) -> None:
    reference, truth = log["trajectory_reference"], log["vehicle_truth"]
    assert reference.t - log.info["plan_start_s"] == pytest.approx(reference["plan_s"], abs=2e-6)
    flown = np.stack([np.interp(reference.t, truth.t, column) for column in truth["p"].T], axis=1)
    assert np.linalg.norm(flown - reference["p"], axis=1).max() < 0.1
    setpoint = log["vehicle_local_position_setpoint"]
    assert setpoint["z"] == pytest.approx(-reference["p"][:, 2])
    low, high = log.info["rotor_thrust_min_N"], log.info["rotor_thrust_max_N"]
    assert reference["f"].min() >= low
    assert reference["f"].max() <= high


def test_it_flies_again_to_the_same_bits(flown: Ended, path: Path, tmp_path: Path) -> None:
    again = halfroll("log", "replay", path, "-o", tmp_path / "again.ulg", "--json")
    assert again.code == 0, again.err
    assert again.json["identical"] is True
    assert again.json["commands_sha256"] == flown.json["commands_sha256"]
    twice = halfroll("log", "replay", tmp_path / "again.ulg", "-o", tmp_path / "twice.ulg", "--json")
    assert twice.json["commands_sha256"] == flown.json["commands_sha256"]
    compared = halfroll("log", "compare", path, tmp_path / "again.ulg", "-o", tmp_path / "both.png", "--json")
    assert compared.json["same_commands"] is True
    assert compared.json["apart_max_m"] == pytest.approx(0.0, abs=1e-12)
    assert (tmp_path / "both.png").is_file()


def test_a_log_cut_off_anywhere_flies_again_as_far_as_it_goes(path: Path, tmp_path: Path) -> None:
    whole = path.read_bytes()
    cut = tmp_path / "cut.ulg"
    cut.write_bytes(whole[: int(0.61803 * len(whole))])
    again = halfroll("log", "replay", cut, "--json")
    assert again.code == 0, again.err
    assert again.json["identical"] is True
    assert 0.5 < again.json["flown_s"] / read_log(path)["vehicle_truth"].t[-1] < 0.7


def test_what_anybodys_client_flew_in_real_time_flies_again_too(tmp_path: Path) -> None:
    path = tmp_path / "f.ulg"
    with simulator("--log", path, "--duration", "10") as (running, instance), Gcs(instance) as gcs:
        gcs.until(lambda message: message.get_type() == "HEARTBEAT", gcs.heartbeat())
        gcs.arm()
        gcs.command(22, 0, 0, 0, *[float("nan")] * 4)
        running.wait()
    assert read_log(path)["vehicle_state"]["armed"].any()
    again = halfroll("log", "replay", path, "--json")
    assert again.code == 0, again.err
    assert again.json["commands_sha256"] == again.json["logged_sha256"]


def test_a_log_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.ulg").write_bytes(b"ULog\x01\x12\x35\x01" + bytes(8))
    ended = halfroll("log", "replay", tmp_path / "x.ulg")
    assert ended.code == 2
    assert "Traceback" not in ended.err


def test_the_raw_link_is_a_tlog_that_pymavlink_reads(path: Path) -> None:
    heard: dict[str, int] = {}
    stamps = []
    with closing(mavutil.mavlink_connection(str(path.with_suffix(".tlog")), dialect="development")) as raw:
        while (message := raw.recv_match()) is not None:
            heard[message.get_type()] = heard.get(message.get_type(), 0) + 1
            stamps.append(message._timestamp)
    references = read_log(path)["trajectory_reference"]
    assert heard["SET_ATTITUDE_TARGET"] >= len(references)
    assert heard["HEARTBEAT"] > 0
    assert heard.get("BAD_DATA", 0) == 0
    assert stamps == sorted(stamps)
    assert stamps[-1] - stamps[0] == pytest.approx(read_log(path)["vehicle_truth"].t[-1], abs=2.0)


def test_mavlogdump_prints_the_link(path: Path) -> None:
    words = ("--dialect", "development", "--types", "HEARTBEAT,SET_ATTITUDE_TARGET", path.with_suffix(".tlog"))
    lines = tool("mavlogdump.py", *words).splitlines()
    assert sum("SET_ATTITUDE_TARGET" in line for line in lines) >= len(read_log(path)["trajectory_reference"])
    assert any("HEARTBEAT" in line for line in lines)


def test_info_says_how_it_ended_and_that_nothing_is_missing(path: Path) -> None:
    told = halfroll("log", "info", path, "--json").json
    assert (told["verdict"], told["complete"], told["damaged"]) == ("Flown within limits", True, False)
    assert {topic["gaps"] for topic in told["topics"]} == {0, None}
    assert any(message["text"].startswith("ground: flying the plan") for message in told["messages"])


def test_tables_read_back_bit_for_bit(path: Path, log: Log, tmp_path: Path) -> None:
    ended = halfroll("log", "export", path, "-o", tmp_path, "--topic", "vehicle_truth", "--json")
    assert ended.json["tables"] == [str(tmp_path / "vehicle_truth.csv")]
    table = np.genfromtxt(tmp_path / "vehicle_truth.csv", delimiter=",", names=True, deletechars="")
    assert (table["p.2"].astype(np.float32) == log["vehicle_truth"]["p"][:, 2]).all()
    assert (table["t_s"] == log["vehicle_truth"].t).all()


def test_parquet_holds_the_numbers_of_the_log_bit_for_bit(path: Path, log: Log, tmp_path: Path) -> None:
    halfroll("log", "export", path, "-o", tmp_path, "--topic", "vehicle_truth", "--format", "parquet")
    table = pyarrow.parquet.read_table(tmp_path / "vehicle_truth.parquet")
    for axis in range(3):
        assert (table[f"p.{axis}"].to_numpy() == log["vehicle_truth"]["p"][:, axis]).all()


def test_every_picture_is_drawn(path: Path, tmp_path: Path) -> None:
    drawn = halfroll("log", "plot", path, "-o", tmp_path / "pictures", "--format", "pdf", "--json").json["pictures"]
    assert [Path(file).stem for file in drawn] == ["overview", "path", "whole", "tracking", "attitude", "rotors"]
    assert all(Path(file).read_bytes().startswith(b"%PDF") for file in drawn)


def test_the_report_is_written_again_from_the_log_alone(flown: Ended, path: Path, tmp_path: Path) -> None:
    again = halfroll("log", "report", path, "-o", tmp_path / "r.pdf", "--json").json
    assert again["flown"]["tracking_max_m"] == flown.json["tracking_max_m"]
    assert again["good"] is True
    assert (tmp_path / "r.pdf").read_bytes().startswith(b"%PDF")


FENCED = ("--set", "params.GF_MAX_VER_DIST=8.02", "--set", "params.GF_ACTION=5", "--scenario", "windy")  # it lands


def test_a_flight_across_its_fence_leaves_log_and_report_with_the_cause_first(tmp_path: Path) -> None:
    ended = halfroll("fly", MISSIONS / "box.plan", *FENCED, "--json", "--out", tmp_path)
    assert ended.code == 1
    assert ended.json["report"] == str(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    first_screen = page[page.index("<body>") : page.index('class="tiles"')]
    assert ended.json["error"]["message"].split(";")[0] in first_screen
    assert "fence" in first_screen.lower()
    assert (tmp_path / "flight.ulg").is_file()
