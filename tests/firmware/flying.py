"""An autopilot in the air, without any process: what the tests of the firmware begin with."""

from __future__ import annotations

from halfroll import _dialect, _firmware


def new(vehicle: str = "mit-vp", scenario: str = "nominal") -> tuple[_firmware.Autopilot, _firmware.World]:
    setup = _firmware.vehicle_setup(vehicle)
    return _firmware.Autopilot(setup.vehicle, setup.params), _firmware.World(setup.plant, scenario, 3)


def command(autopilot: _firmware.Autopilot, number: int, *params: float) -> list[int]:
    """Results of the acknowledgements to one COMMAND_LONG from a ground control station."""
    gcs = _dialect.MAVLink(None, srcSystem=255, srcComponent=190)
    filled = [*params, *[0.0] * (7 - len(params))]
    message = _dialect.MAVLink_command_long_message(1, 1, number, 0, *filled)
    parser = _dialect.MAVLink(None)
    sent = [bytes(frame) for _, _, frame in autopilot.service(message.pack(gcs), link=1)]
    received = [m for frame in sent for m in parser.parse_buffer(frame) or []]
    return [m.result for m in received if m.get_type() == "COMMAND_ACK"]


def airborne(vehicle: str = "mit-vp", scenario: str = "nominal") -> tuple[_firmware.Autopilot, _firmware.World]:
    """Ten seconds after a takeoff to 3 m."""
    autopilot, world = new(vehicle, scenario)
    autopilot.fly(world, 1000)
    assert command(autopilot, _dialect.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 3.0) == [0]
    assert command(autopilot, _dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1.0) == [0]
    autopilot.fly(world, 10000)
    return autopilot, world
