"""One file to a knob: from `knob.toml` to configuration, emulated plant and expected figures."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import torsio
from torsio import perception
from torsio.demos.wall import PEAK_TORQUE_NM
from torsio_hardware import design
from torsio_hardware.flexure import Flexure

DEFAULT = Path(__file__).parent / "knob.toml"
RATES_HZ = {"pico2": 20_000.0, "pico": 10_000.0}
CLAMP_REFERENCE_V = 2.495  # of a TL431
WEIGHT_NM, WALL_NM_PER_RAD = 55e-3, 0.2  # 150 g on a thread round the knob; the first wall
_TRACKED = ("tracking_in", "tracking_out", "torque_gap_nm")
_TABLES = ("supply", "motor", "brake", "knob")
_PLANT = (
    *("knob_inertia_kg_m2", "knob_viscous_nm_s_per_rad", "knob_coulomb_nm"),
    *("brake_inertia_kg_m2", "brake_drag_nm"),
)
_ELECTRICS = {
    "winding_resistance_ohm": "motor_resistance_ohm",
    "winding_inductance_h": "motor_inductance_h",
    "torque_constant_nm_per_a": "motor_torque_constant_nm_per_a",
    "coil_resistance_ohm": "brake_resistance_ohm",
    "coil_inductance_h": "brake_inductance_h",
    "coil_torque_constant_nm_per_a": "brake_torque_constant_nm_per_a",
    "supply_v": "supply_v",
    "supply_divider_ratio": "supply_sense_ratio",
    "sensor_v_per_a": "current_sense_v_per_a",
}
_KINDS: dict[str, Any] = {
    "actuator": torsio.ActuatorConfig,
    "board": torsio.BoardConfig,
    "shaft": torsio.ShaftConfig,
}


@dataclass(frozen=True)
class Value:
    """A number and one standard uncertainty of it; 0: it is exact."""

    value: float
    uncertainty: float = 0.0

    def band(self) -> tuple[float, float]:
        """Return two uncertainties to either side."""
        return self.value - 2 * self.uncertainty, self.value + 2 * self.uncertainty


@dataclass(frozen=True)
class Knob:
    """A knob as its file says."""

    name: str
    board: str
    parts: dict[str, str]
    spring: design.Spring
    pins: dict[str, int]  # by the names of `torsio config`
    values: dict[str, Value]  # likewise, the spring's stiffness among them

    def number(self, name: str) -> float:
        """Return a value without its uncertainty."""
        return self.values[name].value

    def settings(self) -> dict[str, dict[str, float | int]]:
        """Return what `torsio config load` takes: by configuration, the fields of the file."""
        given: dict[str, float | int] = {name: of.value for name, of in self.values.items()}
        for name in ("counts_per_rev", "supply_sense_ratio"):
            given[name] = round(given[name])
        given |= {**self.pins, **self.spring.shaft_config()}
        names = {kind: [field.name for field in fields(of)] for kind, of in _KINDS.items()}
        return {
            f"{kind}_config": {name: given[name] for name in known if name in given}
            for kind, known in names.items()
        }

    def configs(self) -> dict[str, Any]:
        """Return the same as configurations: `actuator`, `board` and `shaft`."""
        given = self.settings()
        return {kind: of(**given[f"{kind}_config"]) for kind, of in _KINDS.items()}

    def plant(self, seed: int | None = None) -> torsio.PlantParams:
        """Give an emulated knob: as the file says, or with a seed one that may come of it.

        Each value is then drawn within two uncertainties of the file's value.
        """
        draw = random.Random(seed)

        def take(name: str) -> float:
            value = self.values[name]
            if seed is None or value.uncertainty == 0:
                return value.value
            off = max(-2.0, min(2.0, draw.gauss(0.0, 1.0)))
            return max(value.value + off * value.uncertainty, 0.05 * value.value)

        electrics: dict[str, Any] = {name: take(of) for name, of in _ELECTRICS.items()}
        plant: dict[str, Any] = {name: take(name) for name in _PLANT}
        return torsio.PlantParams(
            **plant,
            shaft_stiffness_nm_per_rad=take("spring_stiffness_nm_per_rad"),
            brake_time_constant_s=take("brake_time_constant_s"),
            counts_per_rev=round(self.number("counts_per_rev")),
            electrics=torsio.Electrics(**electrics, predictive=self.board == "pico2"),
        )

    def figures(self) -> dict[str, float]:
        """Give what to expect of it, of the law `compensated` at the board's rate.

        Closed forms, and the measures of the study `design` if its package is installed: the
        softest spring that keeps swinging, and in a wall of 30 mN m/deg the missing torque on the
        way out and the errors both ways.
        """
        plant, control = self.plant(), torsio.ControlConfig(law="compensated")
        motor, drag = plant.motor_limit_nm, plant.knob_coulomb_nm + plant.brake_drag_nm
        step = 2 * math.pi * plant.shaft_stiffness_nm_per_rad / plant.counts_per_rev
        found = {
            "critical_torque_nm": min(motor / (1 - control.beta), motor + plant.brake_limit_nm),
            "free_drag_nm": drag,
            "free_drag_jnds": perception.torque_jnds(drag),
            "least_torque_sensed_nm": step,
            "least_torque_sensed_jnds": perception.torque_jnds(step),
        }
        try:
            from torsio_studies.design import devices
        except ModuleNotFoundError:
            return found
        names = {field.name for field in fields(devices.Design)} - {"beta", "control_rate_hz"}
        design = devices.Design(
            beta=control.beta,
            control_rate_hz=RATES_HZ[self.board],
            **{name: getattr(plant, name) for name in names},
        )
        measured = devices.evaluate(design, "compensated")
        tracked = {name: getattr(measured, name) for name in _TRACKED}
        felt = perception.wall_jnds(peak_nm=PEAK_TORQUE_NM, **tracked)
        return {
            **found,
            "stable_stiffness_nm_per_rad": measured.stable_stiffness_nm_per_rad,
            **tracked,
            **{f"{name}_jnds": jnds for name, jnds in felt.items()},
        }

    def expected(self) -> list[tuple[str, str, tuple[float, float]]]:
        """Give what each step of first power should show: step, what, band."""
        values, of = self.values, self.number
        knob, brake = values["knob_coulomb_nm"], values["brake_drag_nm"]
        drag = Value(knob.value + brake.value, math.hypot(knob.uncertainty, brake.uncertainty))
        silent, counts = torsio.ControlConfig(), of("counts_per_rev")
        coil_nm = silent.beta * 10e-3  # the motor has the rest
        coil_v = coil_nm * of("brake_resistance_ohm") / of("brake_torque_constant_nm_per_a")
        clamp_v = CLAMP_REFERENCE_V * of("supply_v") / of("clamp_v")
        # Friction holds the knob to either side of where the weight balances the wall.
        rests, sticks = WEIGHT_NM / WALL_NM_PER_RAD, drag.band()[1] / WALL_NM_PER_RAD

        def scaled(to: float, by: str) -> tuple[float, float]:
            """Scale a figure by a value of the file, which the board takes for true."""
            low, high = values[by].band()
            return to * low / of(by), to * high / of(by)

        def amperes(push_nm: float) -> tuple[float, float]:
            return scaled(push_nm / of("motor_torque_constant_nm_per_a"), "current_sense_v_per_a")

        return [
            ("Link", "the light goes on, 1/s", (0.9, 1.1)),
            ("Link", "enable and bridge inputs to ground, no power, kohm", (4.0, 5.0)),
            ("Encoder", "counts of one turn", (0.998 * counts, 1.002 * counts)),
            ("Supply", "at the bridges, V", values["supply_v"].band()),
            ("Supply", "at the clamp's reference, V", scaled(clamp_v, "supply_v")),
            ("Supply", "enable and bridge inputs, disarmed, V", (0.0, 0.3)),
            ("Emergency stop", "the light goes on, 1/s", (7.0, 9.0)),
            ("Emergency stop", "through the second contact, no power, released, ohm", (0.0, 1.0)),
            ("Motor", "in its line, knob held, A", amperes(1.3 * drag.value)),
            ("PWM", "at the motor's inputs, kHz", (39.6, 40.4)),
            ("Brake", "at the coil, turned against 10 mN m, V", scaled(coil_v, "supply_v")),
            ("Silence", "until all is off, s", (0.0, silent.watchdog_s + silent.passive_ramp_s)),
            ("Confirm", "in the motor's line, knob held, A", amperes(30e-3)),
            ("Calibrate", "coulomb_nm", drag.band()),
            ("Calibrate", "stiffness_nm_per_rad", values["spring_stiffness_nm_per_rad"].band()),
            *(
                ("Calibrate", name, values[name].band())
                for name in ("motor_resistance_ohm", "brake_drag_nm", "knob_inertia_kg_m2")
            ),
            ("A soft wall", "into it under 55 mN m, rad", (rests - sticks, rests + sticks)),
        ]


def _value(table: str, name: str, given: Any) -> Value:
    pair = [given["value"], given["uncertainty"]] if isinstance(given, dict) else [given, 0.0]
    for number in pair:
        if isinstance(number, bool) or not isinstance(number, (int, float)) or not number >= 0:
            raise ValueError(f"[{table}] {name}: {number!r} is no number of 0 or more")
    return Value(*map(float, pair))


def load(path: Path = DEFAULT) -> Knob:
    """Read a knob's file.

    Raises `ValueError` that says what in it is wrong or missing, `OSError` if it cannot be read.
    """
    given = design.read_toml(path)
    try:
        known = {"name", "board", "parts", "spring", "pins", *_TABLES}
        if given.keys() - known:
            raise ValueError(f"unknown table {min(given.keys() - known)!r}")
        values = {
            name: _value(table, name, value)
            for table in _TABLES
            for name, value in given[table].items()
        }
        shape = dict(given["spring"])
        of, stiffness = design.material(shape.pop("material")), shape.pop("stiffness_nm_per_rad")
        spring = design.examine(Flexure(**shape), of, stiffness)
        values["spring_stiffness_nm_per_rad"] = Value(
            stiffness, stiffness * spring.relative_uncertainty
        )
        named = {key: dict(given[key]) for key in ("parts", "pins")}
        knob = Knob(str(given["name"]), str(given["board"]), spring=spring, values=values, **named)
        knob.plant()  # which needs them all
        with torsio.open("emulated") as device:  # which refuses a pin with two jobs
            for config in knob.configs().values():
                device.configure(config)
    except KeyError as error:
        raise ValueError(f"{path}: {error.args[0]} is missing") from None
    except (TypeError, ValueError, AttributeError, ArithmeticError, torsio.Error) as error:
        raise ValueError(f"{path}: {error}") from None
    return knob
