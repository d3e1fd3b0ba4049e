"""The study of designs: its formulas, and that it can be spread, interrupted and resumed."""

from __future__ import annotations

import json
import math
import signal
import subprocess
import sys
import time
from collections import Counter
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from torsio.apps.cli import app
from torsio.errors import InvalidArgument
from torsio_studies.common import StudyError
from torsio_studies.design import devices, study
from torsio_studies.design.devices import SPACE, Batch, Design
from torsio_studies.design.store import Store

DEVICES = 8
KEY = {"evaluation": 1}
BATCHES = tuple(Batch("sample", i, (Design(beta=0.1 * i),)) for i in range(4))


# --- formulas and the sample ---------------------------------------------------------------------


@given(st.integers(0, 10**6))
def test_sampled_design_lies_in_its_ranges_and_depends_on_its_number_only(index: int) -> None:
    one = devices.sample_design(index)
    assert one == devices.sample_design(index)
    for name, span in SPACE.items():
        assert span.low * (1 - 1e-9) <= getattr(one, name) <= span.high * (1 + 1e-9)


def test_sample_fills_every_parameter_evenly() -> None:
    sample = [devices.sample_design(i) for i in range(512)]
    for name, span in SPACE.items():
        edges = [span.at(share) for share in np.linspace(0, 1, 9)]
        counts, _ = np.histogram([getattr(one, name) for one in sample], edges)
        assert counts.min() >= 56, name
        assert counts.max() <= 72, name


@given(st.integers(8, 200), st.integers(0, 200))
def test_larger_sample_begins_with_the_batches_of_a_smaller_one(count: int, more: int) -> None:
    few = list(devices.batches(count, 2, "paper", 16))
    many = set(devices.batches(count + more, 2, "paper", 16))
    assert {batch for batch in few if len(batch.designs) == 16} <= many


def test_evaluation_of_the_default_device_is_what_the_theory_says() -> None:
    measures = devices.evaluate(Design())
    assert 7.0 < measures.stable_stiffness_nm_per_rad < 15.0
    assert measures.critical_torque_nm == pytest.approx(measures.critical_formula_nm, rel=0.06)
    assert measures.tracking_in <= 0.07
    assert measures.tracking_out <= 0.09
    assert measures.sensor_rms_nm <= 4.5e-3
    assert measures.exit_time_s < 0.1
    assert measures.stuck_torque_nm == measures.stays == 0.0


def test_a_knob_that_stays_in_the_wall_says_how_much_the_wall_asks() -> None:
    stiff = Design(shaft_stiffness_nm_per_rad=50.0, beta=1.0)
    measures = devices.evaluate(stiff, "parallel")
    assert math.isnan(measures.exit_time_s)
    assert measures.stuck_torque_nm > 40e-3
    assert measures.stays == 1.0
    table = {
        "exit_time_s": np.array([0.1, math.nan, math.nan]),
        "stays": np.array([0.0, 0.0, 1.0]),
    }
    assert study.count_exits(table) == {"leaves": 1, "held by friction": 1, "stays": 1}


# --- results on disk -----------------------------------------------------------------------------

ROW: dict[str, float] = asdict(Design()) | dict.fromkeys(devices.columns()[7:], 0.25)


def test_a_flipped_bit_never_gives_other_numbers(tmp_path: Path) -> None:
    designs = devices.sample_design(0), devices.sample_design(1), devices.sample_design(2)
    batch = Batch("sample", 0, designs)
    rows = [
        asdict(one) | {name: one.beta + i for i, name in enumerate(devices.columns()[7:])}
        for one in designs
    ]
    store = Store(tmp_path, KEY)
    store.write(batch, rows)
    path = store.path(batch)
    data, numbers = path.read_bytes(), store.read([batch])["sample"]
    refused, wrong = 0, []
    for bit in range(0, 8 * len(data), 251):  # no multiple of 8: every bit of a byte has its turn
        flipped = bytearray(data)
        flipped[bit // 8] ^= 1 << bit % 8
        path.write_bytes(bytes(flipped))
        try:
            found = Store(tmp_path, KEY).read([batch])["sample"]
        except StudyError:
            refused += 1
            continue
        same = list(found) == list(numbers) and all(
            np.array_equal(found[name], values) for name, values in numbers.items()
        )
        if not same:
            wrong.append(bit)
    assert wrong == []
    assert refused > 100


def test_results_of_other_settings_are_refused_and_left_alone(tmp_path: Path) -> None:
    store = Store(tmp_path, KEY)
    store.write(BATCHES[0], [ROW])
    before = store.path(BATCHES[0]).read_bytes()
    with pytest.raises(StudyError, match="other settings"):
        Store(tmp_path, {"evaluation": 2}).intact(BATCHES)
    assert store.path(BATCHES[0]).read_bytes() == before


# --- the whole study -----------------------------------------------------------------------------


def _study(out: Path, *options: str) -> list[str]:
    program = str(Path(sys.executable).parent / "torsio")
    where = ["--out", str(out), "--workers", "1"]
    return [program, "study", "design", "--quick", "--devices", str(DEVICES), *where, *options]


def test_study_killed_in_the_middle_goes_on_where_it_was(tmp_path: Path) -> None:
    folder = tmp_path / "design"
    process = subprocess.Popen(
        _study(tmp_path), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    deadline = time.monotonic() + 60
    while len(list(folder.glob("*.parquet"))) < 2 and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    kept = {path: path.read_bytes() for path in folder.glob("[!.]*.parquet")}
    assert kept
    assert not (tmp_path / "design.json").exists()

    subprocess.run(_study(tmp_path), check=True, capture_output=True)
    results = json.loads((tmp_path / "design.json").read_text())
    total = DEVICES + 2 * 9
    assert results["devices"] == total
    assert 0 < results["computed_now"] <= total - 4 * len(kept)
    for path, data in kept.items():
        assert path.read_bytes() == data

    # A resumed run equals an uninterrupted one.
    work = list(devices.batches(DEVICES, 3, "paper", 4))
    settings = {"evaluation": devices.EVALUATION, "law": "paper", "batch_size": 4}
    rows = Store(folder, settings).read(work[:1])["sample"]
    again = devices.evaluate_batch(work[0])
    for name in devices.columns():
        if name != "seconds":
            np.testing.assert_array_equal(rows[name], [row[name] for row in again], err_msg=name)

    assert set(results) >= {"rows", "cost_by_rate", "cost_by_devices", "parquet", "space"}
    assert {row["parameter"] for row in results["rows"]} == set(SPACE)
    # One count of the encoder in a wall of 10 N m/rad is 12.7 % of 60 mN m at 8,192 counts.
    counts = {row["stiffness_nm_per_rad"]: row["one_jnd"] for row in results["counts_for_walls"]}
    assert counts[10.0] == pytest.approx(8192, rel=0.01)
    assert all(0.0 <= error["unfelt"] <= 1.0 for error in results["jnds"].values())
    for name in results["figures"]:
        assert 20_000 < (tmp_path / name).stat().st_size < 200_000


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("knob_inertia_kg_m2", -6e-5),
        ("shaft_stiffness_nm_per_rad", 0.0),
        ("control_rate_hz", 0.0),
        ("counts_per_rev", 0),
        ("motor_limit_nm", math.nan),
        ("beta", 1.5),
        ("beta", math.nan),
    ],
)
def test_impossible_design_is_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(InvalidArgument, match=name):
        Design(**{name: value})  # type: ignore[arg-type]


def test_command_takes_the_laws_whose_springs_can_swing() -> None:
    refused = CliRunner().invoke(app, ["study", "design", "--law", "calibrated"])
    assert refused.exit_code == 2
    assert "is not one of paper, compensated" in " ".join(refused.output.split())


@given(st.integers(8, 300), st.integers(2, 8), st.integers(1, 40))
def test_batches_hold_every_device_once(count: int, side: int, size: int) -> None:
    work = list(devices.batches(count, side, "paper", size))
    assert len(set(work)) == len(work)
    groups = Counter(batch.group for batch in work for _ in batch.designs)
    assert groups == {"sample": count, f"map_rate_{side}": side**2, f"map_beta_{side}": side**2}
