"""The bench of current loops measures what the parts alone predict."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

import torsio
from tests.bench import bench_stiffness as bench

# By how much each board's own current loop trails: the motor's lag of its configuration.
LAGS_S = {"pico2": 44e-6, "pico": 160e-6}


# Columns in docs/results.md: board, loop, lag, -3 dB, noise, and up to where springs rest.
ROWS = re.findall(
    r"^\| `(\w+)`, \d+ kHz \| (.+?) \| ([\d.]+ [um]s) \| ([\d.]+) kHz \| ([\d.]+) mN m \| (.+) \|$",
    (Path(__file__).parents[2] / "docs" / "results.md").read_text(encoding="utf-8"),
    re.MULTILINE,
)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row[0]}, {row[1]}")
def test_table_of_the_current_loops_is_the_benchmark_s(row: tuple[str, ...]) -> None:
    board, name, lag, kilohertz, noise_mnm, _ = row
    (loop,) = (one for one in bench.LOOPS if (one.board, one.name) == (board, name))
    time_s, response = bench.step_response(loop)
    number, unit = lag.split()
    told_s = float(number) * {"us": 1e-6, "ms": 1e-3}[unit]
    # As many digits as the page has.
    assert bench.lag_s(time_s, response) == pytest.approx(told_s, rel=0.03)
    assert 1e-3 * bench.bandwidth_hz(time_s, response) == pytest.approx(float(kilohertz), rel=0.05)
    assert 1e3 * bench.noise_nm(loop) == pytest.approx(float(noise_mnm), rel=0.08)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row[0]}, {row[1]}")
def test_springs_of_the_table_rest_and_the_next_one_does_not(row: tuple[str, ...]) -> None:
    # All that are softer take minutes.
    board, name, *_, told = row
    (loop,) = (one for one in bench.LOOPS if (one.board, one.name) == (board, name))
    columns = [(1.03, counts, [loop]) for counts in bench.COUNTS]
    columns += [(1.06, 32768, bench.wrong_windings(loop)), (1.06, 32768, bench.weak_supplies(loop))]
    for (step, counts, loops), told_nm_per_rad in zip(columns, told.split(" | "), strict=True):
        series = bench.springs(step)
        at = min(range(len(series)), key=lambda n: abs(series[n] - float(told_nm_per_rad)))
        calm = [bench.rests(one, counts, series[at - 1 : at + 2]).all(axis=1) for one in loops]
        assert [all(spring) for spring in zip(*calm, strict=True)] == [True, True, False], counts


def test_table_of_the_current_loops_is_there() -> None:
    assert len(ROWS) == len([loop for loop in bench.LOOPS if loop.electrics])


def test_full_step_takes_what_supply_and_winding_need_and_the_period_until_the_voltage_acts() -> (
    None
):
    # The whole of 12 V on 2.5 ohm and 1.5 mH, from 0 to nine tenths of 85 mN m at 0.05 N m/A.
    amperes = 0.9 * 85e-3 / 0.05
    winding_s = -1.5e-3 / 2.5 * math.log(1 - amperes * 2.5 / 12)
    fast = next(loop for loop in bench.LOOPS if loop.electrics == bench.FAST)
    assert bench.rise_s(fast) == pytest.approx(winding_s + 25e-6, rel=0.02)
    # A loop that is a lag takes ln 10 of its time.
    lag = next(loop for loop in bench.LOOPS if loop.rate_hz == 20e3 and not loop.electrics)
    assert bench.rise_s(lag) == pytest.approx(44e-6 * math.log(10), rel=0.1)


def test_predicted_stiffness_solves_the_balance_of_feeding_and_losses() -> None:
    for loop in (loop for loop in bench.LOOPS if loop.electrics is None):
        stiffness = bench.predicted_nm_per_rad(loop)
        # (8) of docs/explanation/theory.md, with the reference actuator's numbers.
        late_s = (0.5 + loop.delay_ticks) / loop.rate_hz + 44e-6
        fed = (stiffness - min(2.873, 0.5 * stiffness)) * late_s
        lost = 2.6e-5 + 0.8 * 4 * 6e-3 * math.sqrt(stiffness * 6e-5) / (math.pi * 85e-3)
        assert fed == pytest.approx(lost, rel=1e-9)


def test_fast_loop_is_stable_to_three_times_the_stiffness_of_one_of_500_hertz() -> None:
    # The worst of five speeds at each. The slow loop runs at 10 kHz.
    slow = next(one for one in bench.LOOPS if one.board == "pico" and "500 Hz" in one.name)
    fast = next(one for one in bench.LOOPS if one.board == "pico2" and "40 kHz" in one.name)
    soft = bench.springs(1.06)
    soft = soft[soft < 14.0]
    limit = bench.stable_to(soft, [all(row) for row in bench.rests(slow, 8192, soft)])
    assert limit == pytest.approx(10.0, rel=0.1)
    stiff = bench.springs(1.12)
    stiff = stiff[(stiff > limit) & (stiff < 3.0 * limit * 1.12)]
    assert stiff[-1] >= 3.0 * limit
    assert bench.rests(fast, 8192, stiff).all()


@pytest.mark.parametrize("counts", [2048, 4096, *bench.COUNTS])
@pytest.mark.parametrize("board", LAGS_S)
def test_knob_promises_no_stiffness_that_the_board_does_not_hold(board: str, counts: int) -> None:
    loop = next(one for one in bench.LOOPS if one.board == board and "500 Hz" not in one.name)
    options = torsio.EmulatorOptions(plant=loop.plant(counts), control_rate_hz=loop.rate_hz)
    with torsio.open("emulated", emulator=options) as knob:
        knob.update(counts_per_rev=counts, motor_time_constant_s=LAGS_S[board])
        told = knob.stable_stiffness().stiffness_nm_per_rad
    assert bench.rests(loop, counts, [0.5 * told, 0.75 * told, told]).all()
    # Nor much less than it holds.
    assert not bench.rests(loop, counts, [2.5 * told]).all()
