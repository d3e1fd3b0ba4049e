"""How stiff a spring a knob can render, by theory and by an emulated knob like it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
import numpy.typing as npt

from torsio.closed_loop import LoopOptions, SpinUp, simulate_many
from torsio.common import checks
from torsio.core import PartitionParams
from torsio.perception import VIBRATION_NM, vibration_nm
from torsio.printed.config import ActuatorConfig, ControlConfig
from torsio.printed.plant import PlantParams
from torsio.printed.scenes import Damper, Scene, Spring

__all__ = ["LIMITS", "SPEEDS_RAD_S", "StabilityMap", "boundary", "measure", "plant_of"]

Array = npt.NDArray[np.float64]

LIMITS: Final = {
    "rate": "limited by the control rate",
    "lag": "limited by the motor's lag",
    "counts": "limited by the encoder's counts",
}
"""`StableStiffness.limited_by` in words."""

SPEEDS_RAD_S: Final = (6.0, 10.0, 14.0, 18.0, 22.0)
"""At which a spring catches the knob when it is measured."""

# A fifth is taken off the friction's part, for what the describing function leaves out.
_TRUSTED_FRICTION: Final = 0.8
_OF_NYQUIST: Final = 0.9
_SPIN_UP_SHARE: Final = 0.9
_DURATION_S, _TAIL_S = 1.0, 0.2
_ROWS_PER_S: Final = 1000.0


def plant_of(actuator: ActuatorConfig) -> PlantParams:
    """Give the knob that a configuration describes; the rest is as in the reference."""
    checks.kind("actuator", actuator, ActuatorConfig, "an ActuatorConfig")
    return PlantParams(
        knob_inertia_kg_m2=actuator.knob_inertia_kg_m2,
        knob_viscous_nm_s_per_rad=actuator.knob_viscous_nm_s_per_rad,
        knob_coulomb_nm=actuator.knob_coulomb_nm,
        brake_drag_nm=actuator.brake_drag_nm,
        shaft_stiffness_nm_per_rad=actuator.spring_stiffness_nm_per_rad,
        brake_time_constant_s=actuator.brake_time_constant_s,
        motor_time_constant_s=actuator.motor_time_constant_s,
        motor_limit_nm=actuator.motor_torque_max_nm,
        brake_limit_nm=actuator.brake_torque_max_nm,
        counts_per_rev=actuator.counts_per_rev,
    )


def boundary(
    actuator: ActuatorConfig, control: ControlConfig, rate_hz: float, *, points: int = 8000
) -> tuple[Array, Array]:
    """Give the damping and the stiffness of springs with dampers that are just stable.

    A swing of frequency w goes on for ever if ``J (i w)^2 + b i w + (K + d V(w)) exp(-i w tau)`` is
    0: the commands act half a period and the motor's lag late, and V is the speed estimate of the
    angle. `b` has the friction in it, as its describing function has it where the motor saturates,
    and spring and brake carry their part at once.

    Returns
    -------
    damping_nm_s_per_rad, stiffness_nm_per_rad
        Along the curve, each of shape (n,); docs/explanation/theory.md, "Stability".
    """
    checks.kind("actuator", actuator, ActuatorConfig, "an ActuatorConfig")
    checks.kind("control", control, ControlConfig, "a ControlConfig")
    rate_hz = checks.positive("rate_hz", rate_hz)
    inertia = actuator.knob_inertia_kg_m2
    late_s = 0.5 / rate_hz + actuator.motor_time_constant_s
    largest_nm = min(actuator.motor_torque_max_nm, control.motor_torque_cap_nm)
    friction = _TRUSTED_FRICTION * 4.0 * actuator.knob_coulomb_nm / math.pi
    share = control.beta if PartitionParams(law=control.law).brakes else 0.0
    omega = np.geomspace(10.0, _OF_NYQUIST * math.pi * rate_hz, points)
    # Where the motor saturates the swing's speed is T / (J w).
    losses = actuator.knob_viscous_nm_s_per_rad + friction * inertia * omega / largest_nm
    acts_late = np.exp(-1j * omega * late_s)
    # A difference of the angle behind two poles: core/motion.hpp.
    pole = math.exp(-2.0 * math.pi * control.speed_bandwidth_hz / rate_hz)
    back = np.exp(-1j * omega / rate_hz)
    damper = acts_late * ((1.0 - pole) / (1.0 - pole * back)) ** 2 * (1.0 - back) * rate_hz

    def solve(at_once: float, late: float, carried: float) -> tuple[Array, Array]:
        # spring K + damper d = J w^2 - b i w - what is carried
        spring = at_once + late * acts_late
        right = inertia * omega**2 - 1j * losses * omega - carried * (1.0 - acts_late)
        determinant = (spring.conj() * damper).imag
        stiffness = (right.conj() * damper).imag / determinant
        damping = (spring.conj() * right).imag / determinant
        return damping, stiffness

    # The brake carries its share of a soft spring, but never more than the shaft's winds up.
    shaft = actuator.spring_stiffness_nm_per_rad
    soft = solve(share, 1.0 - share, 0.0)
    stiff = solve(0.0, 1.0, shaft if share > 0.0 else 0.0)
    branches = (
        (*soft, share * soft[1] < shaft),
        (*stiff, (share * stiff[1] >= shaft) & (share > 0.0)),
    )
    kept = [
        np.column_stack([omega, damping, stiffness])[valid & (damping >= 0.0) & (stiffness >= 0.0)]
        for damping, stiffness, valid in branches
    ]
    curve = np.concatenate(kept)
    curve = curve[np.argsort(curve[:, 0])]
    return curve[:, 1], curve[:, 2]


@dataclass(frozen=True, repr=False)
class StabilityMap(checks.ShortRepr):
    """Swings of a knob that was thrown into springs with dampers.

    Attributes
    ----------
    stiffness_nm_per_rad, damping_nm_s_per_rad
        Values of the scenes, shapes (n,) and (m,).
    swing_rad
        The knob's motion, peak to peak, long after it was caught; the worst speed's; shape (n, m).
    vibration_nm
        The motor's torque above 20 Hz then, root of the mean square; shape (n, m).
    at_rest_rad
        A knob that moves by less does not swing.
    """

    stiffness_nm_per_rad: Array
    damping_nm_s_per_rad: Array
    swing_rad: Array
    vibration_nm: Array
    at_rest_rad: float

    @property
    def is_stable(self) -> npt.NDArray[np.bool_]:
        """Whether the knob came to rest and its motor vibrates less than a finger feels.

        Shape (n, m).
        """
        result: npt.NDArray[np.bool_] = (self.swing_rad < self.at_rest_rad) & (
            self.vibration_nm < VIBRATION_NM
        )
        return result

    @property
    def stable_to_nm_per_rad(self) -> Array:
        """Up to where every spring comes to rest, for each damping, shape (m,); 0 if none does."""
        upto = np.logical_and.accumulate(self.is_stable, axis=0).sum(axis=0)
        result: Array = np.append(0.0, self.stiffness_nm_per_rad)[upto]
        return result


def measure(
    plant: PlantParams,
    actuator: ActuatorConfig,
    control: ControlConfig,
    rate_hz: float,
    *,
    stiffness_nm_per_rad: Iterable[float],
    damping_nm_s_per_rad: Iterable[float] = (0.0,),
    speeds_rad_s: Iterable[float] = SPEEDS_RAD_S,
    progress: Callable[[int, int], None] | None = None,
) -> StabilityMap:
    """Throw an emulated knob into springs with dampers, and see which let it come to rest.

    Parameters
    ----------
    plant
        The true knob.
    actuator, control
        Beliefs of its device, and the law by which it controls.
    progress
        Called with how many dampings are done, and of how many.
    """
    checks.kind("plant", plant, PlantParams, "PlantParams")
    checks.kind("actuator", actuator, ActuatorConfig, "an ActuatorConfig")
    checks.kind("control", control, ControlConfig, "a ControlConfig")
    rate_hz = checks.positive("rate_hz", rate_hz)
    stiffness = np.array(checks.numbers("stiffness_nm_per_rad", stiffness_nm_per_rad))
    damping = np.array(checks.numbers("damping_nm_s_per_rad", damping_nm_s_per_rad))
    speeds = checks.numbers("speeds_rad_s", speeds_rad_s)
    spin_up_nm = _SPIN_UP_SHARE * plant.motor_limit_nm
    counts = 3.0 * 2.0 * math.pi / plant.counts_per_rev
    widest, loudest = (np.empty((len(stiffness), len(damping))) for _ in range(2))
    for column, damper in enumerate(damping):
        runs = [
            LoopOptions(
                scene=_scene(spring, damper),
                plant=plant,
                actuator=actuator,
                control=control,
                control_period_ns=round(1e9 / rate_hz),
                spin_up=SpinUp(motor_command_nm=spin_up_nm, speed_rad_s=speed),
            )
            for spring, speed in product(stiffness, speeds)
        ]
        every = max(round(rate_hz / _ROWS_PER_S), 1)
        rows = simulate_many(runs, duration_s=_DURATION_S, record_every=every)
        tails = [one[one["time_s"] >= _DURATION_S - _TAIL_S] for one in rows]
        swings = [float(np.ptp(one["angle_rad"])) for one in tails]
        loud = [vibration_nm(one["motor_torque_nm"], rate_hz / every) for one in tails]
        shape = (len(stiffness), len(speeds))
        widest[:, column] = np.reshape(swings, shape).max(axis=1)
        loudest[:, column] = np.reshape(loud, shape).max(axis=1)
        if progress is not None:
            progress(column + 1, len(damping))
    return StabilityMap(stiffness, damping, widest, loudest, max(counts, 3e-3))


def _scene(stiffness: float, damping: float) -> Scene:
    spring = Spring(stiffness_nm_per_rad=float(stiffness))
    return [spring, Damper(damping_nm_s_per_rad=float(damping))] if damping > 0.0 else spring
