"""Extremes of numbers: long turning, wrapping counters and clocks, rounding, what is not finite."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace

import numpy as np
import numpy.typing as npt

import torsio
from torsio import core, emulator
from torsio.closed_loop import InitialState, LoopOptions, replay, simulate
from torsio.printed import hands, scenes
from torsio.printed.config import ActuatorConfig, ControlConfig
from torsio.printed.plant import PlantParams
from torsio_studies import wide
from torsio_studies.paper import runs

Array = npt.NDArray[np.float64]
COUNTS = PlantParams().counts_per_rev
COUNT_RAD = runs.COUNT_RAD
STIFFNESS = runs.SHAFT_NM_PER_RAD
HELD_NM = 37.5e-3
"""The brake's torque in these cases: half of the peak of scenario 2."""


@dataclass(frozen=True)
class Case:
    """One extreme: what a plain implementation makes of it, and what this one does.

    Attributes
    ----------
    measure
        Name of the numbers, with their unit; small is good.
    bound
        Up to here is good.
    naive, guarded
        The measure without and with the guard; None: there is no plain variant to compare with.
    """

    extreme: str
    measure: str
    bound: float
    guard: str
    case: str
    naive: float | None
    guarded: float

    @property
    def naive_breaks(self) -> bool:
        """Whether the plain implementation is beyond the bound."""
        return self.naive is not None and not self.naive <= self.bound

    @property
    def holds(self) -> bool:
        """Whether the guarded one is within it."""
        return self.guarded <= self.bound

    def as_row(self) -> dict[str, str | float | bool | None]:
        """Give what goes into the results; what is not finite becomes "not finite"."""
        row = {**asdict(self), "naive_breaks": self.naive_breaks, "holds": self.holds}
        for name in ("naive", "guarded"):
            if row[name] is not None and not math.isfinite(row[name]):
                row[name] = "not finite"
        return row


# Turning for hours --------------------------------------------------------------------------------

REVS_PER_S = 10


def _sensed(delta_rad: Array) -> Array:
    """Run the sensor in 64 bits on given differences."""
    torque = 0.0
    out = np.empty(len(delta_rad))
    for i, delta in enumerate(delta_rad):
        torque = min(max(torque - STIFFNESS * float(delta), -HELD_NM), HELD_NM)
        out[i] = torque
    return out


def turning_error_nm(hours: float) -> tuple[float, float]:
    """Error of the sensed torque after so many hours at 10 rev/s: float angle, integer counts.

    Then the knob winds the shaft by 12 counts, one a tick, and back.
    """
    start = round(COUNTS * REVS_PER_S * 3600 * hours)
    steps = np.concatenate([np.arange(13), np.arange(12)[::-1]])
    counts = start + steps
    exact = _sensed(np.diff(counts) * COUNT_RAD)

    angle = (counts * np.float64(COUNT_RAD)).astype(np.float32)
    naive = _sensed(np.diff(angle).astype(np.float64))

    # The device gets there in leaps that its counter allows.
    state, params = core.MotionState(), core.MotionParams()
    leaps = np.append(np.arange(0, start, 1 << 30), start)
    core.track_motion(state, params, (leaps % (1 << 32)).astype(np.uint32))
    motion = core.track_motion(state, params, (counts[1:] % (1 << 32)).astype(np.uint32))
    sensor = core.SoftSensorState()
    held = np.full(len(motion), HELD_NM)
    guarded = core.sense_spring(sensor, motion["delta_rad"], held)
    if state.position_counts != counts[-1]:
        return float(np.abs(naive - exact).max()), math.inf
    return float(np.abs(naive - exact).max()), float(np.abs(guarded - exact).max())


def turned_in_full(hours: float) -> int:
    """Turn for hours, tick by tick at 1 kHz; give by how many counts the device is wrong."""
    ticks = round(3.6e6 * hours)
    state, params = core.MotionState(), core.MotionParams()
    chunk = 1_000_000
    numerator, denominator = COUNTS * REVS_PER_S, 1000
    for first in range(0, ticks + 1, chunk):
        tick = np.arange(first, min(first + chunk, ticks + 1), dtype=np.int64)
        counts = tick * numerator // denominator
        core.track_motion(state, params, (counts % (1 << 32)).astype(np.uint32))
    return abs(state.position_counts - ticks * numerator // denominator)


def far_wall_error_nm(hours: float) -> float:
    """Push into a wall that lies hours of turning away; difference of the motor's torque."""
    turns = round(REVS_PER_S * 3600 * hours)
    stiffness = runs.per_degree(30)
    near = LoopOptions(
        scene=scenes.Wall(angle_rad=0.01, stiffness_nm_per_rad=stiffness),
        hand=hands.TorqueHand(torque_nm=[(0, 0), (0.5, 60e-3), (1.0, 0)]),
    )
    rows = simulate(near, duration_s=1.2)
    far = replace(
        near,
        scene=scenes.Wall(angle_rad=turns * 2.0 * math.pi + 0.01, stiffness_nm_per_rad=stiffness),
    )
    # The device is led there in leaps, and then sees the same push so many turns further on.
    leaps = np.append(np.arange(0, turns * COUNTS, 1 << 30), turns * COUNTS)
    counts = np.concatenate([leaps, rows["position_counts"] + turns * COUNTS]) % (1 << 32)
    far_rows = replay(far, counts)[len(leaps) :]
    return float(np.abs(far_rows["motor_command_nm"] - rows["motor_command_nm"]).max())


def far_plant_speed_error_rad_s(hours: float) -> float:
    """Push the same, with the plant itself so many turns away; change of the knob's speed."""
    turns = round(REVS_PER_S * 3600 * hours)
    hand = hands.TorqueHand(torque_nm=[(0, 0), (0.5, 60e-3), (1.0, 0)])
    near = simulate(LoopOptions(hand=hand), duration_s=1.2)
    far = simulate(LoopOptions(hand=hand, initial=InitialState(revolutions=turns)), duration_s=1.2)
    return float(np.abs(near["speed_rad_s"] - far["speed_rad_s"]).max())


def naive_far_plant_speed_error_rad_s(hours: float) -> float:
    """Swing of knob and brake with angles as plain doubles, near and so far away: change of speed.

    Both are stepped alike, by the semi-implicit rule every 20 us for 0.1 s.
    """
    plant, step_s = PlantParams(), 20e-6
    begin = 2.0 * math.pi * REVS_PER_S * 3600 * hours
    near, far = [0.0, 0.0, 0.0, 0.0], [begin, begin, 0.0, 0.0]
    worst = 0.0
    for _ in range(5000):
        for state in (near, far):
            spring_nm = STIFFNESS * (state[1] - state[0])
            state[2] += step_s * (60e-3 + spring_nm) / plant.knob_inertia_kg_m2
            state[3] -= step_s * spring_nm / plant.brake_inertia_kg_m2
            state[0] += step_s * state[2]
            state[1] += step_s * state[3]
        worst = max(worst, abs(far[2] - near[2]))
    return worst


# Wraps --------------------------------------------------------------------------------------------


def wrap_traces(bits: int) -> tuple[Array, Array, Array]:
    """Sensed torque in a push whose counter wraps on the way in: time, naive, guarded.

    Returns
    -------
    tuple
        Arrays of shape (n,); the naive sensor takes differences of the counter as it stands.
    """
    actuator = ActuatorConfig(counter_bits=bits)
    inside = runs.WALL_RAD / COUNT_RAD + 20
    options = replace(
        runs.push_options(runs.per_degree(30)),
        actuator=actuator,
        plant=PlantParams(encoder_phase_counts=float(2**bits - round(inside))),
    )
    rows = simulate(options, duration_s=runs.PUSH_DURATION_S)
    counter = (rows["position_counts"] - rows["position_counts"][0]) % (2**bits)
    counter = (counter + (2**bits - round(inside))) % (2**bits)
    delta = np.diff(counter, prepend=counter[0]).astype(np.float64) * COUNT_RAD
    torque, naive = 0.0, np.empty(len(rows))
    for i, step in enumerate(delta):
        bound = max(
            float(rows["sensed_brake_capacity_nm"][i]), ActuatorConfig().brake_torque_min_nm
        )
        torque = min(max(torque - STIFFNESS * step, -bound), bound)
        naive[i] = torque
    return rows["time_s"], naive, rows["sensed_spring_torque_nm"].astype(np.float64)


def wrap_errors_nm(bits: int) -> tuple[float, float]:
    """Largest error of the sensed torque against a run whose counter does not wrap."""
    plain = simulate(runs.push_options(runs.per_degree(30)), duration_s=runs.PUSH_DURATION_S)[
        "sensed_spring_torque_nm"
    ].astype(np.float64)
    _, naive, guarded = wrap_traces(bits)
    return float(np.abs(naive - plain).max()), float(np.abs(guarded - plain).max())


def clock_errors(first_tick: int) -> tuple[float, float]:
    """Error of a sine's torque (share of its amplitude) while a 32-bit count of ticks wraps.

    The naive one multiplies a float time by the frequency.
    """
    frequency, amplitude = 5.0, 50e-3
    options = LoopOptions(
        scene=scenes.Periodic(waveform="sine", amplitude_nm=amplitude, frequency_hz=frequency),
        control=ControlConfig(law="motor_only"),
        first_tick=first_tick,
    )
    ticks = np.arange(1000)
    rows = replay(options, np.zeros(len(ticks), dtype=np.uint32))
    # The device's frequency: a whole number of 2^-32 periods a tick.
    period = np.float32(np.float32(1e6) * np.float32(1e-9))
    per_tick = round(float(np.float32(np.float32(frequency) * period)) * 2**32)
    phase = np.array([(first_tick + int(n)) * per_tick % 2**32 for n in ticks]) / 2**32
    exact = np.sin(2 * math.pi * phase)
    time = ((first_tick + ticks) * 1e-3).astype(np.float32)
    true_phase = np.array([(first_tick + int(n)) * 5 % 1000 for n in ticks]) / 1000
    turns = (time * np.float32(frequency)).astype(np.float64)
    naive = np.sin(2 * math.pi * turns) - np.sin(2 * math.pi * true_phase)
    guarded = rows["desired_torque_nm"] / amplitude - exact
    return float(np.abs(naive).max()), float(np.abs(guarded).max())


def microsecond_errors_s() -> tuple[float, float]:
    """Let an emulated knob run past 2^32 microseconds; largest error of a step of its time.

    Returns
    -------
    tuple
        Of 32-bit microseconds that the device's own ticks make, and of the time that the SDK gives
        its samples.
    """
    with torsio.open("emulated") as knob:
        knob.emulator.advance(2**32 * 1e-6 - 0.1)
        samples = knob.record(duration_s=0.2, rate_hz=1000.0)
    ticks = samples["tick"].astype(np.int64)
    if not (ticks[0] * 1000 < 2**32 <= ticks[-1] * 1000):
        raise AssertionError("the samples do not go past the wrap")
    step_s = 1e-3 * np.diff(ticks)
    microseconds = (ticks * 1000) % 2**32
    naive = np.abs(1e-6 * np.diff(microseconds) - step_s).max()
    return float(naive), float(np.abs(np.diff(samples["time_s"]) - step_s).max())


# Rounding -----------------------------------------------------------------------------------------


def subnormal_ticks(seconds: float = 60.0) -> tuple[int, int]:
    """Ticks that a released brake's model spends in subnormal numbers: plain, and the device's."""
    ticks = round(1000 * seconds)
    decay = np.float32(math.exp(-1e-3 / PlantParams().brake_time_constant_s))
    tiny = float(np.finfo(np.float32).tiny)
    value, naive = np.float32(0.1), 0
    for _ in range(ticks):
        value = np.float32(value * decay)
        naive += int(0 < value < tiny)
    state = core.BrakeState(capacity_nm=0.1)
    params = core.BrakeParams(floor_nm=0.0)
    states = core.model_brake(state, params, np.zeros(ticks))
    return naive, int(np.count_nonzero((states > 0) & (states < tiny)))


def subnormal_plant_states() -> tuple[int, int]:
    """Count subnormal torques of motor and brake for 60 s after both are let go.

    Looked at every millisecond while the motor's torque decays, and every 100 ms from then on.

    Returns
    -------
    tuple
        Of a brake's torque that is multiplied by its decay at every look, in doubles, and of both
        lags of the emulated knob.
    """
    tiny = float(np.finfo(np.float64).tiny)
    params = PlantParams(brake_drag_nm=0.0)  # the drag would hide the brake's own torque
    plant = emulator.Plant(params)
    plant.set_command(motor_command_nm=50e-3, brake_command_nm=0.1)
    plant.advance(200_000_000)
    plant.set_command()
    torque_nm, naive, guarded = 0.1, 0, 0
    for step_ms in [1] * 200 + [100] * 598:
        torque_nm *= math.exp(-1e-3 * step_ms / params.brake_time_constant_s)
        plant.advance(1_000_000 * step_ms)
        naive += 0.0 < torque_nm < tiny
        lags_nm = (plant.state["motor_torque_nm"], plant.state["brake_capacity_nm"])
        guarded += sum(0.0 < abs(value) < tiny for value in lags_nm)
    return naive, guarded


def precision_trace(options: LoopOptions, duration_s: float) -> tuple[Array, Array]:
    """Time, and the motor's torque in 32 bits minus the 64-bit build's on the same counts."""
    rows = simulate(options, duration_s=duration_s)
    counts = rows["position_counts"] % (1 << 32)
    single = replay(options, counts)
    double = wide.replay(options, counts)
    return rows["time_s"], np.asarray(single["motor_command_nm"] - double["motor_command_nm"])
