"""Fly a mission as any ground control station does: upload, arm, start, watch.

Start the simulator and the ground station first, each in a terminal of its own:

    halfroll sitl
    halfroll ground

then run this in a third, with a QGroundControl .plan or a .waypoints file, or with nothing for a 4 m box:

    python examples/upload_and_fly.py [MISSION]

Plain pymavlink: nothing here knows how the mission is flown. The ground station sees it in the autopilot, plans it, and
takes over once the vehicle has taken off.
"""

import json
import math
import sys
from pathlib import Path

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mav

GCS_PORT = 14550
MISSION_MODE = (4, 4)  # main and sub mode
COMPLETE = 5  # MISSION_CURRENT.mission_state
HOME = (47.397742, 8.545594)
ANSWER_WITHIN_S = 5.0
POSITION_COMMANDS = (mav.MAV_CMD_NAV_TAKEOFF, mav.MAV_CMD_NAV_WAYPOINT, mav.MAV_CMD_NAV_LAND)

Item = tuple[int, int, list[float]]  # command, frame, param 1..7 with latitude and longitude in degrees


def box() -> list[Item]:
    """Up 3 m, around a 4 m square, down again."""
    metre = 1.0 / 111_200.0
    corners = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0)]
    commands = [mav.MAV_CMD_NAV_TAKEOFF, *[mav.MAV_CMD_NAV_WAYPOINT] * 4, mav.MAV_CMD_NAV_LAND]
    heights = [3.0] * 5 + [0.0]
    places = [(HOME[0] + n * metre, HOME[1] + e * metre / math.cos(math.radians(HOME[0]))) for n, e in [*corners, (0, 0)]]
    return [
        (command, 3, [0.0, 0.0, 0.0, math.nan, lat, lon, height])
        for command, (lat, lon), height in zip(commands, places, heights)
    ]


def read(path: Path) -> list[Item]:
    """The simple items of a QGroundControl .plan, or a QGC WPL 110 text file."""
    text = path.read_text()
    if path.suffix == ".plan":
        items = json.loads(text)["mission"]["items"]
        return [(i["command"], i["frame"], [math.nan if p is None else p for p in i["params"]]) for i in items]
    rows = [line.split("\t") for line in text.splitlines()[1:] if line.strip()]
    return [(int(row[3]), int(row[2]), [float(number) for number in row[4:11]]) for row in rows]


def wait_for(link: mavutil.mavfile, *kinds: str) -> mav.MAVLink_message:
    message = link.recv_match(type=list(kinds), blocking=True, timeout=ANSWER_WITHIN_S)
    if message is None:
        sys.exit(f"no {' or '.join(kinds)} within {ANSWER_WITHIN_S:.0f} s: is halfroll sitl running?")
    return message


def upload(link: mavutil.mavfile, items: list[Item]) -> None:
    link.mav.mission_count_send(link.target_system, link.target_component, len(items))
    while True:
        asked = wait_for(link, "MISSION_REQUEST_INT", "MISSION_ACK")
        if asked.get_type() == "MISSION_ACK":
            if asked.type != mav.MAV_MISSION_ACCEPTED:
                sys.exit(f"the mission was refused: {mav.enums['MAV_MISSION_RESULT'][asked.type].name}")
            return
        command, frame, (p1, p2, p3, p4, x, y, z) = items[asked.seq]
        scale = 1 if frame == mav.MAV_FRAME_MISSION else 1e7
        place = (round(x * scale), round(y * scale), z)
        link.mav.mission_item_int_send(
            link.target_system, link.target_component, asked.seq, frame, command, 0, 1, p1, p2, p3, p4, *place
        )


def command(link: mavutil.mavfile, number: int, *params: float) -> bool:
    filled = [*params, *[0.0] * (7 - len(params))]
    link.mav.command_long_send(link.target_system, link.target_component, number, 0, *filled)
    while True:
        answer = wait_for(link, "COMMAND_ACK")
        if answer.command == number:
            return answer.result == mav.MAV_RESULT_ACCEPTED


def watch_until_landed(link: mavutil.mavfile) -> int:
    """Prints what happens; the state of the mission when the vehicle has disarmed."""
    state, seq = 0, -1
    while True:
        message = wait_for(link, "HEARTBEAT", "MISSION_CURRENT", "STATUSTEXT")
        if message.get_type() == "STATUSTEXT":
            print(f"  {message.text}")
        elif message.get_type() == "MISSION_CURRENT":
            state = message.mission_state
            if message.seq != seq:
                seq = message.seq
                print(f"on the way to item {seq}")
        elif message.get_srcComponent() == 1 and not message.base_mode & mav.MAV_MODE_FLAG_SAFETY_ARMED:
            return state


def main() -> None:
    items = read(Path(sys.argv[1])) if len(sys.argv) > 1 else box()
    link = mavutil.mavlink_connection(f"udpin:127.0.0.1:{GCS_PORT}", source_system=255, source_component=190, dialect="common")
    while link.recv_match(type="HEARTBEAT", blocking=True, timeout=ANSWER_WITHIN_S).get_srcComponent() != 1:
        pass
    link.target_system, link.target_component = link.sysid or 1, 1
    upload(link, items)
    print(f"{len(items)} items stored; waiting for the plan")
    while "plan" not in wait_for_text(link):
        pass
    if not command(link, mav.MAV_CMD_DO_SET_MODE, 1, *MISSION_MODE) or not command(link, mav.MAV_CMD_COMPONENT_ARM_DISARM, 1):
        sys.exit(f"it does not start: {wait_for_text(link)}")
    print("armed and started")
    while not wait_for(link, "HEARTBEAT").base_mode & mav.MAV_MODE_FLAG_SAFETY_ARMED:
        pass
    state = watch_until_landed(link)
    print("landed and disarmed, mission " + ("complete" if state == COMPLETE else f"not complete (state {state})"))
    sys.exit(state != COMPLETE)


if __name__ == "__main__":
    main()
