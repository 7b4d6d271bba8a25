"""Write docs/parameters.md from the table that the firmware itself carries."""

from __future__ import annotations

from pathlib import Path

from halfroll import _firmware

WHOLE, LOCKED, READ_ONLY = 1, 2, 4
HEAD = """# Parameters

Made from `firmware/core/params.def` by `python docs/make_parameters.py`; a test compares the two. All are 32-bit
floats on the wire. A vehicle's own values stand in the `[params]` table of its file in `ground/halfroll/vehicles/`;
`--set params.ATT_WN=12` overrides one for one run, any MAVLink client changes them while the autopilot runs.

The paper has no reference extrapolation, no actuator lead and no fade: `REF_EXTRAP = 0`, `ACT_LEAD = 0`,
`FADE_FORCE = 0` and `SIGN_RULE = 1` together are the paper's own controller.

| parameter | default | range | unit | meaning |
|---|---|---|---|---|
"""


def row(info: _firmware.ParamInfo) -> str:
    notes = [
        note
        for flag, note in ((WHOLE, "whole"), (LOCKED, "locked while armed"), (READ_ONLY, "read-only"))
        if info.flags & flag
    ]
    meaning = info.meaning + (f" ({', '.join(notes)})" if notes else "")
    return f"| `{info.id}` | {info.default:g} | {info.least:g} … {info.most:g} | {info.unit} | {meaning} |\n"


def text() -> str:
    return HEAD + "".join(row(info) for info in _firmware.parameter_table())


if __name__ == "__main__":
    Path(__file__).with_name("parameters.md").write_text(text())
