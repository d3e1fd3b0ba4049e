"""Turns a calibration into a proposed configuration, and applies it."""

from __future__ import annotations

import dataclasses
import datetime
import html
import math
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from torsio import perception
from torsio.calibration.brake_curve import BrakeCurve
from torsio.calibration.circuit import MEASURED_OF_BOARD
from torsio.calibration.cogging import Cogging
from torsio.calibration.doubts import Doubted
from torsio.calibration.found import Findings
from torsio.calibration.quantity import Fit, Quantity
from torsio.calibration.shaft import Shaft
from torsio.common import checks, notebook
from torsio.common.extras import need_matplotlib
from torsio.errors import Error
from torsio.knob import Knob, need_knob
from torsio.printed.config import ActuatorConfig, BoardConfig, CalibrationConfig, Law, ShaftConfig

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Calibration", "apply", "certain_assist_nm", "put_together"]

# Share of the certain friction: bearings wear in. A device takes no more than three quarters.
_ASSISTED = 0.73


@dataclass(frozen=True, repr=False)
class Calibration:
    """A knob as found.

    Attributes
    ----------
    quantities
        By name. All torques are as true as the proposed torque constant, or else the configured
        one.
    actuator, shaft
        The configurations that are proposed; nothing was saved.
    law, free_assist_nm
        Proposals for the control: the law that uses all these values, and the certain part of the
        friction. After a look for drift, the knob's own.
    known
        Uncertainties, date and conditions, for the device to keep.
    cogging
        Over the angle from the device's zero; None after a look for drift.
    curve
        Twist in rad and torque in N m of the shaft's corners.
    brake_curve
        The brake's torque over its command, up and down; None after a look for drift.
    seconds
        Duration, in the knob's time.
    conditions
        Serial number, board, firmware, rate, date, whether the motor's current is measured.
    board
        The same, of the motor; it takes effect when the knob starts the next time, and torques are
        these from then on. None: nothing of it was measured.
    """

    quantities: dict[str, Quantity]
    actuator: ActuatorConfig
    shaft: ShaftConfig
    law: Law
    free_assist_nm: float
    known: CalibrationConfig
    cogging: Cogging | None
    curve: tuple[tuple[float, float], ...]
    brake_curve: BrakeCurve | None
    seconds: float
    conditions: dict[str, Any]
    fits: tuple[Fit, ...]
    board: BoardConfig | None = None

    @property
    def title(self) -> str:
        """Say whose calibration it is, and how long it took."""
        return (
            f"Calibration of {self.conditions['serial']}: {self.seconds:.0f} s of the knob's time"
        )

    def __repr__(self) -> str:
        """Say whose it is and how much was found."""
        return (
            f"<torsio.calibration.Calibration of {self.conditions['serial']!r}, "
            f"{len(self.quantities)} quantities>"
        )

    def _repr_html_(self) -> str:
        found = [
            (of.name, f"{of.value:.4g} +- {of.standard_uncertainty:.2g}", of.meaning)
            for of in self.quantities.values()
        ]
        twist, torque = zip(*self.curve, strict=True)
        shaft = notebook.curve(twist, torque, "twist, rad", "torque of the shaft, N m")
        return f"<p>{html.escape(self.title)}</p>{shaft}{notebook.table(found)}"

    def plot(self) -> Figure:
        """Draw each step's data with its model, and the residuals.

        A notebook shows the figure; ``savefig(path)`` writes it. Needs the extra ``plot``.
        """
        need_matplotlib()
        from torsio.calibration.figure import plot_fits

        return plot_fits(self.fits, self.title)

    def as_dict(self) -> dict[str, Any]:
        """Give all but the pictures, as JSON has it."""
        return {
            "quantities": {
                name: {
                    "value": of.value,
                    "standard_uncertainty": of.standard_uncertainty,
                    "meaning": of.meaning,
                    "jnds": perception.jnds_of(name, of.value, of.standard_uncertainty),
                }
                for name, of in self.quantities.items()
            },
            "actuator": dataclasses.asdict(self.actuator),
            "shaft": dataclasses.asdict(self.shaft),
            "board": None if self.board is None else dataclasses.asdict(self.board),
            "law": self.law,
            "free_assist_nm": self.free_assist_nm,
            "known": dataclasses.asdict(self.known),
            "cogging": None if self.cogging is None else self.cogging.as_dict(),
            "curve": [list(corner) for corner in self.curve],
            "brake_curve": None
            if self.brake_curve is None
            else self.brake_curve.as_dict(self.conditions["brake_torque_constant_nm_per_a"]),
            "seconds": self.seconds,
            "conditions": self.conditions,
        }


def apply(knob: Knob, calibration: Calibration) -> None:
    """Configure a disarmed knob as proposed, or change nothing; `Knob.save` keeps that.

    Values of the board take effect when the knob starts the next time.
    """
    need_knob(knob)
    checks.kind("calibration", calibration, Calibration, "what calibrate() gave")
    board, control = knob.board_config(), knob.control_config()
    before = (knob.actuator_config(), knob.shaft_config(), board, control)
    # Its caps, limits and pins may be others by now.
    law = replace(control, law=calibration.law, free_assist_nm=calibration.free_assist_nm)
    motor = board
    if calibration.board is not None:
        measured = dataclasses.asdict(calibration.board)
        motor = replace(board, **{name: measured[name] for name in MEASURED_OF_BOARD})
    proposed = (calibration.actuator, calibration.shaft, motor, law)
    known = knob.calibration_config()
    try:
        # Uncertainties come last: they describe the values that the device has by then.
        for config in (*proposed, calibration.known):
            knob.configure(config)
    except Error:
        for config in (*before, known):
            with suppress(Error):
                knob.configure(config)
        raise


def _sigmas_of_knee(quantities: dict[str, Quantity]) -> dict[str, Any]:
    """Give the uncertainties of a knee, if one was found."""
    sigmas = {}
    if "knee_rad" in quantities:
        sigmas["sigma_knee_1_rad"] = quantities["knee_rad"].standard_uncertainty
    stiffness, factor = quantities["stiffness_nm_per_rad"], quantities.get("stiffness_factor")
    if factor is not None:
        sigmas["sigma_knee_1_nm_per_rad"] = math.hypot(
            factor.value * stiffness.standard_uncertainty,
            stiffness.value * factor.standard_uncertainty,
        )
    return sigmas


def _bent(shaft: Shaft, configured: ShaftConfig, sigmas: dict[str, Any]) -> ShaftConfig:
    if shaft.knee is None or shaft.factor is None:
        return ShaftConfig()
    found = ShaftConfig(
        knee_1_rad=shaft.knee.value,
        knee_1_nm_per_rad=shaft.stiffness.value * shaft.factor.value,
    )
    is_noise = all(
        abs(getattr(found, name) - getattr(configured, name)) <= 1.96 * sigmas[f"sigma_{name}"]
        for name in ("knee_1_rad", "knee_1_nm_per_rad")
    )
    return configured if is_noise else found


_PROPOSED_FROM: Final = {
    "spring_stiffness_nm_per_rad": "stiffness_nm_per_rad",
    "knob_coulomb_nm": "knob_coulomb_nm",
    "knob_viscous_nm_s_per_rad": "knob_viscous_nm_s_per_rad",
    "knob_inertia_kg_m2": "knob_inertia_kg_m2",
    "brake_inertia_kg_m2": "brake_inertia_kg_m2",
    "brake_time_constant_s": "rise_s",
    "brake_release_time_constant_s": "release_s",
    "brake_hysteresis_nm": "hysteresis_nm",
    "brake_drag_nm": "brake_drag_nm",
}


def _proposed(
    actuator: ActuatorConfig, quantities: dict[str, Quantity]
) -> tuple[dict[str, float], dict[str, Any]]:
    """Give the found values and their uncertainties, without changes that are noise.

    Keep the configured value if it lies in the interval. Use zero if zero lies in it.
    """
    values: dict[str, float] = {}
    sigmas: dict[str, Any] = {}
    for name, of in _PROPOSED_FROM.items():
        if of not in quantities:
            continue
        found = quantities[of]
        configured, best = float(getattr(actuator, name)), max(found.value, 0.0)
        values[name] = next((one for one in (configured, 0.0) if found.holds(one)), best)
        sigmas[f"sigma_{name}"] = math.hypot(found.standard_uncertainty, values[name] - best)
    rise, release = "brake_time_constant_s", "brake_release_time_constant_s"
    lag_s = float(getattr(actuator, rise))
    # Without a value of its own it lets go as it takes hold.
    if (
        getattr(actuator, release) == 0.0
        and values.get(rise) == lag_s
        and quantities["release_s"].holds(lag_s)
    ):
        values[release], sigmas[f"sigma_{release}"] = 0.0, 0.0
    return values, sigmas


def certain_assist_nm(quantities: dict[str, Quantity], configured_nm: float) -> float:
    """Give the assist: the certain friction, less a reserve for wear.

    Leave out the friction that the brake's loop keeps: a knob that has not braked yet lacks it.
    Leave out the part that holds a steady pull; otherwise a knob pushed that way would go on. Keep
    the configured value if the difference may be noise.
    """
    # The sum is at least as certain as the drag, which is all friction less the knob's.
    certain_nm = quantities["knob_coulomb_nm"].value + quantities["brake_drag_nm"].interval[0]
    certain_nm = _ASSISTED * (certain_nm - max(map(abs, quantities["offset_nm"].interval)))
    if certain_nm <= 0.0:
        return 0.0
    noise_nm = _ASSISTED * 1.96 * quantities["brake_drag_nm"].standard_uncertainty
    return configured_nm if abs(configured_nm - certain_nm) <= noise_nm else certain_nm


def _conditions(
    knob: Knob, board: BoardConfig, ambient_c: float | None, now: datetime.datetime
) -> dict[str, Any]:
    info = knob.info
    return {
        "serial": info.serial,
        "board": info.board,
        "firmware_version": info.firmware_version,
        "control_rate_hz": info.control_rate_hz,
        "counts_per_rev": info.counts_per_rev,
        "brake_torque_constant_nm_per_a": board.brake_torque_constant_nm_per_a,
        "ambient_c": ambient_c,
        "current_measured": knob.motor_current().measured,
        "date": now.isoformat(timespec="seconds"),
    }


def put_together(
    knob: Knob,
    actuator: ActuatorConfig,
    findings: Findings,
    found: Doubted,
    seconds: float,
    ambient_c: float | None,
) -> Calibration:
    """Propose what was found."""
    shaft, brake, circuit = findings["shaft"], findings.get("brake"), findings.get("circuit")
    quantities = found.quantities
    values, sigmas = _proposed(actuator, quantities)
    sigmas |= _sigmas_of_knee(quantities)
    board = knob.board_config()
    if board.brake_inductance_h > 0.0:
        # The bridge drives the coil as slowly as this says: it would be slower each time.
        values.pop("brake_time_constant_s", None)
        sigmas["sigma_brake_time_constant_s"] = 0.0
    proposed = replace(actuator, **values)  # type: ignore[arg-type]
    now = datetime.datetime.now(datetime.timezone.utc)
    # A look for drift may miss a knee and knows too little of the brake: the known values stay.
    keeps_shaft = brake is None and shaft.knee is None
    configured = knob.shaft_config()
    bent = configured if keeps_shaft else _bent(shaft, configured, sigmas)
    straight = {} if keeps_shaft else {"sigma_knee_1_rad": 0.0, "sigma_knee_1_nm_per_rad": 0.0}
    sigmas = straight | sigmas | ({} if circuit is None else circuit.sigmas())
    before, control = knob.calibration_config(), knob.control_config()
    values_are, law, assist_nm = before.values_are, control.law, control.free_assist_nm
    if brake is not None:
        values_are, law = "measured", "calibrated"
        assist_nm = certain_assist_nm(quantities, assist_nm)
    known = replace(
        before,
        values_are=values_are,
        calibrated_unix_s=int(now.timestamp()),
        ambient_k=0.0 if ambient_c is None else ambient_c + 273.15,
        calibrated_rate_hz=knob.info.control_rate_hz,
        **sigmas,
    )
    fits = (*findings["free"].fits, *shaft.fits, *(brake.fits if brake is not None else ()))
    return Calibration(
        quantities,
        proposed,
        bent,
        law,
        assist_nm,
        known,
        found.cogging,
        tuple((float(twist), float(torque)) for twist, torque in np.asarray(shaft.curve)),
        found.brake_curve,
        seconds,
        _conditions(knob, board, ambient_c, now),
        fits if circuit is None else (*circuit.motor.fits, *fits),
        None if circuit is None else circuit.board,
    )
