"""Whatever lies where a file is read: it is read, or told in a sentence, and nothing is changed."""

from __future__ import annotations

import json
import os
import random
import re
import socket
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import torsio
from tests.python.test_firmware import image
from torsio.apps.commands import games, settings
from torsio.calibration import keeping
from torsio.common import whole_file
from torsio.errors import Error
from torsio.trading.runs import Kept
from torsio.trading.sources import configuration_of

SERVER = Path(torsio.__file__).parent / "bin/torsio_virtual_knob"


@dataclass
class Reader:
    """One that reads a file.

    Attributes
    ----------
    valid
        What it reads.
    read
        Reads it; gives something to compare, or raises.
    is_sealed
        A sum over the bytes tells that one was changed.
    takes
        What it may read too.
    """

    path: Path
    valid: bytes
    read: Callable[[], Any]
    is_sealed: bool = False
    takes: tuple[str, ...] = ()


Make = Callable[[Path, pytest.MonkeyPatch], Reader]


def loaded(module: ModuleType, path: Path, load: Callable[[], None], monkeypatch: Any) -> Reader:
    """Make a reader of a command that configures a knob."""
    knob = torsio.open("emulated")

    @contextmanager
    def opened(*_: object, changes: bool) -> Iterator[torsio.Knob]:
        yield knob

    def read() -> None:
        before = torsio.dump_config(knob)
        try:
            load()
        except BaseException:
            assert torsio.dump_config(knob) == before
            raise
        torsio.load_config(knob, before)

    monkeypatch.setattr(module, "opened", opened)
    return Reader(path, torsio.dump_config(knob).encode(), read, takes=("utf-16", "utf-32"))


def configuration(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Reader:
    path = folder / "knob.json"
    return loaded(settings, path, lambda: settings.config_load_command(path), monkeypatch)


def profile(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Reader:
    monkeypatch.setattr(games, "user_folder", lambda _: folder)
    path = folder / "mine.json"
    return loaded(games, path, lambda: games.profile_load_command("mine"), monkeypatch)


def calibration(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Reader:
    path = folder / "KNOB.json"
    monkeypatch.setattr(keeping, "place_of", lambda _: path)
    quantity = {"value": 1e-5, "standard_uncertainty": 1e-7}
    valid = json.dumps({"quantities": {"inertia": quantity}, "conditions": {"serial": "KNOB"}})
    takes = ("nowhere", "nothing", "utf-16", "utf-32")  # nobody has calibrated it
    return Reader(path, valid.encode(), lambda: keeping.kept("KNOB"), takes=takes)


def recording(folder: Path, _: pytest.MonkeyPatch) -> Reader:
    path = folder / "x.mcap"
    with torsio.open("emulated") as knob, knob.record_to(path):
        knob.sleep(0.02)

    def read() -> bool:
        if not torsio.load(path).whole:
            raise Error(f"{path} is torn")  # as the commands tell it
        return True

    return Reader(path, path.read_bytes(), read, takes=("latin-1",))


def firmware(folder: Path, _: pytest.MonkeyPatch) -> Reader:
    path = folder / "x.uf2"
    return Reader(path, image(), lambda: torsio.read_firmware(path), is_sealed=True)


def serve(*options: str | Path) -> None:
    """Start a server; with options that it takes it fails where it should listen."""
    command = [SERVER, *options, "--address", "192.0.2.1"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60.0, check=False)
    assert done.returncode in (1, 2), done
    if "192.0.2.1" not in done.stderr:
        raise Error(done.stderr)


def hand(folder: Path, _: pytest.MonkeyPatch) -> Reader:
    path = folder / "hand.txt"
    valid = b"torque_nm\n0.0 0.0\n0.5 0.05  # push\n0.5 0.0\n"
    takes = ("cut off", "latin-1")
    return Reader(path, valid, lambda: serve("--hand", f"scripted:{path}"), takes=takes)


def storage(folder: Path, _: pytest.MonkeyPatch) -> Reader:
    path = folder / "flash"
    takes = ("flipped", "null for", "nothing", "nowhere")  # an empty slot, a file that is to be
    return Reader(path, b"\xff" * 1024, lambda: serve("--storage", path), takes=takes)


def trade_config(folder: Path, _: pytest.MonkeyPatch) -> Reader:
    path = folder / "knob.json"
    with torsio.open("emulated") as knob:
        valid = torsio.dump_config(knob).encode()
    return Reader(path, valid, lambda: configuration_of(path), takes=("utf-16", "utf-32"))


def trade_kept(folder: Path, _: pytest.MonkeyPatch) -> Reader:
    path = folder / "kept.json"
    Kept(path).get("x", lambda: {"cpu_s": 1.0})

    def read() -> Any:
        return Kept(path).get("x", lambda: pytest.fail("it was kept"))

    valid = path.read_bytes()
    assert read() == {"cpu_s": 1.0}
    # A line that is torn is made again; so is all where there is no file yet.
    takes = ("cut off", "null for", "nothing", "nowhere", "/dev/null")
    return Reader(path, valid, lambda: bool(Kept(path)), takes=takes)


READERS: dict[str, Make] = {
    made.__name__: made
    for made in (
        *(configuration, profile, calibration, recording, firmware, hand, storage),
        *(trade_config, trade_kept),
    )
}


def contents(valid: bytes) -> Iterator[tuple[str, bytes]]:
    """Yield what may lie there instead, the same each time."""
    chance = random.Random(33)
    for _ in range(12):
        bit = chance.randrange(8 * len(valid))
        flipped = bytearray(valid)
        flipped[bit // 8] ^= 1 << bit % 8
        yield f"bit {bit} flipped", bytes(flipped)
    for _ in range(4):
        size = chance.randrange(len(valid))
        yield f"cut off at {size}", valid[:size]
    text = valid.decode(errors="replace")
    for encoding in ("utf-8-sig", "utf-16", "utf-32"):
        yield encoding, text.encode(encoding)
    yield "latin-1", valid + "ä".encode("latin-1")
    yield "null for numbers", re.sub(rb"-?\b[0-9][0-9.e-]*", b"null", valid)
    yield "zeros", bytes(5000)
    yield "anything", chance.randbytes(5000)
    for bomb in ("[" * 200_000, '{"a":' * 100_000, "1" * 200_000, "1e999999999", "-", "NaN"):
        yield f"{bomb[:20]}... {len(bomb)} long", bomb.encode()


def places(path: Path) -> Iterator[str]:
    """Put what is no file where one should be."""
    yield "nothing"
    for target in ("/dev/zero", "/dev/null", str(path.with_name("nowhere"))):
        path.symlink_to(target)
        yield target
        path.unlink()
    path.mkdir()
    yield "a folder"
    path.rmdir()
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(path))
        yield "a socket"
    path.unlink()
    os.mkfifo(path)
    with subprocess.Popen(["sh", "-c", 'exec cat /dev/zero > "$0"', path]) as feeder:
        yield "an endless pipe"
        feeder.kill()
    path.unlink()


@pytest.mark.parametrize("name", READERS)
def test_bad_file_is_told_in_a_sentence_and_changes_nothing(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    check(READERS[name](tmp_path, monkeypatch), monkeypatch)


def check(reader: Reader, monkeypatch: pytest.MonkeyPatch) -> None:
    """Put what may lie there in the place of what is read."""
    monkeypatch.setattr(whole_file, "_MOST_BYTES", 1 << 20)
    reader.path.write_bytes(reader.valid)
    good = reader.read()

    def told(what: str) -> str:
        """Read what is there; give the sentence, or nothing if it was taken."""
        try:
            read = reader.read()
        except (Error, OSError) as error:
            said = f"{what}: {error}"
            assert reader.path.name in said, said
            assert len(said) < 500, said
            assert "\0" not in said
            assert "Traceback" not in said
            return said
        assert not reader.is_sealed or read == good, what
        return ""

    takes = ("flipped", "utf-8-sig", *reader.takes)
    for what, content in contents(reader.valid):
        reader.path.write_bytes(content)
        assert told(what) or any(word in what for word in takes), what
        assert reader.path.read_bytes() == content
    reader.path.unlink()
    for what in places(reader.path):
        assert told(what) or any(word in what for word in takes), what


def test_file_that_is_just_small_enough_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(whole_file, "_MOST_BYTES", 1 << 20)
    file = tmp_path / "x"
    file.write_bytes(bytes(1 << 20))
    assert len(whole_file.content(file)) == 1 << 20
    file.write_bytes(bytes((1 << 20) + 1))
    with pytest.raises(OSError, match="more than 1 MiB"):
        whole_file.content(file)
