"""How several workers share the tests, that none of them is timed, and what they leave for docs/reliability.md."""

from __future__ import annotations

import signal

import hypothesis
import pytest
from xdist.scheduler import LoadScopeScheduling

from figures import Collector

_STARTS_PROCESSES = ("tests/system/", "tests/hil/", "tests/test_readme.py")
_BY_MISSION = "tests/system/links/test_link_faults.py"
_IN_PROCESS = ("tests/system/contract/", "tests/system/links/", "tests/system/test_stream_lost_anywhere.py")

hypothesis.settings.register_profile("halfroll", deadline=None)  # a slow moment of the machine is no failure
hypothesis.settings.load_profile("halfroll")

# A shell's background job ignores Ctrl-C, and so would all that it starts.
signal.signal(signal.SIGINT, signal.default_int_handler)


class ByFileAndPorts(LoadScopeScheduling):
    """One worker runs what starts simulators and ground stations, as these listen on the same ports.

    The rest goes file by file, so that what a file prepares is prepared once; flights of one mission, which is planned
    once, together.
    """

    def _split_scope(self, nodeid: str) -> str:
        file = nodeid.split("::")[0]
        if file == _BY_MISSION:
            return file + nodeid.partition("[")[2].partition("-")[0]
        return "ports" if file.startswith(_STARTS_PROCESSES) and not file.startswith(_IN_PROCESS) else file


def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> LoadScopeScheduling:
    return ByFileAndPorts(config, log)


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Collector(), "reliability")
