"""Fly a mission as any ground control station does: upload, arm, start, watch.

Start the simulator and the ground station first, each in a terminal of its own:

    halfroll sitl
    halfroll ground

then run this in a third, with a QGroundControl .plan or a .waypoints file, or with nothing for a 4 m box:

    python examples/upload_and_fly.py [MISSION]

Plain pymavlink: nothing here knows how the mission is flown. The ground station sees it in the autopilot, plans it, and
takes over once the vehicle has taken off. Without a ground station the autopilot flies the mission alone, slowly.
"""

import argparse
import json
import math
import os
import sys
import time
from pathlib import Path

os.environ.setdefault("MAVLINK20", "1")  # before pymavlink is imported
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mav

GCS_PORT = 14550
MISSION_MODE = (4, 4)  # main and sub mode
COMPLETE = 5  # MISSION_CURRENT.mission_state
HOME = (47.397742, 8.545594)
ANSWER_WITHIN_S = 5.0
PLANNING_WITHIN_S = 5.0  # a ground station that is there says so
ARMING_TRIES = 20
AUTOPILOT = 1  # component id

Item = tuple[int, int, list[float]]  # command, frame, param 1..7 with latitude and longitude in degrees


def box() -> list[Item]:
    """Up 3 m, around a 4 m square, down again."""
    takeoff, waypoint, land = mav.MAV_CMD_NAV_TAKEOFF, mav.MAV_CMD_NAV_WAYPOINT, mav.MAV_CMD_NAV_LAND
    legs = [(takeoff, 0, 0), (waypoint, 4, 0), (waypoint, 4, 4), (waypoint, 0, 4), (waypoint, 0, 0), (land, 0, 0)]
    north_deg = 1.0 / 111_200.0
    east_deg = north_deg / math.cos(math.radians(HOME[0]))
    return [
        (number, 3, [0.0, 0.0, 0.0, math.nan, HOME[0] + n * north_deg, HOME[1] + e * east_deg, 3.0 * (number != land)])
        for number, n, e in legs
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


def wait_for_plan(link: mavutil.mavfile) -> None:
    """The ground station says so through the autopilot."""
    began_s, is_planning = time.monotonic(), False
    while is_planning or time.monotonic() - began_s < PLANNING_WITHIN_S:
        message = wait_for(link, "STATUSTEXT", "HEARTBEAT")
        if message.get_type() == "STATUSTEXT":
            print(f"  {message.text}")
            is_planning = is_planning or "planning" in message.text
            if "plan ready" in message.text or ("plan" in message.text and "not" in message.text):
                return
    print("no ground station plans it, the autopilot flies alone")


def start(link: mavutil.mavfile) -> None:
    """Mission mode, then arm, which starts it; the autopilot may still be finding out where it is."""
    if not command(link, mav.MAV_CMD_DO_SET_MODE, 1, *MISSION_MODE):
        sys.exit(f"it does not start: {wait_for(link, 'STATUSTEXT').text}")
    for _ in range(ARMING_TRIES):
        if command(link, mav.MAV_CMD_COMPONENT_ARM_DISARM, 1):
            return
        reason = wait_for(link, "STATUSTEXT").text
        time.sleep(1.0)
    sys.exit(f"it does not arm: {reason}")


def watch_until_landed(link: mavutil.mavfile) -> int:
    """Prints what happens; the state of the mission when the vehicle has disarmed."""
    state, seq, has_armed = 0, -1, False
    while True:
        message = wait_for(link, "HEARTBEAT", "MISSION_CURRENT", "STATUSTEXT")
        if message.get_type() == "STATUSTEXT":
            print(f"  {message.text}")
        elif message.get_type() == "MISSION_CURRENT":
            state = message.mission_state
            if message.seq != seq:
                seq = message.seq
                print(f"on the way to item {seq}")
        elif message.get_srcComponent() == AUTOPILOT:
            armed = bool(message.base_mode & mav.MAV_MODE_FLAG_SAFETY_ARMED)
            if has_armed and not armed:
                return state
            has_armed = armed


def main() -> None:
    parser = argparse.ArgumentParser(description="Fly a mission as any ground control station does.")
    parser.add_argument("mission", nargs="?", type=Path, help=".plan or .waypoints; default a 4 m box")
    parser.add_argument("--port", type=int, default=GCS_PORT, help=f"of halfroll sitl's --peer-gcs ({GCS_PORT})")
    given = parser.parse_args()
    items = read(given.mission) if given.mission else box()
    link = mavutil.mavlink_connection(f"udpin:127.0.0.1:{given.port}", source_system=255, source_component=190)
    while (heard := wait_for(link, "HEARTBEAT")).get_srcComponent() != AUTOPILOT:
        pass
    link.target_system, link.target_component = heard.get_srcSystem(), AUTOPILOT
    upload(link, items)
    print(f"{len(items)} items stored")
    wait_for_plan(link)
    start(link)
    print("armed and started")
    state = watch_until_landed(link)
    print("landed and disarmed, mission " + ("complete" if state == COMPLETE else f"not complete (state {state})"))
    sys.exit(state != COMPLETE)


if __name__ == "__main__":
    main()
