"""The files of recordings: torn, damaged and hostile ones, and which recording has a name."""

from __future__ import annotations

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

import torsio
from tests.faults.lines import Injection
from tests.python.processes import TORSIO, command
from torsio.recordings.stream import Claim
from torsio.recordings.writing import FileWriter
from torsio.trading.sources import options_of


@pytest.fixture
def knob() -> Iterator[torsio.Knob]:
    with torsio.open("emulated") as knob:
        yield knob


def test_torn_recording_gives_all_but_its_end(knob: torsio.Knob, tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    with knob.record_to(file) as recording:
        began = file.stat().st_size
        for _ in range(3):
            knob.sleep(0.5)
            # As after a second; this knob's clock runs faster than the wall's.
            recording.put(lambda _: recording.writer._mcap.flush(), [None])
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


def test_damaged_chunk_costs_no_other(knob: torsio.Knob, tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    with knob.record_to(file) as recording:
        for _ in range(4):
            knob.sleep(0.5)
            recording.put(lambda _: recording.writer._mcap.flush(), [None])
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

    real, begun, may_end = FileWriter._begin, threading.Event(), threading.Event()
    monkeypatch.setattr(FileWriter, "_begin", begin)
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
        recording.put(recording.writer.write, [later])
    with pytest.raises(torsio.Error, match=r"400,\d+,\d+ ticks from \d+ samples"):
        torsio.replay(file)
    with pytest.raises(torsio.Error, match="more than an hour"):
        options_of(file, {})
