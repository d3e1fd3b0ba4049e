"""`torsio calibrate`, and what it leaves behind."""

from __future__ import annotations

import io
import json
import re
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from rich.console import Console
from typer.testing import CliRunner

import torsio
from torsio import calibration
from torsio.apps.cli import app
from torsio.apps.commands.calibrate import save, words_of
from torsio.apps.doctor.examination import missing
from torsio.calibration import brake, numeric, report, steps
from torsio.calibration.proposal import certain_assist_nm


@pytest.fixture(autouse=True)
def data_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return tmp_path / "data"


@pytest.fixture(scope="module")
def found() -> tuple[calibration.Calibration, torsio.ActuatorConfig, torsio.ActuatorConfig]:
    """Calibrate a knob that is not what its device believes."""
    plant = torsio.PlantParams(
        knob_coulomb_nm=9e-3,
        shaft_stiffness_nm_per_rad=2.0,
        brake_inertia_kg_m2=6e-5,
        brake_time_constant_s=40e-3,
        brake_hysteresis=torsio.BrakeHysteresis(half_width_nm=8e-3),
    )
    options = torsio.EmulatorOptions(
        seed=3, control_rate_hz=10_000.0, plant=plant, actuator=torsio.ActuatorConfig()
    )
    with torsio.open("emulated", emulator=options) as knob:
        before, law = knob.actuator_config(), knob.control_config()
        result = calibration.calibrate(knob, ambient_c=21.5)
        assert knob.state == "disarmed"
        assert knob.control_config() == law
        return result, before, knob.actuator_config()


def test_calibration_changes_nothing_and_proposes_what_it_found(found: Any) -> None:
    result, before, after = found
    assert after == before
    assert result.actuator.spring_stiffness_nm_per_rad == pytest.approx(2.0, rel=0.01)
    assert result.actuator.knob_coulomb_nm == pytest.approx(9e-3, rel=0.03)
    assert result.actuator.brake_inertia_kg_m2 == pytest.approx(6e-5, rel=0.03)
    assert result.actuator.brake_hysteresis_nm == pytest.approx(8e-3, rel=0.01)
    assert result.actuator.brake_time_constant_s == pytest.approx(40e-3, rel=0.01)
    assert result.actuator.brake_release_time_constant_s == pytest.approx(40e-3, rel=0.01)
    assert result.actuator.counts_per_rev == before.counts_per_rev
    assert result.law == "calibrated"
    # 0.73 of the certain friction: 9 mN m of the knob's side and the brake's drag of 2.
    assert 0.98 * 0.73 * 11e-3 < result.free_assist_nm < 0.73 * 11e-3
    assert result.seconds < 90.0


def test_friction_that_holds_a_steady_pull_is_not_taken_off() -> None:
    """A knob that is pushed the way it is pulled has the rest alone to stop it."""
    pull_nm, friction_nm = 1.2e-3, 8e-3
    options = torsio.EmulatorOptions(
        control_rate_hz=10_000.0, hand=torsio.TorqueHand(torque_nm=pull_nm)
    )
    with torsio.open("emulated", emulator=options) as knob:
        result = calibration.calibrate(knob)
    assert abs(result.quantities["offset_nm"].value) == pytest.approx(pull_nm, rel=0.05)
    most_nm = 0.73 * (friction_nm - pull_nm)
    assert 0.97 * most_nm < result.free_assist_nm < most_nm


def test_assistance_that_a_pull_leaves_nothing_for_is_none() -> None:
    def quantity(name: str, value: float) -> calibration.Quantity:
        return calibration.Quantity(name, value, 1e-4)

    found = {
        "knob_coulomb_nm": quantity("knob_coulomb_nm", 2e-3),
        "brake_drag_nm": quantity("brake_drag_nm", 1e-3),
        "offset_nm": quantity("offset_nm", -3e-3),
    }
    assert certain_assist_nm(found, 1e-4) == 0.0


@pytest.mark.parametrize("rate_hz", [1_000.0, 2_000.0, 10_000.0])
def test_lags_are_those_of_the_plant_at_every_control_rate(rate_hz: float) -> None:
    for lag_s in (30e-3, 60e-3, 120e-3):
        plant = torsio.PlantParams(brake_time_constant_s=lag_s)
        options = torsio.EmulatorOptions(
            seed=1, control_rate_hz=rate_hz, plant=plant, actuator=torsio.ActuatorConfig()
        )
        with torsio.open("emulated", emulator=options) as knob:
            quantities = calibration.calibrate(knob).quantities
        for name in ("rise_s", "release_s"):
            of = quantities[name]
            assert abs(of.value - lag_s) < 1.96 * of.standard_uncertainty, (name, of)
            assert of.standard_uncertainty < 0.4e-3


def test_what_noise_would_change_is_not_proposed() -> None:
    with torsio.open("emulated") as knob:
        first = calibration.calibrate(knob)
        told = [name for name, _, _ in report.proposals(knob, first)]
        assert told == ["law", "free_assist_nm"]  # the values are the plant's
        calibration.apply(knob, first)
        assert report.proposals(knob, calibration.calibrate(knob)) == []
        # A loop that is not there.
        knob.update(brake_hysteresis_nm=1e-3)
        last = calibration.calibrate(knob)
        changes = [(name, new) for name, _, new in report.proposals(knob, last)]
        assert changes == [("brake_hysteresis_nm", 0.0)]


@pytest.mark.parametrize(
    ("value", "sigma", "text"),
    [
        (0.00800083, 2.7e-7, "0.00800083 +- 2.7e-07"),
        (1.0000123, 1.6e-4, "1.00001 +- 0.00016"),
        (1e-4, 5e-8, "0.000100000 +- 5.0e-08"),
        (2.8743, 2.5e-3, "2.8743 +- 0.0025"),
        (-6.6e-8, 5.1e-7, "-7e-08 +- 5.1e-07"),
        (3e-9, 5.1e-7, "0 +- 5.1e-07"),
        (123.456, 12.0, "123 +- 12"),
        (2.87312345, 0.0, "2.873"),
    ],
)
def test_value_has_digits_down_to_its_uncertainty(value: float, sigma: float, text: str) -> None:
    assert report.number(value, sigma) == text


@pytest.mark.parametrize("brake_viscous", [0.0, 2e-6, 6e-6])
def test_viscous_friction_that_is_proposed_is_that_of_the_knob_s_side(brake_viscous: float) -> None:
    plant = torsio.PlantParams(brake_viscous_nm_s_per_rad=brake_viscous)
    configured = replace(torsio.ActuatorConfig(), knob_viscous_nm_s_per_rad=1e-4)
    options = torsio.EmulatorOptions(
        seed=1, control_rate_hz=10_000.0, plant=plant, actuator=configured
    )
    with torsio.open("emulated", emulator=options) as knob:
        found = calibration.calibrate(knob)
    proposed = found.actuator.knob_viscous_nm_s_per_rad
    sigma = found.known.sigma_knob_viscous_nm_s_per_rad
    true = plant.knob_viscous_nm_s_per_rad
    assert abs(proposed - true) < 1.96 * sigma < 0.2 * true
    assert proposed < 1.1 * true  # more would let a law take a stiff wall for stable


def _profile_nm(cogging: torsio.Cogging, angle_rad: npt.NDArray[np.float64]) -> Any:
    """The plant's own table: straight lines between its corners."""
    along = np.mod(angle_rad * cogging.periods_per_rev / (2.0 * np.pi), 1.0)
    table = list(cogging.torque_nm)
    corners = [*table, table[0]]
    return np.interp(along, np.linspace(0.0, 1.0, len(corners)), corners)


def test_knob_that_still_swings_from_the_last_calibration_is_waited_for() -> None:
    with torsio.open("emulated") as knob:
        calibration.calibrate(knob)
        assert calibration.calibrate(knob, drift=True).quantities


def test_map_of_the_cogging_is_that_of_the_plant_over_the_whole_turn() -> None:
    place = 2.0 * np.pi * np.arange(32) / 32
    table = 1.5e-3 * np.sin(place + 0.3) + 0.6e-3 * np.sin(2.0 * place + 1.0)
    cogging = torsio.Cogging(periods_per_rev=7, torque_nm=tuple(table.tolist()))
    plant = torsio.PlantParams(cogging=cogging, encoder_noise_counts=0.2)
    options = torsio.EmulatorOptions(seed=5, control_rate_hz=10_000.0, plant=plant)
    with torsio.open("emulated", emulator=options) as knob:
        found = calibration.calibrate(knob)
    told = json.loads(json.dumps(found.as_dict()))["cogging"]
    assert [wave["periods_per_rev"] for wave in told["waves"]] == [7, 14]
    angle_rad = np.array(told["angle_rad"])
    assert np.ptp(angle_rad) > 6.2
    assert np.max(np.diff(angle_rad)) < np.pi / 64
    errors = np.array(told["torque_nm"]) - _profile_nm(cogging, angle_rad)
    sigma = np.array(told["standard_uncertainty_nm"])
    assert np.mean(np.abs(errors) < 1.96 * sigma) > 0.9
    assert np.max(sigma) < 0.1 * np.max(table)
    # The JSON says it as waves, too.
    waves = sum(
        wave["amplitude_nm"] * np.sin(wave["periods_per_rev"] * angle_rad + wave["phase_rad"])
        for wave in told["waves"]
    )
    assert waves == pytest.approx(np.array(told["torque_nm"]), abs=1e-9)
    assert any(row[0] == "periods_per_rev" and "7 (1.5 mN m)" in row[1] for row in
               report.lines(found))  # fmt: skip


def test_brake_s_torque_over_its_current_is_that_of_the_plant_up_and_down(found: Any) -> None:
    told = json.loads(json.dumps(found[0].as_dict()))["brake_curve"]
    ways = [point["way"] for point in told["points"]]
    assert ways == ["up"] * 4 + ["down"] * 4
    held_nm = 8e-3  # the plant's play, after the brake has held
    for point in told["points"]:
        command_nm = point["command_nm"]
        assert point["current_a"] == pytest.approx(command_nm / 0.44)
        held_nm = min(max(held_nm, command_nm - 8e-3), command_nm + 8e-3)
        sigma = point["standard_uncertainty_nm"]
        assert abs(point["torque_nm"] - held_nm) < 3.0 * sigma
        assert sigma < 0.3e-3
    assert told["in_words"].startswith("straight, within")
    assert any(line[0] == "brake_curve" and line[1] == told["in_words"]
               for line in report.lines(found[0]))  # fmt: skip


def test_brake_that_is_no_straight_line_is_told_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whose commands are other numbers than the knob was told, as if it saturated."""
    top_nm = 50e-3

    def torque_of(command_nm: Any) -> Any:
        share = command_nm / top_nm
        return top_nm * (share - 0.2 * share**2) / 0.8

    commands_nm = np.linspace(0.0, 2.0 * top_nm, 10_000)

    def relabelled(*args: Any, **values: Any) -> Any:
        log = brake.slip(*args, **values)
        before_nm = np.interp(log.brake_nm, torque_of(commands_nm), commands_nm)
        return replace(log, brake_nm=before_nm)

    monkeypatch.setattr(steps, "slip", relabelled)
    options = torsio.EmulatorOptions(control_rate_hz=10_000.0)
    with torsio.open("emulated", emulator=options) as knob:
        result = calibration.calibrate(knob)
    assert result.brake_curve is not None
    for point in result.brake_curve.points:
        true_nm = float(torque_of(point.command_nm))
        assert point.torque_nm == pytest.approx(true_nm, abs=max(4.0 * point.sigma_nm, 0.2e-3))
    assert not result.brake_curve.is_straight
    words = result.brake_curve.in_words()
    assert re.fullmatch(
        r"bent: at [\d.]+ mN m [\d.]+ % of its most \w+ than a straight line", words
    )


def test_device_keeps_what_is_known_until_a_value_changes(found: Any) -> None:
    result = found[0]
    with torsio.open("emulated:known") as knob:
        assert knob.calibration_config() == torsio.CalibrationConfig()
        calibration.apply(knob, result)
        knob.save()
    with torsio.open("emulated:known") as knob:
        known = knob.calibration_config()
        assert known.values_are == "measured"
        assert 0 <= time.time() - known.calibrated_unix_s < 3600
        assert known.calibrated_rate_hz == 10_000.0
        assert known.ambient_k == pytest.approx(273.15 + 21.5)
        for name, of in (
            ("spring_stiffness_nm_per_rad", "stiffness_nm_per_rad"),
            ("brake_inertia_kg_m2", "brake_inertia_kg_m2"),
            ("brake_release_time_constant_s", "release_s"),
        ):
            sigma = result.quantities[of].standard_uncertainty
            assert sigma > 0.0
            assert getattr(known, f"sigma_{name}") == pytest.approx(sigma)
        text = torsio.dump_config(knob)
        knob.update(spring_stiffness_nm_per_rad=3.0)
        assert knob.calibration_config() == replace(known, values_are="assumed")
        torsio.load_config(knob, text)
        assert knob.calibration_config() == known
        knob.load_defaults()
        assert knob.calibration_config().values_are == "assumed"
        knob.update(values_are="stated")
        assert knob.calibration_config().values_are == "stated"


def test_law_is_taken_with_the_rest_and_what_was_set_meanwhile_stays(found: Any) -> None:
    result = found[0]
    with torsio.open("emulated") as knob:
        before = knob.control_config()
        assert before.law != "calibrated"
        knob.update(speed_limit_rad_s=20.0, motor_torque_cap_nm=0.0625)
        told = {name: (old, new) for name, old, new in report.proposals(knob, result)}
        assert told["law"] == (before.law, "calibrated")
        assert told["free_assist_nm"] == (0.0, result.free_assist_nm)
        calibration.apply(knob, result)
        after = knob.control_config()
    assert after.free_assist_nm == pytest.approx(result.free_assist_nm)
    assert replace(after, free_assist_nm=0.0) == replace(
        before, speed_limit_rad_s=20.0, motor_torque_cap_nm=0.0625, law="calibrated"
    )


def test_info_shows_values_with_uncertainty_date_and_conditions(found: Any) -> None:
    runner = CliRunner()
    with torsio.open("emulated") as knob:
        assert "assumed" in words_of(knob)["values_are"]
        calibration.apply(knob, found[0])
        words = words_of(knob)
        knob.update(law="paper")
        assert words_of(knob)["law"] == "paper; calibrated would use all of these values"
    assert words["law"] == "calibrated, which uses all of these values"
    assert words["values_are"] == "measured"
    assert (words["control_rate_hz"], words["ambient_c"]) == (10_000.0, 21.5)
    assert words["date"].startswith(found[0].conditions["date"][:13])
    value, _, sigma = words["spring_stiffness_nm_per_rad"].partition(" +- ")
    assert float(value) == pytest.approx(2.0, rel=0.01)
    assert 0.0 < float(sigma) < 0.01
    shown = runner.invoke(app, ["info", "--device", "emulated"])
    assert "assumed; torsio calibrate measures them" in " ".join(shown.output.split())


def test_kept_calibration_is_read_back_and_has_not_drifted(found: Any, data_folder: Path) -> None:
    path = calibration.keep(found[0])
    assert path.parent == data_folder / "torsio/calibration"
    back = calibration.kept(found[0].conditions["serial"])
    assert back == json.loads(json.dumps(found[0].as_dict()))
    assert back is not None
    assert calibration.drifts(back, found[0]) == []
    back["quantities"]["coulomb_nm"]["value"] *= 1.3
    assert [drift.name for drift in calibration.drifts(back, found[0])] == ["coulomb_nm"]


def test_emulated_knob_says_how_long_its_calibration_is_kept(found: Any, data_folder: Path) -> None:
    with torsio.open("emulated") as knob:
        save(knob, found[0], Console(file=(said := io.StringIO()), width=300))
    path = data_folder / "torsio/calibration/EMULATED.json"
    assert (
        said.getvalue()
        .split(maxsplit=1)[1]
        .startswith(f"until this command ends, and all that was found in {path}")
    )
    assert path.is_file()


def test_command_prints_quantities_and_saves_only_when_told(data_folder: Path) -> None:
    runner = CliRunner()
    asked = ["calibrate", "--drift", "--json", "--device", "emulated", "--picture"]
    quiet = runner.invoke(app, [*asked, str(picture := data_folder.parent / "fits.png")])
    assert quiet.exit_code == 0, quiet.output
    assert picture.stat().st_size > 50_000
    quantities = json.loads(quiet.stdout)["quantities"]
    assert quantities["stiffness_nm_per_rad"]["value"] == pytest.approx(2.873, rel=0.01)
    assert not data_folder.exists()


def test_limit_that_the_turns_would_break_is_named_before_anything_turns() -> None:
    with torsio.open("emulated") as knob:
        knob.update(speed_limit_rad_s=40.0)
        with pytest.raises(calibration.Refusal, match="speed_limit_rad_s=160") as refused:
            calibration.calibrate(knob)
        assert refused.value.reason == "limited"
        assert knob.health().faults == ()
        assert knob.control_config().speed_limit_rad_s == 40.0


@pytest.mark.parametrize(
    ("caps", "named"),
    [
        # As first power saves them: the brake's holds less than the motor's pulls.
        ({"motor_torque_cap_nm": 0.03, "brake_torque_cap_nm": 0.015}, "brake_torque_cap_nm"),
        ({"motor_torque_cap_nm": 0.012}, "motor_torque_cap_nm"),
        ({"motor_torque_cap_nm": 0.004}, "motor_torque_cap_nm"),  # less than the friction
    ],
)
def test_cap_that_keeps_the_twist_too_small_is_named(caps: dict[str, float], named: str) -> None:
    with torsio.open("emulated") as knob:
        knob.update(**caps)
        with pytest.raises(calibration.Refusal) as refused:
            calibration.calibrate(knob, drift=True)
    assert refused.value.reason == "limited"
    limit = getattr(torsio.ActuatorConfig(), named.replace("cap", "max"))
    assert f"{named} is {caps[named]:g}, of {limit:g}: raise it" in str(refused.value)


def test_limit_that_the_doctor_recommends_is_one_that_calibration_takes() -> None:
    with torsio.open("emulated") as knob:
        none = replace(knob.limits(), speed_limit_rad_s=0.0)
        lacks = missing("pico2", none)
        assert lacks is not None
        (limit,) = re.findall(r"speed_limit_rad_s=([0-9.]+)", lacks[1])
        knob.update(speed_limit_rad_s=float(limit))
        calibration.calibrate(knob, drift=True)


def _as_board(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let emulated knobs say that they are a real board's."""
    before = vars(torsio.Knob)["info"]
    monkeypatch.setattr(
        torsio.Knob, "info", property(lambda knob: replace(before.fget(knob), board="pico2"))
    )


def test_board_that_nobody_has_confirmed_is_named_before_anything_turns(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with torsio.open("emulated") as knob:
        _as_board(monkeypatch)
        with pytest.raises(
            calibration.Refusal, match=r"nobody has confirmed.*confirmed=on"
        ) as told:
            calibration.calibrate(knob, drift=True)
        assert told.value.reason == "unconfirmed"
        assert knob.position_rad() == 0.0


def test_board_that_is_held_low_until_it_is_measured_is_measured_without_a_warning(
    monkeypatch: pytest.MonkeyPatch, recwarn: pytest.WarningsRecorder
) -> None:
    with torsio.open("emulated") as knob:
        knob.update(confirmed=True)
        _as_board(monkeypatch)
        monkeypatch.setattr(torsio.Knob, "_is_held_low", lambda _: True)
        with pytest.warns(torsio.HeldLowWarning):
            knob.arm()
        knob.disarm()
        recwarn.clear()
        assert calibration.calibrate(knob, drift=True).quantities
    assert not [one for one in recwarn if one.category is torsio.HeldLowWarning]


def test_quick_look_leaves_the_knees_that_it_does_not_see() -> None:
    bent = torsio.ShaftConfig(knee_1_rad=0.5, knee_1_nm_per_rad=4.0)  # beyond its twist
    with torsio.open("emulated") as knob:
        knob.configure(bent)
        knob.update(values_are="measured", sigma_knee_1_rad=1e-3)
        knob.update(law="paper", free_assist_nm=1e-3)
        control = knob.control_config()
        found = calibration.calibrate(knob, drift=True)
    assert found.shaft == bent
    assert found.known.sigma_knee_1_rad == pytest.approx(1e-3)
    assert found.known.values_are == "measured"
    assert (found.law, found.free_assist_nm) == (control.law, control.free_assist_nm)
    assert found.cogging is None


def test_restoring_goes_on_where_a_part_fails(found: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    measured, *_ = found
    with torsio.open("emulated") as knob:
        before = (knob.actuator_config(), knob.shaft_config(), knob.control_config())
        configure, calls = knob.configure, []

        def fails_twice(config: Any) -> None:
            calls.append(config)
            if config == measured.known or (len(calls) > 1 and config == before[1]):
                raise torsio.Timeout("lost")
            configure(config)

        monkeypatch.setattr(knob, "configure", fails_twice)
        with pytest.raises(torsio.Timeout):
            calibration.apply(knob, measured)
        assert (knob.actuator_config(), knob.control_config()) == (before[0], before[2])


def test_calibration_that_is_refused_in_part_changes_nothing(found: Any) -> None:
    measured, *_ = found
    with torsio.open("emulated") as knob:
        before = (knob.actuator_config(), knob.control_config())
        wrong = replace(measured, known=replace(measured.known, ambient_k=-1.0))
        with pytest.raises(torsio.InvalidArgument):
            calibration.apply(knob, wrong)
        assert (knob.actuator_config(), knob.control_config()) == before


@pytest.mark.parametrize(
    ("believed", "says"),
    [
        ({"encoder_reversed": True}, "encoder counts down while the motor's torque is positive"),
        ({"knob_inertia_kg_m2": 1e-3}, "all that turns has 1.00e-04 kg m^2"),
    ],
)
def test_command_says_what_is_wrong(
    believed: dict[str, Any], says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def wrong_knob(*_: Any, **__: Any) -> torsio.Knob:
        actuator = torsio.ActuatorConfig(**believed)
        return original("emulated", emulator=torsio.EmulatorOptions(actuator=actuator))

    original = torsio.open
    monkeypatch.setattr(torsio, "open", wrong_knob)
    result = CliRunner().invoke(app, ["calibrate", "--device", "emulated"])
    assert result.exit_code == 1
    assert says in " ".join(result.output.split())


# The mathematics, against closed forms ----------------------------------------------------------


def test_border_of_counts_is_read_off_far_finer_than_a_count() -> None:
    torque = np.linspace(-1.0, 1.0, 4001)
    angle = 17.3 * torque + 0.4
    borders, read = numeric.crossings(np.floor(angle), torque)
    assert len(borders) > 20
    assert read == pytest.approx((borders - 0.4) / 17.3, abs=1e-3)


@pytest.mark.parametrize("begins_at", [2e-2, -2e-2])
@pytest.mark.parametrize("seed", range(6))
def test_size_near_nothing_is_as_certain_as_the_noise_leaves_it(
    begins_at: float, seed: int
) -> None:
    x = np.linspace(0.0, 1.0, 2000)
    measured = 2e-4 * x + np.random.default_rng(seed).normal(0.0, 1e-3, len(x))
    fit = numeric.gauss_newton(
        lambda value: np.asarray(abs(value[0]) * x + value[1]),
        measured,
        np.array([begins_at, 0.0]),
        scale=np.array([1e-3, 1e-5]),
    )
    of_a_line = 1e-3 / np.sqrt(np.sum((x - x.mean()) ** 2))
    assert fit.sigma(0) == pytest.approx(of_a_line, rel=0.1)
