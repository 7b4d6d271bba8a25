"""Engines: who flies the runs. Threads of this process, processes of this machine, or a Dask cluster.

Why: one small interface. Rows come back as they are ready, in any order, each run's once; a worker that dies costs time
and no run. At most a few blocks a worker are under way, whatever the number of runs.
"""

from __future__ import annotations

import multiprocessing
import os
import re
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from typing import Any, Protocol

from halfroll.campaign.flights import fly_run
from halfroll.campaign.prepared import Prepared
from halfroll.campaign.sampling import Run, blocks
from halfroll.errors import FlightError, InputError, LinkError

Row = dict[str, Any]
Block = list[Run]
UNDER_WAY = 3  # blocks a worker, one of them being flown
DEATHS = 3  # of workers on one block, before it is the block that kills
DASK_BLOCK = 20  # runs of a task: a scheduler places a few thousand a second
_CONNECT_S = 5.0


class Engine(Protocol):
    def fly_runs(self, prepared: Prepared, indices: Iterable[int]) -> Iterator[Row]:
        """A row for each index, as it is ready. indices rise. Raises FlightError, LinkError."""
        ...


def processors() -> int:
    return len(os.sched_getaffinity(0))


class Threads:
    """In this process: while it flies, a run holds no lock of Python's."""

    def __init__(self, workers: int | None = None) -> None:
        self._workers = workers or processors()

    def fly_runs(self, prepared: Prepared, indices: Iterable[int]) -> Iterator[Row]:
        with ThreadPoolExecutor(self._workers) as pool:
            waiting = blocks(prepared.space, indices, size=4)
            yield from _flown(pool, lambda block: (_fly_block, prepared, block), waiting, self._workers)


class Processes:
    """One process each; where one dies, the others' work is kept and its own done again."""

    def __init__(self, workers: int | None = None) -> None:
        self._workers = workers or processors()

    def fly_runs(self, prepared: Prepared, indices: Iterable[int]) -> Iterator[Row]:
        waiting: Iterator[Block] = blocks(prepared.space, indices, size=10)
        deaths: dict[int, int] = {}
        while True:
            lost: list[Block] = []
            with ProcessPoolExecutor(self._workers, multiprocessing.get_context("spawn"), _begin, (prepared,)) as pool:
                yield from _flown(pool, lambda block: (_fly_block_here, block), waiting, self._workers, lost)
            if not lost:
                return
            for block in lost:
                first = block[0].index
                deaths[first] = deaths.get(first, 0) + 1
                if deaths[first] >= DEATHS:
                    raise FlightError(f"runs {first} to {block[-1].index} have ended their process {DEATHS} times")
            waiting = _chained(lost, waiting)


class Dask:
    """Workers of a Dask cluster, each with halfroll installed."""

    def __init__(self, address: str) -> None:
        self._address = address

    def fly_runs(self, prepared: Prepared, indices: Iterable[int]) -> Iterator[Row]:
        with self._client() as client:
            shared = client.scatter(prepared, broadcast=True, hash=False)
            waiting = blocks(prepared.space, indices, size=DASK_BLOCK)
            workers = max(sum(client.nthreads().values()), 1)
            under_way: set[Any] = set()
            while True:
                for block in _next(waiting, UNDER_WAY * workers - len(under_way)):
                    under_way.add(client.submit(_fly_block, shared, block, pure=False, retries=DEATHS))
                if not under_way:
                    return
                done = _first_done(client, under_way)
                under_way -= done
                for future in done:
                    yield from _rows_of(future)

    def _client(self) -> Any:
        if not re.fullmatch(r"(tcp|tls|ws|wss)://[^/]+:\d+", self._address):
            raise InputError(f"--dask {self._address}: a scheduler's address is wanted, like tcp://127.0.0.1:8786")
        try:
            from distributed import Client
        except ModuleNotFoundError:
            raise InputError(
                "--dask needs distributed, which is not installed: pip install 'halfroll[cluster]'"
            ) from None
        try:
            client = Client(self._address, timeout=_CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            raise LinkError(
                f"no Dask scheduler answers at {self._address} within {_CONNECT_S:.0f} s; start one with `dask "
                "scheduler`, or check the address"
            ) from error
        if not client.nthreads():
            client.close()
            raise LinkError(f"the Dask scheduler at {self._address} has no workers; start some with `dask worker`")
        return client


def _first_done(client: Any, under_way: set[Any]) -> set[Any]:
    from distributed import wait as wait_for

    with client.as_current():
        return set(wait_for(list(under_way), return_when="FIRST_COMPLETED").done)


def _rows_of(future: Any) -> list[Row]:
    from distributed import KilledWorker

    try:
        rows: list[Row] = future.result()
    except KilledWorker as error:
        raise FlightError(f"a block of runs has ended its Dask worker again and again: {error}") from error
    return rows


def _fly_block(prepared: Prepared, block: Block) -> list[Row]:
    return [fly_run(prepared, run) for run in block]


_prepared: Prepared | None = None  # of a worker process, sent once


def _begin(prepared: Prepared) -> None:
    import signal

    global _prepared
    _prepared = prepared
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides


def _fly_block_here(block: Block) -> list[Row]:
    assert _prepared is not None
    return _fly_block(_prepared, block)


def _flown(
    pool: Executor,
    call: Callable[[Block], tuple[Any, ...]],
    waiting: Iterator[Block],
    workers: int,
    lost: list[Block] | None = None,
) -> Iterator[Row]:
    """lost: takes the blocks that were under way when the pool broke."""
    under_way: dict[Future[list[Row]], Block] = {}
    try:
        while True:
            try:
                for block in _next(waiting, UNDER_WAY * workers - len(under_way)):
                    under_way[_submit(pool, call(block), block, lost)] = block
            except _Broken:
                pass
            if not under_way:
                return
            done, _ = wait(under_way, return_when=FIRST_COMPLETED)
            for future in done:
                block = under_way.pop(future)
                try:
                    yield from future.result()
                except BrokenProcessPool:
                    if lost is None:
                        raise
                    lost.append(block)
            if lost:
                lost += under_way.values()
                return
    finally:
        for future in under_way:
            future.cancel()


class _Broken(Exception):
    pass


def _submit(pool: Executor, words: tuple[Any, ...], block: Block, lost: list[Block] | None) -> Future[list[Row]]:
    try:
        return pool.submit(*words)
    except BrokenProcessPool:
        if lost is None:
            raise
        lost.append(block)
        raise _Broken from None


def _next(waiting: Iterator[Block], count: int) -> Iterator[Block]:
    for _ in range(count):
        with suppress(StopIteration):
            yield next(waiting)


def _chained(first: list[Block], then: Iterator[Block]) -> Iterator[Block]:
    queue = deque(sorted(first, key=lambda block: block[0].index))
    while queue:
        yield queue.popleft()
    yield from then
