"""The scripts that find the firmware's sources and make its image: what they take and refuse."""

from __future__ import annotations

import shutil
import struct
from pathlib import Path

import pytest

from tools import apt, boards, firmware_sources, uf2

KEY = "/usr/share/keyrings/example.gpg"

SOURCES = {
    "deb822": (
        f"Types: deb deb-src\n# a comment\nURIs: http://a.example/debian http://b.example/debian\n"
        f"Suites: bookworm bookworm-updates\nComponents: main contrib\nSigned-By: {KEY}\n",
        apt.Archive("http://a.example/debian", KEY),
    ),
    "deb822 of Ubuntu, security first": (
        "Types: deb\nURIs: http://security.ubuntu.example/ubuntu\nSuites: noble-security\n"
        f"Components: main universe\nSigned-By: {KEY}\n\n"
        "Types: deb\nURIs: http://archive.ubuntu.example/ubuntu\nSuites: noble noble-updates\n"
        f"Components: main universe\nSigned-By: {KEY}\n",
        apt.Archive("http://archive.ubuntu.example/ubuntu", KEY),
    ),
    "one line": (
        "deb http://a.example/debian bookworm main\n",
        apt.Archive("http://a.example/debian", ""),
    ),
    "one line with options": (
        f"# deb http://old.example/debian bullseye main\n"
        f"deb [arch=amd64 signed-by={KEY}] http://a.example/debian bookworm main contrib\n",
        apt.Archive("http://a.example/debian", KEY),
    ),
    "one line, security and sources first": (
        "deb-src http://a.example/debian bookworm main\n"
        "deb http://security.example/debian-security bookworm-security main\n"
        "deb http://a.example/debian bookworm main\n",
        apt.Archive("http://a.example/debian", ""),
    ),
    "only security": (
        "Types: deb\nURIs: http://a.example/debian\nSuites: bookworm-security\nComponents: main\n",
        None,
    ),
    "only sources": (
        "Types: deb-src\nURIs: http://a.example/debian\nSuites: bookworm\nComponents: main\n",
        None,
    ),
    "nothing": ("", None),
}


@pytest.mark.parametrize("case", SOURCES)
def test_archive_is_found_in_apts_own_files(case: str) -> None:
    text, archive = SOURCES[case]
    assert apt.parse_sources(text) == archive


def test_security_archive_of_debian_stands_beside_the_main_one() -> None:
    for uri in ("http://a.example/debian", "http://a.example/debian/"):
        security = apt.Archive(uri, KEY).security
        assert security == apt.Archive("http://a.example/debian-security", KEY)


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


def test_users_sdk_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PICO_SDK_PATH", str(sdk(tmp_path / "mine")))
    sdk(tmp_path / "fetched" / firmware_sources.SDK)
    assert firmware_sources.locate(tmp_path / "fetched") == tmp_path / "mine"


def test_users_sdk_without_tinyusb_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.rmtree(sdk(tmp_path / "mine") / "lib")
    monkeypatch.setenv("PICO_SDK_PATH", str(tmp_path / "mine"))
    with pytest.raises(RuntimeError, match="has no lib/tinyusb"):
        firmware_sources.locate(tmp_path / "fetched")


@pytest.mark.parametrize("version", [(2, 1, 0), (1, 5, 1), (2, 0, 9)])
def test_users_sdk_that_is_too_old_is_refused(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    version: tuple[int, int, int],
) -> None:
    monkeypatch.setenv("PICO_SDK_PATH", str(sdk(tmp_path / "mine", version)))
    found = ".".join(str(part) for part in version)
    with pytest.raises(RuntimeError, match=f"is version {found}, and 2.1.1 is needed"):
        firmware_sources.locate(tmp_path / "fetched")


@pytest.mark.parametrize("version", [(2, 1, 1), (2, 2, 0), (3, 0, 0)])
def test_newer_sdk_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, version: tuple[int, int, int]
) -> None:
    mine = sdk(tmp_path / "mine", version)
    monkeypatch.setenv("PICO_SDK_PATH", str(mine))
    assert firmware_sources.locate(tmp_path / "fetched") == mine


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
    """Make a folder of boards, with one board in it and one folder that is none."""
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


def test_firmware_of_no_board_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = folder / "torsio-yours.elf"
    source.write_bytes(elf())
    assert uf2.main([str(source), str(folder / "torsio-yours.uf2")]) == 1
    assert "no board 'yours'; there are mine" in capsys.readouterr().err


def test_board_without_a_chip_is_refused(folder: Path) -> None:
    (folder / "mine" / "board.cmake").write_text("set(PICO_BOARD mine)\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"board\.cmake: no line set\(TORSIO_CHIP"):
        boards.chips()


def image(chip: str = "rp2040") -> bytes:
    """Make an image of three pages."""
    return uf2.make(uf2.read_elf(elf(data=bytes(700))), chip)


def patched(data: bytes, at: int, value: int) -> bytes:
    """Write a 32-bit word into a copy."""
    return data[:at] + struct.pack("<I", value) + data[at + 4 :]


BAD_UF2 = {
    "empty": (b"", "not a whole number of blocks"),
    "cut off": (image()[:-1], "not a whole number of blocks"),
    "a block missing": (image()[:-512], "counted as"),
    "blocks exchanged": (image()[512:1024] + image()[:512] + image()[1024:], "counted as"),
    "first magic": (patched(image(), 0, 0), "magic"),
    "second magic": (patched(image(), 4, 0), "magic"),
    "last magic": (patched(image(), 508, 0), "magic"),
    "half a page": (patched(image(), 16, 128), "not one page"),
    "between two pages": (patched(image(), 12, 0x10000080), "not one page"),
    "outside the flash": (patched(image(), 12, 0x20000000), "address"),
    "the same page twice": (patched(image(), 512 + 12, 0x10000000), "address"),
    "without a family": (patched(image(), 8, 0), "not for rp2040"),
    "for the other chip": (image("rp2350")[512:], "not for rp2040"),
}


@pytest.mark.parametrize("case", BAD_UF2)
def test_bad_image_is_refused(case: str) -> None:
    data, complaint = BAD_UF2[case]
    with pytest.raises(uf2.FormatError, match=complaint):
        uf2.check(data, "rp2040")


def test_image_for_an_rp2350_needs_its_leading_block() -> None:
    with pytest.raises(uf2.FormatError, match="leading block"):
        uf2.check(image("rp2350")[512:], "rp2350")
