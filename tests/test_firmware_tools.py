"""The script that makes the firmware's image: what it takes and refuses."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from tools import boards, uf2


def sdk(folder: Path, version: tuple[int, int, int] = (2, 1, 1)) -> Path:
    """Make what looks like an SDK."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = zip(("MAJOR", "MINOR", "REVISION"), version, strict=True)
    text = "# set(PICO_SDK_VERSION_MAJOR 9)\n"
    text += "".join(f"set(PICO_SDK_VERSION_{name} {number})\n" for name, number in lines)
    (folder / "pico_sdk_version.cmake").write_text(text, encoding="utf-8")
    driver = folder / "lib/tinyusb/src/portable/raspberrypi/rp2040/dcd_rp2040.c"
    driver.parent.mkdir(parents=True)
    driver.touch()
    (folder / "pico_sdk_init.cmake").touch()
    return folder


def elf(address: int = 0x10000000, data: bytes = bytes(range(100)), machine: int = 40) -> bytes:
    """Make an ELF file with one segment, after the format's description."""
    ident = b"\x7fELF\x01\x01\x01".ljust(16, b"\0")
    header = struct.pack("<HHIIIIIHHHHHH", 2, machine, 1, address, 52, 0, 0, 52, 32, 1, 40, 0, 0)
    segment = struct.pack("<8I", 1, 84, address, address, len(data), len(data), 5, 4)
    return ident + header + segment + data


def test_image_of_a_small_program_is_one_page() -> None:
    pages = uf2.read_elf(elf())
    assert pages == {0x10000000: bytes(range(100)).ljust(256, b"\0")}
    for chip in ("rp2040", "rp2350"):
        assert uf2.check(uf2.make(pages, chip), chip) == pages


BAD_ELF = {
    "empty": (b"", "not a 32-bit little-endian ELF file"),
    "text": (b"hello, world" * 10, "not a 32-bit little-endian ELF file"),
    "64 bits": (elf().replace(b"ELF\x01", b"ELF\x02", 1), "not a 32-bit little-endian ELF file"),
    "big endian": (elf().replace(b"ELF\x01\x01", b"ELF\x01\x02", 1), "not a 32-bit"),
    "for another processor": (elf(machine=62), "not for an Arm processor"),
    "below the flash": (elf(address=0x0FFFFFF0), "not in the flash"),
    "beyond the flash": (elf(address=0x10FFFFF0), "not in the flash"),
    "in the RAM": (elf(address=0x20000000), "not in the flash"),
    "header cut off": (elf()[:40], "not a 32-bit little-endian ELF file"),
    "program headers cut off": (elf()[:60], "cut off"),
    "data cut off": (elf()[:-1], "cut off"),
    "nothing to load": (elf(data=b""), "nothing to load"),
}


@pytest.mark.parametrize("case", BAD_ELF)
def test_bad_elf_file_makes_no_image(
    case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data, complaint = BAD_ELF[case]
    (tmp_path / "torsio-pico.elf").write_bytes(data)
    target = tmp_path / "torsio-pico.uf2"
    assert uf2.main([str(tmp_path / "torsio-pico.elf"), str(target)]) == 1
    assert complaint in capsys.readouterr().err
    assert not target.exists()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make a folder of boards, with one board and one folder without a board."""
    monkeypatch.setattr(boards, "FOLDER", tmp_path)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "board.cmake").write_text(
        "# A board.\nset(PICO_BOARD mine)\nset(TORSIO_CHIP rp2350)\n", encoding="utf-8"
    )
    (tmp_path / "rp2").mkdir()
    return tmp_path


def test_a_folder_is_all_that_the_tools_need_to_know_a_board(folder: Path) -> None:
    assert boards.chips() == {"mine": "rp2350"}
    source, target = folder / "torsio-mine.elf", folder / "torsio-mine.uf2"
    label = b"torsio firmware".ljust(44, b"\0")
    source.write_bytes(elf(data=bytes(300) + label))
    assert uf2.main([str(source), str(target)]) == 0
    pages = uf2.read_elf(source.read_bytes())
    assert uf2.check(target.read_bytes(), "rp2350") == uf2.seal(pages) != pages


@pytest.mark.parametrize(
    "labels",
    [b"", b"torsio firmware".ljust(44, b"\0") * 2, b"torsio firmware".ljust(40, b"\0") + b"odd!"],
)
def test_program_without_one_label_is_no_firmware(
    labels: bytes, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = folder / "torsio-mine.elf"
    source.write_bytes(elf(data=bytes(100) + labels))
    assert uf2.main([str(source), str(folder / "torsio-mine.uf2")]) == 1
    assert "label" in capsys.readouterr().err
