"""Two ground stations at once on one link: the autopilot is flown by the one that was first.

Why: a second laptop that was left running must neither fly the vehicle nor keep the first from flying it.
"""

from __future__ import annotations

import pytest

from halfroll.station.station import State, Station
from halfroll.wire.link import Link
from halfroll.wire.messages import GROUND
from system.links.faulty_link import Faults
from system.links.linked_flight import A, Errand, LinkedFlight, RememberedPlans, hear_all
from system.links.test_ground_killed import PAUSE_CONTINUE, fly_until
from system.processes import MISSIONS

GOOD = Faults(delay_ms=2)


class TwoStations(LinkedFlight):
    """The other one speaks from another port, as a second laptop does."""

    ends = (*LinkedFlight.ends, (A, 1))

    def __init__(self, errand: Errand, seed: int) -> None:
        super().__init__(errand, GOOD, seed)
        self._other_link = Link(self._end(2), GROUND)
        self.other = Station(
            self._other_link,
            errand.vehicle,
            RememberedPlans(self.clock),
            errand.options,
            finer=errand.mission,
            clock=self.clock,
        )

    def _turn(self) -> None:
        super()._turn()
        hear_all([self._other_link], [self.other.hear])
        self.other.go_on()


@pytest.fixture(scope="module")
def box() -> Errand:
    return Errand.of(MISSIONS / "box.plan")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_second_station_does_not_disturb_the_first(box: Errand, seed: int) -> None:
    flight = TwoStations(box, seed)
    account = flight.fly()
    assert account.ended == "completed by the plan", account
    assert "Offboard: setpoint dropped (another source)" in account.texts
    assert not account.crashed
    assert not account.broken


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_when_the_one_that_flies_is_killed_the_vehicle_is_safe_and_the_mission_goes_on(box: Errand, seed: int) -> None:
    flight = TwoStations(box, seed)
    fly_until(flight, lambda: flight.record is not None and len(flight.record.error_m) > 100 + 50 * seed)
    flight.end_station()
    killed_s = flight.clock()
    fly_until(flight, lambda: flight.clock() > killed_s + 6.0)
    if "Offboard: setpoints regained" not in flight.account.texts:  # the other's, in the millisecond of the failsafe
        assert "Failsafe: offboard lost, Hold" in flight.account.texts
        assert flight.hovers
        assert flight.other.state is State.READY  # with a plan of what is left
        flight.say(PAUSE_CONTINUE, 1.0)
    fly_until(flight, lambda: flight.clock() > killed_s + 60.0)
    assert flight.pilot.done
    assert not flight.world.crashed
    assert not flight.account.broken
