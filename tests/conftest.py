"""How several workers share the tests, and that none of them is timed."""

from __future__ import annotations

import hypothesis
import pytest
from xdist.scheduler import LoadScopeScheduling

_STARTS_PROCESSES = ("tests/system/", "tests/hil/", "tests/test_readme.py")
_IN_PROCESS = "tests/system/contract/"

hypothesis.settings.register_profile("halfroll", deadline=None)  # a slow moment of the machine is no failure
hypothesis.settings.load_profile("halfroll")


class ByFileAndPorts(LoadScopeScheduling):
    """One worker runs what starts simulators and ground stations, as these listen on the same ports.

    The rest goes file by file, so that what a file prepares is prepared once.
    """

    def _split_scope(self, nodeid: str) -> str:
        file = nodeid.split("::")[0]
        return "ports" if file.startswith(_STARTS_PROCESSES) and not file.startswith(_IN_PROCESS) else file


def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> LoadScopeScheduling:
    return ByFileAndPorts(config, log)
