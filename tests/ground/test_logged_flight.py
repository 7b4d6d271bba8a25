"""Verdicts, comparison and tables of made-up flights."""

from __future__ import annotations

import csv
import json
import struct

import numpy as np
import pytest

from halfroll.errors import InputError
from halfroll.flight_recorder import EMBEDDED_PIECE, FlightRecorder
from halfroll.results.comparison import compare
from halfroll.results.log import read_log
from halfroll.results.log_export import export
from halfroll.results.log_facts import facts
from halfroll.results.logged_flight import LoggedFlight, require_flight
from halfroll.station.record import Event
from halfroll.wire.cutting import frames, only_plain
from halfroll.wire.tlog import RecordedTransport
from halfroll.wire.transport import MemoryTransport

FLOWN = Event("armed", 1.0, "armed, taking off")


@pytest.fixture
def logged(tmp_path, fly_circle):
    """A flight to which the ground has added how it ended, and what was said."""

    def log(error=None, texts=(), embedded=None, name="f.ulg", **flight):
        path = fly_circle(tmp_path / name, **flight)
        with path.open("ab") as file:
            for t_s, severity, text in texts:
                body = struct.pack("<BQ", ord("0") + severity, round(t_s * 1e6)) + text.encode()
                file.write(struct.pack("<HB", len(body), ord("L")) + body)
        recorder = FlightRecorder(path, {"mission": "box.plan", **(embedded or {})})
        recorder.hear(FLOWN)
        recorder.end(None, error, {"notes": []})
        return path

    return log


def verdict(path):
    return require_flight(read_log(path)).verdict


def test_a_crash_is_the_verdict_and_what_was_said_before_it_the_cause(logged):
    texts = [(4.0, 2, "Rotor 2 failed"), (4.5, 2, "crashed at 4.500 s, met the ground at 7.1 m/s")]
    found = verdict(logged(InputError("the simulator ended"), texts))
    assert not found.good
    assert found.line == "Crashed: crashed at 4.500 s, met the ground at 7.1 m/s"
    assert found.causes == ("4.00 s: Rotor 2 failed", "the simulator ended")


def test_an_error_that_ended_the_flight_is_the_verdict(logged):
    found = verdict(logged(InputError("the vehicle landed early"), [(3.0, 4, "Fence breached"), (2.0, 6, "hello")]))
    assert found.line == "Failed: the vehicle landed early"
    assert found.causes == ("3.00 s: Fence breached",)


def test_a_log_that_was_never_closed_says_that_the_simulator_was_killed(logged, ulog_bytes, tmp_path):
    rows = {"vehicle_truth": [(1000 * ms, *[0.0] * 6, 1, *[0.0] * 10) for ms in range(10)]}
    (tmp_path / "k.ulg").write_bytes(ulog_bytes(rows))
    assert "the simulator was killed" in verdict(tmp_path / "k.ulg").line


def test_a_text_of_any_length_is_kept_whole(logged):
    long = "Größe äöü €\n" * EMBEDDED_PIECE
    assert read_log(logged(embedded={"mission_file": long})).embedded["mission_file"] == long


def test_a_plan_comes_back_bit_for_bit_and_is_judged(logged, tmp_path):
    from halfroll import plan

    made = plan("examples/first_flight.plan")
    flight = LoggedFlight.of(read_log(logged(embedded={"plan": made.as_json()})))
    assert flight.plan.as_json() == made.as_json()
    assert (flight.plan.trajectory.coefficients == made.trajectory.coefficients).all()
    assert flight.figures is None  # it was never begun


def test_a_plan_that_is_none_is_refused_by_name(logged):
    with pytest.raises(InputError, match=r"the plan in .*f\.ulg is not a plan"):
        LoggedFlight.of(read_log(logged(embedded={"plan": "{}"})))


def test_equal_flights_have_equal_commands_and_are_not_apart(logged):
    flights = [require_flight(read_log(logged(name=name))) for name in ("a.ulg", "b.ulg")]
    found = compare(*flights)
    assert found.same_commands
    assert found.apart_max_m == 0.0
    assert all(figure.difference in (0.0, None) for figure in found.figures)


def test_flights_are_apart_by_their_offset_and_commands_differ_from_the_first_other_bit_on(logged):
    first = require_flight(read_log(logged(name="a.ulg")))
    second = require_flight(read_log(logged(name="b.ulg", offset=(0.0, 0.3, 0.0), thrust_peak=2.6)))
    found = compare(first, second)
    assert found.apart_max_m == pytest.approx(0.3, abs=1e-6)
    assert found.same_until_s == pytest.approx(3.0, abs=0.01)
    json.dumps(found.as_json())


def test_facts_count_samples_rates_and_gaps(tmp_path, ulog_bytes):
    rows = [(1000 * ms, 1, 2, 3, 4) for ms in range(100) if ms not in (40, 41)]
    truth = [(1000 * ms, *[0.0] * 6, 1, *[0.0] * 10) for ms in range(100)]
    (tmp_path / "g.ulg").write_bytes(ulog_bytes({"rotor_commands": rows, "vehicle_truth": truth}))
    commands, whole = facts(read_log(tmp_path / "g.ulg")).topics
    assert (commands.samples, commands.gaps, whole.gaps) == (98, 1, 0)
    assert commands.longest_interval_s == pytest.approx(0.003)
    assert whole.rate_hz == pytest.approx(1000.0)


def test_a_table_gives_back_every_bit(tmp_path, ulog_bytes):
    chance = np.random.default_rng(1)
    sent = [(1000 * i, *chance.normal(size=4).astype(np.float32).tolist()) for i in range(50)]
    (tmp_path / "c.ulg").write_bytes(ulog_bytes({"rotor_commands": sent}))
    (file,) = export(read_log(tmp_path / "c.ulg"), tmp_path / "tables")
    with file.open() as lines:
        rows = list(csv.DictReader(lines))
    assert [np.float32(row["thrust.3"]) for row in rows] == [np.float32(row[4]) for row in sent]


def test_parquet_without_its_library_says_what_to_install(tmp_path, ulog_bytes, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    (tmp_path / "c.ulg").write_bytes(ulog_bytes({"rotor_commands": [(0, 1, 2, 3, 4)]}))
    with pytest.raises(InputError, match="pip install pyarrow"):
        export(read_log(tmp_path / "c.ulg"), tmp_path, "parquet")


HEARTBEAT = bytes.fromhex("fd09000000ffbe000000") + bytes(9) + b"\x12\x34"


def test_a_datagram_of_several_frames_is_kept_frame_by_frame():
    signed = b"\xfd\x01\x01" + bytes(7) + b"x" + bytes(2) + bytes(13)
    old = b"\xfe\x02" + bytes(4) + b"xy" + bytes(2)
    assert list(frames(b"\x00" + HEARTBEAT + signed + old + HEARTBEAT[:9])) == [HEARTBEAT, signed, old]
    assert only_plain(HEARTBEAT + HEARTBEAT) == [HEARTBEAT] * 2
    for beside in (signed, old, HEARTBEAT[:9], b"\x00", b"\xfd\x00"):
        assert only_plain(HEARTBEAT + beside) is None


def test_both_directions_are_recorded_behind_their_time(tmp_path):
    here, there = MemoryTransport.pair()
    recorded = RecordedTransport(here, tmp_path / "l.tlog")
    recorded.time_us = lambda: 5_000_000
    recorded.send(HEARTBEAT)
    there.send(HEARTBEAT + HEARTBEAT)
    assert recorded.receive() == [HEARTBEAT + HEARTBEAT]
    assert there.receive() == [HEARTBEAT]
    recorded.close()
    kept = (tmp_path / "l.tlog").read_bytes()
    size = 8 + len(HEARTBEAT)
    stamps = [struct.unpack(">Q", kept[i : i + 8])[0] for i in range(0, len(kept), size)]
    assert [kept[i + 8 : i + size] for i in range(0, len(kept), size)] == [HEARTBEAT] * 3
    assert len(set(stamps)) == 1
