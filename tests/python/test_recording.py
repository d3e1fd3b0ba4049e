"""Recordings: whole, torn, and as tables; and the commands that make and show them."""

from __future__ import annotations

import csv
import io
import itertools
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from pyarrow import parquet
from rich.console import Console

import torsio
from tests.faults.lines import Injection
from tests.python.processes import TORSIO, command
from tests.recordings import check_recording, counts_in_foxglove
from torsio.apps.commands.live import monitor_table
from torsio.knob.recording import _DeviceClock
from torsio.printed.config import Law
from torsio.recordings.file import RecordingFile
from torsio.recordings.stream import Claim
from torsio.trading.sources import options_of

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


def test_torn_recording_gives_all_but_its_end(knob: torsio.Knob, tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    with knob.record_to(file) as recording:
        began = file.stat().st_size
        for _ in range(3):
            knob.sleep(0.5)
            # As after a second; this knob's clock runs faster than the wall's.
            recording.put(lambda _: recording._writer.flush(), [None])
    whole = file.read_bytes()
    sizes = set()
    # The last eight bytes are the format's closing mark, without which all is there.
    for end in range(0, len(whole) - 8, 997):
        file.write_bytes(whole[:end])
        if end < began:
            with pytest.raises(torsio.Error, match="torn before it began"):
                torsio.load(file)
            continue
        torn = torsio.load(file)
        assert not torn.whole
        ticks = torn.telemetry["tick"]
        assert len(ticks) == 0 or set(np.diff(ticks)) <= {1}
        sizes.add(len(ticks))
    # Chunk by chunk.
    assert len(sizes) >= 3

    damaged = bytearray(whole)
    damaged[len(whole) // 2] ^= 0xFF
    file.write_bytes(damaged)
    torsio.load(file)  # the readable part


def test_damaged_chunk_costs_no_other(knob: torsio.Knob, tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    with knob.record_to(file) as recording:
        for _ in range(4):
            knob.sleep(0.5)
            recording.put(lambda _: recording._writer.flush(), [None])
    whole = file.read_bytes()
    all_ticks = torsio.load(file).telemetry["tick"]
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert len(summary.chunk_indexes) >= 4
    for chunk in summary.chunk_indexes:
        damaged = bytearray(whole)
        damaged[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 0xFF
        file.write_bytes(damaged)
        loaded = torsio.load(file)
        assert not loaded.whole
        assert 0.6 * len(all_ticks) < len(loaded.telemetry) < len(all_ticks)
        assert np.isin(loaded.telemetry["tick"], all_ticks).all()


def test_program_that_is_killed_leaves_what_it_had(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    with subprocess.Popen(
        [sys.executable, "-c", TORSIO, "record", file, "--device", "emulated"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as process:
        # Until a second's samples have been written.
        size = 0
        deadline = time.monotonic() + 60
        while size < 6000 and time.monotonic() < deadline:
            time.sleep(0.1)
            size = file.stat().st_size if file.exists() else 0
        process.kill()
    recorded = torsio.load(file)
    assert not recorded.whole
    assert len(recorded.telemetry) > 100


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


def test_what_is_no_recording_is_named(tmp_path: Path) -> None:
    other = tmp_path / "notes.txt"
    other.write_text("hello")
    with pytest.raises(torsio.Error, match="is no recording of Torsio"):
        torsio.load(other)
    with pytest.raises(FileNotFoundError):
        torsio.load(tmp_path / "none.mcap")


@pytest.mark.parametrize("tick", [-1, 2**64, "a", None, [1]])
def test_sample_that_cannot_be_one_is_damage(tmp_path: Path, tick: object) -> None:
    file = tmp_path / "x.mcap"
    sample = dict.fromkeys(torsio.TELEMETRY_DTYPE.names or (), 0)
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("telemetry", "jsonschema", b"{}")
        channel = writer.register_channel("telemetry", "json", schema)
        writer.add_metadata("versions", {})
        writer.add_message(channel, 0, json.dumps({**sample, "tick": tick}).encode(), 0)
        writer.finish()
    with pytest.raises(torsio.Error, match=r"x\.mcap' is damaged: a message cannot be read"):
        torsio.load(file)


def _rewritten(file: Path, change: Callable[[str, dict[str, object]], object]) -> None:
    """Write a recording again, whole, with other messages."""
    with file.open("rb") as stream:
        reader = make_reader(stream)
        messages = [
            (channel.topic, json.loads(message.data), message.log_time)
            for _, channel, message in reader.iter_messages()
        ]
        metadata = list(reader.iter_metadata())
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("any", "jsonschema", b"{}")
        for one in metadata:
            writer.add_metadata(one.name, one.metadata)
        channels = {
            topic: writer.register_channel(topic, "json", schema) for topic, _, _ in messages
        }
        for topic, message, at in messages:
            change(topic, message)
            writer.add_message(channels[topic], at, json.dumps(message).encode(), at)
        writer.finish()


def test_field_that_is_not_known_is_left_out_and_one_that_is_missing_named(
    knob: torsio.Knob, tmp_path: Path
) -> None:
    file = tmp_path / "x.mcap"
    knob.update(law="calibrated")
    with knob.record_to(file):
        knob.sleep(1.0)
    before = torsio.load(file)
    assert before.energies
    _rewritten(file, lambda _, message: message.update(of_tomorrow=1))
    after = torsio.load(file)
    assert after.whole
    np.testing.assert_array_equal(after.telemetry, before.telemetry)
    assert after.energies == before.energies

    for topic, field in (("energies", "time_s"), ("telemetry", "angle_rad")):
        torn = tmp_path / f"{topic}.mcap"
        torn.write_bytes(file.read_bytes())
        _rewritten(torn, lambda of, row, t=topic, f=field: of == t and row.pop(f))  # type: ignore[misc]
        words = rf"was written by Torsio {torsio.__version__}, and a message lacks '{field}'"
        with pytest.raises(torsio.Error, match=words):
            torsio.load(torn)
        done = command("export", torn, tmp_path / "x.csv")
        assert done.returncode == 1
        assert not (tmp_path / "x.csv").exists()


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


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_place_where_no_table_can_be_is_named_as_it_was_given(
    knob: torsio.Knob, tmp_path: Path, ending: str
) -> None:
    file = tmp_path / "x.mcap"
    with knob.record_to(file):
        knob.sleep(0.1)
    table, folder = tmp_path / "none" / f"x.{ending}", tmp_path / f"folder.{ending}"
    folder.mkdir()
    of_folder = "denied" if sys.platform == "win32" else "Is a directory"
    for place, why in ((table, "No such file or directory"), (folder, of_folder)):
        done = command("export", file, place)
        assert done.returncode == 1
        assert done.stderr.startswith("torsio: error: ")
        assert why in done.stderr
        assert str(place) in done.stderr.replace("\n", "")
        assert ".part" not in done.stderr


def test_file_that_cannot_be_made_leaves_the_knob_as_it_was(
    knob: torsio.Knob, tmp_path: Path
) -> None:
    with pytest.raises(OSError, match="No such file"):
        knob.record_to(tmp_path / "no" / "folder.mcap")
    with knob.record_to(tmp_path / "x.mcap"):
        pass


def test_monitor_says_that_a_wall_is_rendered_as_it_was_asked(knob: torsio.Knob) -> None:
    knob.update(law="calibrated")
    shown = io.StringIO()
    Console(file=shown, width=120).print(monitor_table(knob, knob.record(0.1)))
    line = next(line for line in shown.getvalue().splitlines() if "stiffest now" in line)
    assert line.split(maxsplit=2)[2].strip() == "as asked"


def bomb(file: Path, chunks: int, message: bytes, compression: CompressionType) -> None:
    """Write chunks of 16 MiB each, which become very little."""
    with file.open("wb") as stream:
        writer = Writer(stream, chunk_size=1 << 24, compression=compression)
        writer.start()
        writer.add_metadata("versions", {"torsio": '"0.1.0"'})
        schema = writer.register_schema("torsio.events", "jsonschema", b"{}")
        channel = writer.register_channel("events", "json", schema)
        for _ in range(chunks):
            writer.add_message(channel, 0, message, 0)
        writer.finish()


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4])
def test_recording_that_would_fill_the_memory_is_refused(
    compression: CompressionType, tmp_path: Path
) -> None:
    file = tmp_path / "bomb.mcap"
    bomb(file, 6, b'{"kind": "' + b"x" * (1 << 24) + b'"}', compression)
    assert file.stat().st_size < 1_000_000
    with pytest.raises(torsio.Error, match=r"bomb\.mcap' would fill the memory"):
        torsio.load(file)


def test_size_that_a_chunk_claims_is_not_believed(tmp_path: Path) -> None:
    file = tmp_path / "claims.mcap"
    bomb(file, 1, b'{"kind": "mark"}', CompressionType.ZSTD)
    content = bytearray(file.read_bytes())
    begin = content.index(b"zstd") - 4 - 4 - 8  # before: CRC of the unpacked bytes, their size
    content[begin : begin + 8] = (8 << 30).to_bytes(8, "little")
    file.write_bytes(content)
    with pytest.raises(torsio.Error, match=f"unpacks to {8 << 30} bytes"):
        torsio.load(file)
    # Nor no size at all: what is packed says more.
    bomb(file, 6, b'{"kind": "' + b"x" * (1 << 24) + b'"}', CompressionType.ZSTD)
    said = re.compile(rb".{8}(.{4}\x04\0\0\0zstd)", re.DOTALL)
    file.write_bytes(said.sub(rb"\0\0\0\0\0\0\0\0\1", file.read_bytes(), count=6))
    with pytest.raises(torsio.Error, match="would fill the memory"):
        torsio.load(file)


def test_knob_at_rest_is_no_bomb(knob: torsio.Knob, tmp_path: Path) -> None:
    with knob.record_to(tmp_path / "rest.mcap"):
        knob.sleep(20.0)
    assert len(torsio.load(tmp_path / "rest.mcap").telemetry) >= 20_000


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


def test_recording_that_waits_for_a_reader_of_its_pipe_holds_up_no_other(
    knob: torsio.Knob, tmp_path: Path
) -> None:
    pipe, begun = tmp_path / "pipe", threading.Event()
    os.mkfifo(pipe)

    def begin() -> None:
        with torsio.open("emulated") as other, other.record_to(tmp_path / "x.mcap"):
            begun.set()

    waits = threading.Thread(target=lambda: knob.record_to(pipe), daemon=True)
    waits.start()
    threading.Thread(target=begin, daemon=True).start()
    is_begun = begun.wait(20.0)
    with pipe.open("rb"):
        waits.join()
        knob.close()
    assert is_begun


def test_two_recordings_do_not_share_a_file(knob: torsio.Knob, tmp_path: Path) -> None:
    file, link = tmp_path / "x.mcap", tmp_path / "link.mcap"
    link.symlink_to(file)
    with torsio.open("emulated") as other, knob.record_to(file):
        for path in (file, link):
            with pytest.raises(torsio.Error, match=r"another recording is being written to .*mcap"):
                other.record_to(path)
        knob.record(0.1)
    assert len(torsio.load(file).telemetry) >= 100
    with torsio.open("emulated") as other:
        other.record_to(file).close()


TWO = """
import sys, torsio
with torsio.open("emulated") as knob:
    for path in sys.stdin:
        try:
            with knob.record_to(path.strip()) as recording:
                recording.note("mine", of=sys.argv[1])
                print("begun", flush=True)
                sys.stdin.readline()
        except torsio.Error as error:
            print(error, flush=True)
            sys.stdin.readline()
        print(flush=True)
"""


def test_one_of_two_processes_that_begin_a_file_at_once_is_refused(tmp_path: Path) -> None:
    def say(text: str) -> list[str]:
        for to, _ in pipes:
            to.write(f"{text}\n")
            to.flush()
        return [said.readline() for _, said in pipes]

    both = [
        subprocess.Popen(
            [sys.executable, "-c", TWO, str(i)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )
        for i in range(2)
    ]  # fmt: skip
    pipes = [(one.stdin, one.stdout) for one in both if one.stdin and one.stdout]
    for i in range(200):
        file = tmp_path / f"{i % 150}.mcap"  # the last ones take an older one's place
        said = say(str(file))
        say("")
        assert said.count("begun\n") == 1, said
        assert any("another recording is being written" in one for one in said)
        loaded = torsio.load(file)
        assert loaded.whole
        assert [int(event["of"]) for event in loaded.events if event["kind"] == "mine"] == [
            said.index("begun\n")
        ]
    for one in both:
        one.communicate()


def test_claim_that_fails_anywhere_leaves_the_name_free(tmp_path: Path) -> None:
    # In a thread: what is raised while another error is handled stays with its thread.
    with ThreadPoolExecutor(1) as pool:
        pool.submit(fail_anywhere, tmp_path).result()


def fail_anywhere(tmp_path: Path) -> None:
    kept: list[BaseException] = []  # with what their frames have
    for at in itertools.count():
        injection = Injection(at, OSError)
        try:
            with injection.active(), Claim(tmp_path / "x.mcap") as claim:
                claim.take()
        except OSError as error:
            kept.append(error)
        with Claim(tmp_path / "x.mcap") as claim:
            claim.take()
        if injection.where is None:
            break
    assert len(kept) > 10


def test_child_forked_while_a_file_is_begun_may_begin_another(
    knob: torsio.Knob, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def begin(*given: Any) -> None:
        begun.set()
        may_end.wait()
        real(*given)

    real, begun, may_end = RecordingFile._begin, threading.Event(), threading.Event()
    monkeypatch.setattr(RecordingFile, "_begin", begin)
    thread = threading.Thread(target=knob.record_to, args=[tmp_path / "parent.mcap"])
    thread.start()
    begun.wait()
    if (child := os.fork()) == 0:
        try:
            signal.alarm(20)
            monkeypatch.undo()
            with torsio.open("emulated") as other:
                other.record_to(tmp_path / "child.mcap").close()
            os._exit(0)
        finally:
            os._exit(1)
    may_end.set()
    thread.join()
    assert os.waitpid(child, 0)[1] == 0
    assert torsio.load(tmp_path / "child.mcap").whole


def test_small_file_with_a_long_gap_is_not_replayed(tmp_path: Path) -> None:
    file = tmp_path / "gap.mcap"
    options = torsio.EmulatorOptions(log_inputs=False)
    with torsio.open("emulated", emulator=options) as knob, knob.record_to(file) as recording:
        knob.play(torsio.Spring(stiffness_nm_per_rad=0.1))
        knob.arm()
        later = knob.record(0.1).copy()
        knob.disarm()
        knob.stop_telemetry()
        knob.read(timeout_s=0.0)
        later["tick"] += np.uint64(400_000_000)
        later["time_s"] += 400_000.0
        recording.put(recording.write, [later])
    with pytest.raises(torsio.Error, match=r"400,\d+,\d+ ticks from \d+ samples"):
        torsio.replay(file)
    with pytest.raises(torsio.Error, match="more than an hour"):
        options_of(file, {})
