"""The script that makes the firmware's image: what it takes and refuses."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from tools import boards, uf2


def elf(address: int = 0x10000000, data: bytes = bytes(range(100)), machine: int = 40) -> bytes:
    """Make an ELF file with one segment, after the format's description."""
    ident = b"\x7fELF\x01\x01\x01".ljust(16, b"\0")
    header = struct.pack("<HHIIIIIHHHHHH", 2, machine, 1, address, 52, 0, 0, 52, 32, 1, 40, 0, 0)
    segment = struct.pack("<8I", 1, 84, address, address, len(data), len(data), 5, 4)
    return ident + header + segment + data


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
