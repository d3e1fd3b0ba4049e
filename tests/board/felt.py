"""A hand on a board, real binary or emulated device: the paper's three scenarios.

Everything that the board is told goes over its USB endpoints, and keep-alives as a host sends them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from tests.board import dangers
from tests.board.pico import MS, EmulatedPico, confirm, enumerated
from tests.board.twin import Twin
from tests.board.world import World
from torsio.emulator import Plant
from torsio.printed.hands import Hand, ImpedanceHand, NoHand, PrescribedMotion, TorqueHand
from torsio.printed.plant import Electrics, PlantParams

Columns = dict[str, Any]

ELECTRICS = {
    "pico": Electrics(predictive=False, current_period_s=0.0, output_delay_s=50e-6),
    "pico2": Electrics(),
}
ALIVE_MS, READ_MS = 50, 4
WALL_RAD, PEAK_NM, WEIGHT_NM = 0.05, 75e-3, 50e-3
SPIN_UP_NM, RELEASE_SPEED_RAD_S = 40e-3, 18.0
# Of a hand that goes where it means to.
HAND_NM_PER_RAD, HAND_NM_S_PER_RAD, HAND_KG_M2 = 10.0, 10e-3, 1e-4
COIL_HENRY = ELECTRICS["pico2"].coil_inductance_h


class Place(Protocol):
    """Where a board's knob is: a world or a twin."""

    params: PlantParams

    @property
    def time_s(self) -> float: ...
    def set_hand(self, hand: Hand) -> None: ...
    def record(self) -> Columns: ...


@dataclass
class Bench:
    """A board that knows its host, disarmed, with a knob at rest."""

    board: EmulatedPico
    place: Place

    def run(self, duration_s: float) -> None:
        """Let time pass with a host that is alive and reads the telemetry."""
        for n in range(round(1e3 * duration_s / READ_MS)):
            if n % (ALIVE_MS // READ_MS) == 0:
                self.board.post("command", op="keep_alive")
            self.board.run(READ_MS)
            self.board.listen(2, within_ms=0)

    def told(self) -> Columns:
        """Give the samples of the telemetry, in this place's time."""
        board = self.board
        tick_s = 1e-9 * board.model.tick_ns
        late = []
        for _ in range(3):  # an answer is older than its arrival: the youngest tells most
            tick = board.get("clock")["tick"]
            late.append(self.place.time_s - tick_s * tick)
        step = board.get("identity")["torque_step_nm"]
        found: dict[str, list[float]] = {"time_s": [], "desired_torque": [], "spring_torque": []}
        for report in board.telemetry:
            for n in range(report["axis_samples"] >> 4):
                ticks = report["tick"] + n * report["decimation"]
                found["time_s"].append(min(late) + tick_s * ticks)
                for name in ("desired_torque", "spring_torque"):
                    found[name].append(step * report["sample"][n][name])
        return {name: np.array(values) for name, values in found.items()}

    def play(self, effect: str, **values: Any) -> None:
        """Let one effect play."""
        assert self.board.send(effect, slot=0, **values)["status"] == 0
        assert self.board.send("commit", active=1)["status"] == 0


def plant_of(board: str, **changes: Any) -> PlantParams:
    """The reference actuator with the electrics of one of the boards."""
    return PlantParams(electrics=ELECTRICS[board], **changes)


@contextmanager
def binary(
    params: PlantParams, boot: Callable[[], AbstractContextManager[EmulatedPico]] = enumerated
) -> Iterator[Bench]:
    """Give the chosen board's binary, coupled to a plant."""
    world = World(params)
    with boot() as board:
        board.couple(world.pass_period)
        yield Bench(board, world)


@contextmanager
def twin(params: PlantParams, seed: int = 1) -> Iterator[Bench]:
    """Give the emulated device with the same plant and the chosen board's electrics and rate."""
    with EmulatedPico(lambda model: Twin(params, model.tick_ns, seed=seed)) as board:
        board.run(5)
        confirm(board)
        assert isinstance(board.bench, Twin)
        yield Bench(board, board.bench)


def prepare(bench: Bench, **control: Any) -> None:
    """Tell the board all that a scenario needs, and stream a sample a millisecond."""
    board = bench.board
    assert board.set("board_config", motor_current_continuous_a=2.0)["status"] == 0
    told = {"passive_ramp_s": 0.005, "law": "paper", "watchdog_s": 0.25, **control}
    assert board.set("control_config", **told)["status"] == 0
    every = MS // board.model.tick_ns
    assert board.send("stream", decimation=every, prompt="off")["status"] == 0
    board.telemetry.clear()


def wall(bench: Bench, stiffness: float) -> None:
    """Arm with the paper's wall."""
    angle = round(WALL_RAD / (2 * math.pi) * 2**32)
    bench.play(
        "wall", side="above", angle_turns_q32=angle, stiffness_nm_per_rad=stiffness,
        damping_nm_s_per_rad=0.0,
    )  # fmt: skip
    assert bench.board.command("arm") == "ok"
    bench.run(0.02)


def begin(bench: Bench) -> float:
    """Give a whole millisecond that is soon."""
    return math.ceil(1e3 * bench.place.time_s + 1) / 1e3


def push(bench: Bench, stiffness: float, *, move_s: float = 1.0, hold_s: float = 0.2) -> Columns:
    """Push into a wall until it asks for 75 mN m, hold, and come out: scenario 2."""
    wall(bench, stiffness)
    give = (PEAK_NM + bench.place.params.knob_coulomb_nm) / HAND_NM_PER_RAD
    deepest = WALL_RAD + PEAK_NM / stiffness + give
    zero = begin(bench)
    path = [(0.0, 0.0), (move_s, deepest), (move_s + hold_s, deepest), (2 * move_s + hold_s, 0.0)]
    hand = ImpedanceHand(
        intended_angle_rad=[(zero + time, angle) for time, angle in path],
        stiffness_nm_per_rad=HAND_NM_PER_RAD,
        damping_nm_s_per_rad=HAND_NM_S_PER_RAD,
        inertia_kg_m2=HAND_KG_M2,
    )
    bench.place.set_hand(hand)
    bench.run(path[-1][0] + 0.04)
    return finish(bench, zero)


def cut(
    bench: Bench,
    stiffness: float,
    *,
    ramp_s: float = 0.8,
    hold_s: float = 0.4,
    after_s: float = 1.0,
) -> Columns:
    """Let a weight sink into a wall, and cut its string: scenario 3."""
    wall(bench, stiffness)
    zero = begin(bench)
    end = zero + ramp_s + hold_s
    weight = [(zero, 0.0), (zero + ramp_s, WEIGHT_NM), (end, WEIGHT_NM), (end, 0.0)]
    bench.place.set_hand(TorqueHand(torque_nm=weight))
    bench.run(ramp_s + hold_s + after_s + READ_MS / 1e3)
    return finish(bench, zero)


def bounce(bench: Bench, stiffness: float, *, after_s: float = 1.0) -> Columns:
    """Let go of a knob that turns at 18 rad/s, and have a spring catch it: scenario 1.

    A hand spins it up and lets go at the moment at which the host commits the spring, whose middle
    is where the knob will be then. Time 0 is there.
    """
    spin_s, middle = spin_up(bench.place.params, bench.place.record()["angle_rad"][-1])
    assert bench.board.command("arm") == "ok"
    bench.run(0.02)
    angle = round(middle / (2 * math.pi) * 2**32)
    spring = {"angle_turns_q32": angle, "deadband_rad": 0.0, "torque_limit_nm": 100.0}
    sent = bench.board.send("spring", slot=0, stiffness_nm_per_rad=stiffness, **spring)
    assert sent["status"] == 0
    start = begin(bench)
    let_go = start + spin_s
    torque = [(start, 0.0), (start, SPIN_UP_NM), (let_go, SPIN_UP_NM), (let_go, 0.0)]
    bench.place.set_hand(TorqueHand(torque_nm=torque))
    bench.board.run(1e3 * (let_go - bench.place.time_s))
    bench.board.post("commit", active=1)
    bench.run(after_s)
    columns = finish(bench, let_go)
    columns["angle_rad"] = columns["angle_rad"] - middle
    return columns


def spin_up(params: PlantParams, from_rad: float) -> tuple[float, float]:
    """How long it takes to 18 rad/s without a motor, and where the knob is then."""
    passive = replace(params, electrics=None)
    plant = Plant(passive, TorqueHand(torque_nm=[(0.0, SPIN_UP_NM)]))
    while plant.state["speed_rad_s"] < RELEASE_SPEED_RAD_S:
        plant.advance(MS)
    return 1e-9 * plant.time_ns, from_rad + plant.angle_rad


def finish(bench: Bench, zero_s: float) -> Columns:
    """Disarm, take the hand away, and give the truth from a moment on, which becomes time 0.

    ``desired_torque_nm`` and ``sensed_spring_torque_nm`` are the board's own, from its telemetry.
    """
    bench.board.listen(4, within_ms=0)
    health = bench.board.get("health")
    assert (health["state"], health["faults"]) == ("armed", 0), health
    assert bench.board.command("disarm") == "ok"
    assert bench.board.send("commit", active=0)["status"] == 0
    bench.place.set_hand(NoHand())
    rows = bench.place.record()
    inside = rows["time_s"] >= zero_s - 1e-9
    rows = {name: column[inside] for name, column in rows.items()}
    told = bench.told()
    for name in ("desired_torque", "spring_torque"):
        column = np.interp(rows["time_s"], told["time_s"], told[name])
        rows["sensed_spring_torque_nm" if name == "spring_torque" else f"{name}_nm"] = column
    rows["time_s"] = rows["time_s"] - zero_s
    rows["felt_nm"] = rows["spring_torque_nm"] + rows["motor_torque_nm"]
    return rows


@dataclass(frozen=True)
class RunAway:
    """The end of a knob whose parts lie."""

    off_s: float | None
    """When motor and brake went off; None: not at all."""
    moved_rad: float
    fastest_rad_s: float
    faults: int


def cut_encoder(bench: Bench, pins: Sequence[int], hand: Hand, within_s: float) -> RunAway:
    """Cut wires of a leaning knob's encoder, and have another hand at it; of a binary only."""
    bench.board.do("cut_wires", pins=list(pins))
    return watch_run_away(bench, hand, within_s)


def turn_wrong_way(bench: Bench, part: str) -> None:
    """Swap the wires of the ``motor`` or of the ``encoder``; of a binary only."""
    world = bench.place
    assert isinstance(world, World)

    def pass_period(motor: float, brake: float, enabled: bool) -> tuple[float, list[float]]:
        # The sensor sits between bridge and motor: it sees the current as the bridge does.
        sign = -1 if part == "motor" else 1
        amperes, edges = world.pass_period(sign * motor, brake, enabled)
        return sign * amperes, edges if part == "motor" else [-time for time in edges]

    bench.board.couple(pass_period)


def touch_spring(bench: Bench, within_s: float) -> RunAway:
    """Arm at the middle of a spring, as if for the first time, and touch the knob for 40 ms."""
    board = bench.board
    assert board.set("board_config", confirmed="off")["status"] == 0
    middle = board.get("clock")["position_counts"] / bench.place.params.counts_per_rev
    spring = {"deadband_rad": 0.0, "torque_limit_nm": 100.0, "stiffness_nm_per_rad": 2.0}
    bench.play("spring", angle_turns_q32=round(middle * 2**32), **spring)
    assert board.command("arm") == "ok"
    bench.run(0.02)
    zero = begin(bench)
    touch = TorqueHand(torque_nm=[(zero, 0.0), (zero, 15e-3), (zero + 0.04, 15e-3),
                                  (zero + 0.04, 0.0)])  # fmt: skip
    return watch_run_away(bench, touch, within_s)


def shift_zero(bench: Bench, amperes: float, within_s: float) -> RunAway:
    """Let an armed knob go outside a wall, where its current sensor's zero moves; binary only."""
    wall(bench, 1.0)
    dangers.shift_zero(bench.board, amperes)
    return watch_run_away(bench, NoHand(), within_s)


def watch_run_away(bench: Bench, hand: Hand, within_s: float) -> RunAway:
    """Have a hand at a knob until its outputs go off, or so long."""
    begin_s, begin_rad = bench.place.time_s, bench.place.record()["angle_rad"][-1]
    bench.place.set_hand(hand)
    off_s = None
    while off_s is None and bench.place.time_s < begin_s + within_s:
        bench.run(READ_MS / 1e3)
        if bench.board.motor() is None:
            off_s = bench.place.time_s - begin_s
    rows = bench.place.record()
    since = rows["time_s"] >= begin_s
    return RunAway(
        off_s=off_s,
        moved_rad=float(np.max(np.abs(rows["angle_rad"][since] - begin_rad))),
        fastest_rad_s=float(np.max(np.abs(rows["speed_rad_s"][since]))),
        faults=bench.board.get("health")["faults"],
    )


@dataclass(frozen=True)
class Pressed:
    """The state of a knob after a press into a wall."""

    off_s: float | None
    """When motor and brake went off; None: not at all."""
    coil_a: float
    """The most that was in the brake's coil."""
    faults: int


def press(bench: Bench, depth_rad: float, within_s: float) -> Pressed:
    """Move a knob so deep into a wall of 30 mN m a degree in 0.1 s, and hold it; of a binary only.

    Its parts are confirmed or not, as they were.
    """
    world = bench.place
    assert isinstance(world, World)
    wall(bench, math.degrees(30e-3))
    zero = begin(bench)
    path = [(0.0, 0.0), (zero, 0.0), (zero + 0.1, WALL_RAD + depth_rad)]
    world.set_hand(PrescribedMotion(angle_rad=path))
    coil_a, off_s, begin_s = 0.0, None, world.time_s
    while off_s is None and world.time_s < begin_s + within_s:
        bench.run(READ_MS / 1e3)
        coil_a = max(coil_a, abs(world.circuit.electrics.coil_current_a))
        if bench.board.motor() is None:
            off_s = world.time_s - begin_s
    return Pressed(off_s, coil_a, bench.board.get("health")["faults"])


def press_with_supply(board: str, supply_v: float, *, confirmed: bool) -> Pressed:
    """Press a knob whose supply is configured as 12 V.

    With parts that nobody has confirmed both drives give all they may then, else the motor
    30 mN m and the brake nothing.
    """
    plant = plant_of(board)
    assert plant.electrics is not None
    plant = replace(plant, electrics=replace(plant.electrics, supply_v=supply_v))
    with binary(plant) as bench:
        prepare(bench, law="motor_only" if confirmed else "paper")
        told = bench.board.set("board_config", confirmed="on" if confirmed else "off")
        assert told["status"] == 0
        return press(bench, math.radians(1 if confirmed else 5), 0.4)


@contextmanager
def with_coil(**actuator_config: Any) -> Iterator[EmulatedPico]:
    """Give a board that was started anew and knows the inductance of the brake's coil."""
    with enumerated() as board:
        assert board.set("board_config", brake_inductance_h=COIL_HENRY)["status"] == 0
        assert board.set("actuator_config", **actuator_config)["status"] == 0
        board.do("erase_time", ns=MS)
        assert board.command("save") == "ok"
        board.power_cycle()
        board.enumerate()
        confirm(board)
        yield board


def let_go(bench: Bench, within_s: float) -> Columns:
    """Press a knob into a wall, pull it out within 2 ms, and watch the coil; of a binary only.

    Each PWM period is a row: the share of the supply on the coil, and its current. Time 0 is where
    the knob begins to leave, armed as before.
    """
    world = bench.place
    assert isinstance(world, World)
    rows = []

    def pass_period(motor: float, brake: float, enabled: bool) -> tuple[float, list[float]]:
        passed = world.pass_period(motor, brake, enabled)
        rows.append((world.time_s, brake, world.circuit.electrics.coil_current_a, enabled))
        return passed

    wall(bench, math.degrees(30e-3))
    bench.board.couple(pass_period)
    zero = begin(bench) + 0.06
    path = [(0.0, 0.0), (zero - 0.06, 0.0), (zero - 0.02, WALL_RAD + 0.05),
            (zero, WALL_RAD + 0.05), (zero + 2e-3, 0.0)]  # fmt: skip
    world.set_hand(PrescribedMotion(angle_rad=path))
    bench.run(zero - world.time_s + within_s)
    bench.board.couple(world.pass_period)
    assert bench.board.command("disarm") == "ok"
    names = ("time_s", "share", "coil_a", "enabled")
    found = dict(zip(names, np.array(rows).T, strict=True))
    found["time_s"] -= zero
    return found


@dataclass(frozen=True)
class TickCost:
    """The cost of a tick inside one wall: the most instructions and time that were seen."""

    instructions: int
    tick_time_ns: int
    """As the board itself says in its health report: from the encoder to the PWM's levels."""
    interrupt_share: float
    """Share of the processor's time, with all rounds of the current loop."""


def lean(bench: Bench, stiffness: float, torque_nm: float) -> None:
    """Lean on a wall until the knob rests there."""
    wall(bench, stiffness)
    zero = begin(bench)
    bench.place.set_hand(TorqueHand(torque_nm=[(zero, 0.0), (zero + 0.04, torque_nm)]))
    bench.run(0.12)


def tick_cost(bench: Bench) -> TickCost:
    """Lean on a wall of 30 mN m a degree with 20 mN m; of a binary only."""
    board = bench.board
    lean(bench, math.degrees(30e-3), 20e-3)
    board.do("count_instructions")
    before = board.status()
    board.run(8)
    after = board.status()
    health = board.get("health")
    assert (health["state"], health["faults"]) == ("armed", 0), health
    assert board.command("disarm") == "ok"
    busy_ns = after["interrupt_ns"] - before["interrupt_ns"]
    return TickCost(
        instructions=after["tick_instructions"],
        tick_time_ns=health["tick_time_max_ns"],
        interrupt_share=busy_ns / (after["ns"] - before["ns"]),
    )


def difference_nm(one: Columns, other: Columns, *, rows: int = 0) -> tuple[float, float]:
    """Root of the mean square, and the most, of what a hand feels of one and not of the other.

    Parameters
    ----------
    rows
        So many rows, of a millisecond each, the other may be earlier or later.
    """
    size = min(len(one["felt_nm"]), len(other["felt_nm"]))
    felt_nm = one["felt_nm"][:size]
    near_nm = sliding_window_view(np.pad(other["felt_nm"][:size], rows, mode="edge"), 2 * rows + 1)
    error = felt_nm - np.clip(felt_nm, near_nm.min(axis=1), near_nm.max(axis=1))
    return float(np.sqrt(np.mean(error**2))), float(np.max(np.abs(error)))
