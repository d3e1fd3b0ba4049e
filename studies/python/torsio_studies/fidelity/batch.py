"""Error against cost of many knobs at once, by parts, rate, precision and program.

First the knob's closed loop in `torsio.batch`: the control rate, the parts of the plant and the
precision of its steps are what one gives up for speed, and the error is against all parts at the
highest rate in double precision. The law is the device's, in single precision: what that costs is
told by the law in double precision over the same counts. Then commands that
are played to many copies of one plant, in `torsio.batch` and in MuJoCo's `rollout`. That varies no
joint's friction, so nothing engages the brake there.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from torsio.batch import Knobs, LoopOptions
from torsio.closed_loop import replay, simulate
from torsio.demos import wall
from torsio.printed.config import ControlConfig
from torsio.printed.hands import Hand, ImpedanceHand
from torsio.printed.plant import Belt, BrakeHysteresis, Cogging, PlantParams, ShaftHardening
from torsio.printed.scenes import Wall
from torsio_studies import wide
from torsio_studies.fidelity.mujoco_model import Settings, Simulation
from torsio_studies.fidelity.truth import PLANT, hand_torque, simulate_truth
from torsio_studies.steppers import Method, stepped_by

Array = npt.NDArray[np.float64]

RATES_HZ: Final = (1_000, 2_000, 5_000, 10_000, 20_000)
MUJOCO_STEPS_US: Final = (1000, 500, 200, 100, 50, 20)
QUICK_MUJOCO_STEPS_US: Final = (1000, 200)
EVERYTHING: Final = replace(
    PLANT,
    shaft_hardening=ShaftHardening(knee_rad=0.005),
    brake_hysteresis=BrakeHysteresis(),
    belt=Belt(),
    cogging=Cogging.sine(periods_per_rev=12, amplitude_nm=2e-3),
)
PLANTS: Final = {
    "all": EVERYTHING,
    "without hardening": replace(EVERYTHING, shaft_hardening=None),
    "without hysteresis": replace(EVERYTHING, brake_hysteresis=None),
    "without belt": replace(EVERYTHING, belt=None),
    "without cogging": replace(EVERYTHING, cogging=None),
    "none": PLANT,
}
ROUNDS: Final = 3


def _least_s(run: Callable[[], object]) -> float:
    """Give the CPU time of a run that has been warm before, the least of some."""
    run()
    times = []
    for _ in range(ROUNDS):
        begin = time.process_time()
        run()
        times.append(time.process_time() - begin)
    return min(times)


def at_the_wall(hand: Hand, rate_hz: int = 1_000, plant: PlantParams = PLANT) -> LoopOptions:
    """Give the closed loop of a visit to the wall, under the paper's law."""
    return LoopOptions(
        scene=Wall(
            angle_rad=wall.WALL_ANGLE_RAD, stiffness_nm_per_rad=wall.WALL_STIFFNESS_NM_PER_RAD
        ),
        hand=hand,
        plant=plant,
        # The device knows of no parts.
        actuator=PLANT.matching_config(),
        control=ControlConfig(law="paper", beta=wall.BETA),
        control_period_ns=round(1e9 / rate_hz),
    )


def _felt_nm(options: LoopOptions, duration_s: float) -> Array:
    """Give what the hand feels, once a millisecond."""
    every = 1_000_000 // options.control_period_ns
    rows = simulate(options, duration_s=duration_s, record_every=every)
    felt_nm: Array = rows["spring_torque_nm"] + rows["motor_torque_nm"]
    return felt_nm


def law_error(hand: Hand, duration_s: float) -> dict[str, float]:
    """Give what single precision costs the law: error and RMS of the torque that it commands.

    The law runs again over the counts of a visit, in both precisions. Relative to the peak.
    """
    options = at_the_wall(hand)
    counts = simulate(options, duration_s=duration_s)["position_counts"]
    single, double = replay(options, counts), wide.replay(options, counts)
    peak_nm = error_nm = square = 0.0
    for name in ("motor_command_nm", "brake_command_nm"):
        difference = single[name] - double[name]
        peak_nm = max(peak_nm, float(np.abs(double[name]).max()))
        error_nm = max(error_nm, float(np.abs(difference).max()))
        square = max(square, float(np.mean(difference**2)))
    return {"error": error_nm / peak_nm, "error_rms": float(np.sqrt(square)) / peak_nm}


def closed_loop_rows(hand: Hand, duration_s: float, *, knobs: int) -> list[dict[str, Any]]:
    """Give a row for each control rate, with all parts and with none, and for each part left out.

    With all parts there is one more at the highest and the lowest rate, in single precision.

    The error is of the torque that the hand feels, relative to its peak.
    """
    truth_nm = _felt_nm(at_the_wall(hand, RATES_HZ[-1], EVERYTHING), duration_s)
    peak_nm = float(np.abs(truth_nm).max())
    exact: Method = "exact"
    wanted = [(parts, rate_hz, exact) for parts in ("all", "none") for rate_hz in RATES_HZ]
    wanted += [(parts, RATES_HZ[-1], exact) for parts in PLANTS if parts not in ("all", "none")]
    wanted += [("all", rate_hz, "exact_single") for rate_hz in (RATES_HZ[0], RATES_HZ[-1])]
    rows = []
    for parts, rate_hz, method in wanted:
        options = stepped_by(method, at_the_wall(hand, rate_hz, PLANTS[parts]))
        error_nm = _felt_nm(options, duration_s) - truth_nm
        together = Knobs(knobs, options, threads=1)
        ticks = round(duration_s * rate_hz)

        def run(together: Knobs = together, ticks: int = ticks) -> None:
            together.reset()
            together.step(ticks)

        rows.append(
            {
                "parts": parts,
                "control_rate_hz": rate_hz,
                "precision": "single" if method == "exact_single" else "double",
                "error": float(np.abs(error_nm).max()) / peak_nm,
                "error_rms": float(np.sqrt(np.mean(error_nm**2))) / peak_nm,
                "knobs_in_real_time": knobs * duration_s / _least_s(run),
            }
        )
    return rows


class _Played:
    """Inputs: the motor's commands for a wall that the motor alone renders."""

    def __init__(self, hand: ImpedanceHand, duration_s: float) -> None:
        self.options = replace(at_the_wall(hand), control=ControlConfig(law="motor_only"))
        rows = simulate(self.options, duration_s=duration_s)
        self.duration_s = duration_s
        self.hand = hand_torque(hand)
        self.motor_nm = rows["motor_command_nm"].astype(np.float64)
        self.brake_nm = np.zeros_like(self.motor_nm)
        truth = simulate_truth(PLANT, self.hand, self.motor_nm, self.brake_nm, period_s=1e-3)
        self._angle_rad = truth.angle_rad
        self._twist_rad = truth.angle_rad - truth.brake_angle_rad

    def error(self, angles: Array) -> float:
        """Give the largest error of the knob's angle and of the twist, as the study has it."""
        angle = np.abs(angles[:, 0] - self._angle_rad).max() / np.ptp(self._angle_rad)
        twist = np.abs(angles[:, 0] - angles[:, 1] - self._twist_rad).max()
        return float(max(angle, twist / np.abs(self._twist_rad).max()))


def played_rows(
    hand: ImpedanceHand,
    duration_s: float,
    settings: Settings,
    *,
    knobs: int,
    steps_us: tuple[int, ...],
) -> list[dict[str, Any]]:
    """Give a row for `torsio.batch`, and one for each step of MuJoCo's rollout, on one thread."""
    played = _Played(hand, duration_s)
    together = Knobs(knobs, played.options, actions="commands", threads=1)
    angles = np.zeros((len(played.motor_nm), 2))

    def run() -> None:
        together.reset()
        for row, command_nm in enumerate(played.motor_nm):
            together.actions["motor_command_nm"] = command_nm
            together.step()
            state = together.states[-1]
            angles[row] = state["angle_rad"], state["brake_angle_rad"]

    def row(method: str, step_us: int, error: float, cpu_s: float, count: int) -> dict[str, Any]:
        return {
            "method": method,
            "step_s": step_us / 1e6,
            "error": error,
            "knobs_in_real_time": count * duration_s / cpu_s,
        }

    cpu_s = _least_s(run)
    rows = [row("torsio.batch", 1000, played.error(angles), cpu_s, knobs)]
    for step_us in steps_us:
        # A step costs MuJoCo the same for any number of copies, and each state is kept.
        few = max(2, knobs * step_us // 10_000)
        found, cpu_s = _rollout(played, settings, step_us, few)
        rows.append(row("mujoco.rollout", step_us, played.error(found), cpu_s, few))
    return rows


def _rollout(played: _Played, settings: Settings, step_us: int, knobs: int) -> tuple[Array, float]:
    """Play to copies in MuJoCo; give the angles of the last at the ticks' ends, and the time."""
    mujoco = importlib.import_module("mujoco")
    rollout = importlib.import_module("mujoco.rollout").rollout
    simulation = Simulation(
        PLANT,
        played.hand,
        played.motor_nm,
        played.brake_nm,
        period_s=1e-3,
        step_s=step_us / 1e6,
        settings=settings,
    )
    model, data = simulation.model, mujoco.MjData(simulation.model)
    begin = np.zeros(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, begin, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    torque = simulation.torque_nm
    control = np.column_stack([torque, np.zeros_like(torque)])[np.newaxis]
    states = np.zeros((knobs, len(torque), len(begin)))

    def run() -> None:
        rollout(
            model,
            [data],
            np.tile(begin, (knobs, 1)),
            control,
            control_spec=int(mujoco.mjtState.mjSTATE_QFRC_APPLIED),
            state=states,
        )

    cpu_s = _least_s(run)
    every = 1000 // step_us
    return states[-1, every - 1 :: every, 1:3], cpu_s  # behind the time
