"""Messages, against an autopilot that writes down what it heard."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from fake_autopilot import FakeAutopilot
from hypothesis import given
from hypothesis import strategies as st

from halfroll.errors import LinkError, MissionError
from halfroll.missions.mission import MissionItem
from halfroll.wire import messages as wire
from halfroll.wire.conversations import (
    SET_MISSION_CURRENT,
    NoAnswer,
    Talk,
    command,
    differing_item,
    download,
    read_param,
    read_params,
    set_mode,
    upload,
    write_param,
)
from halfroll.wire.link import Link, dialect
from halfroll.wire.transport import MemoryTransport

ITEMS = (
    MissionItem(22, 3, (15.0, 0.0, 0.0, math.nan), 473977394, 85455904, 5.0),
    MissionItem(16, 3, (0.1, 0.0, 0.0, -math.pi), 473978729, 85455932, 10.1),
    MissionItem(530, 2, (math.nan, 0.0, math.nan, math.nan), 0, 0, math.nan, autocontinue=False),
    MissionItem(21, 3, (0.0, 0.0, 0.0, math.nan), -473977394, -85455904, 0.0),
)


class Clock:
    """Goes on by itself, so that what is lost is repeated."""

    def __init__(self):
        self.s = 0.0

    def __call__(self):
        self.s += 0.01
        return self.s


@pytest.fixture
def connected():
    here, there = MemoryTransport.pair()
    link, autopilot = Link(here, wire.GCS, wire.GCS_SYSTEM), FakeAutopilot([there])
    autopilot.heartbeat()
    link.receive()
    return link, autopilot


def test_what_is_gathered_goes_out_together_and_in_order():
    here, there = MemoryTransport.pair()
    link = Link(here, wire.GROUND)
    link.address(1)
    with link.gathering():
        for n in range(40):
            link.send(link.status_text(f"{n:050}"))
    link.send(link.heartbeat())
    datagrams = there.receive()
    parser = dialect.MAVLink(None)
    said = [[message.to_dict() for message in parser.parse_buffer(datagram)] for datagram in datagrams]
    assert [len(frames) for frames in said] == [19, 19, 2, 1]
    assert max(map(len, datagrams)) <= 1200
    assert [int(frame["text"]) for frames in said[:3] for frame in frames] == list(range(40))


def test_what_was_gathered_before_an_error_is_sent():
    here, there = MemoryTransport.pair()
    link = Link(here, wire.GROUND)
    link.address(1)

    def falls_silent():
        with link.gathering():
            link.send(link.heartbeat())
            raise LinkError("silent")

    with pytest.raises(LinkError):
        falls_silent()
    assert len(there.receive()) == 1


def talk(link, autopilot, conversation, clock=None):
    """Carries a conversation to its end."""
    going = Talk(link, conversation, clock or Clock())
    while not going.done:
        autopilot.listen()
        for message in link.receive():
            going.hear(message)
        going.go_on()
    return going.result


def test_nothing_is_sent_before_an_autopilot_was_heard():
    here, there = MemoryTransport.pair()
    link = Link(here, wire.GROUND)
    link.send(link.heartbeat())
    assert there.receive() == []


def test_the_station_is_a_component_of_the_vehicle_it_hears():
    here, there = MemoryTransport.pair()
    link, autopilot = Link(here, wire.GROUND), FakeAutopilot([there])
    autopilot.heartbeat()
    link.receive()
    link.send(link.heartbeat())
    autopilot.listen()
    _, frame = autopilot.heard[-1]
    assert (frame.get_srcSystem(), frame.get_srcComponent(), frame.type, frame.autopilot) == (1, 191, 18, 8)
    assert (frame.base_mode, frame.custom_mode) == (0, 0)


def test_telemetry_is_north_west_up_and_forward_left_up(connected):
    link, autopilot = connected
    autopilot.send("attitude_quaternion", 120, 0.5, 0.1, 0.2, 0.3, 1.0, 2.0, 3.0)
    autopilot.send("local_position_ned", 120, 1.0, 2.0, -3.0, 0.1, 0.2, 0.3)
    (here,) = link.receive()
    assert here.t_us == 120_000
    assert here.p_WB == pytest.approx([1.0, -2.0, 3.0])  # 2 m east is -2 m west, 3 m up is -3 m down
    assert here.v_WB == pytest.approx([0.1, -0.2, -0.3])
    assert here.w_WB_B == pytest.approx([1.0, -2.0, -3.0])
    assert here.q_WB == pytest.approx([0.5, 0.1, -0.2, -0.3])


def test_a_position_without_the_attitude_of_the_same_moment_is_no_telemetry(connected):
    link, autopilot = connected
    autopilot.send("attitude_quaternion", 120, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    autopilot.send("local_position_ned", 130, 1.0, 2.0, -3.0, 0.0, 0.0, 0.0)
    assert link.receive() == []


def test_the_halves_of_telemetry_may_come_in_any_order_between_those_of_other_moments(connected):
    link, autopilot = connected
    autopilot.send("local_position_ned", 130, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    autopilot.send("attitude_quaternion", 120, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    autopilot.send("attitude_quaternion", 130, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    autopilot.send("local_position_ned", 120, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert [(here.t_us, here.p_WB[0]) for here in link.receive()] == [(130_000, 2.0), (120_000, 1.0)]


def test_halves_whose_other_half_is_lost_are_forgotten(connected):
    link, autopilot = connected
    for ms in range(0, 1000, 10):
        autopilot.send("attitude_quaternion", ms, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    autopilot.send("local_position_ned", 0, 1.0, 2.0, -3.0, 0.0, 0.0, 0.0)
    assert link.receive() == []


def test_what_newer_news_has_passed_on_the_way_is_no_news(connected):
    link, autopilot = connected
    for seq, mode in ((150, 0), (253, 1), (1, 3), (255, 2), (2, 4), (0, 2), (3, 5)):
        autopilot.codecs[0].seq = seq
        autopilot.send("heartbeat", 2, 0, 29, mode, 3)
    assert [message.mode for message in link.receive()] == [0, 1, 3, 4, 5]


def test_an_autopilot_that_starts_again_is_heard_at_once(connected):
    link, autopilot = connected
    for seq, mode in ((200, 1), (0, 2), (1, 3)):
        autopilot.codecs[0].seq = seq
        autopilot.send("heartbeat", 2, 0, 29, mode, 3)
    assert [message.mode for message in link.receive()] == [1, 2, 3]


def test_the_time_is_heard_from_messages_that_nobody_reads_unless_they_are_damaged_or_another_vehicle_s(connected):
    link, autopilot = connected
    autopilot.send("attitude", 120, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0)
    assert (link.receive(), link.t_us) == ([], 120_000)
    autopilot.codecs[0].srcSystem = 2
    autopilot.send("attitude", 130, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0)
    assert (link.receive(), link.t_us) == ([], 120_000)
    damaged = bytearray(frame_of("attitude", 140, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0))
    damaged[12] ^= 1
    assert heard([bytes(damaged)]) == ([], 0)
    assert heard([frame_of("servo_output_raw", 140_000, 1, *[1500] * 8)]) == ([], 0)  # that is another time


@given(st.sets(st.integers(1, 200), max_size=12))
def test_bytes_in_any_portions_say_what_whole_datagrams_say(cuts):
    stream = b"".join([
        frame_of("attitude", 6, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0),
        frame_of("attitude_quaternion", 7, 1.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3),
        frame_of("local_position_ned", 7, 1.0, 2.0, -3.0, 0.1, 0.2, 0.3),
        frame_of("mission_item_reached", 3),
        frame_of("statustext", 6, b"Mission: plan ready"),
    ])  # fmt: skip
    edges = [0, *sorted(cut for cut in cuts if cut < len(stream)), len(stream)]
    assert heard([stream[a:b] for a, b in pairwise(edges)]) == heard([stream])
    assert heard([stream])[1] == 7000


def frame_of(name, *fields):
    codec = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    return getattr(codec, f"{name}_encode")(*fields).pack(codec)


def heard(pieces):
    """What a link makes of these, and the time it has then."""
    here, there = MemoryTransport.pair()
    link = Link(here, wire.GROUND)
    link.address(1)
    for piece in pieces:
        there.send(piece)
    return [str(message) for message in link.receive()], link.t_us


def test_a_setpoint_carries_attitude_rates_signed_thrust_and_its_stamp(connected):
    link, autopilot = connected
    link.send(link.attitude_target(1_230_000, np.array([0.8, 0.0, 0.6, 0.0]), np.array([1.0, 2.0, 3.0]), -0.25))
    autopilot.listen()
    (frame,) = autopilot.setpoints()
    assert (frame.time_boot_ms, frame.type_mask, frame.thrust) == (1230, 0, -0.25)
    assert frame.q == pytest.approx([0.8, 0.0, -0.6, 0.0])
    assert (frame.body_roll_rate, frame.body_pitch_rate, frame.body_yaw_rate) == (1.0, -2.0, -3.0)


def test_a_setpoint_beyond_what_is_taken_is_cut_rather_than_dropped_whole(connected):
    link, autopilot = connected
    link.send(link.attitude_target(0, [1.0, 0.0, 0.0, 0.0], [100.0, 0.0, 0.0], 1.5))
    autopilot.listen()
    (frame,) = autopilot.setpoints()
    assert (frame.body_roll_rate, frame.thrust) == (40.0, 1.0)


def test_only_the_autopilot_is_heard_and_what_the_station_said_through_it(connected):
    link, autopilot = connected
    for component in (2, 191):
        autopilot.codecs[0].srcComponent = component
        autopilot.send("statustext", 6, b"Mission: plan ready")
        autopilot.heartbeat()
    assert link.receive() == [wire.StatusText(6, "Mission: plan ready", 191)]


def test_a_mission_comes_back_as_it_was_sent_in_every_bit(connected):
    link, autopilot = connected
    mission_id = talk(link, autopilot, upload(link, ITEMS))
    assert mission_id == autopilot.mission_id
    stored_id, stored = talk(link, autopilot, download(link))
    assert stored_id == mission_id
    assert differing_item(ITEMS, stored) is None
    assert differing_item(ITEMS, (*stored[:2], stored[3], stored[3])) == 2
    assert differing_item(ITEMS, stored[:3]) == 3


@pytest.mark.parametrize("seed", range(5))
def test_a_transfer_survives_losses_in_both_directions(connected, seed):
    link, autopilot = connected
    lose = np.random.default_rng(seed)
    autopilot.lost = lambda frame: lose.random() < 0.3
    talk(link, autopilot, upload(link, ITEMS))
    _, stored = talk(link, autopilot, download(link))
    assert stored == ITEMS


def test_an_upload_whose_last_answer_is_lost_begins_again(connected):
    link, autopilot = connected
    acks = iter([True])
    autopilot.lost = lambda frame: frame.get_type() == "MISSION_ACK" and next(acks, False)
    assert talk(link, autopilot, upload(link, ITEMS)) == autopilot.mission_id


def test_a_refused_item_is_named_with_the_reason(connected):
    link, autopilot = connected
    bad = MissionItem(31, 3, (0.0, 0.0, 0.0, 0.0), 0, 0, 10.0)
    with pytest.raises(MissionError, match=r"item 2 .* not supported") as caught:
        talk(link, autopilot, upload(link, (*ITEMS[:2], bad)))
    assert (caught.value.item, caught.value.exit_code) == (2, 2)


def test_a_command_whose_answer_is_lost_is_sent_again(connected):
    link, autopilot = connected
    losses = iter([True, True])
    autopilot.lost = lambda frame: frame.get_type() == "COMMAND_ACK" and next(losses, False)
    assert talk(link, autopilot, command(link, SET_MISSION_CURRENT, 3.0, what="progress")) == wire.ACCEPTED
    assert autopilot.commands() == [(224, 3.0, 0.0, 0.0)] * 3


def test_a_round_trip_is_known_of_questions_that_were_asked_once(connected):
    link, autopilot = connected
    clock = Clock()
    talk(link, autopilot, read_param(link, "POS_KP_Z"), clock)
    assert len(link.round_trips_s) == 1
    lost = [True]
    autopilot.lost = lambda frame: frame.get_type() == "PARAM_VALUE" and bool(lost and lost.pop())
    talk(link, autopilot, read_param(link, "POS_KP_Z"), clock)
    assert len(link.round_trips_s) == 1


def test_the_result_of_a_refused_command_is_returned(connected):
    link, autopilot = connected
    autopilot.refuse[176] = wire.TEMPORARILY_REJECTED
    assert talk(link, autopilot, set_mode(link, wire.OFFBOARD)) == wire.TEMPORARILY_REJECTED
    assert autopilot.commands()[-1] == (176, 1.0, 6.0, 0.0)


@pytest.mark.parametrize("mode", list(wire.MODE_NAMES))
def test_a_mode_is_asked_for_by_its_main_and_sub_number(connected, mode):
    link, autopilot = connected
    talk(link, autopilot, set_mode(link, mode))
    assert autopilot.mode == mode


def test_a_silent_autopilot_ends_a_conversation_in_one_sentence(connected):
    link, autopilot = connected
    autopilot.lost = lambda frame: True
    with pytest.raises(NoAnswer, match=r"did not answer a mode change .*6 s") as caught:
        talk(link, autopilot, set_mode(link, wire.MISSION))
    assert caught.value.exit_code == 3


def test_parameters_are_read_and_set_by_name(connected):
    link, autopilot = connected
    assert talk(link, autopilot, read_params(link, ["ATT_WN", "ACT_LEAD"])) == pytest.approx(
        {"ATT_WN": 16.0, "ACT_LEAD": 0.021}
    )
    assert talk(link, autopilot, write_param(link, "ATT_WN", 12.0)) == 12.0
    assert autopilot.params["ATT_WN"] == 12.0


def test_an_unknown_parameter_is_named(connected):
    link, autopilot = connected
    with pytest.raises(LinkError, match="NO_SUCH_NAME"):
        talk(link, autopilot, read_param(link, "NO_SUCH_NAME"))
