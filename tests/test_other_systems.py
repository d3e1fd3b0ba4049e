"""The code for operating systems compiles for macOS and Windows.

`./dev macos` compiles the rest too, and `./dev windows` runs it.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tools import macos

TREE = Path(__file__).parent.parent
# Apple's 64-bit object files begin with four bytes and the number of the kind of processor,
# Microsoft's with that number alone.
SYSTEMS = {
    "aarch64-macos": ("APPLE", "cffaedfe0c000001"),
    "x86_64-macos": ("APPLE", "cffaedfe07000001"),
    "x86_64-windows-gnu": ("WIN32", "6486"),
}
FOLDERS = (
    *("sdk/src", "sdk/include", "emulator/include", "firmware"),
    "build/release/sdk/include",
)


def sources(system: str) -> list[str]:
    """Give what sdk/CMakeLists.txt takes for a system, and what calls it."""
    text = (TREE / "sdk/CMakeLists.txt").read_text(encoding="utf-8")
    (names,) = re.findall(rf"if\({system}\)\n  set\(system (.*)\)", text)
    return [*names.split(), "hid_transport"]


@pytest.mark.parametrize("target", SYSTEMS)
def test_what_is_of_the_system_compiles_there(tmp_path: Path, target: str) -> None:
    system, begin = SYSTEMS[target]
    lines = [f'#include "{TREE}/sdk/src/{name}.cpp"' for name in sources(system)]
    assert len(lines) == 5
    (tmp_path / "all.cpp").write_text("\n".join([*lines, ""]))
    result = subprocess.run(
        [
            *(sys.executable, "-m", "ziglang", "c++", "-target", target, "-std=c++20"),
            *(f"-I{TREE / folder}" for folder in FOLDERS),
            *("-isystem", macos.HIDAPI_HEADERS, "-c", "all.cpp", "-o", "all.o"),
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "all.o").read_bytes().startswith(bytes.fromhex(begin))
