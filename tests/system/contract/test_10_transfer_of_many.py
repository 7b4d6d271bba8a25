"""Contract, section 10, at scale: long missions over good and bad links, and clients that quarrel."""

from __future__ import annotations

import random

import pytest

from system.contract.aircraft import A, Aircraft, B, Client, Item
from system.contract.lossy_link import upload_over
from system.contract.missions import TAKEOFF_ITEM, waypoint

LONG: list[Item] = [TAKEOFF_ITEM, *[waypoint(float(n % 40), float(n % 7)) for n in range(199)]]


def test_two_hundred_items_need_one_round_trip_each(gcs: Client) -> None:
    assert gcs.upload(LONG) == 0
    assert [m.seq for m in gcs.all("MISSION_REQUEST_INT")] == list(range(200))
    assert len(gcs.all("MISSION_ACK")) == 1


def test_two_hundred_items_upload_within_a_second_where_a_round_trip_takes_three_milliseconds(
    grounded: Aircraft,
) -> None:
    assert upload_over(grounded, LONG, seed=0, loss=0.0, delay_ms=(1, 1)) <= 1.0


@pytest.mark.parametrize("seed", range(5))
def test_two_hundred_items_upload_within_ten_seconds_over_a_bad_radio(grounded: Aircraft, seed: int) -> None:
    """One datagram in ten lost each way, jitter that reorders."""
    assert upload_over(grounded, LONG, seed, loss=0.1, delay_ms=(1, 12)) <= 10.0
    assert grounded.client().download() == LONG


def variant(n: int, size: int) -> list[Item]:
    """A mission that tells whose it is in each of its items."""
    return [TAKEOFF_ITEM, *[waypoint(float(i % 30), z=10.0 + n / 64) for i in range(size - 1)]]


def test_five_hundred_broken_and_interleaved_uploads_leave_one_whole_mission_each_time(grounded: Aircraft) -> None:
    chance = random.Random(1)
    clients = [grounded.client(B), grounded.client(A, slot=2, system=250)]
    stored: list[Item] = []
    begun: list[tuple[Client, list[Item], int]] = []  # who uploads, what, items sent
    completed = 0
    for n in range(500):
        missions = [variant(2 * n + k, chance.randint(2, 12)) for k in range(2)]
        uploads = [(client, mission, 0) for client, mission in zip(clients, missions, strict=True)]
        for client, mission, _ in chance.sample(uploads, 2):
            client.count(len(mission))
        begun = uploads
        for _ in range(chance.randint(0, 30)):  # then items in any order, from both
            which = chance.randrange(2)
            client, mission, sent = begun[which]
            seq = sent if chance.random() < 0.8 else chance.randrange(len(mission))
            if seq >= len(mission):
                continue
            answers = client.item(seq, mission[seq])
            requests = [m.seq for m in answers if m.get_type() == "MISSION_REQUEST_INT"]
            accepted = [m.type for m in answers if m.get_type() == "MISSION_ACK"]
            begun[which] = (client, mission, requests[-1] if requests else sent)
            if accepted == [0]:
                stored, completed = mission, completed + 1
        how = chance.randrange(3)
        if how == 0:
            clients[0].ask(clients[0].encode.mission_ack_encode(1, 1, 15))
            clients[1].ask(clients[1].encode.mission_ack_encode(1, 1, 15))
        elif how == 1:
            grounded.run(5.1)
        assert clients[n % 2].download() == stored
    assert completed > 50
