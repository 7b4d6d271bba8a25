"""Reading logs. The file is written by the tests' own few lines of struct (conftest), not by the code that flies."""

from __future__ import annotations

import numpy as np
import pytest

from ground.conftest import ulog_message
from halfroll.errors import InputError
from halfroll.results.log import read_log


def test_a_topic_is_arrays_in_vehicle_seconds_with_array_fields_as_columns(tmp_path, fly_circle):
    log = read_log(fly_circle(tmp_path / "f.ulg"))
    truth = log["vehicle_truth"]
    assert truth.t[:2] == pytest.approx([0.0, 0.002])
    assert truth["p"].shape == (len(truth), 3)
    assert truth["q"].shape == (len(truth), 4)
    assert log["vehicle_state"]["mode"].shape == (len(log["vehicle_state"]),)
    assert np.all(np.diff(truth.t) > 0)


def test_array_fields_keep_their_order(tmp_path, ulog_bytes):
    path = tmp_path / "f.ulg"
    path.write_bytes(ulog_bytes({"rotor_commands": [(1000, 0.5, -1.5, 2.5, -3.0)]}))
    assert read_log(path)["rotor_commands"]["thrust"].tolist() == [[0.5, -1.5, 2.5, -3.0]]


def test_what_the_writer_said_is_in_info(tmp_path, fly_circle):
    info = read_log(fly_circle(tmp_path / "f.ulg")).info
    assert info["vehicle"] == "mit-vp"
    assert info["commands_sha256"] == "ab" * 32


def test_a_log_cannot_be_changed(tmp_path, fly_circle):
    log = read_log(fly_circle(tmp_path / "f.ulg"))
    with pytest.raises(ValueError, match="read-only"):
        log["vehicle_truth"]["p"][0, 0] = 1.0
    with pytest.raises(TypeError):
        log.topics["vehicle_truth"] = None


def test_a_log_cut_short_in_a_sample_is_read_as_far_as_it_goes(tmp_path, fly_circle):
    path = fly_circle(tmp_path / "f.ulg")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 4])
    assert 0 < len(read_log(path)["vehicle_truth"]) < 5000


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", "not a ULog file"),
        (b"PK\x03\x04 something else entirely, and long enough", "not a ULog file"),
        (b"ULog\x01\x12\x35\x01" + bytes(8), "ends before its first sample"),
    ],
)
def test_what_is_no_log_is_refused_in_one_sentence(tmp_path, content, complaint):
    path = tmp_path / "f.ulg"
    path.write_bytes(content)
    with pytest.raises(InputError, match=complaint) as refused:
        read_log(path)
    assert str(path) in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_log_whose_writer_died_before_the_first_sample_says_so(tmp_path, ulog_bytes):
    path = tmp_path / "f.ulg"
    path.write_bytes(ulog_bytes({"vehicle_truth": []}))
    with pytest.raises(InputError, match="before its first sample"):
        read_log(path)


def test_a_missing_file_topic_or_field_is_named(tmp_path, fly_circle):
    with pytest.raises(InputError, match="cannot be read: No such file"):
        read_log(tmp_path / "none.ulg")
    log = read_log(fly_circle(tmp_path / "f.ulg"))
    with pytest.raises(InputError, match="nothing was logged as wind"):
        log["wind"]
    with pytest.raises(InputError, match="vehicle_truth has no field colour"):
        log["vehicle_truth"]["colour"]


def test_every_single_byte_that_is_wrong_gives_a_log_or_a_sentence(tmp_path, ulog_bytes):
    whole = ulog_bytes({"rotor_commands": [(1000, 1, 2, 3, 4), (2000, 1, 2, 3, 4)]}, {"vehicle": "mit-vp"})
    path = tmp_path / "f.ulg"
    for place in range(len(whole)):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        try:
            read_log(path)
        except InputError:
            continue


def test_reading_prints_nothing_on_standard_output(tmp_path, fly_circle, capsys):
    path = fly_circle(tmp_path / "f.ulg")
    path.write_bytes(path.read_bytes()[:-7])
    read_log(path)
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("formats", "complaint"),
    [
        ([b"a:uint64_t timestamp;a x;"], "holds others without end"),
        ([b"a:uint64_t timestamp;float[60000] x;"], "more than 2000 columns"),
        ([b"b:float[100] x;", b"a:b[100] x;uint64_t timestamp;"], "more than 2000 columns"),
    ],
)
def test_a_topic_without_an_end_is_refused_before_it_is_begun(tmp_path, formats, complaint):
    path = tmp_path / "f.ulg"
    messages = [ulog_message("F", each) for each in formats] + [ulog_message("A", b"\0\0\0a")]
    path.write_bytes(b"ULog\x01\x12\x35\x01" + bytes(8) + b"".join(messages))
    with pytest.raises(InputError, match=complaint):
        read_log(path)


def test_a_log_that_is_mostly_damaged_is_given_up(tmp_path, ulog_bytes):
    path = tmp_path / "f.ulg"
    path.write_bytes(ulog_bytes({"rotor_commands": [(1000, 1, 2, 3, 4)]}) + b"\xf0\xf0" * 100_000)
    with pytest.raises(InputError, match="most of it is damaged"):
        read_log(path)
