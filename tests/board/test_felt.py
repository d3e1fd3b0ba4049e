"""Both binaries feel the wall: coupled to the plant, and beside the emulated device."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.bench.bench_mcu import TickTime, tick_times
from tests.board import felt, pico
from tests.board.felt import WALL_RAD, Columns, difference_nm
from torsio.printed.hands import NoHand, PrescribedMotion

STIFFNESS = math.degrees(30e-3)
ENCODER, OVERRUN = 1 << 2, 1 << 4
Visits = dict[str, tuple[Columns, Columns]]


@pytest.fixture(scope="module")
def visits(_model: None) -> Visits:
    """Push into a wall and cut a string, with the binary and with the emulated device."""
    params = felt.plant_of(pico.chosen.name)
    both: list[dict[str, Columns]] = []
    for place in (felt.binary, felt.twin):
        with place(params) as bench:
            felt.prepare(bench)
            pushed = felt.push(bench, STIFFNESS, move_s=0.06, hold_s=0.06)
            # Until the brake has let go: how soon requests are answered is another matter.
            bench.board.run(60)
            cut = felt.cut(bench, STIFFNESS, ramp_s=0.03, hold_s=0.03, after_s=0.05)
            both.append({"push": pushed, "cut": cut})
    return {name: (both[0][name], both[1][name]) for name in both[0]}


def test_wall_gives_the_hand_its_torque_and_lets_it_out(visits: Visits) -> None:
    rows, _ = visits["push"]
    depth = rows["angle_rad"] - WALL_RAD
    deepest = int(np.argmax(depth))
    assert depth[deepest] > 0.03
    # Where it is held, motor and shaft give what the law asks: stiffness times depth. One count is
    # 1.3 mN m here, and a held current is noisy.
    held = rows["knob_sticks"] & (depth > 0.9 * depth[deepest])
    assert np.count_nonzero(held) >= 5
    assert np.mean(rows["felt_nm"][held]) == pytest.approx(
        -STIFFNESS * np.mean(depth[held]), abs=2.5e-3
    )
    assert depth[-1] < 0.0
    assert np.all(np.abs(rows["motor_torque_nm"][-10:]) < 3e-3)


def test_knob_leaves_the_wall_when_the_string_is_cut(visits: Visits) -> None:
    rows, _ = visits["cut"]
    depth = rows["angle_rad"] - WALL_RAD
    assert depth.max() > 0.015
    assert depth[-1] < 0.0


@pytest.mark.parametrize("visit", ["push", "cut"])
def test_binary_and_emulated_device_feel_the_same(visits: Visits, visit: str) -> None:
    # As far apart as two emulated devices whose sensors' noise differs: 0.4 to 0.55 mN m on a
    # pico2, 2.1 at most, and a knob that is thrown out of a wall ends 1 to 4 mrad elsewhere.
    binary, emulated = visits[visit]
    usual, most = difference_nm(binary, emulated)
    assert usual < 1e-3
    assert most < 4e-3
    size = min(len(binary["angle_rad"]), len(emulated["angle_rad"]))
    end_rad = binary["angle_rad"][size - 1] - emulated["angle_rad"][size - 1]
    assert abs(end_rad) < 10e-3


@pytest.fixture(scope="module")
def cost(_model: None) -> felt.TickCost:
    """Lean on a wall, and count."""
    with felt.binary(felt.plant_of(pico.chosen.name)) as bench:
        felt.prepare(bench)
        return felt.tick_cost(bench)


def test_tick_in_a_wall_leaves_the_processor_its_time(cost: felt.TickCost) -> None:
    # The aim for the product; without floating point it cannot be.
    most = {"pico2": 0.4, "pico": 0.7}[pico.chosen.name]
    assert cost.tick_time_ns < most * pico.chosen.tick_ns
    assert cost.interrupt_share < most


@pytest.fixture(scope="module")
def in_walls(_model: None) -> dict[int, TickTime | None]:
    """Count inside many damped walls."""
    return tick_times()


def test_tick_in_sixteen_damped_walls_leaves_the_product_its_time(
    in_walls: dict[int, TickTime | None],
) -> None:
    sixteen = in_walls[16]
    if pico.chosen.name == "pico":
        assert sixteen is None, "without floating point it cannot be"
    else:
        assert sixteen is not None
        assert sixteen.usual_ns < 0.4 * pico.chosen.tick_ns


@pytest.mark.slow_chip
@pytest.mark.parametrize(("law", "most"), [("paper", 8), ("calibrated", 5)])
def test_so_many_damped_walls_fit(law: str, most: int) -> None:
    with pico.enumerated() as board:
        assert board.set("control_config", law=law)["status"] == 0
        board.turn(60)
        for walls, faults in ((most, 0), (most + 4, OVERRUN)):  # in between is the edge
            board.arm_at_wall(walls, stiffness_nm_per_rad=0.1, damping_nm_s_per_rad=1e-4)
            for _ in range(3):  # the soft start, and what comes after
                board.run(25)
                board.post("command", op="keep_alive")
            assert board.get("health")["faults"] == faults
            if faults == 0:
                assert board.command("disarm") == "ok"


def _let_go_s(rows: Columns, share: float) -> float:
    """How long the coil takes to fall to a share of its current."""
    held_a = np.mean(rows["coil_a"][(rows["time_s"] > -5e-3) & (rows["time_s"] < 0.0)])
    assert held_a > 0.03
    return float(rows["time_s"][(rows["time_s"] > 0.0) & (rows["coil_a"] < share * held_a)][0])


def test_brake_whose_coil_is_driven_lets_go_backwards_and_is_demagnetised() -> None:
    limit_a, erase_a = 0.3, 0.05 * 0.3
    with felt.binary(
        felt.plant_of(pico.chosen.name), lambda: felt.with_coil(brake_time_constant_s=5e-3)
    ) as bench:
        felt.prepare(bench)
        rows = felt.let_go(bench, 0.2)
    assert np.all(rows["enabled"][rows["time_s"] > -0.06])
    after_s, coil_a = rows["time_s"], rows["coil_a"]
    assert rows["share"][(after_s > 0.0) & (after_s < 0.01)].min() < -0.9
    # The whole supply takes a tenth of an ampere away in L/R ln((0.3 + 0.1) / (0.3 + 0.01)),
    # 15 ms; the last of it follows with 5.
    assert _let_go_s(rows, 0.1) < 25e-3
    assert np.max(np.abs(coil_a)) <= limit_a
    # Two of the coil's time constants, 120 ms, after nearly nothing flowed, a pulse backwards.
    empty_s = after_s[(after_s > 0.0) & (coil_a < erase_a)][0]
    pulse = coil_a < -0.5 * erase_a
    assert after_s[pulse][0] - empty_s == pytest.approx(0.12, abs=3e-3)
    assert np.min(coil_a) == pytest.approx(-erase_a, rel=0.1)
    assert after_s[pulse][-1] - after_s[pulse][0] < 10e-3
    # Outside the pulse the supply's sag makes the current slightly negative.
    quiet = ~((after_s > empty_s + 0.115) & (after_s < empty_s + 0.13))
    assert np.min(coil_a[quiet]) > -3.5e-3
    assert abs(coil_a[-1]) < 1e-3


def test_another_lag_of_the_brake_reaches_its_coil_without_a_restart() -> None:
    with felt.binary(
        felt.plant_of(pico.chosen.name), lambda: felt.with_coil(brake_time_constant_s=60e-3)
    ) as bench:
        felt.prepare(bench)
        half_s = 60e-3 * math.log(2)
        # Later by the time in which the knob leaves, while the coil still rises.
        assert half_s < _let_go_s(felt.let_go(bench, 0.05), 0.5) < half_s + 6e-3
        bench.run(0.05)
        assert bench.board.set("actuator_config", brake_time_constant_s=5e-3)["status"] == 0
        pico.confirm(bench.board)
        assert _let_go_s(felt.let_go(bench, 0.03), 0.1) < 25e-3


@pytest.mark.one_board
def test_dead_encoder_channel_of_a_knob_that_is_held_asks_no_more_and_is_found_when_it_moves() -> (
    None
):
    with felt.binary(felt.plant_of(pico.chosen.name)) as bench:
        felt.prepare(bench)
        felt.lean(bench, STIFFNESS, 50e-3)
        before_nm = abs(bench.place.record()["motor_torque_nm"][-1])
        still = PrescribedMotion(angle_rad=[(0.0, bench.place.record()["angle_rad"][-1])])
        held = felt.cut_encoder(bench, [3], still, 0.02)
        assert (held.off_s, held.faults) == (None, 0)
        assert held.moved_rad < 5e-3
        after_nm = abs(bench.place.record()["motor_torque_nm"][-1])
        # One count is 1.3 mN m of this wall.
        assert after_nm == pytest.approx(before_nm, abs=3e-3)
        moved = felt.cut_encoder(bench, [3], NoHand(), 0.2)
        assert moved.faults == ENCODER
        assert moved.moved_rad < 0.4
