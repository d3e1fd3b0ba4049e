"""`torsio firmware`: what is in a file, and the way of new firmware onto a stand-in for a board."""

from __future__ import annotations

import dataclasses
import os
import shutil
import signal
import struct
import threading
import time
import zlib
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import torsio
from tools import uf2
from torsio import protocol
from torsio.apps.cli import app
from torsio.knob.firmware import ExaminedKnob, FirmwareUpdate

OURS = protocol.fingerprint()


def image(
    chip: str = "rp2350",
    board: bytes = b"pico2",
    version: tuple[int, int, int] = (0, 9, 7),
    fingerprint: int = OURS,
    marks: int = 1,
) -> bytes:
    """Make a file as the build does, of a program that says who it is at an odd place."""
    label = (
        b"torsio firmware\0" + struct.pack("<I3Bx", fingerprint, *version) + board.ljust(20, b"\0")
    )
    program = (bytes(range(256)) * 2 + b"odd" + label * marks).ljust(1024, b"\xee")
    pages = {0x10000000 + at: program[at : at + 256] for at in range(0, len(program), 256)}
    return uf2.make(uf2.seal(pages) if marks == 1 else pages, chip)


def patched(data: bytes, block: int, at: int, value: int) -> bytes:
    at += 512 * block
    return data[:at] + struct.pack("<I", value) + data[at + 4 :]


FLAGS, ADDRESS, SIZE, NUMBER, COUNT, FAMILY, LAST = 8, 12, 16, 20, 24, 28, 508
PICO = image("rp2040", b"pico")
BAD = {
    "empty": (b"", "has 0 bytes"),
    "cut off": (PICO[:-1], "cut off"),
    "text": (b"hello, world, " * 256, "no UF2 file"),
    "begin damaged": (patched(PICO, 2, 0, 0), "block 2 is damaged"),
    "end damaged": (patched(PICO, 3, LAST, 0), "block 3 is damaged"),
    "half a page": (patched(PICO, 1, SIZE, 128), "block 1 is not one page"),
    "beyond a page": (patched(PICO, 1, SIZE, 477), "block 1 is not one page"),
    "between pages": (patched(PICO, 1, ADDRESS, 0x10000180), "block 1 is not one page"),
    "no family": (patched(PICO, 0, FLAGS, 0), "does not say for which chip"),
    "another chip": (patched(PICO, 0, FAMILY, 0xADA52840), "another chip"),
    "RISC-V": (patched(image()[512:], 0, FAMILY, 0xE48BFF5A), "RISC-V"),
    "two chips": (PICO[:512] + image()[1024:], "mixes"),
    "last block missing": (PICO[:-512], "missing, doubled or out of order"),
    "first block missing": (PICO[512:], "missing, doubled or out of order"),
    "exchanged": (PICO[:512] + PICO[1024:1536] + PICO[512:1024] + PICO[1536:], "out of order"),
    "doubled": (PICO[:512] + PICO, "missing, doubled"),
    "a gap": (patched(PICO, 3, ADDRESS, 0x10000400), "block 3 goes to address 0x10000400"),
    "not from the begin": (patched(PICO, 0, ADDRESS, 0x10000100), "0x10000000 comes next"),
    "into the RAM": (patched(PICO, 0, ADDRESS, 0x20000000), "goes to address 0x20000000"),
    "not for the flash": (patched(PICO, 1, FLAGS, 0x2001), "goes to address"),
    "only the leading block": (image()[:512], "no chip in particular"),
    "not ours": (image(marks=0), "not Torsio's firmware"),
    "two marks": (image(marks=2), "more than once"),
    "board is no name": (image(board=b"\xff\xfe"), "damaged"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_file_is_told_in_a_sentence(case: str, tmp_path: Path) -> None:
    data, words = BAD[case]
    file = tmp_path / "bad.uf2"
    file.write_bytes(data)
    with pytest.raises(torsio.InvalidArgument, match=words) as told:
        torsio.read_firmware(file)
    assert str(told.value).startswith(f"{file}: ")
    result = CliRunner().invoke(app, ["firmware", "show", str(file)])
    assert result.exit_code == 1
    assert "torsio: error: " in result.output


def test_every_flipped_bit_of_what_would_run_is_told(tmp_path: Path) -> None:
    file = tmp_path / "flipped.uf2"
    for bit in range(0, 8 * 1024, 13):
        at, data = 512 * (bit // 2048) + 32 + bit // 8 % 256, bytearray(PICO)
        data[at] ^= 1 << bit % 8
        file.write_bytes(data)
        with pytest.raises(torsio.InvalidArgument, match=r"checksum is wrong|not Torsio's|damaged"):
            torsio.read_firmware(file)
    with pytest.raises(torsio.InvalidArgument, match="checksum is wrong"):
        torsio.update_firmware(file)
    assert "checksum is wrong" in CliRunner().invoke(app, ["firmware", "show", str(file)]).output


def test_checksum_stands_behind_the_label_and_is_that_of_all_else() -> None:
    program = b"".join(uf2.check(PICO, "rp2040").values())
    at = program.index(b"torsio firmware\0") + 40
    without = program[:at] + bytes(4) + program[at + 4 :]
    assert struct.unpack_from("<I", program, at) == (zlib.crc32(without),)


def test_endless_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(torsio.InvalidArgument, match="larger than any firmware"):
        torsio.read_firmware("/dev/zero")
    huge = tmp_path / "huge.uf2"
    with huge.open("wb") as file:
        file.truncate(2**40)
    with pytest.raises(torsio.InvalidArgument, match="larger than any firmware"):
        torsio.read_firmware(huge)


def test_file_says_for_which_board_it_is(tmp_path: Path) -> None:
    for name, data in {"pico2": image(), "pico": PICO}.items():
        file = tmp_path / f"{name}.uf2"
        file.write_bytes(data)
        found = torsio.read_firmware(file)
        assert (found.board, found.version, found.fingerprint) == (name, "0.9.7", OURS)
        assert found.chip == {"pico2": "rp2350", "pico": "rp2040"}[name]
        assert found.size == 1024
    assert "board  pico2" in CliRunner().invoke(
        app, ["firmware", "show", str(tmp_path / "pico2.uf2")]
    ).output  # fmt: skip


def test_file_whose_name_is_no_text_is_told(tmp_path: Path) -> None:
    file = tmp_path / os.fsdecode(b"b\xfcro.uf2")
    file.write_bytes(b"")
    with pytest.raises(torsio.InvalidArgument) as told:
        torsio.read_firmware(file)
    assert str(told.value).startswith(f"{file}: it has 0 bytes")


def test_what_cannot_be_read_is_told_with_its_reason(tmp_path: Path) -> None:
    with pytest.raises(torsio.Error, match=r"none\.uf2 cannot be read: No such file"):
        torsio.read_firmware(tmp_path / "none.uf2")
    with pytest.raises(torsio.Error, match="cannot be read: Is a directory"):
        torsio.read_firmware(tmp_path)


def test_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["firmware", "show", str(tmp_path / "none.uf2")])
    assert result.exit_code == 1
    assert "none.uf2" in result.output


# No board: a drive is a folder, and a copied file becomes the knob's firmware --------------------


class StandIn:
    """A knob that becomes a drive and a knob again; both are seen where the update looks."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.mount = root / "media/me/my knob"
        self.version, self.board, self.serial = "0.1.0", "pico2", "E66118604B7A3C2D"
        self.board_id, self.problem = "RP2350", ""
        self.error: Exception | None = None
        self.plugged, self.returns, self.mounts, self.takes = True, True, True, True
        self.owner: Any = "none"
        self.other_release = False
        self.loses_configuration, self.twin = False, False
        self.started: list[str] = []
        self.taken = b""
        self.taking = threading.Thread(target=self._take, daemon=True)
        self.knob = torsio.open("emulated")
        (root / "proc").mkdir()
        (root / "proc/mounts").write_text("proc /proc proc rw 0 0\n", encoding="ascii")

    # As the library does with hardware.

    def list_devices(self) -> list[torsio.ListedDevice]:
        emulated = torsio.list_devices()[-1:]
        if not self.plugged:
            return emulated
        mine = torsio.ListedDevice(
            path="/dev/hidraw7", serial=self.serial, product="Torsio knob", board=self.board,
            transport="hid", problem=self.problem,
        )  # fmt: skip
        twins = [dataclasses.replace(mine, path="/dev/hidraw8")] if self.twin else []
        return [mine, *twins, *emulated]

    def examine(self, path: str) -> ExaminedKnob | None:
        assert path == "/dev/hidraw7"
        if self.error is not None:
            raise self.error
        if self.other_release:
            return None
        info = dataclasses.replace(
            self.knob.info, board=self.board, firmware_version=self.version, serial=self.serial
        )
        return ExaminedKnob(info, self.owner, torsio.dump_config(self.knob))

    def start_bootloader(self, path: str) -> None:
        self.started.append(path)
        self.plugged = False
        self.appear()

    def appear(self) -> None:
        """Show the drive, and take what comes."""
        link = self.root / "dev/disk/by-label" / self.board_id
        link.parent.mkdir(parents=True, exist_ok=True)
        link.touch()
        if self.mounts:
            self.mount.mkdir(parents=True)
            (self.mount / "INFO_UF2.TXT").write_text(
                f"UF2 Bootloader v1.0\r\nModel: Raspberry Pi\r\nBoard-ID: {self.board_id}\r\n"
            )
            (self.root / "proc/mounts").write_text(
                "/dev/sda1 /media/me/my\\040knob vfat rw 0 0\n", encoding="ascii"
            )
            self.taking.start()

    def _take(self) -> None:
        # A boot loader starts the program once all blocks have come.
        copied = self.mount / "torsio.uf2"
        data = b""
        for _ in range(2000):
            # Not of /dev/full, which has no end.
            data = copied.read_bytes() if copied.is_file() else b""
            if data and len(data) == 512 * (1 + struct.unpack_from("<I", data, 512 + COUNT)[0]):
                break
            time.sleep(0.005)
        else:
            return  # nothing was copied, and the test is over
        self.taken = data
        time.sleep(0.02)
        (self.root / "proc/mounts").write_text("", encoding="ascii")
        shutil.rmtree(self.mount)
        if self.takes:
            at = data.index(b"torsio firmware") - 32  # in the third block, behind its header
            at += 32
            self.version = ".".join(map(str, data[at + 20 : at + 23]))
        self.other_release = False
        if self.loses_configuration:
            self.knob.load_defaults()
        self.plugged = self.returns


@pytest.fixture
def board(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[StandIn]:
    (tmp_path / "system").mkdir()
    board = StandIn(tmp_path / "system")
    monkeypatch.chdir(tmp_path)
    yield board
    board.knob.close()


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "torsio-pico2.uf2"
    path.write_bytes(image())
    return path


def do(board: StandIn, file: Path, selector: str = "", **options: Any) -> FirmwareUpdate:
    return torsio.update_firmware(
        file, selector or None, host=board, **{"timeout_s": 10.0} | options
    )


def test_update_disarms_copies_and_sees_the_new_version_run(board: StandIn, file: Path) -> None:
    board.knob.update(beta=0.25)
    steps: list[str] = []
    done = do(board, file, board.serial, say=steps.append)
    assert done.before is not None
    assert (done.before.firmware_version, done.after.firmware_version) == ("0.1.0", "0.9.7")
    assert done.kept is True
    assert board.started == ["/dev/hidraw7"]
    for word in ("boot loader", "drive", "copying", "waiting for the knob"):
        assert any(word in step for step in steps)


def test_configuration_that_is_not_kept_is_handed_back(board: StandIn, file: Path) -> None:
    board.knob.update(beta=0.25)
    board.loses_configuration = True
    done = do(board, file)
    assert done.kept is False
    torsio.load_config(board.knob, done.configuration)
    assert board.knob.control_config().beta == 0.25


def test_knob_of_another_release_is_updated_and_its_owner_warned(
    board: StandIn, file: Path
) -> None:
    board.other_release = True
    plan = torsio.prepare_update(file, timeout_s=10.0, host=board)
    assert plan.loses_configuration
    assert "of another release" in str(plan)
    done = torsio.carry_out(plan)
    assert (done.before, done.kept, done.configuration) == (None, None, "")


def test_board_that_waits_already_gets_its_first_firmware(board: StandIn, file: Path) -> None:
    board.plugged = False
    board.appear()
    done = do(board, file)
    assert done.after.firmware_version == "0.9.7"
    assert board.started == []


def test_drive_that_the_user_names_is_taken(board: StandIn, file: Path) -> None:
    assert do(board, file, drive=board.mount).kept is True


def test_drive_that_nobody_mounts_is_told_with_the_command(board: StandIn, file: Path) -> None:
    board.mounts = False
    said: list[str] = []
    with pytest.raises(torsio.Timeout, match=r"udisksctl mount -b /dev/disk/by-label/RP2350"):
        do(board, file, timeout_s=0.5, say=said.append)
    assert any("udisksctl mount" in text for text in said)


def test_drive_that_does_not_come_is_told(board: StandIn, file: Path) -> None:
    board.mounts, board.board_id = False, "none"
    with pytest.raises(torsio.Timeout, match=r"did not appear within 0\.3 s"):
        do(board, file, timeout_s=0.3)


def test_drive_of_another_chip_gets_nothing(board: StandIn, file: Path) -> None:
    board.board_id = "RPI-RP2"
    with pytest.raises(torsio.Timeout, match="a drive RP2350"):
        do(board, file, timeout_s=0.3)
    with pytest.raises(torsio.InvalidArgument, match="nothing was copied"):
        do(board, file, drive=board.mount)
    assert not (board.mount / "torsio.uf2").exists()


def test_knob_that_does_not_come_back_is_told(board: StandIn, file: Path) -> None:
    board.returns = False
    with pytest.raises(torsio.Timeout, match="no knob runs it"):
        do(board, file, timeout_s=0.5)


def test_knob_that_still_runs_the_old_firmware_is_told(board: StandIn, file: Path) -> None:
    board.takes = False
    with pytest.raises(torsio.Error, match=r"runs firmware 0\.1\.0 .*not 0\.9\.7"):
        do(board, file)


def test_disk_that_is_full_is_told(board: StandIn, file: Path) -> None:
    def say(step: str) -> None:
        if step.startswith("copying"):
            (board.mount / "torsio.uf2").symlink_to("/dev/full")

    with pytest.raises(torsio.Error, match=r"No space left.*still waits"):
        do(board, file, say=say)


def test_two_drives_are_not_guessed_between(board: StandIn, file: Path) -> None:
    board.plugged = False
    board.appear()
    shutil.copytree(board.mount, board.root / "media/you")
    mounts = board.root / "proc/mounts"
    mounts.write_text(mounts.read_text() + "/dev/sdb1 /media/you vfat rw 0 0\n")
    with pytest.raises(torsio.Error, match=r"more than one board waits.*my knob, .*/media/you;"):
        do(board, file)
    assert not (board.mount / "torsio.uf2").exists()


def test_file_that_changes_after_consent_is_not_copied(board: StandIn, file: Path) -> None:
    plan = torsio.prepare_update(file, host=board)
    file.write_bytes(image(version=(0, 9, 8)))
    with pytest.raises(torsio.InvalidArgument, match="changed since"):
        torsio.carry_out(plan)
    assert board.started == []


@pytest.mark.parametrize("timeout_s", [0.0, -1.0, float("nan"), float("inf")])
def test_timeout_that_is_none_is_refused_first(
    board: StandIn, file: Path, timeout_s: float
) -> None:
    with pytest.raises(torsio.InvalidArgument, match=r"timeout_s is .*, allowed are above 0"):
        do(board, file, timeout_s=timeout_s)
    assert board.started == []


def test_what_is_raised_while_it_tells_its_steps_ends_it(board: StandIn, file: Path) -> None:
    def say(step: str) -> None:
        if "waiting" in step:
            raise KeyError(step)

    with pytest.raises(KeyError, match="drive"):
        do(board, file, say=say)


def test_interrupt_ends_the_wait(board: StandIn, file: Path) -> None:
    board.mounts, board.board_id = False, "none"

    def say(step: str) -> None:
        if "waiting" in step:
            threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()

    with pytest.raises(KeyboardInterrupt):
        do(board, file, timeout_s=60.0, say=say)


REFUSALS: dict[str, tuple[dict[str, Any], bytes, str, str]] = {
    "another board": ({"board": "pico"}, image(), "", "take torsio-pico.uf2"),
    "another release": (
        {}, image(fingerprint=OURS ^ 1), "",
        f"0x{OURS ^ 1:08x}, this library 0x{OURS:08x}: .*same release",
    ),
    "virtual knob": ({"board": "emulated"}, image(), "", "no firmware of its own"),
    "a game": ({"owner": "game"}, image(), "", "a game has the knob"),
    "another program": (
        {"error": torsio.DeviceBusy("somebody has opened it")}, image(), "", "opened it",
    ),
    "too many knobs": (
        {"twin": True}, image(), "", "name one: /dev/hidraw7, /dev/hidraw8",
    ),
    "no such knob": ({}, image(), "TS-1", "there is no knob"),
    "emulated": ({}, image(), "emulated", "no firmware of its own"),
    "named emulated": ({}, image(), "emulated:x", "no firmware of its own"),
    "a board that cannot be asked": (
        {"other_release": True, "board": "pico"}, image(), "", "take torsio-pico.uf2",
    ),
    "nothing plugged in": ({"plugged": False}, image(), "", "BOOTSEL"),
    "not whole": ({}, image()[:-512], "", "missing"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSALS)
def test_what_cannot_be_is_refused_before_anything_happens(
    case: str, board: StandIn, file: Path
) -> None:
    values, data, selector, words = REFUSALS[case]
    file.write_bytes(data)
    for name, value in values.items():
        setattr(board, name, value)
    with pytest.raises(torsio.Error, match=words):
        do(board, file, selector)
    assert board.started == []


@pytest.mark.parametrize("what", ["a pipe", "an endless file", "a folder", "a huge file"])
def test_drive_with_such_a_file_that_no_boot_loader_has_is_passed_over(
    what: str, board: StandIn, file: Path
) -> None:
    board.mounts = False
    board.appear()
    board.mount.mkdir(parents=True)
    info = board.mount / "INFO_UF2.TXT"
    if what == "a pipe":
        os.mkfifo(info)
    elif what == "an endless file":
        info.symlink_to("/dev/zero")
    elif what == "a folder":
        info.mkdir()
    else:
        info.write_text("\n" * 5000 + f"Board-ID: {board.board_id}\n")
    (board.root / "proc/mounts").write_text("/dev/sda1 /media/me/my\\040knob vfat rw 0 0\n")
    with pytest.raises(torsio.Timeout, match="mount"):
        do(board, file, timeout_s=0.3)


def test_second_board_in_its_boot_loader_is_not_guessed_about(board: StandIn, file: Path) -> None:
    board.appear()
    with pytest.raises(torsio.Error, match="another board waits"):
        do(board, file)
    assert board.started == []


def test_command_asks_first_and_tells_what_it_did(
    board: StandIn, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(torsio, "prepare_update", partial(torsio.prepare_update, host=board))
    asked = CliRunner().invoke(app, ["firmware", "update", str(file)])
    assert asked.exit_code == 1
    assert "--yes" in asked.output
    assert board.started == []
    board.knob.update(beta=0.25)
    board.loses_configuration = True
    done = CliRunner().invoke(app, ["firmware", "update", str(file), "--yes"])
    assert done.exit_code == 0, done.output
    assert "runs firmware 0.9.7 of board pico2" in done.output
    kept = Path(f"torsio-{board.serial}.json")
    assert str(kept) in done.output
    assert '"beta": 0.25' in kept.read_text(encoding="utf-8")


def test_emulated_knob_has_no_boot_loader() -> None:
    with pytest.raises(torsio.Refused, match="unsupported"):
        torsio.start_bootloader("emulated")
    with pytest.raises(torsio.DeviceNotFound):
        torsio.start_bootloader("TS-9999")
