"""The plant's electrics against closed forms and SciPy, and the board's own power stage on them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

import torsio
from tests.python.plant_oracle import OraclePlant, OracleRun
from torsio import Electrics, EmulatorOptions, PlantParams, PrescribedMotion
from torsio.emulator import Circuit, Plant
from torsio.telemetry import Record

Array = npt.NDArray[np.float64]

# A supply that nothing moves, so that the voltages are the shares.
STIFF = Electrics(supply_resistance_ohm=0.0)
# A sensor and a PWM that hide nothing of the loop.
CLEAN = replace(
    STIFF, sensor_noise_v=0.0, sensor_bits=24, pwm_steps=65535, sample_offset_s=0.0
)  # fmt: skip
K, OHM, HENRY, VOLT = 0.05, 2.5, 1.5e-3, 12.0
COIL_NM_PER_A, COIL_OHM, COIL_HENRY = 0.44, 40.0, 2.4


def driven(
    plant: Plant, motor: Array | float, brake: Array | float, *, on: bool = True, n: int = 0,
    period_ns: int = 25_000,
) -> tuple[Record, Array]:  # fmt: skip
    size = n or len(np.atleast_1d(motor))
    shares = [np.broadcast_to(np.asarray(share, dtype=float), (size,)) for share in (motor, brake)]
    return plant.record_bridges(shares[0], shares[1], np.full(size, float(on)), period_ns=period_ns)


def at_angle(speed_rad_s: float = 0.0) -> PrescribedMotion:
    return PrescribedMotion(angle_rad=[(0.0, 0.0), (10.0, 10.0 * speed_rad_s)])


@pytest.mark.parametrize("belt", [None, torsio.Belt()])
@pytest.mark.parametrize("speed", [0.0, 30.0])
def test_current_rises_as_resistance_and_inductance_have_it(
    speed: float, belt: torsio.Belt | None
) -> None:
    params = PlantParams(electrics=STIFF, belt=belt)
    plant = Plant(params, at_angle(speed), step_ns=25_000)
    rows, _ = driven(plant, 0.5, 0.25, n=100)
    settled = K * (0.5 * VOLT - K * speed) / OHM
    expected = settled * -np.expm1(-rows["time_s"] * OHM / HENRY)
    np.testing.assert_allclose(rows["motor_torque_nm"], expected, rtol=1e-11, atol=1e-15)
    capacity = COIL_NM_PER_A * 0.25 * VOLT / COIL_OHM
    np.testing.assert_allclose(
        rows["brake_capacity_nm"] - params.brake_drag_nm,
        capacity * -np.expm1(-rows["time_s"] * COIL_OHM / COIL_HENRY),
        rtol=1e-10, atol=1e-15,
    )  # fmt: skip


def test_brake_with_hysteresis_follows_its_coils_current_with_a_play() -> None:
    half_nm, lag_s, period_s = 4e-3, COIL_HENRY / COIL_OHM, 25e-6
    play = torsio.BrakeHysteresis(half_width_nm=half_nm)
    plant = Plant(PlantParams(electrics=STIFF, brake_hysteresis=play), step_ns=25_000)
    brake = np.repeat([0.3, 0.2, 0.25, 0.0, -0.1, 0.1], 4000)
    rows, _ = driven(plant, 0.0, brake, n=len(brake))
    # The coil's current as a torque: exponentials from step to step, with its sign.
    coil_nm, held_nm = 0.0, 0.0
    expected = []
    for share in brake:
        expected.append(abs(held_nm))
        end_nm = COIL_NM_PER_A * share * VOLT / COIL_OHM
        coil_nm = end_nm + (coil_nm - end_nm) * math.exp(-period_s / lag_s)
        held_nm = float(np.clip(held_nm, coil_nm - half_nm, coil_nm + half_nm))
    # Where the current changes its sign the play is crossed within a period.
    np.testing.assert_allclose(rows["brake_capacity_nm"] - 2e-3, expected, rtol=0, atol=2e-5)
    assert max(expected) == pytest.approx(COIL_NM_PER_A * 0.3 * VOLT / COIL_OHM - half_nm, rel=0.3)


def test_little_current_backwards_takes_away_what_a_brake_with_hysteresis_has_kept() -> None:
    half_nm = 5e-3
    play = torsio.BrakeHysteresis(half_width_nm=half_nm)
    plant = Plant(PlantParams(electrics=STIFF, brake_hysteresis=play), step_ns=25_000)
    back = half_nm / COIL_NM_PER_A * COIL_OHM / VOLT  # the share that holds so much backwards
    n = 24_000  # 0.6 s, ten times the coil's lag
    rows, _ = driven(plant, 0.0, np.repeat([0.3, 0.0, -back, 0.0], n), n=4 * n)
    held_nm = rows["brake_capacity_nm"] - 2e-3
    assert held_nm[2 * n - 1] == pytest.approx(half_nm, rel=1e-3)
    assert held_nm[-1] == pytest.approx(0.0, abs=1e-3 * half_nm)


@pytest.mark.parametrize("period_s", [25e-6, 400e-6])
def test_motor_with_back_emf_moves_the_knob_as_scipy_has_it(period_s: float) -> None:
    generator = np.random.default_rng(4)
    n = 150
    motor = np.repeat(generator.uniform(-1, 1, n // 10), 10)
    brake = np.repeat(generator.uniform(0.0, 0.5, n // 10), 10)
    hand = torsio.TorqueHand(torque_nm=[(0.0, 0.02), (n * period_s, -0.02)])
    plant = Plant(PlantParams(electrics=STIFF), hand, step_ns=round(1e9 * period_s))
    rows, _ = driven(plant, motor, brake, period_ns=round(1e9 * period_s))
    oracle = OracleRun(
        OraclePlant(
            motor_time_constant_s=HENRY / OHM,
            back_emf_nm_s_per_rad=K * K / OHM,
            brake_time_constant_s=COIL_HENRY / COIL_OHM,
        ),
        hand_torque_nm=lambda t: 0.02 - 0.04 * t / (n * period_s),
    )
    expected = np.empty((n, 5))
    for i in range(n):
        expected[i] = [oracle.y[0], oracle.y[1], oracle.y[2], oracle.y[4], oracle.y[5]]
        oracle.advance(
            period_s, K * motor[i] * VOLT / OHM, COIL_NM_PER_A * brake[i] * VOLT / COIL_OHM
        )
    columns = ["angle_rad", "brake_angle_rad", "speed_rad_s", "motor_torque_nm"]
    for column, name in enumerate(columns):
        scale = np.max(np.abs(expected[:, column]))
        np.testing.assert_allclose(rows[name], expected[:, column], rtol=0, atol=1e-8 * scale)
    assert oracle.events >= 1


def test_bridge_that_is_off_sends_the_current_back_until_there_is_none() -> None:
    plant = Plant(
        # A capacitor so large that its voltage hardly moves.
        PlantParams(electrics=replace(STIFF, supply_resistance_ohm=1.0, supply_capacitance_f=50.0)),
        at_angle(),
        step_ns=5_000,
    )
    driven(plant, 1.0, 0.0, n=20)
    begin_a = plant.state["motor_torque_nm"] / K
    rows, supply = driven(plant, 0.0, 0.0, on=False, n=60, period_ns=5_000)
    current = rows["motor_torque_nm"] / K
    tau_s = HENRY / OHM
    time_s = rows["time_s"] - rows["time_s"][0]
    # Against the whole supply, until L/R ln(1 + i R / V). The copper is 25 degrees still.
    end_s = tau_s * math.log1p(begin_a * OHM / VOLT)
    expected = np.where(
        time_s < end_s, (begin_a + VOLT / OHM) * np.exp(-time_s / tau_s) - VOLT / OHM, 0.0
    )
    assert 0.1 < begin_a < 4.8
    np.testing.assert_allclose(current, expected, atol=2e-4 * begin_a)
    assert current[-1] == 0.0
    # The charge that ran back into the supply, the integral of the line above.
    charge = (begin_a + VOLT / OHM) * tau_s * -math.expm1(-end_s / tau_s) - VOLT / OHM * end_s
    assert supply[-1] - VOLT == pytest.approx(charge / 50.0, rel=0.05)


def test_circuit_moves_a_plant_period_by_period_as_a_record_does() -> None:
    shares = np.linspace(-0.8, 0.9, 60)
    whole, apart = (Plant(PlantParams(electrics=Electrics()), step_ns=25_000) for _ in range(2))
    rows, supply = driven(whole, shares, np.abs(shares))
    circuit = Circuit(apart)
    for row, volts, share in zip(rows, supply, shares, strict=True):
        state = circuit.electrics
        assert (apart.angle_rad, state.supply_v) == (row["angle_rad"], volts)
        assert K * circuit.current_a() == pytest.approx(row["motor_torque_nm"], rel=1e-12)
        circuit.advance(25_000, motor_share=share, brake_share=abs(share), enabled=True)


def test_supply_sags_to_what_its_resistance_leaves() -> None:
    plant = Plant(
        PlantParams(electrics=replace(STIFF, supply_resistance_ohm=0.5)), at_angle(), step_ns=25_000
    )
    _, supply = driven(plant, 1.0, 0.0, n=4000)
    # V = 12 - 0.5 i with i = V / 2.5.
    assert supply[-1] == pytest.approx(VOLT * OHM / (OHM + 0.5), rel=1e-4)


def test_coil_driven_backwards_ends_at_zero_and_rises_on_the_other_side() -> None:
    plant = Plant(PlantParams(electrics=STIFF), step_ns=100_000)
    driven(plant, 0.0, 1.0, n=600, period_ns=100_000)
    begin_nm = plant.state["brake_capacity_nm"] - 2e-3
    full_nm = COIL_NM_PER_A * VOLT / COIL_OHM
    rows, _ = driven(plant, 0.0, -1.0, n=600, period_ns=100_000)
    signed = (begin_nm + full_nm) * np.exp(
        -(rows["time_s"] - rows["time_s"][0]) * COIL_OHM / COIL_HENRY
    ) - full_nm
    assert signed[0] > 0.05
    assert signed[-1] < -0.02
    np.testing.assert_allclose(rows["brake_capacity_nm"] - 2e-3, np.abs(signed), atol=1e-8)


def test_held_current_warms_winding_and_rotor_as_their_resistances_have_it() -> None:
    # Time constants of tenths of a second, so that a test can wait for them.
    warm = replace(
        CLEAN, winding_heat_j_per_k=0.02, winding_to_rotor_k_per_w=2.0, rotor_heat_j_per_k=0.02,
        rotor_to_air_k_per_w=3.0, coil_heat_j_per_k=0.01, coil_to_air_k_per_w=8.0,
    )  # fmt: skip
    options = EmulatorOptions(
        control_rate_hz=20_000, plant=PlantParams(electrics=warm), hand=at_angle(),
        control=torsio.ControlConfig(law="motor_only", watchdog_s=60.0),
    )  # fmt: skip
    with torsio.open("emulated", emulator=options) as knob:
        assert knob.emulator is not None
        before = knob.emulator.electrics
        assert (before.winding_c, before.rotor_c, before.coil_c) == (25.0, 25.0, 25.0)
        knob.arm()
        knob.play(torsio.Constant(torque_nm=0.04))
        knob.sleep(2.0)
        state = knob.emulator.electrics
        watts = 0.8**2 * OHM * (1 + 3.93e-3 * (state.winding_c - 25.0))
        assert state.motor_current_a == pytest.approx(0.8, rel=0.02)
        assert state.winding_c - 25.0 == pytest.approx(watts * 5.0, rel=0.03)
        assert state.rotor_c - 25.0 == pytest.approx(watts * 3.0, rel=0.03)
        # Warm copper resists more; the current loop does not mind.
        assert state.supply_v == VOLT


def test_warm_coil_resists_more_and_so_brakes_less() -> None:
    warm = replace(STIFF, coil_heat_j_per_k=0.01, coil_to_air_k_per_w=8.0)
    params = PlantParams(electrics=warm)
    rows, _ = driven(Plant(params, step_ns=100_000), 0.0, 1.0, n=10_000, period_ns=100_000)
    # At rest: the coil's power, through 8 K/W, makes it as warm as the power needs.
    share = (1.0 + math.sqrt(1.0 + 4.0 * 3.93e-3 * 8.0 * VOLT**2 / COIL_OHM)) / 2.0
    coil_nm = rows["brake_capacity_nm"][-1] - params.brake_drag_nm
    assert coil_nm == pytest.approx(COIL_NM_PER_A * VOLT / (share * COIL_OHM), rel=3e-3)


def test_warm_winding_resists_more_and_so_pushes_less() -> None:
    warm = replace(
        STIFF, winding_heat_j_per_k=0.01, winding_to_rotor_k_per_w=1.0, rotor_heat_j_per_k=0.01,
        rotor_to_air_k_per_w=1.0,
    )  # fmt: skip
    plant = Plant(PlantParams(electrics=warm), at_angle(), step_ns=100_000)
    rows, _ = driven(plant, 0.5, 0.0, n=10_000, period_ns=100_000)
    share = (1.0 + math.sqrt(1.0 + 4.0 * 3.93e-3 * 2.0 * (0.5 * VOLT) ** 2 / OHM)) / 2.0
    assert rows["motor_torque_nm"][-1] == pytest.approx(K * 0.5 * VOLT / (share * OHM), rel=3e-3)


def test_knob_without_electrics_says_so() -> None:
    with torsio.open("emulated") as knob:
        assert knob.emulator is not None
        with pytest.raises(torsio.Error, match="no electrics"):
            _ = knob.emulator.electrics
        with pytest.raises(torsio.Error, match="no electrics"):
            knob.emulator.set_current_sensor("dead")
    with torsio.open(
        "emulated", emulator=EmulatorOptions(plant=PlantParams(electrics=Electrics()))
    ) as knob:
        assert knob.emulator is not None
        with pytest.raises(torsio.InvalidArgument, match="allowed are works, dead"):
            knob.emulator.set_current_sensor("broken")  # type: ignore[arg-type]
        knob.emulator.set_current_sensor("dead")
