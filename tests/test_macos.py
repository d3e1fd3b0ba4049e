"""What is of the operating system compiles for macOS; `./dev macos` compiles the rest too."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tools import macos

TREE = Path(__file__).parent.parent
# What sdk/CMakeLists.txt takes for macOS, and what calls it.
SOURCES = ("device_lock", "directory_watch_timed", "file_sync", "hid_files_other", "hid_transport")


@pytest.mark.parametrize(("machine", "number"), [("aarch64", "0c000001"), ("x86_64", "07000001")])
def test_what_is_of_the_system_compiles_for_macos(
    tmp_path: Path, machine: str, number: str
) -> None:
    assert all(name in (TREE / "sdk/CMakeLists.txt").read_text() for name in SOURCES)
    lines = [f'#include "{TREE}/sdk/src/{name}.cpp"' for name in SOURCES]
    (tmp_path / "all.cpp").write_text("\n".join([*lines, ""]))
    folders = (
        "sdk/src",
        "sdk/include",
        "emulator/include",
        "firmware",
        "build/release/sdk/include",
    )
    result = subprocess.run(
        [
            *(sys.executable, "-m", "ziglang", "c++", "-target", f"{machine}-macos", "-std=c++20"),
            *(f"-I{TREE / folder}" for folder in folders),
            *("-isystem", macos.HIDAPI_HEADERS, "-c", "all.cpp", "-o", "all.o"),
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    # Apple's 64-bit object files begin so, with the number of the kind of processor behind.
    assert (tmp_path / "all.o").read_bytes()[:8] == bytes.fromhex(f"cffaedfe{number}")
