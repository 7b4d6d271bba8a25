"""How several workers share the tests."""

from __future__ import annotations

from pathlib import Path

import pytest

_STARTS_PROCESSES = ("system", "hil", "test_readme.py")
_IN_PROCESS = "system/contract"


@pytest.hookimpl(tryfirst=True)  # before the workers read the groups
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """One worker runs what starts simulators and ground stations, as these listen on the same ports; others go file by
    file, so that what a file prepares is prepared once."""
    here = Path(__file__).parent
    for item in items:
        path = item.path.relative_to(here)
        shares_ports = path.parts[0] in _STARTS_PROCESSES and not path.is_relative_to(_IN_PROCESS)
        item.add_marker(pytest.mark.xdist_group("ports" if shares_ports else str(path)))
