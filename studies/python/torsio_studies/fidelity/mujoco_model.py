"""The same plant in MuJoCo, for the study `fidelity`.

Two hinges, a fixed tendon between them as the shaft spring, and MuJoCo's joint friction on either.
Everything that is known beforehand is computed beforehand and exactly: the lags of motor and brake,
averaged over each of MuJoCo's steps, and the hand's torque; the joint has the hand's stiffness,
damping and inertia. So MuJoCo is asked for nothing but mechanics and friction. Parts of its
pipeline that the model does not use are switched off, and its steps are called from compiled code.
"""

from __future__ import annotations

import ctypes
import importlib
import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from torsio.printed.plant import PlantParams
from torsio_studies import _studies
from torsio_studies.common import StudyError
from torsio_studies.fidelity.truth import HandTorque

Array = npt.NDArray[np.float64]

_UNUSED = (
    '<flag contact="disable" gravity="disable" equality="disable" limit="disable" '
    'sensor="disable" actuation="disable" island="disable"/>'
)
_SMALL = 1e-9  # MuJoCo wants bodies with mass; all inertia that matters is the joints' armature


@dataclass(frozen=True)
class Settings:
    """Settings of MuJoCo for this model.

    Attributes
    ----------
    solref_steps
        Time constant of the friction constraint, in steps; 2 is the least that MuJoCo accepts, and
        None its default of 20 ms.
    impedance
        How hard the constraint is, below 1; None is the default (0.9 to 0.95).
    """

    integrator: str = "Euler"
    solref_steps: float | None = None
    impedance: float | None = None
    solver: str = "Newton"
    iterations: int = 100

    @property
    def is_default(self) -> bool:
        """Nothing chosen."""
        return self == Settings()

    def as_text(self) -> str:
        """Name it in a few words."""
        if self.is_default:
            return "defaults"
        return (
            f"{self.integrator}, {self.solver} with at most {self.iterations} iterations, friction "
            f"time constant {self.solref_steps:g} steps, impedance {self.impedance:g}"
        )


def _mujoco() -> Any:
    try:
        return importlib.import_module("mujoco")
    except ImportError:
        raise StudyError(
            "the study `fidelity` compares with MuJoCo, which is not installed; in a clone of the "
            "project: pip install './studies[mujoco]'"
        ) from None


def mujoco_version() -> str:
    """Tell which MuJoCo there is."""
    return str(_mujoco().__version__)


def _step_address(mujoco: Any) -> int:
    library = next(Path(mujoco.__file__).parent.glob("libmujoco.so*"), None)
    if library is None:
        raise StudyError("MuJoCo's shared library is not where its package usually has it")
    address = ctypes.cast(ctypes.CDLL(str(library)).mj_step, ctypes.c_void_p).value
    assert address is not None
    return address


def _xml(plant: PlantParams, hand: HandTorque, step_s: float, settings: Settings) -> str:
    friction = ""
    if settings.solref_steps is not None:
        friction += f' solreffriction="{settings.solref_steps * step_s!r} 1"'
    if settings.impedance is not None:
        friction += f' solimpfriction="{settings.impedance!r} {settings.impedance!r} 0.001"'
    knob_inertia = plant.knob_inertia_kg_m2 + hand.inertia_kg_m2 - _SMALL
    knob_damping = plant.knob_viscous_nm_s_per_rad + hand.damping_nm_s_per_rad
    body = f'<inertial pos="0 0 0" mass="1" diaginertia="{_SMALL} {_SMALL} {_SMALL}"/>'
    return f"""<mujoco>
  <option timestep="{step_s!r}" integrator="{settings.integrator}" solver="{settings.solver}"
          iterations="{settings.iterations}">{"" if settings.is_default else _UNUSED}</option>
  <worldbody>
    <body>{body}
      <joint name="knob" type="hinge" axis="0 0 1" armature="{knob_inertia!r}"
             damping="{knob_damping!r}" stiffness="{hand.stiffness_nm_per_rad!r}"
             frictionloss="{plant.knob_coulomb_nm!r}"{friction}/>
    </body>
    <body>{body}
      <joint name="brake" type="hinge" axis="0 0 1"
             armature="{plant.brake_inertia_kg_m2 - _SMALL!r}"
             damping="{plant.brake_viscous_nm_s_per_rad!r}"
             frictionloss="{plant.brake_drag_nm!r}"{friction}/>
    </body>
  </worldbody>
  <tendon>
    <fixed stiffness="{plant.shaft_stiffness_nm_per_rad!r}"
           damping="{plant.shaft_damping_nm_s_per_rad!r}" springlength="0">
      <joint joint="knob" coef="1"/><joint joint="brake" coef="-1"/>
    </fixed>
  </tendon>
</mujoco>"""


def lagged(command: Array, time_constant_s: float, steps: int, step_s: float) -> Array:
    """Means of the lagged command over each step, exactly."""
    begin = np.arange(steps) * step_s
    decay = np.exp(-begin / time_constant_s)
    mean = -math.expm1(-step_s / time_constant_s) * time_constant_s / step_s
    kept = math.exp(-steps * step_s / time_constant_s)
    result = np.empty((len(command), steps))
    value = 0.0
    for i, target in enumerate(command):
        result[i] = target + (value - target) * mean * decay
        value = target + (value - target) * kept
    return result.ravel()


def hand_force(hand: HandTorque, times_s: Array) -> Array:
    """Give a hand's torque without its stiffness and damping, in N m."""
    value = np.interp(times_s, hand.corners_s, hand.values)
    if hand.stiffness_nm_per_rad == 0.0 and hand.damping_nm_s_per_rad == 0.0:
        return value
    slopes = np.append(np.diff(hand.values) / np.diff(hand.corners_s), 0.0)
    slope = slopes[np.clip(np.searchsorted(hand.corners_s, times_s) - 1, 0, None)]
    return hand.stiffness_nm_per_rad * value + hand.damping_nm_s_per_rad * slope


class Simulation:
    """One run in MuJoCo, ready to be made again and again.

    Attributes
    ----------
    model
        MuJoCo's own.
    torque_nm
        Of hand and motor on the knob, for each of MuJoCo's steps.
    """

    def __init__(
        self,
        plant: PlantParams,
        hand: HandTorque,
        motor_nm: Array,
        brake_nm: Array,
        *,
        period_s: float,
        step_s: float,
        settings: Settings,
    ) -> None:
        """Compile the model and compute its inputs.

        Parameters
        ----------
        motor_nm, brake_nm
            Commands of shape (n,), each held for `period_s`, which `step_s` divides.
        """
        mujoco = _mujoco()
        self._mujoco = mujoco
        self._steps = round(period_s / step_s)
        self.model = mujoco.MjModel.from_xml_string(_xml(plant, hand, step_s, settings))
        self._data = mujoco.MjData(self.model)
        self._step = _step_address(mujoco)
        middle = (np.arange(len(motor_nm) * self._steps) + 0.5) * step_s
        self.torque_nm = lagged(motor_nm, plant.motor_time_constant_s, self._steps, step_s)
        self.torque_nm += hand_force(hand, middle.astype(np.float64))
        self._friction = lagged(brake_nm, plant.brake_time_constant_s, self._steps, step_s)
        self._friction += plant.brake_drag_nm

    def run(self) -> tuple[Array, float]:
        """Give angles of knob and brake at the periods' ends, shape (n, 2), and the CPU time."""
        self._mujoco.mj_resetData(self.model, self._data)
        begin = time.thread_time()
        angles = _studies.drive_foreign(
            step=self._step,
            model=self.model._address,
            data=self._data._address,
            torque=self._data.qfrc_applied.ctypes.data,
            friction=self.model.dof_frictionloss.ctypes.data + 8,  # the second joint's
            angles=self._data.qpos.ctypes.data,
            torque_nm=self.torque_nm,
            friction_nm=self._friction,
            steps_per_row=self._steps,
        )
        return angles, time.thread_time() - begin
