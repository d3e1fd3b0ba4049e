"""How stiff a spring may be: what the device, theory and an emulated knob say, and who warns."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from typer.testing import CliRunner

import torsio
from torsio import stability
from torsio.apps.cli import app


def solved(actuator: torsio.ActuatorConfig, control: torsio.ControlConfig, rate_hz: float) -> float:
    """Equation (8) of docs/explanation/theory.md by a root finder, in 64 bits."""
    late_s = 0.5 / rate_hz + actuator.motor_time_constant_s
    most_nm = min(actuator.motor_torque_max_nm, control.motor_torque_cap_nm)
    beta = 0.0 if control.law == "motor_only" else control.beta

    def excess(stiffness: float) -> float:
        carried = min(actuator.spring_stiffness_nm_per_rad, beta * stiffness)
        swing = math.sqrt(stiffness * actuator.knob_inertia_kg_m2) / most_nm
        friction = 0.8 * 4.0 * actuator.knob_coulomb_nm / math.pi * swing
        return (stiffness - carried) * late_s - actuator.knob_viscous_nm_s_per_rad - friction

    by_counts = most_nm * actuator.counts_per_rev / (2.0 * math.pi)
    return min(brentq(excess, 1e-3, 1e7), by_counts)


def with_steps(
    stiffness_nm_per_rad: float, actuator: torsio.ActuatorConfig, control: torsio.ControlConfig
) -> float:
    """The bound with the encoder's steps: (8') of docs/explanation/theory.md."""
    most_nm = min(actuator.motor_torque_max_nm, control.motor_torque_cap_nm)
    rad_per_count = 2.0 * math.pi / actuator.counts_per_rev
    return 1.0 / (1.0 / stiffness_nm_per_rad + rad_per_count / most_nm)


@pytest.mark.parametrize(
    ("actuator", "control", "limited_by"),
    [
        (torsio.ActuatorConfig(), torsio.ControlConfig(), "rate"),
        (torsio.ActuatorConfig(motor_time_constant_s=1.6e-4), torsio.ControlConfig(), "lag"),
        (torsio.ActuatorConfig(), torsio.ControlConfig(law="motor_only"), "rate"),
        (torsio.ActuatorConfig(), torsio.ControlConfig(beta=0.05), "rate"),
        (
            torsio.ActuatorConfig(counts_per_rev=256, motor_time_constant_s=1e-5),
            torsio.ControlConfig(motor_torque_cap_nm=0.01),
            "counts",
        ),
        (
            torsio.ActuatorConfig(
                knob_coulomb_nm=2e-3, knob_inertia_kg_m2=2e-4, motor_time_constant_s=1.6e-4
            ),
            torsio.ControlConfig(law="calibrated", motor_torque_cap_nm=0.04),
            "lag",
        ),
    ],
)
def test_knob_tells_how_stiff_its_parts_can_be(
    actuator: torsio.ActuatorConfig, control: torsio.ControlConfig, limited_by: str
) -> None:
    options = torsio.EmulatorOptions(control_rate_hz=10_000.0)
    with torsio.open("emulated", emulator=options) as knob:
        knob.configure(actuator)
        knob.configure(control)
        found = knob.stable_stiffness()
    assert found.limited_by == limited_by
    expected = with_steps(solved(actuator, control, 1e4), actuator, control)
    assert found.stiffness_nm_per_rad == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("law", ["motor_only", "paper"])
@pytest.mark.parametrize("rate_hz", [4e3, 2e4])
def test_boundary_is_where_a_swing_neither_grows_nor_dies(law: str, rate_hz: float) -> None:
    actuator = torsio.ActuatorConfig()
    control = torsio.ControlConfig(law=law)  # type: ignore[arg-type]
    damping, stiffness = stability.boundary(actuator, control, rate_hz)
    assert len(damping) > 50
    assert np.all(damping >= 0.0)
    # Without a damper it is the device's starting value, computed another way.
    device = solved(actuator, control, rate_hz)
    assert stiffness[np.argmin(damping)] == pytest.approx(device, rel=0.15)
    if law == "paper":
        return
    # One root of the characteristic equation lies on the imaginary axis.
    late_s = 0.5 / rate_hz + actuator.motor_time_constant_s
    pole = math.exp(-2.0 * math.pi * control.speed_bandwidth_hz / rate_hz)
    for d, k in zip(damping[::25], stiffness[::25], strict=True):

        def left(w: float, d: float = d, k: float = k) -> complex:
            friction = 0.8 * 4.0 * actuator.knob_coulomb_nm / math.pi
            b = actuator.knob_viscous_nm_s_per_rad
            b += friction * actuator.knob_inertia_kg_m2 * w / actuator.motor_torque_max_nm
            z = np.exp(1j * w / rate_hz)
            speed = rate_hz * (1.0 - pole) ** 2 * z * (z - 1.0) / (z - pole) ** 2
            acts = (k + d * speed) * np.exp(-1j * w * late_s)
            return complex(-actuator.knob_inertia_kg_m2 * w * w + 1j * b * w + acts)

        # Where its imaginary part changes its sign the real part is nothing too.
        grid = np.linspace(1.0, 0.91 * math.pi * rate_hz, 8000)
        values = np.array([left(float(w)) for w in grid])
        at = np.flatnonzero(np.diff(np.sign(values.imag)) != 0)
        roots = [brentq(lambda w: left(w).imag, grid[i], grid[i + 1]) for i in at]
        assert min(abs(left(w).real) / k for w in roots) < 1e-6


def test_emulated_knob_rests_and_swings_where_it_was_predicted() -> None:
    actuator, control = torsio.PlantParams().matching_config(), torsio.ControlConfig()
    predicted = solved(actuator, control, 1e4)
    damping, _ = stability.boundary(actuator, control, 1e4)
    found = stability.measure(
        torsio.PlantParams(), actuator, control, 1e4,
        stiffness_nm_per_rad=[0.5 * predicted, 3.0 * predicted],
        damping_nm_s_per_rad=[0.0, 3.0 * float(damping.max())], speeds_rad_s=(6.0, 18.0),
    )  # fmt: skip
    assert found.is_stable.tolist() == [[True, False], [False, False]]
    assert found.stable_to_nm_per_rad.tolist() == [0.5 * predicted, 0.0]


def test_knob_that_hardly_moves_and_buzzes_between_two_counts_is_not_at_rest() -> None:
    plant = torsio.PlantParams(counts_per_rev=2048)
    found = stability.measure(
        plant, plant.matching_config(), torsio.ControlConfig(law="compensated"), 1e4,
        stiffness_nm_per_rad=[30.0, 60.0],
    )  # fmt: skip
    assert (found.swing_rad < found.at_rest_rad).all()
    assert found.vibration_nm[1, 0] > 20e-3
    assert found.is_stable[:, 0].tolist() == [True, False]


@pytest.mark.parametrize("rate_hz", [1e3, 1e4])
def test_boundary_with_dampers_is_near_what_comes_to_rest(rate_hz: float) -> None:
    actuator, control = torsio.PlantParams().matching_config(), torsio.ControlConfig()
    damping, stiffness = stability.boundary(actuator, control, rate_hz)
    tried = np.array([0.3, 0.5, 0.7]) * damping.max()
    found = stability.measure(
        torsio.PlantParams(), actuator, control, rate_hz,
        stiffness_nm_per_rad=np.geomspace(0.1, 1.2, 25) * stiffness.max(),
        damping_nm_s_per_rad=tried,
    )  # fmt: skip
    for damper, rests_to in zip(tried, found.stable_to_nm_per_rad, strict=True):
        crossed = np.diff(np.sign(damping - damper)) != 0
        assert rests_to == pytest.approx(stiffness[:-1][crossed].max(), rel=0.25)


def test_plant_of_a_configuration_matches_it() -> None:
    actuator = replace(torsio.ActuatorConfig(), knob_coulomb_nm=4e-3, counts_per_rev=4096)
    back = stability.plant_of(actuator).matching_config()
    for name in ("knob_coulomb_nm", "counts_per_rev", "spring_stiffness_nm_per_rad"):
        assert getattr(back, name) == pytest.approx(getattr(actuator, name))


def test_command_maps_and_draws(tmp_path: Path) -> None:
    picture = tmp_path / "map.png"
    arguments = ["stability", "--device", "emulated", "--quick", "--picture", str(picture)]
    result = CliRunner().invoke(app, [*arguments, "--json", "--law", "motor_only"])
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert found["law"] == "motor_only"
    stable = np.array(found["is_stable"])
    assert stable.shape == (len(found["stiffness_nm_per_rad"]), len(found["damping_nm_s_per_rad"]))
    assert stable.any()
    assert not stable.all()
    assert picture.stat().st_size > 20_000


def test_command_says_which_laws_there_are() -> None:
    result = CliRunner().invoke(
        app, ["stability", "--device", "emulated", "--law", "best", "--quick"]
    )
    assert result.exit_code != 0
    assert "calibrated" in result.output
