"""The library's symbols and their names are as agreed."""

from __future__ import annotations

import ctypes
import os
import re
import subprocess
from pathlib import Path

import pytest

from tests.c import layouts
from tests.c.calling import HEADER, TREE, N, run

ABI = 1


def test_library_shows_exactly_what_the_header_declares(library: Path) -> None:
    shown = run("nm", "--dynamic", "--defined-only", "--with-symbol-versions", library).split("\n")
    symbols = {line.split()[2] for line in shown if " T " in line}
    assert {name.partition("@@")[2] for name in symbols} == {f"TORSIO_{ABI}"}
    assert {name.partition("@@")[0] for name in symbols} == set(HEADER.functions)
    others = [line for line in shown if line and " T " not in line and " A TORSIO_" not in line]
    assert others == []


def test_library_names_its_interface(library: Path) -> None:
    link = os.readlink(library)
    chain = [library.name, link, os.readlink(library.parent / link)]
    assert chain[:2] == ["libtorsio.so", f"libtorsio.so.{ABI}"]
    assert re.fullmatch(rf"libtorsio\.so\.{ABI}(\.\d+){{3}}", chain[2])
    assert f"[libtorsio.so.{ABI}]" in run("readelf", "--dynamic", library)


def _hold_against(header: str, library: Path, folder: Path) -> tuple[int, str]:
    """Hold the library against one that is compiled of another header, as libabigail sees both.

    The number is 0 if they are the same, and has bit 4 or 8 if not.
    """
    script = TREE / "build/release/sdk/c/symbols.map"
    (folder / "hollow.c").write_text(layouts.hollow(header), encoding="utf-8")
    other = folder / "hollow.so"
    run(
        "gcc", "-g", "-shared", "-fPIC", "-fvisibility=hidden", f"-Wl,--version-script={script}",
        f"-Wl,-soname,libtorsio.so.{ABI}", folder / "hollow.c", "-o", other,
    )  # fmt: skip
    result = subprocess.run(
        ("abidiff", other, library), stdout=subprocess.PIPE, text=True, check=False
    )
    assert not result.returncode & 3, result.stdout  # it could not do it
    return result.returncode, result.stdout


def test_interface_is_the_one_that_was_agreed_on() -> None:
    agreed = (TREE / "tests/c/agreed.txt").read_text(encoding="utf-8").strip()
    assert layouts.checksum() == agreed, (
        "the C interface has changed. If linked programs would break, raise TORSIO_ABI_VERSION in "
        "torsio_base.h, unless it has grown since the last release. Then run "
        f"python -m tests.c.layouts > tests/c/agreed.txt\n{layouts.changes()}"
    )


def test_library_is_as_its_header_says(library: Path, tmp_path: Path) -> None:
    """Functions, their parameters, and all members, in what the compilers wrote into both."""
    code, told = _hold_against(layouts.whole(), library, tmp_path)
    assert code == 0, told


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("double stiffness_nm_per_rad;", "float stiffness_nm_per_rad;"),
        ("double angle_rad;\n  int32_t side;", "int32_t side;\n  double angle_rad;"),
        ("TORSIO_API torsio_result torsio_knob_arm(torsio_knob* knob);", ""),
        (
            "torsio_knob_sleep(torsio_knob* knob, double",
            "torsio_knob_sleep(torsio_knob* knob, float",
        ),
    ],
    ids=["type", "order", "function", "parameter"],
)
def test_other_interface_is_seen(library: Path, tmp_path: Path, old: str, new: str) -> None:
    header = layouts.whole()
    assert old in header
    code, told = _hold_against(header.replace(old, new), library, tmp_path)
    assert code & 12, told


WITHOUT = {
    "Emulator.game",  # for the tests of drivers, in C++ and Python
    "Emulator.inputs",  # for recordings, which are Python's
    "Knob.tap",  # the same, and for pages that look on
    "Knob.feature",  # the same
}


def _methods(name: str, header: str) -> set[str]:
    """Give the names of a C++ class's public methods."""
    text = (TREE / f"sdk/include/torsio/{header}.hpp").read_text(encoding="utf-8")
    pattern = rf"^class TORSIO_EXPORT {name}\b[^;]*?{{(.*?)^(?: private:|}};)"
    (body,) = re.findall(pattern, text, re.S | re.M)
    return {*re.findall(r"^  (?!~)[\w\[\]:<>,&* ]*?\b(\w+)\(", body, re.M)} - {name}


def test_all_members_of_the_cpp_classes_have_a_twin() -> None:
    """Where the languages differ on purpose, a table says what C has instead."""
    instead = {
        "Knob.open": "torsio_knob_open",
        "Knob.events": "torsio_knob_next_event",
        "Knob.on_event": "torsio_knob_next_event",
        "Knob.configure": "torsio_knob_set_control_config",
        "Knob.update": "torsio_knob_set_control_config",
        "Knob.emulator": "torsio_emulator_advance",
        "Knob.disarm_to_close": "torsio_knob_close",
        "Emulator.set_hand": "torsio_emulator_set_torque_hand",
        "DeviceWatch.stop": "torsio_watch_free",
        "DeviceWatch.is_stopped": "torsio_watch_next",
    }
    for name, header, start in (
        ("Knob", "knob", "torsio_knob"),
        ("Emulator", "emulator", "torsio_emulator"),
        ("DeviceWatch", "hotplug", "torsio_watch"),
    ):
        for member in _methods(name, header):
            own = f"{name}.{member}"
            if own not in WITHOUT and own not in instead:
                assert f"{start}_{member}" in HEADER.functions, own
    assert set(instead.values()) <= set(HEADER.functions)


def test_names_of_results_are_those_of_the_header(lib: ctypes.CDLL) -> None:
    for number in range(13):
        name = lib.torsio_result_name(number).decode()
        assert N[name] == number
    assert lib.torsio_result_name(13) is None
    assert lib.torsio_result_name(-1) is None
    assert lib.torsio_state_name(-1) is None
    assert lib.torsio_state_name(4) is None
    version = re.search(
        r"VERSION ([\d.]+)", (TREE / "CMakeLists.txt").read_text().split("project(torsio")[1]
    )
    assert version
    assert lib.torsio_version().decode() == version[1]
    assert lib.torsio_abi_version() == ABI
