"""Parameter files in QGroundControl's format."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from halfroll.errors import InputError
from halfroll.param_files import read_params, write_params

QGC = """# Onboard parameters for Vehicle 1
#
# Stack: PX4 Pro
# Vehicle: Multi-Rotor
# Version: 1.14.0
#
# Vehicle-Id Component-Id Name Value Type
1\t1\tATT_WN\t16.000000000000000000\t9
1\t1\tMAV_SYS_ID\t1\t6
"""


def test_a_file_of_qgroundcontrol_is_read(tmp_path: Path) -> None:
    file = tmp_path / "vehicle.params"
    file.write_text(QGC)
    assert read_params(file) == {"ATT_WN": 16.0, "MAV_SYS_ID": 1.0}


@given(
    st.dictionaries(
        st.from_regex(r"[A-Z][A-Z0-9_]{0,15}", fullmatch=True),
        st.floats(width=32, allow_nan=False, allow_infinity=False),
        min_size=1,
    )
)
def test_what_is_written_comes_back_as_the_same_32_bit_floats(
    tmp_path_factory: pytest.TempPathFactory, values: dict[str, float]
) -> None:
    file = tmp_path_factory.mktemp("params") / "p.params"
    write_params(file, values)
    back = read_params(file)
    assert {name: struct.pack("<f", value) for name, value in back.items()} == {
        name: struct.pack("<f", value) for name, value in values.items()
    }


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("1\t1\tATT_WN\t16", "line 1: 4 columns"),
        ("1\t1\tATT_WN\tfast\t9", "ATT_WN is 'fast'"),
        ("1\t1\tATT_WN\tnan\t9", "must be finite"),
        ("1\t1\tATT_WN\t16\t9\n1\t1\tATT_WN\t17\t9", "line 2: ATT_WN stands there twice"),
        ("# nothing", "no parameters"),
    ],
)
def test_a_wrong_line_is_named(tmp_path: Path, line: str, complaint: str) -> None:
    file = tmp_path / "wrong.params"
    file.write_text(line + "\n")
    with pytest.raises(InputError, match=complaint):
        read_params(file)
