"""Make the MAVLink dialect: C headers for the firmware and a Python module for the ground, from one definition.

Why: the installed definition lags the public one by a few extension fields that the mission protocol needs
(mission_id, opaque_id). Extension fields do not change a message's CRC, so adding them here stays compatible.
"""

from __future__ import annotations

import contextlib
import io
import shutil
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pymavlink
from pymavlink.generator import mavgen, mavparse

DIALECT = "development"
INCLUDED = ("development", "common", "standard", "minimal")
EXTENSIONS = {
    "MISSION_CURRENT": ("mission_id", "fence_id", "rally_points_id"),
    "MISSION_ACK": ("opaque_id",),
    "MISSION_COUNT": ("opaque_id",),
}


def complete(xml: Path) -> None:
    """Append the extension fields that are missing; only to messages that already have extensions."""
    tree = ET.parse(xml)
    for message in tree.iter("message"):
        wanted = EXTENSIONS.get(message.get("name", ""), ())
        present = {field.get("name") for field in message.iter("field")}
        missing = [name for name in wanted if name not in present]
        if missing and message.find("extensions") is None:
            raise SystemExit(f"{xml.name}: {message.get('name')} has no extensions to append {missing} to")
        for name in missing:
            ET.SubElement(message, "field", type="uint32_t", name=name).text = "appended"
    tree.write(xml)


def main(out: Path) -> None:
    definitions = Path(pymavlink.__file__).parent / "dialects" / "v20"
    copies = out / "definitions"
    copies.mkdir(parents=True, exist_ok=True)
    for name in INCLUDED:
        shutil.copy(definitions / f"{name}.xml", copies)
        complete(copies / f"{name}.xml")
    chatter = io.StringIO()
    for language, output in (("C", out / "mavlink"), ("Python3", out / "_dialect.py")):
        options = mavgen.Opts(str(output), wire_protocol=mavparse.PROTOCOL_2_0, language=language, validate=False)
        with contextlib.redirect_stdout(chatter), contextlib.redirect_stderr(chatter):
            done = mavgen.mavgen(options, [str(copies / f"{DIALECT}.xml")])
        if done is False:
            raise SystemExit(f"mavgen failed for {language}:\n{chatter.getvalue()}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
