"""One flight, end to end: starts the simulator and the crew, watches both, and leaves nothing behind.

Why: the only place that owns processes. Whatever happens to one of them, the others end, and one sentence says what was
lost.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from importlib import import_module
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from socket import socket
from typing import IO, TYPE_CHECKING, Any

from halfroll import boards, simulator
from halfroll.errors import HalfrollError, InputError, LinkError, PortInUse, SimulatorDied
from halfroll.flight_recorder import FlightRecorder
from halfroll.missions.geodesy import GeoPoint
from halfroll.missions.mission import DEFAULT_OPTIONS, LimitsKind, Mission, PlanMode, PlanOptions
from halfroll.missions.mission_files import load_mission
from halfroll.planner.course import endless, home_of, with_takeoff_and_landing
from halfroll.scenario import Scenario, load_scenario, shipped_scenarios
from halfroll.station.crew import Debriefing, Orders, hear_all
from halfroll.station.planning import Planned, PlanningProcess
from halfroll.station.record import Event
from halfroll.station.station import Station
from halfroll.station.telling import Teller
from halfroll.vehicle import Vehicle, built_vehicle
from halfroll.wire.link import Link
from halfroll.wire.messages import GROUND
from halfroll.wire.tlog import RecordedTransport
from halfroll.wire.told import TOLD_PORT
from halfroll.wire.transport import LOOPBACK, SerialTransport, UdpTransport, bound_socket, wait_for_any, wall_s

if TYPE_CHECKING:
    from halfroll.planner.plan import Plan

OFFBOARD_PORT, GCS_PORT = 14540, 14550  # ours; the simulator's own are
SITL_OFFBOARD_PORT, SITL_GCS_PORT, SITL_COMPANION_PORT = 14580, 18570, 14280
INSTANCES = range(10)  # 14540 + 10 would be the GCS's port
_POLL_S = 0.05
_HEARD_AT_ONCE = 4  # times, before what answers it goes out: a setpoint of 50 ms ago is too old
_ENDS_WITHIN_S = 3.0
_SILENT_S = 30.0  # the crew tells the time a few times a second, once it has begun
_BAD_OPTION, _PORT_TAKEN = 2, 3  # exit codes of halfroll-sitl
_PHASES = {
    "mission": "plan",
    "planning": "plan",
    "plan-progress": "plan",
    "armed": "take off",
    "approach": "go to the plan's start",
    "flying": "fly the plan",
    "progress": "fly the plan",
    "left": "fly on without the plan",
    "handed-back": "end the mission",
}
# A process of ours never imports from the folder that it happens to be started in.
_CREW = "import sys; sys.path = [path for path in sys.path if path]; from halfroll.station.crew import main; main()"
_QUIET = ("-W", "ignore::UserWarning:multiprocessing.resource_tracker")  # it complains of a crew that was killed
_HASH = re.compile(r"commands_sha256 ([0-9a-f]{64})")
_BOARD = re.compile(r"^halfroll-sitl: board (\{.*\})$", re.MULTILINE)

Progress = Callable[[str, "float | None"], None]


@dataclass(frozen=True)
class FlightResult:
    """What a flight left, unjudged (evaluation.py judges). Without plan, the autopilot flew alone."""

    mission: Mission  # as it was uploaded
    vehicle: Vehicle
    plan: Plan | None
    plan_start_s: float | None  # vehicle time
    plan_end_s: float | None
    log_path: Path
    references_sent: int
    reference_rate_Hz: float  # per second of vehicle time in lockstep, of wall clock in real time
    interval_p99_s: float  # wall clock
    commands_sha256: str
    texts: tuple[str, ...]  # what the autopilot said
    notes: tuple[str, ...]  # what was added to the mission
    board: Mapping[str, float] | None = None  # what a board has measured: steps, instructions, bits that differ

    def plot(self) -> Any:
        """A matplotlib figure of path, error, tilt and rotor thrusts. Raises InputError where no plan was flown."""
        return import_module("halfroll.results.cards").picture_of(self)

    def _repr_html_(self) -> str:
        """For a notebook."""
        return str(import_module("halfroll.results.cards").flight_card(self))


def fly(
    mission: Mission | str | Path,
    vehicle: Vehicle | str | Path | None = None,
    *,
    scenario: Scenario | str | Path = "nominal",
    seed: int | None = None,
    lockstep: bool = True,
    speed: float | None = None,
    limits: LimitsKind = "mission",
    margin: float | None = None,
    mode: PlanMode = "paper",
    changes: Mapping[str, float | None] | None = None,
    yaw: str | None = None,
    overrides: Mapping[str, str | float] | None = None,
    in_world: Vehicle | None = None,
    planned: Planned | None = None,
    origin: GeoPoint | None = None,
    log_path: str | Path | None = None,
    command: str | None = None,
    instance: int | None = None,
    board: str | None = None,
    beside: bool = False,
    watched: bool = False,
    on_ports: Callable[[int], object] = lambda instance: None,
    progress: Progress = lambda phase, fraction: None,
    report: Callable[[Event], None] = lambda event: None,
) -> FlightResult:
    """Fly a mission in a simulator of its own, from takeoff to landing, and return what was recorded.

    vehicle, seed: default the scenario's, else mit-vp and 0; scenario: shipped name, file, or built; changes, yaw:
    as for preflight.plan; in_world: the vehicle as it is, where its autopilot and the planner are to know another;
    planned: the plan of exactly this mission, in place of one made on the way; speed: times real time, 0 as fast as it
    goes (default in lockstep; 1 else); origin: of W, default the planned home of a .plan; log_path: default in a new
    temporary folder, the raw link beside it as .tlog; command: that flies this again, for the log; instance: of the
    ports, default the first that is free; board: as for boards.command, flies in place of the simulator's own firmware,
    or with `beside` along with it, compared bit by bit; watched: events of kind time bring a Glance ten times a second;
    on_ports(instance) is called before it flies, for whoever wants to watch; progress(phase, fraction or None) and
    report(event) are called on the way.

    Raises MissionError and PlanError for what cannot be flown, FlightError when it ended early, PortInUse,
    SimulatorDied and other LinkErrors. Nothing is left running, whatever is raised (KeyboardInterrupt, too).
    """
    wanted = mission if isinstance(mission, Mission) else load_mission(mission)
    flown, notes = with_takeoff_and_landing(wanted)
    if error := endless(flown.items):
        raise error
    world = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
    flown_by = built_vehicle(vehicle or world.vehicle or "mit-vp", overrides)
    options = PlanOptions.of(mode, limits, margin, changes, yaw)
    log = Path(log_path) if log_path else Path(tempfile.mkdtemp(prefix="halfroll-")) / "flight.ulg"
    recorder = FlightRecorder(log, _asked(wanted, flown, flown_by, world, options, command))
    progress("start the simulator", None)
    with contextlib.ExitStack() as stack:
        number, sockets = _ports(instance)
        for each in sockets:
            stack.enter_context(each)
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="halfroll-")))
        words = [
            str(simulator.executable()),
            *simulator.vehicle_arguments(flown_by, in_world),
            *(["--scenario", scenario] if scenario in shipped_scenarios() else simulator.scenario_arguments(world)),
            *("--instance", str(number), "--seed", str(world.seed or 0 if seed is None else seed)),
            *("--storage", str(folder), "--log", str(log)),
            "--origin=" + ",".join(f"{x:.9f}" for x in origin or home_of(wanted)),
            *([] if speed is None else ["--speed", f"{speed:g}"]),
            *(["--lockstep"] if lockstep else []),
            *boards.arguments(board, beside),
        ]
        output = stack.enter_context((folder / "output").open("w+"))
        sitl = stack.enter_context(_process(words, output=output))
        core = _shared_core(number) if lockstep and board is None else None
        if core is not None:
            os.sched_setaffinity(sitl.pid, {core})
        on_ports(number)
        ours, theirs = Pipe()
        descriptors = (theirs.fileno(), *(each.fileno() for each in sockets))
        python = [sys.executable, *_QUIET, "-c", _CREW, *map(str, descriptors)]
        crew = stack.enter_context(_process(python, keep=descriptors))
        theirs.close()
        with contextlib.suppress(ConnectionError):  # it ended at once; the watch says so
            tlog = log.with_suffix(".tlog")
            ours.send(Orders(flown, flown_by, options, core, TOLD_PORT + number, watched, planned, tlog))

        def heard(event: Event) -> None:
            recorder.hear(event)
            if event.kind != "time" or event.glance:
                report(event)

        watch = _Watch(flown, sitl, output, crew, ours, log, progress, heard)
        try:
            debriefing = watch.until_debriefed()
        except HalfrollError as error:
            recorder.end(None, error, {})
            raise
        record = debriefing.record
        recorder.end(record, None, {"lockstep": debriefing.lockstep, "notes": notes})
        said = watch.until_simulator_ends()
    return FlightResult(
        mission=flown,
        vehicle=flown_by,
        plan=record.planned.plan if record else None,
        plan_start_s=record.plan_start_s if record else None,
        plan_end_s=record.plan_end_s if record else None,
        log_path=log,
        references_sent=record.references_sent if record else 0,
        reference_rate_Hz=record.rate_hz(by_wall_clock=not debriefing.lockstep) if record else 0.0,
        interval_p99_s=record.interval_p99_s() if record else 0.0,
        commands_sha256=found[1] if (found := _HASH.search(said)) else "",
        texts=debriefing.texts,
        notes=tuple(notes),
        board=json.loads(found[1]) if (found := _BOARD.search(said)) else None,
    )


def _asked(
    wanted: Mission,
    flown: Mission,
    vehicle: Vehicle,
    world: Scenario,
    options: PlanOptions,
    command: str | None,
) -> dict[str, str]:
    """What the log keeps of what was asked for, by name."""
    asked = {
        "mission": wanted.name,
        "mission_items": json.dumps([asdict(item) for item in flown.items], default=str),
        "vehicle_numbers": vehicle.model_dump_json(),
        "scenario_numbers": world.model_dump_json(),
        "plan_options": json.dumps(asdict(options), default=str),
    }
    with contextlib.suppress(OSError, UnicodeDecodeError, TypeError):
        asked["mission_file"] = Path(wanted.source or "").read_text(encoding="utf-8")
    return asked if command is None else {**asked, "command": command}


def run_ground(
    vehicle: Vehicle,
    *,
    instance: int = 0,
    serial: str | None = None,
    options: PlanOptions = DEFAULT_OPTIONS,
    log: Path | None = None,
    tlog: Path | None = None,
    report: Callable[[Event], None] = lambda event: None,
) -> None:
    """The ground station alone, until KeyboardInterrupt: plans what is stored, flies what is started.

    serial: DEVICE or DEVICE:BAUD, in place of UDP; log: of the simulator that flies, to which is added what the ground
    knows; tlog: where the raw link goes; report: called for what a person wants to read, not for every step of
    progress. Raises PortInUse, LinkError, OSError.
    """
    asked = {"vehicle_numbers": vehicle.model_dump_json(), "plan_options": json.dumps(asdict(options), default=str)}
    recorder = None if log is None else FlightRecorder(log, asked)

    def tell(event: Event) -> None:
        if recorder:
            recorder.hear(event)
            if event.kind == "planned" and not recorder.begun:
                words = f"{log}: no such log to add to; start halfroll sitl --log {log} first, then the ground"
                report(Event("text", event.t_s, words))
        if not event.kind.endswith("progress"):
            report(event)

    transport = UdpTransport.bind(OFFBOARD_PORT + instance) if serial is None else SerialTransport(serial)
    told = UdpTransport.bind(0, (LOOPBACK, TOLD_PORT + instance))
    teller = Teller(told)
    with contextlib.ExitStack() as stack:
        stack.callback(told.close)
        stack.callback(transport.close)
        raw = None if tlog is None else RecordedTransport(transport, tlog)
        if raw:
            stack.callback(raw.close)
        planner = stack.enter_context(PlanningProcess())
        report(Event("connected", 0.0, f"waiting for an autopilot on {transport.name}"))

        def met() -> tuple[Link, Station]:
            link = Link(raw or transport, GROUND)
            if raw:
                raw.time_us = lambda: link.t_us
            return link, Station(link, vehicle, planner, options, report=tell)

        link, station = met()
        try:
            while True:
                wait_for_any([transport], _POLL_S / 2)
                try:
                    with link.gathering():
                        for _ in range(_HEARD_AT_ONCE):
                            if not hear_all([link], [station.hear]):
                                break
                        station.go_on()
                        station.answer_time()
                except LinkError as error:  # it may come back
                    tell(Event("released", link.t_us * 1e-6, str(error)))
                    transport.forget_peer()
                    link, station = met()
                teller.tell(station)
        finally:
            if recorder:
                record = station.following.record if station.following else None
                recorder.end(record, None, {"lockstep": station.lockstep})


class _Watch:
    """Both processes of one flight, seen from outside."""

    def __init__(
        self,
        mission: Mission,
        sitl: subprocess.Popen[Any],
        output: IO[str],
        crew: subprocess.Popen[Any],
        connection: Connection,
        log: Path,
        progress: Progress,
        report: Callable[[Event], None],
    ) -> None:
        self._mission, self._sitl, self._output, self._crew, self._connection = mission, sitl, output, crew, connection
        self._log, self._progress, self._report = log, progress, report
        self._t_s, self._item, self._heard_s = 0.0, 0, wall_s()

    def until_debriefed(self) -> Debriefing:
        """Raises what ended the flight early."""
        while True:
            sitl_ended = self._sitl.poll() is not None
            heard = self._hear(_ENDS_WITHIN_S / 3 if sitl_ended and self._sitl.returncode == 0 else _POLL_S)
            if isinstance(heard, Debriefing):
                return heard
            if isinstance(heard, HalfrollError) and not self._simulator_fell():
                raise heard
            if sitl_ended or heard:
                raise self._simulator_died()
            if wall_s() - self._heard_s > _SILENT_S:
                raise LinkError(f"the ground station's process has been silent {self._where()}; fly again")

    def until_simulator_ends(self) -> str:
        """It was told to shut down; its last words."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._sitl.wait(_ENDS_WITHIN_S)
        if self._sitl.returncode != 0:
            raise self._simulator_died()
        return self._words()

    def _hear(self, timeout_s: float) -> Debriefing | HalfrollError | None:
        """The outcome if it comes; events on the way are passed on."""
        try:
            while self._connection.poll(timeout_s):
                heard = self._connection.recv()
                if not isinstance(heard, Event):
                    outcome: Debriefing | HalfrollError = heard
                    return outcome
                self._pass_on(heard)
        except (EOFError, ConnectionError):
            code = self._crew.wait()
            return LinkError(f"the ground station's process ended (exit code {code}) {self._where()}; fly again")
        return None

    def _pass_on(self, event: Event) -> None:
        self._t_s, self._heard_s = max(self._t_s, event.t_s), wall_s()
        self._item = self._item if event.item is None else event.item
        self._report(event)
        if event.kind in _PHASES:
            self._progress(_PHASES[event.kind], event.fraction if event.kind in ("flying", "progress") else None)

    def _simulator_fell(self) -> bool:
        """An error that follows from the simulator's end is not the reason."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._sitl.wait(_POLL_S)
        return self._sitl.poll() not in (None, 0)

    def _simulator_died(self) -> HalfrollError:
        code, words = self._sitl.poll(), self._words().strip().splitlines()
        said = f"; it said: {words[-1]}" if words else ""
        if code == _PORT_TAKEN:
            return PortInUse(words[-1] if words else "a UDP port of the simulator is taken; choose another --instance")
        if code == _BAD_OPTION:
            return InputError(words[-1] if words else "the simulator refused its options")
        if code is not None and code > 0:
            return LinkError(f"the simulator did not run (exit code {code}){said}")
        how = "does not end" if code is None else "ended" if code == 0 else f"was ended by {signal.Signals(-code).name}"
        return SimulatorDied(f"the simulator {how} {self._where()}; its log up to then is {self._log}; fly again")

    def _where(self) -> str:
        last = len(self._mission.items) - 1
        return f"at {self._t_s:.2f} s of vehicle time, on the way to item {self._item} of {last}"

    def _words(self) -> str:
        self._output.seek(0)
        return self._output.read()


def _ports(instance: int | None) -> tuple[int, tuple[socket, socket]]:
    """An instance whose ports are free, and our two of them, held. Raises PortInUse."""
    for number in INSTANCES if instance is None else [instance]:
        held: list[socket] = []
        try:
            for port in (OFFBOARD_PORT, GCS_PORT, SITL_OFFBOARD_PORT, SITL_GCS_PORT, SITL_COMPANION_PORT):
                held.append(bound_socket(port + number))
        except PortInUse:
            for each in held:
                each.close()
            if instance is not None:
                raise
            continue
        for each in held[2:]:  # the simulator's own
            each.close()
        return number, (held[0], held[1])
    raise PortInUse(f"the ports of all {len(INSTANCES)} instances are taken; end one of the other flights")


def _shared_core(number: int) -> int:
    """For both sides of a lockstep flight: they never work at once, and to wake a neighbour takes a virtual machine up
    to 0.2 ms, twice a tick, where a change of process takes a hundredth of that."""
    cores = sorted(os.sched_getaffinity(0))
    return cores[number % len(cores)]


@contextlib.contextmanager
def _process(
    words: list[str], output: IO[str] | None = None, keep: tuple[int, ...] = ()
) -> Iterator[subprocess.Popen[Any]]:
    """A process and all it starts, in a session of its own (Ctrl-C is ours to handle), ended with the context."""
    process = subprocess.Popen(
        words,
        stdin=subprocess.DEVNULL,
        stdout=output if output else None,
        stderr=subprocess.STDOUT if output else None,
        pass_fds=keep,
        start_new_session=True,
        preexec_fn=_end_with_parent,  # one call into C, takes no lock
        env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
    )
    try:
        yield process
    finally:
        _end(process)


def _end_with_parent() -> None:
    """Linux: the kernel ends this process when its parent dies, even by SIGKILL."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGTERM)


def _end(process: subprocess.Popen[Any]) -> None:
    for number in (signal.SIGTERM, signal.SIGKILL):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, number)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(_ENDS_WITHIN_S if number == signal.SIGTERM else None)
            return
