"""Both binaries feel the wall: coupled to the plant, and beside the emulated device."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from tests.bench.bench_mcu import tick_time_ns
from tests.board import felt, pico
from tests.board.felt import Columns, difference_nm
from tests.mcu.mcu import as_documented
from torsio.hands import NoHand, PrescribedMotion
from torsio_studies.paper.runs import WALL_RAD

STIFFNESS = math.degrees(30e-3)
ENCODER, WINDING = 1 << 2, 1 << 7
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


def test_documents_say_what_a_tick_in_a_wall_costs(cost: felt.TickCost) -> None:
    # A telemetry sample more or less makes some per cent.
    some, whole = as_documented(0.05), 100 * as_documented(0.02)
    text = (pico.TREE / "docs" / "hardware.md").read_text(encoding="utf-8")
    rows = re.findall(
        r"^\| `(\w+)` \| ([\d,]+) \| ([\d.]+) us \| (\d+) % \| (\d+) % \|$", text, re.M
    )
    (told,) = (row[1:] for row in rows if row[0] == pico.chosen.name)
    instructions, tick_us, tick_percent, busy_percent = (float(n.replace(",", "")) for n in told)
    assert instructions == pytest.approx(cost.instructions, rel=some)
    assert 1e3 * tick_us == pytest.approx(cost.tick_time_ns, rel=some)
    assert tick_percent == pytest.approx(100 * cost.tick_time_ns / pico.chosen.tick_ns, abs=whole)
    assert busy_percent == pytest.approx(100 * cost.interrupt_share, abs=whole)


@pytest.mark.slow_chip
def test_documents_say_how_long_a_tick_in_damped_walls_takes() -> None:
    text = (pico.TREE / "docs" / "architecture.md").read_text(encoding="utf-8")
    rows = {
        name: [float(cell) for cell in re.findall(r"[\d.]+", cells)]
        for name, cells in re.findall(r"^\| (walls|us a tick)((?: \| [\d.]+)+) \|$", text, re.M)
    }
    # The newest tick, which may send a sample or look at the heat.
    for walls, told_us in zip(rows["walls"], rows["us a tick"], strict=True):
        tick_ns = tick_time_ns(int(walls))
        assert 1e3 * told_us == pytest.approx(tick_ns, rel=as_documented(0.1))


def test_dead_encoder_channel_does_not_throw_the_knob() -> None:
    # The count goes one up and one down from then on, so the wall would push for ever.
    with felt.binary(felt.plant_of(pico.chosen.name)) as bench:
        felt.prepare(bench)
        felt.lean(bench, STIFFNESS, 50e-3)
        found = felt.cut_encoder(bench, [3], NoHand(), 0.2)
        assert found.off_s is not None, "the outputs stay on"
        assert found.off_s < 0.08
        assert found.faults == ENCODER
        assert found.moved_rad < 0.4
        assert found.fastest_rad_s < 20.0
        # Off is off: friction takes the speed away from then on.
        speed = abs(bench.place.record()["speed_rad_s"][-1])
        bench.board.run(20)
        assert abs(bench.place.record()["speed_rad_s"][-1]) < speed
        assert bench.board.command("clear_fault") == "ok"


def test_encoder_cable_that_falls_off_does_not_throw_the_knob_for_long() -> None:
    # What gives it away is the voltage that a motor makes which is said to stand still.
    with felt.binary(felt.plant_of(pico.chosen.name)) as bench:
        felt.prepare(bench)
        felt.lean(bench, STIFFNESS, 50e-3)
        found = felt.cut_encoder(bench, [2, 3], NoHand(), 0.4)
        assert found.off_s is not None, "the outputs stay on"
        assert found.faults == WINDING
        assert found.fastest_rad_s < 100.0


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
