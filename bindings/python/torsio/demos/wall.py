"""The main demonstration: a hand pushes an (emulated or real) knob into a virtual wall.

`run` plays the wall, records the visit and gives a `WallVisit`; `measure` turns that into numbers.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from functools import partial

import numpy as np
import numpy.typing as npt

from torsio import _torsio, perception
from torsio.errors import Error
from torsio.knob import Knob
from torsio.knob.configuration import put_back
from torsio.printed.config import ControlConfig
from torsio.printed.hands import ImpedanceHand, Profile
from torsio.printed.scenes import Wall
from torsio.telemetry import Record

Array = npt.NDArray[np.float64]

WALL_ANGLE_RAD = 0.05
WALL_STIFFNESS_NM_PER_RAD = math.degrees(25e-3)  # 25 mN m per degree
PEAK_TORQUE_NM = 75e-3
BETA = 0.5
RATE_HZ = 1000.0

# The hand pushes in for 1 s, holds for 0.2 s and comes out in 1 s. It has the stiffness, damping
# and mass of fingers that grip a knob.
PUSH_S, HOLD_S, PULL_S, AFTER_S = 1.0, 0.2, 1.0, 0.2
HAND_STIFFNESS_NM_PER_RAD = 1.0
HAND_DAMPING_NM_S_PER_RAD = 10e-3
HAND_INERTIA_KG_M2 = 1e-4
KNOB_FRICTION_NM = 6e-3

# Tracking up to here feels like a wall, as shares of the peak.
GOOD_TRACKING_IN, GOOD_TRACKING_OUT = 0.07, 0.09

EMULATED_DURATION_S = PUSH_S + HOLD_S + PULL_S + AFTER_S
HARDWARE_DURATION_S = 6.0


@dataclass(frozen=True)
class Setting:
    """Knob and wall of a visit.

    Attributes
    ----------
    realtime_factor
        Seconds of the device in a second of the clock on the wall.
    counts_per_rev
        Counts of the encoder in a turn.
    """

    device: str
    law: str
    control_rate_hz: float
    wall_angle_rad: float
    wall_stiffness_nm_per_rad: float
    beta: float
    samples_lost: int
    realtime_factor: float
    counts_per_rev: int


@dataclass(frozen=True)
class WallVisit(Setting):
    """The record of one visit to the wall. Arrays of shape (n,); torques are on the knob."""

    time_s: Array
    angle_rad: Array
    desired_torque_nm: Array
    motor_command_nm: Array
    brake_capacity_nm: Array
    spring_torque_nm: Array
    truth: Record | None
    """The emulator's true values, at the times of the telemetry."""

    @property
    def rendered_torque_nm(self) -> Array:
        """The felt torque: spring and motor together, true where known."""
        if self.truth is None:
            return self.spring_torque_nm + self.motor_command_nm
        return np.asarray(self.truth["spring_torque_nm"] + self.truth["motor_torque_nm"])

    @property
    def ideal_torque_nm(self) -> Array:
        """A perfect wall's torque at the knob's angle, true where known."""
        angle_rad = self.angle_rad if self.truth is None else self.truth["angle_rad"]
        depth_rad = np.maximum(angle_rad - self.wall_angle_rad, 0.0)
        return -self.wall_stiffness_nm_per_rad * depth_rad


@dataclass(frozen=True)
class WallMeasures(Setting):
    """The visit in numbers.

    Attributes
    ----------
    peak_torque_nm
        Largest torque that was asked for.
    tracking_rms_in, tracking_rms_out
        RMS difference of rendered and ideal torque inside the wall, as a fraction of the peak, on
        the way in (up to 98 % of the peak) and on the way out (from there on).
    torque_gap_nm
        Largest torque missing on the way out.
    sensor_rms_nm
        RMS error of the sensed spring torque; None on hardware, where the truth is not known.
    """

    peak_torque_nm: float
    tracking_rms_in: float
    tracking_rms_out: float
    torque_gap_nm: float
    sensor_rms_nm: float | None
    final_angle_rad: float
    left_wall: bool
    samples: int

    def jnds(self) -> dict[str, float]:
        """Give the errors, and the step from count to count, in just noticeable differences."""
        found = perception.wall_jnds(
            peak_nm=self.peak_torque_nm,
            tracking_in=self.tracking_rms_in,
            tracking_out=self.tracking_rms_out,
            torque_gap_nm=self.torque_gap_nm,
        )
        if self.sensor_rms_nm is not None:
            found["sensor"] = perception.torque_jnds(self.sensor_rms_nm)
        step_nm = perception.count_step_nm(self.wall_stiffness_nm_per_rad, self.counts_per_rev)
        return found | {"count_step": perception.torque_jnds(step_nm)}

    def as_dict(self) -> dict[str, object]:
        """Give what goes into the JSON file."""
        return asdict(self) | {"jnds": self.jnds()}

    def shortcomings(self) -> list[str]:
        """Say what is not as it should be; nothing if it feels like a wall."""
        found = []
        for way, share, limit in (
            ("in", self.tracking_rms_in, GOOD_TRACKING_IN),
            ("out", self.tracking_rms_out, GOOD_TRACKING_OUT),
        ):
            if not share <= limit:
                found.append(
                    f"tracking on the way {way} errs by {100 * share:.1f} %, "
                    f"more than {100 * limit:.0f} %"
                )
        if not self.left_wall:
            found.append("the knob is still in the wall")
        if self.samples_lost > 0:
            found.append(f"samples lost: {self.samples_lost}")
        return found


class WallNotReachedError(RuntimeError):
    """The knob was never pushed into the wall, so there is nothing to measure."""


def fingers(intended_angle_rad: Profile) -> ImpedanceHand:
    """Give a grip on the knob that means to go this way."""
    return ImpedanceHand(
        intended_angle_rad=intended_angle_rad,
        stiffness_nm_per_rad=HAND_STIFFNESS_NM_PER_RAD,
        damping_nm_s_per_rad=HAND_DAMPING_NM_S_PER_RAD,
        inertia_kg_m2=HAND_INERTIA_KG_M2,
    )


def hand(stiffness_nm_per_rad: float = WALL_STIFFNESS_NM_PER_RAD) -> ImpedanceHand:
    """Give the hand that visits a wall of this stiffness.

    To press with the peak torque a compliant hand must aim further than the knob goes: by the depth
    in the wall, and by its own compliance.
    """
    depth_rad = PEAK_TORQUE_NM / stiffness_nm_per_rad
    give_rad = (PEAK_TORQUE_NM + KNOB_FRICTION_NM) / HAND_STIFFNESS_NM_PER_RAD
    deepest_rad = WALL_ANGLE_RAD + depth_rad + give_rad
    arrive_s, leave_s = PUSH_S, PUSH_S + HOLD_S
    return fingers(((0, 0), (arrive_s, deepest_rad), (leave_s, deepest_rad), (leave_s + PULL_S, 0)))


def run(knob: Knob, on_progress: Callable[[float], None] = lambda _: None) -> WallVisit:
    """Play the wall and record a visit to it.

    Parameters
    ----------
    knob
        Disarmed. An emulated one must have been opened with ``EmulatorOptions(log_truth=True)``.
    on_progress
        Called with the share that is done, 0 to 1.

    Raises
    ------
    Error
        If an emulated knob was opened without it, or the configuration cannot be restored.
    """
    before = knob.control_config()
    try:
        knob.update(law="paper", beta=BETA)
        knob.zero()
        knob.relax()
        knob.play(Wall(angle_rad=WALL_ANGLE_RAD, stiffness_nm_per_rad=WALL_STIFFNESS_NM_PER_RAD))
        knob.arm()
        # The torque comes softly after arming; the visit begins when it is all there.
        knob.sleep(before.passive_ramp_s)
        return _record_visit(knob, on_progress)
    finally:
        _end(knob, before)


@_torsio.all_of
def _end(knob: Knob, before: ControlConfig) -> Iterable[Callable[[], object]]:
    """Stop, and configure the knob as before."""
    return partial(_stop, knob), partial(_restore, knob, before)


def _stop(knob: Knob) -> None:
    with suppress(Error):  # or it cannot be put back, which is told
        knob.stop()


def _restore(knob: Knob, before: ControlConfig) -> None:
    if not knob.is_open or knob.state != "disconnected":  # which forgets unsaved values
        put_back(knob, before, "the demonstration")


def _record_visit(knob: Knob, on_progress: Callable[[float], None]) -> WallVisit:
    duration_s = HARDWARE_DURATION_S
    rate_hz = knob.start_telemetry(rate_hz=RATE_HZ)
    if knob.is_emulated:
        duration_s = EMULATED_DURATION_S
        knob.emulator.truth()  # forgets what was before
        knob.emulator.set_hand(hand())
    begin = time.perf_counter()
    chunks: list[Record] = []
    total = 0
    for chunk in knob.telemetry(duration_s=duration_s, rate_hz=RATE_HZ, max_samples=64):
        chunks.append(chunk)
        total += len(chunk)
        on_progress(total / (duration_s * rate_hz))
    elapsed_s = time.perf_counter() - begin
    log = np.concatenate(chunks)
    truth = _truth_at(log, knob.emulator.truth()) if knob.is_emulated else None

    config = knob.control_config()
    return WallVisit(
        device="emulated" if knob.is_emulated else knob.info.serial or knob.info.path,
        law=config.law,
        control_rate_hz=knob.info.control_rate_hz,
        wall_angle_rad=WALL_ANGLE_RAD,
        wall_stiffness_nm_per_rad=WALL_STIFFNESS_NM_PER_RAD,
        beta=config.beta,
        time_s=log["time_s"] - log["time_s"][0],
        angle_rad=log["angle_rad"],
        desired_torque_nm=log["desired_torque_nm"].astype(np.float64),
        motor_command_nm=log["motor_command_nm"].astype(np.float64),
        brake_capacity_nm=log["brake_capacity_nm"].astype(np.float64),
        spring_torque_nm=log["spring_torque_nm"].astype(np.float64),
        truth=truth,
        samples_lost=knob.statistics().samples_lost,
        realtime_factor=duration_s / elapsed_s,
        counts_per_rev=knob.info.counts_per_rev,
    )


def _truth_at(log: Record, truth: Record) -> Record:
    return truth[np.searchsorted(truth["time_s"], log["time_s"] - 1e-9)]


def phases(visit: WallVisit) -> tuple[slice, slice]:
    """Give the samples on the way in and on the way out of the wall.

    Raises
    ------
    WallNotReachedError
        If the knob was never in the wall.
    """
    asked = np.abs(visit.desired_torque_nm)
    inside = np.flatnonzero(asked > 0)
    if len(inside) == 0:
        raise WallNotReachedError(
            "the knob never reached the wall at "
            f"{math.degrees(visit.wall_angle_rad):.1f} degrees: turn it further"
        )
    top = np.flatnonzero(asked >= 0.98 * asked.max())
    return slice(inside[0], top[0] + 1), slice(top[-1], inside[-1] + 1)


def measure(visit: WallVisit) -> WallMeasures:
    """Turn a visit into numbers."""
    way_in, way_out = phases(visit)
    ideal, rendered = visit.ideal_torque_nm, visit.rendered_torque_nm
    error = rendered - ideal
    peak = float(np.abs(visit.desired_torque_nm).max())
    missing = np.abs(ideal) - rendered * np.sign(ideal)
    sensor_rms = None
    if visit.truth is not None:
        sensor_rms = rms(visit.spring_torque_nm - visit.truth["spring_torque_nm"])
    final = float(visit.angle_rad[-1])
    return WallMeasures(
        **{field.name: getattr(visit, field.name) for field in fields(Setting)},
        peak_torque_nm=peak,
        tracking_rms_in=rms(error[way_in]) / peak,
        tracking_rms_out=rms(error[way_out]) / peak,
        torque_gap_nm=float(missing[way_out].max()),
        sensor_rms_nm=sensor_rms,
        final_angle_rad=final,
        left_wall=final < visit.wall_angle_rad,
        samples=len(visit.time_s),
    )


def rms(values: Array) -> float:
    """Root of the mean square; NaN of nothing."""
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else math.nan
