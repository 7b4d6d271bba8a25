"""`halfroll params`: a running autopilot's parameters to a file and back, beside whoever else talks to it."""

from __future__ import annotations

from pathlib import Path

from system.gcs import Gcs
from system.processes import free_instance, halfroll, simulator


def test_parameters_travel_by_file(tmp_path: Path) -> None:
    file = tmp_path / "vehicle.params"
    with simulator() as (_, instance), Gcs(instance) as gcs:
        gcs.until(lambda m: m.get_type() == "HEARTBEAT")
        written = halfroll("params", "export", file, "--instance", str(instance))
        assert written.code == 0, written.err
        text = file.read_text()
        assert "\t1\tNAV_ACC_RAD\t2.0\t9" in text
        changed = text.replace("NAV_ACC_RAD\t2.0", "NAV_ACC_RAD\t1.5")
        file.write_text(changed)
        read = halfroll("params", "import", file, "--instance", str(instance))
        assert (read.code, read.out) == (0, "1 changed\n"), read.err
        ask = gcs._codec.param_request_read_encode(*gcs._target, b"NAV_ACC_RAD", -1)
        assert (
            gcs.until(lambda m: m.get_type() == "PARAM_VALUE" and m.param_id == "NAV_ACC_RAD", ask).param_value == 1.5
        )
        file.write_text(changed.replace("ATT_WN\t16.0", "ATT_WN\t1e6") + "1\t1\tNO_SUCH\t1\t9\n")
        read = halfroll("params", "import", file, "--instance", str(instance))
        assert read.code == 2
        assert "NO_SUCH: unknown here" in read.err
        assert "ATT_WN: refused" in read.err


def test_without_an_autopilot_it_says_so(tmp_path: Path) -> None:
    said = halfroll("params", "export", tmp_path / "p.params", "--instance", str(free_instance()))
    assert said.code == 3
    assert "did not answer" in said.err
