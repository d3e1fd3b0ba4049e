"""One file to a knob: from `knob.toml` to configuration, emulated plant and expected figures."""

from __future__ import annotations

import math
import random
import sys
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import torsio
from torsio import perception
from torsio.common.whole_file import text_of
from torsio.demos.wall import PEAK_TORQUE_NM
from torsio_hardware import design
from torsio_hardware.flexure import Flexure

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

DEFAULT = Path(__file__).parent / "knob.toml"
RATES_HZ = {"pico2": 20_000.0, "pico": 10_000.0}
_TRACKED = ("tracking_in", "tracking_out", "torque_gap_nm")
_TABLES = ("supply", "motor", "brake", "knob")
_SHAPE = ("arms", "hub_radius_m", "rim_radius_m", "thickness_m", "wrap_rad", "swing_rad", "waves")
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

    def band(self, widths: float = 2.0) -> tuple[float, float]:
        """Return so many uncertainties to either side."""
        return self.value - widths * self.uncertainty, self.value + widths * self.uncertainty


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
        whole = ("counts_per_rev", "supply_sense_ratio")
        given: dict[str, float | int] = {
            name: round(value.value) if name in whole else value.value
            for name, value in self.values.items()
        }
        given |= {**self.pins, **self.spring.shaft_config()}
        return {
            f"{kind}_config": {
                field.name: given[field.name] for field in fields(of) if field.name in given
            }
            for kind, of in _KINDS.items()
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

    def expected(self) -> list[tuple[str, str, tuple[float, float], str]]:
        """Give what each step of first power should show: step, what, band, unit."""
        values, counts = self.values, self.number("counts_per_rev")
        knob, brake = values["knob_coulomb_nm"], values["brake_drag_nm"]
        both = math.hypot(knob.uncertainty, brake.uncertainty)
        drag = Value(knob.value + brake.value, both)
        silent = torsio.ControlConfig()

        def scaled(to: float, by: str) -> tuple[float, float]:
            """Scale a figure by a value of the file, which the board takes for true."""
            of = values[by]
            return to * of.band()[0] / of.value, to * of.band()[1] / of.value

        def amperes(push_nm: float) -> tuple[float, float]:
            kt = self.number("motor_torque_constant_nm_per_a")
            return scaled(push_nm / kt, "current_sense_v_per_a")

        coil_v = 10e-3 * self.number("brake_resistance_ohm")
        coil_v /= self.number("brake_torque_constant_nm_per_a")
        return [
            ("link", "the light goes on", (0.9, 1.1), "1/s"),
            ("link", "enable and bridge inputs to ground, no power", (4.0, 5.0), "kohm"),
            ("encoder", "counts of one turn", (0.998 * counts, 1.002 * counts), "counts"),
            ("supply", "at the bridges", values["supply_v"].band(), "V"),
            ("supply", "enable and bridge inputs, disarmed", (0.0, 0.3), "V"),
            ("stop", "the light goes on", (7.0, 9.0), "1/s"),
            ("motor", "in its line, knob held", amperes(1.3 * drag.value), "A"),
            ("PWM", "at the motor's inputs", (39.6, 40.4), "kHz"),
            ("brake", "at the coil, for 10 mN m", scaled(coil_v, "supply_v"), "V"),
            ("silence", "until all is off", (0.0, silent.watchdog_s + silent.passive_ramp_s), "s"),
            ("confirm", "in the motor's line, knob held", amperes(30e-3), "A"),
            ("calibrate", "coulomb_nm", drag.band(), "N m"),
            *(
                ("calibrate", name.removeprefix("spring_"), values[name].band(), unit)
                for name, unit in (
                    ("spring_stiffness_nm_per_rad", "N m/rad"),
                    ("motor_resistance_ohm", "ohm"),
                    ("brake_drag_nm", "N m"),
                    ("knob_inertia_kg_m2", "kg m2"),
                )
            ),
        ]


def _value(table: str, name: str, given: Any) -> Value:
    where = f"[{table}] {name}"
    if isinstance(given, dict):
        if set(given) != {"value", "uncertainty"}:
            raise ValueError(f"{where} needs value and uncertainty, and nothing else")
        value, uncertainty = given["value"], given["uncertainty"]
    else:
        value, uncertainty = given, 0.0
    for number in (value, uncertainty):
        if isinstance(number, bool) or not isinstance(number, (int, float)) or number < 0:
            raise ValueError(f"{where}: {number!r} is no number of 0 or more")
    return Value(float(value), float(uncertainty))


def load(path: Path = DEFAULT) -> Knob:
    """Read a knob's file.

    Raises `ValueError` that says what in it is wrong or missing, `OSError` if it cannot be read.
    """
    text = text_of(path)
    try:
        given = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is no TOML: {error}") from None
    try:
        known = {"name", "board", "parts", "spring", "pins", *_TABLES}
        if given.keys() - known:
            raise ValueError(f"unknown table {min(given.keys() - known)!r}")
        values = {
            name: _value(table, name, value)
            for table in _TABLES
            for name, value in given[table].items()
        }
        shape = {key: value for key, value in given["spring"].items() if key in _SHAPE}
        of = design.material(given["spring"]["material"])
        stiffness = float(given["spring"]["stiffness_nm_per_rad"])
        flexure = design.for_stiffness(replace(Flexure(), **shape), of, stiffness)
        spring = design.examine(flexure, of)
        values["spring_stiffness_nm_per_rad"] = Value(
            stiffness, stiffness * spring.relative_uncertainty
        )
        knob = Knob(
            str(given["name"]), str(given["board"]), dict(given["parts"]), spring,
            dict(given["pins"]), values,
        )  # fmt: skip
        knob.plant()  # which needs them all
        with torsio.open("emulated") as device:  # which refuses a pin with two jobs
            for config in knob.configs().values():
                device.configure(config)
    except KeyError as error:
        raise ValueError(f"{path}: {error.args[0]} is missing") from None
    except (TypeError, ValueError, AttributeError, ArithmeticError, torsio.Error) as error:
        raise ValueError(f"{path}: {error}") from None
    return knob
