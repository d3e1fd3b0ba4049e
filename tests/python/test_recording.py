"""Recordings: their content and its times, and the same as tables and on a screen."""

from __future__ import annotations

import csv
import io
import json
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from pyarrow import parquet
from rich.console import Console

import torsio
from tests.python.processes import command
from tests.recordings import check_recording, counts_in_foxglove
from torsio.apps.commands.live import monitor_table
from torsio.knob.recording import _DeviceClock
from torsio.printed.config import Law

WALL = torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.4)


@pytest.fixture
def knob() -> Iterator[torsio.Knob]:
    hand = torsio.TorqueHand(torque_nm=[(0.0, 0.0), (0.8, 0.05)])
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(hand=hand)) as knob:
        yield knob


def test_recording_holds_what_was_read_slept_over_and_asked(
    knob: torsio.Knob, tmp_path: Path
) -> None:
    file = tmp_path / "wall.mcap"
    with knob.record_to(file) as recording:
        knob.play(WALL)
        knob.arm()
        read = knob.record(1.0)
        knob.sleep(2.5)
        recording.note("mark", participant=7)
        with pytest.raises(torsio.Error, match="recorded already"):
            knob.record_to(file)
    knob.disarm()  # after the end: not in it
    with pytest.raises(torsio.Closed, match="has ended"):
        recording.note("lost")

    recorded = torsio.load(file)
    assert recorded.whole
    assert recorded.samples_lost == 0
    # Every tick of a second and two and a half, without a hole.
    assert set(np.diff(recorded.telemetry["tick"])) == {1}
    assert len(recorded.telemetry) >= 3500
    begin = int(np.searchsorted(recorded.telemetry["tick"], read["tick"][0]))
    np.testing.assert_array_equal(recorded.telemetry[begin : begin + len(read)], read)
    assert [event["kind"] for event in recorded.events] == ["play", "arm", "mark"]
    scene = recorded.events[0]["scene"]
    assert scene[0].pop("type") == "Wall"
    assert torsio.Wall(**scene[0]) == WALL
    assert recorded.events[2]["participant"] == 7
    assert recorded.metadata["info"]["serial"] == knob.info.serial
    config = recorded.metadata["configuration"]["ControlConfig"]
    assert torsio.ControlConfig(**config) == knob.control_config()


def test_what_nobody_read_is_kept_before_another_rate_begins(tmp_path: Path) -> None:
    paced = torsio.EmulatorOptions(paced=True)
    with torsio.open("emulated", emulator=paced) as knob, knob.record_to(tmp_path / "x.mcap"):
        while knob.statistics().samples_received < 50:
            time.sleep(0.01)
        first = knob.record(0.02, rate_hz=500.0)["tick"][0]
    assert np.sum(torsio.load(tmp_path / "x.mcap").telemetry["tick"] < first) >= 50


def test_restarted_telemetry_misses_no_sample_of_a_file_or_says_how_many(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with torsio.open("emulated") as knob, knob.record_to(path):
        knob.sleep(0.05)
        knob.start_telemetry()  # as it runs already
        knob.sleep(0.05)
        knob.start_telemetry(500.0)
        knob.sleep(0.05)
        knob.record(0.05, rate_hz=250.0)
    loaded = torsio.load(path)
    steps = np.diff(loaded.telemetry["tick"].astype(int))
    assert np.all(steps[:90] == 1)
    assert set(steps[-10:]) == {4}
    # The distances in which each stream's samples go on.
    into_500, into_250 = np.flatnonzero(steps == 2)[0] - 1, np.flatnonzero(steps == 4)[0] - 1
    between = steps[into_500] - 1 + (steps[into_250] - 2) // 2
    assert loaded.samples_lost == between


def test_other_programs_find_times_and_schemas_in_it(knob: torsio.Knob, tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    before_ns = time.time_ns()
    with knob.record_to(file):
        knob.sleep(0.5)
    with file.open("rb") as stream:
        messages = list(make_reader(stream).iter_messages(topics=["telemetry"]))
    assert len(messages) >= 500
    schema, channel, first = messages[0]
    assert channel.message_encoding == "json"
    assert schema is not None
    assert schema.encoding == "jsonschema"
    told = json.loads(schema.data)["properties"]
    assert set(told) == set(json.loads(first.data))
    assert told["angle_rad"] == {"type": "number"}
    # Device time laid on the host's clock: half a second from end to end, from about now on.
    assert messages[-1][2].log_time - first.log_time == pytest.approx(0.5e9, rel=0.02)
    assert before_ns < first.log_time < before_ns + 60e9


def test_every_message_of_every_topic_is_as_its_schema_says(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    options = torsio.EmulatorOptions(log_inputs=True)
    with torsio.open("emulated", emulator=options) as knob, knob.record_to(file) as recording:
        knob.play([WALL, torsio.Curve(span_rad=1.0, torque_nm=[0.0, 0.01, 0.0])])
        knob.update(law="calibrated")
        knob.arm()
        knob.sleep(0.2)
        recording.note("mark", participant=7, sizes=[1, 2.5], none=None)
        knob.emulator.set_emergency_stop(pressed=True)
        knob.sleep(0.2)
    counts = check_recording(file)
    assert counts.keys() >= {
        *("telemetry", "energies", "events", "device_events", "reports", "inputs"),
    }
    assert counts_in_foxglove(file) == counts


def test_recording_of_the_law_that_counts_has_its_energies(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    hand = torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (1.0, 0.15), (2.0, 0.0)])
    options = torsio.EmulatorOptions(hand=hand, control_rate_hz=4000.0, log_truth=True)
    with torsio.open("emulated", emulator=options) as knob:
        knob.update(law="calibrated")
        knob.play(WALL)
        knob.arm()
        with knob.record_to(file):
            knob.sleep(1.0)
            knob.sleep(1.2)
            truth = knob.emulator.truth()
        last = knob.energies()
    recorded = torsio.load(file)
    told = recorded.energies
    # Eight a second, and one at the end, in the order of time and of the telemetry's clock.
    assert 15 <= len(told) <= 25
    times_s = np.array([one.time_s for one in told])
    assert np.all(np.diff(times_s) > 0.0)
    assert recorded.telemetry["time_s"][0] <= times_s[0]
    assert told[-1] == last
    # By the plant's truth, as near as counts tell it.
    turn_rad = np.diff(truth["angle_rad"])
    for name, columns in (
        ("motor_j", ("motor_torque_nm",)),
        ("felt_j", ("motor_torque_nm", "spring_torque_nm")),
    ):
        torque = np.sum([truth[column].astype(float) for column in columns], axis=0)
        done_j = np.append(0.0, np.cumsum(0.5 * (torque[1:] + torque[:-1]) * turn_rad))
        true_j = np.interp(times_s, truth["time_s"], done_j)
        largest_j = np.max(np.abs(true_j))
        told_j = np.array([getattr(one, name) for one in told])
        assert told_j == pytest.approx(true_j, abs=0.08 * largest_j)


@pytest.mark.parametrize("law", ["paper", "motor_only"])
def test_recording_of_a_law_that_does_not_count_has_none(law: Law, tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    with torsio.open("emulated") as knob:
        knob.update(law=law)
        with knob.record_to(file):
            knob.sleep(0.5)
    assert torsio.load(file).energies == []


def test_tables_hold_the_same_numbers(knob: torsio.Knob, tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    with knob.record_to(file):
        knob.sleep(0.3)
    recorded = torsio.load(file)
    for ending in ("csv", "parquet"):
        done = command("export", file, tmp_path / f"x.{ending}")
        assert done.returncode == 0, done.stderr
    table = parquet.read_table(tmp_path / "x.parquet")
    rows = list(csv.DictReader(io.StringIO((tmp_path / "x.csv").read_text())))
    for name in torsio.TELEMETRY_DTYPE.names or ():
        np.testing.assert_array_equal(table[name].to_numpy(), recorded.telemetry[name])
        read = np.array([row[name] for row in rows], torsio.TELEMETRY_DTYPE[name])
        np.testing.assert_array_equal(read, recorded.telemetry[name])
    with pytest.raises(torsio.Error, match=r"ends in neither \.csv nor \.parquet"):
        recorded.save(tmp_path / "x.xlsx")


@pytest.mark.parametrize("paced", [False, True])
def test_notes_and_reports_stand_on_the_time_line_of_the_telemetry(
    paced: bool, tmp_path: Path
) -> None:
    file = tmp_path / "x.mcap"
    step_s = 0.05 if paced else 10.0
    truth_s = []
    with (
        torsio.open("emulated", emulator=torsio.EmulatorOptions(paced=paced)) as knob,
        knob.record_to(file) as recording,
    ):
        before_ns = time.time_ns()
        for count in range(4):
            before_s = knob.emulator.time_s
            recording.note("mark", count=count, time_s="mine")
            truth_s.append((before_s, knob.emulator.time_s))
            knob.arm()
            knob.sleep(step_s)
        after_ns = time.time_ns()
    recorded = torsio.load(file)
    marks = [event for event in recorded.events if event["kind"] == "mark"]
    for mark, (low_s, high_s) in zip(marks, truth_s, strict=True):
        assert low_s <= mark["device_time_s"] <= high_s
        assert before_ns <= mark["host_time_ns"] <= after_ns
        assert mark["time_s"] == "mine"
    armed = recorded.device_events[0]
    assert armed["device_time_s"] == pytest.approx(armed["tick"] / 1000.0)
    # Other programs see the same: log_time is the device's, publish_time the host's.
    with file.open("rb") as stream:
        rows = [
            (json.loads(message.data), message.log_time)
            for _, channel, message in make_reader(stream).iter_messages(
                topics=["telemetry", "reports", "events"]
            )
        ]
    (row, zero_ns), *_ = [(row, at) for row, at in rows if "angle_rad" in row]
    zero_ns -= round(1e9 * row["time_s"])
    for row, at in rows:
        if "tick" in row:
            assert at - zero_ns == pytest.approx(1e6 * row["tick"], abs=10)
        elif row["kind"] == "mark":
            assert low_s <= 1e-9 * (at - zero_ns) or row["count"] < 3


class _FarKnob:
    """A knob on a cable: its time is asked for once, and a sample takes 3 ms or more."""

    is_emulated = False

    def clock(self) -> dict[str, float]:
        return {"time_s": time.monotonic() - 100.0 - 0.5}  # a slow answer


def test_time_of_a_knob_on_a_cable_follows_its_promptest_samples(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now_s = 1000.0
    monkeypatch.setattr(time, "monotonic", lambda: now_s)
    clock = _DeviceClock(_FarKnob())  # type: ignore[arg-type]
    for late_s in (0.2, 0.003, 0.4):
        now_s += 1.0
        clock.hear(now_s - 100.0 - late_s)
    assert clock.now_s() == pytest.approx(now_s - 100.0, abs=0.004)
    now_s += 3600.0  # its crystal is slow: 50 ppm
    clock.hear(now_s - 100.0 - 0.18)
    assert clock.now_s() == pytest.approx(now_s - 100.18, abs=0.004)


def test_note_without_a_number_is_json_all_the_same(knob: torsio.Knob, tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    values = [float("nan"), float("inf"), -np.inf, np.float32("nan")]
    with knob.record_to(file) as recording:
        recording.note("odd", values=values, array=np.array(values), one=values[0])
        recording.note("long", value=np.longdouble(1.5))
    with file.open("rb") as stream:
        for _, _, message in make_reader(stream).iter_messages(topics=["events"]):
            json.loads(message.data, parse_constant=lambda name: pytest.fail(name))
    odd, long = torsio.load(file).events
    assert float(long["value"]) == 1.5
    for read in (odd["values"], odd["array"], [odd["one"], "Infinity", "-Infinity", "NaN"]):
        np.testing.assert_array_equal([float(one) for one in read], values)


def test_monitor_says_that_a_wall_is_rendered_as_it_was_asked(knob: torsio.Knob) -> None:
    knob.update(law="calibrated")
    shown = io.StringIO()
    Console(file=shown, width=120).print(monitor_table(knob, knob.record(0.1)))
    line = next(line for line in shown.getvalue().splitlines() if "stiffest now" in line)
    assert line.split(maxsplit=2)[2].strip() == "as asked"


def test_reports_before_a_cable_is_pulled_are_in_the_recording(
    knob: torsio.Knob, tmp_path: Path
) -> None:
    recording = knob.record_to(tmp_path / "pulled.mcap")
    knob.emulator.unplug(after_s=0.002)
    with pytest.raises(torsio.Disconnected):
        knob.arm()
    recording.close()
    with (tmp_path / "pulled.mcap").open("rb") as stream:
        reports = make_reader(stream).iter_messages(topics=["reports"])
        assert "event" in [json.loads(message.data)["name"] for *_, message in reports]
