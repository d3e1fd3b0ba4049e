"""A calibration of the motor's circuit, on emulated knobs whose electrics are hidden from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from typer.testing import CliRunner

import torsio
from torsio import calibration
from torsio.apps.cli import app
from torsio.apps.commands.calibrate import words_of
from torsio.calibration.circuit import ELECTRIC_STEPS, MEASURED_OF_BOARD, push_current
from torsio.calibration.play import Player
from torsio.printed.told import MotorCurrent

OHM, HENRY, SUPPLY_V, SENSOR_V_PER_A = 2.3, 1.7e-3, 12.8, 0.19
COGGING_NM = 2e-3
ELECTRICS = torsio.Electrics(
    winding_resistance_ohm=OHM,
    winding_inductance_h=HENRY,
    supply_v=SUPPLY_V,
    sensor_v_per_a=SENSOR_V_PER_A,
)
CIRCUIT = ("motor_resistance_ohm", "motor_inductance_h", "motor_torque_constant_nm_per_a")


def opened(
    electrics: torsio.Electrics | None,
    name: str = "emulated",
    cogging: torsio.Cogging | None = None,
) -> torsio.Knob:
    plant = torsio.PlantParams(electrics=electrics, cogging=cogging)
    knob = torsio.open(name, emulator=torsio.EmulatorOptions(plant=plant, control_rate_hz=20_000.0))
    knob.sleep(0.2)  # the board learns its sensor's zero
    return knob


@pytest.fixture(autouse=True)
def data_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


@pytest.fixture(scope="module")
def measured() -> tuple[calibration.Calibration, list[str]]:
    steps: list[str] = []
    cogging = torsio.Cogging.sine(periods_per_rev=14, amplitude_nm=COGGING_NM, points=64)
    with opened(ELECTRICS, cogging=cogging) as knob:
        return calibration.calibrate(knob, supply_v=SUPPLY_V, progress=steps.append), steps


def assert_torques(found: calibration.Calibration, measure: float) -> None:
    plant = torsio.PlantParams()
    for name, truth in (
        ("inertia_kg_m2", plant.knob_inertia_kg_m2 + plant.brake_inertia_kg_m2),
        ("stiffness_nm_per_rad", plant.shaft_stiffness_nm_per_rad),
    ):
        assert found.quantities[name].value == pytest.approx(measure * truth, rel=0.01), name


def test_circuit_is_found_as_the_board_sees_it(measured: Any) -> None:
    found, _ = measured
    sensor = SENSOR_V_PER_A / 0.2
    expected = (OHM / sensor, HENRY / sensor, 0.05)
    for name, truth in zip(CIRCUIT, expected, strict=True):
        low, high = found.quantities[name].interval
        assert low <= truth <= high, name
        assert high - low < 0.06 * truth
        assert getattr(found.board, name) == found.quantities[name].value
    assert found.board.supply_v == SUPPLY_V
    zero, noise = found.quantities["current_zero_v"], found.quantities["current_noise_a"]
    assert zero.interval[0] <= 1.65 <= zero.interval[1]
    assert noise.interval[0] <= 5e-3 <= noise.interval[1]
    low, high = found.quantities["current_gain"].interval
    assert low < sensor < high
    # The current is less than the board takes it for.
    assert_torques(found, sensor)


def test_map_of_the_cogging_is_as_uncertain_as_its_amplitude(measured: Any) -> None:
    found, _ = measured
    amplitude = found.quantities["cogging_nm"]
    assert amplitude.interval[0] <= COGGING_NM * SENSOR_V_PER_A / 0.2 <= amplitude.interval[1]
    assert found.cogging.amplitudes_nm[0] == pytest.approx(amplitude.value)
    assert found.cogging.sigmas_nm[0] == pytest.approx(amplitude.standard_uncertainty)


def test_supply_that_nothing_would_use_is_an_error() -> None:
    cases = [
        (opened(torsio.Electrics()), True, "a look for drift leaves them out"),
        (torsio.open("emulated"), False, "this device measures no current"),
    ]
    for one, quick, why in cases:
        with one as knob, pytest.raises(torsio.InvalidArgument, match=why):
            calibration.calibrate(knob, drift=quick, supply_v=12.3)


@pytest.mark.parametrize("supply_v", [10.8, pytest.param(13.2, marks=pytest.mark.slow)])
def test_supply_that_nobody_measured_spoils_no_torque_constant(supply_v: float) -> None:
    with opened(torsio.Electrics(supply_v=supply_v)) as knob:
        before = knob.board_config()
        found = calibration.calibrate(knob)
        assert found.board is not None
        assert found.board.supply_v == before.supply_v == 12.0
        told, name = found.quantities[CIRCUIT[2]], CIRCUIT[2]
        assert told.value == pytest.approx(0.05 * 12.0 / supply_v, rel=5e-3)
        # Of the supplies within a tenth 95 % lie within 0.95 of it.
        assert told.standard_uncertainty == pytest.approx(0.095 / 1.96 * told.value, rel=1e-2)
        assert getattr(found.board, name) == getattr(before, name) == pytest.approx(0.05)
        assert_torques(found, 1.0)
        known = calibration.calibrate(knob, supply_v=supply_v)
        assert known.board is not None
        assert known.board.supply_v == supply_v
        told = known.quantities[name]
        assert told.interval[0] <= 0.05 <= told.interval[1]
        assert told.standard_uncertainty == pytest.approx(0.01 * 0.05, rel=0.05)
        assert getattr(known.board, name) == told.value
        assert_torques(known, 1.0)


def test_supply_that_the_board_watches_is_not_guessed() -> None:
    with opened(ELECTRICS, "emulated:watched") as knob:
        knob.update(supply_sense_pin=28, supply_sense_ratio=11)
        found = calibration.calibrate(knob)
    told = found.quantities[CIRCUIT[2]]
    assert told.standard_uncertainty < 3e-3 * told.value
    assert found.board is not None
    assert found.board.motor_torque_constant_nm_per_a == told.value


def test_torque_constant_that_no_supply_explains_is_proposed_and_torques_are_its() -> None:
    with opened(replace(ELECTRICS, torque_constant_nm_per_a=0.04)) as knob:
        found = calibration.calibrate(knob)
    told = found.quantities[CIRCUIT[2]]
    assert told.value == pytest.approx(0.04 * 12.0 / SUPPLY_V, rel=5e-3)
    assert found.board is not None
    assert found.board.motor_torque_constant_nm_per_a == told.value
    # For 1 N m the current is 0.04 / 0.05 / (SENSOR / 0.2); the device takes it for the sensor's
    # reading.
    assert_torques(found, SENSOR_V_PER_A / 0.2 * 12.0 / SUPPLY_V)


def test_steps_are_told_in_their_order(measured: Any) -> None:
    sensor, constant, winding = ELECTRIC_STEPS
    signs, free, *others = calibration.STEPS
    assert measured[1] == [sensor, signs, constant, free, winding, *others]


def test_board_keeps_what_was_found_and_info_shows_it(measured: Any) -> None:
    found, _ = measured
    with opened(ELECTRICS, "emulated:circuit") as knob:
        calibration.apply(knob, found)
        knob.save()
    with opened(ELECTRICS, "emulated:circuit") as knob:
        for name in CIRCUIT:
            quantity = found.quantities[name]
            assert getattr(knob.board_config(), name) == pytest.approx(quantity.value, rel=1e-6)
            short = name.removesuffix("_ohm").removesuffix("_h").removesuffix("_nm_per_a")
            kept = getattr(knob.calibration_config(), f"sigma_{short}_permille")
            assert kept == pytest.approx(
                1e3 * quantity.standard_uncertainty / quantity.value, abs=1.0
            )
            value, sigma = words_of(knob)[name].split(" +- ")
            assert float(value) == pytest.approx(quantity.value, rel=1e-3)
            assert sigma.endswith(" %")
        # With it, the board reckons as the world is, seen by its sensor.
        told = knob.motor_current().torque_constant_nm_per_a
        assert told == pytest.approx(found.quantities[CIRCUIT[2]].value, rel=1e-6)


def test_what_was_configured_meanwhile_stays_and_a_look_before_the_next_start_sees_no_drift(
    measured: Any,
) -> None:
    found, _ = measured
    with opened(ELECTRICS) as knob:
        board = replace(knob.board_config(), motor_current_max_a=1.75, brake_current_max_a=0.25)
        knob.configure(board)
        calibration.apply(knob, found)
        circuit = {name: getattr(board, name) for name in MEASURED_OF_BOARD}
        assert replace(knob.board_config(), **circuit) == board
        assert knob.calibration_config().values_are == "measured"
        knob.sleep(0.5)
        looked = calibration.calibrate(knob, drift=True)
        assert calibration.drifts(found.as_dict(), looked) == []


def sensor(state: Literal["dead", "stuck", "saturated"]) -> Callable[[torsio.Knob], None]:
    return lambda knob: knob.emulator.set_current_sensor(state)


@pytest.mark.parametrize(
    ("electrics", "sabotage", "step", "reason"),
    [
        (ELECTRICS, sensor("dead"), "current sensor", "dead_sensor"),
        (ELECTRICS, sensor("saturated"), "current sensor", "saturated_sensor"),
        (ELECTRICS, sensor("stuck"), "current sensor", "no_current"),
        (
            replace(ELECTRICS, winding_resistance_ohm=900.0),
            None,
            "current sensor",
            "no_current",
        ),
        (replace(ELECTRICS, winding_resistance_ohm=4.4), None, "winding", "winding_values"),
        (
            replace(ELECTRICS, coil_torque_constant_nm_per_a=0.01),
            None,
            "winding",
            "does_not_hold",
        ),
    ],
)
def test_what_is_broken_is_refused_with_its_reason(
    electrics: torsio.Electrics,
    sabotage: Callable[[torsio.Knob], None] | None,
    step: str,
    reason: str,
) -> None:
    with opened(electrics) as knob:
        if sabotage is not None:
            sabotage(knob)
            knob.sleep(0.2)
        with pytest.raises(calibration.Refusal) as refusal:
            calibration.calibrate(knob)
        assert refusal.value.reason == reason
        assert refusal.value.step == step
        assert knob.state != "armed"


@pytest.mark.parametrize("step", [ELECTRIC_STEPS[1], *calibration.STEPS])
def test_fault_on_the_way_is_named(step: str) -> None:
    with opened(ELECTRICS) as knob:

        def press(name: str) -> None:
            if name == step:
                knob.emulator.set_emergency_stop(pressed=True)

        with pytest.raises(calibration.Refusal, match="the fault emergency_stop") as refusal:
            calibration.calibrate(knob, progress=press)
        assert (refusal.value.step, refusal.value.reason) == (step, "fault")


def test_stretch_is_as_long_as_it_is_however_long_each_look_takes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ask = torsio.Knob.motor_current

    def slow(knob: torsio.Knob) -> MotorCurrent:
        knob.sleep(2e-3)
        return ask(knob)

    with opened(ELECTRICS) as knob:
        actuator, board = knob.actuator_config(), knob.board_config()
        monkeypatch.setattr(torsio.Knob, "motor_current", slow)
        with Player.playing(knob) as player:
            begin_s = ask(knob).time_s
            held = push_current(
                player,
                board,
                motor_nm=actuator.motor_torque_max_nm,
                brake_nm=actuator.brake_torque_max_nm,
            )
            passed_s = ask(knob).time_s - begin_s
            assert player.seconds == pytest.approx(passed_s, abs=1e-3)
    # Six levels and two waves, without the parts that are left out of each.
    assert float(np.sum(held.duration_s)) == pytest.approx(6 * 0.086 + 2 * 0.486, abs=8 * 10e-3)


def test_command_says_what_the_supply_is_taken_for_before_anything_turns(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[float | None] = []

    def refuse(*_: Any, supply_v: float | None, **__: Any) -> None:
        asked.append(supply_v)
        raise calibration.Refusal("signs", "still", "nothing moves")

    monkeypatch.setattr(calibration, "calibrate", refuse)
    original = torsio.open
    monkeypatch.setattr(
        torsio,
        "open",
        lambda *_, **__: original(
            "emulated",
            emulator=torsio.EmulatorOptions(plant=torsio.PlantParams(electrics=ELECTRICS)),
        ),
    )
    for supply, says in (([], True), (["--supply", "13.2"], False)):
        done = CliRunner().invoke(app, ["calibrate", "--device", "emulated", *supply])
        assert done.exit_code == 1
        assert ("supply   taken for 12 V" in done.output) is says
    assert asked == [None, 13.2]


def test_knob_that_measures_no_current_is_calibrated_without_and_says_so() -> None:
    done = CliRunner().invoke(app, ["calibrate", "--device", "emulated"])
    assert done.exit_code == 0, done.output
    assert "does not measure the motor's current" in " ".join(done.output.split())
    assert "motor_resistance_ohm" not in done.output
    assert "proposed for the configuration:" in done.output
