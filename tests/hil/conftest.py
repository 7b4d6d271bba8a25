from __future__ import annotations

import pytest

from hil.flights import TURN_OVER, Report, flip_flight

SHORT_S = 15.0


@pytest.fixture(scope="session")
def short_flip() -> Report:
    """A quarter of a minute on the Cortex-M4, with a half turn at its end."""
    return flip_flight("qemu-m4", SHORT_S, [TURN_OVER])
