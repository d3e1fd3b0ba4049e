"""Formatters, linters, types, layers: the checks of ``./dev check``, and that they can fail."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tools import check, check_layers


@pytest.mark.parametrize("name", check.CHECKS)
def test_check_passes(name: str) -> None:
    passed, output = check.run(check.CHECKS[name]())
    if not passed:
        pytest.fail(output, pytrace=False)


@pytest.mark.parametrize("header", check.headers())
def test_header_compiles_alone(header: str) -> None:
    passed, output = check.run(check.compile_header(header))
    if not passed:
        pytest.fail(output, pytrace=False)


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("firmware/core/planted.hpp", '#include "device/device.hpp"'),
        ("firmware/core/planted.hpp", '#include "protocol/reports.hpp"'),
        ("firmware/core/planted.cpp", "#include <cmath>"),
        ("firmware/core/planted.cpp", "#include <vector>"),
        ("firmware/core/planted.cpp", "#include <stdio.h>"),
        ("firmware/protocol/planted.hpp", '#include "core/motion.hpp"'),
        ("firmware/device/planted.cpp", '#include "emulator/plant.hpp"'),
        ("firmware/device/planted.cpp", "#  include <string>"),
        ("firmware/device/planted.cpp", '#include "boards/reference.hpp"'),
        ("firmware/boards/board.hpp", "#include <hardware/gpio.h>"),
        ("firmware/boards/rp2/pins.hpp", "#include <string>"),
        ("firmware/usb/planted.cpp", '#include "emulator/plant.hpp"'),
        ("firmware/usb/planted.cpp", "#include <pico/stdlib.h>"),
        ("firmware/device/planted.cpp", "#include <tusb.h>"),
        ("emulator/planted.cpp", '#include "torsio/knob.hpp"'),
        ("emulator/planted.cpp", '#include "boards/reference.hpp"'),
        ("sdk/src/planted.cpp", '#include "boards/all.hpp"'),
        ("emulator/planted.cpp", '#include "usb/usb_device.hpp"'),
        ("emulator/usbip/planted.cpp", "#include <tusb.h>"),
        ("emulator/usbip/bus.cpp", "#include <sys/socket.h>"),
        ("firmware/somewhere/planted.cpp", ""),
        ("sdk/include/torsio/planted.hpp", '#include "protocol/reports.hpp"'),
        ("sdk/src/planted.cpp", '#include "emulator/plant.hpp"'),
        ("sdk/src/planted.cpp", "#include <hidapi.h>"),
        ("sdk/src/planted.cpp", "#include <hidapi/hidapi.h>"),
        ("sdk/src/emulated_transport.cpp", "#include <hidapi.h>"),
        ("sdk/src/hid_transport.cpp", '#include "emulator/plant.hpp"'),
        ("sdk/src/planted.cpp", "#include PLANTED"),
        ("bindings/python/torsio/planted.py", "from tests.python import wire"),
        ("examples/cpp/planted.cpp", '#include "emulator/plant.hpp"'),
        ("examples/game/planted.cpp", '#include "torsio/knob.hpp"'),
        ("examples/game/lock.cpp", "#include <SDL.h>"),
        ("examples/python/planted.py", "from torsio import _torsio"),
    ],
)
def test_layer_check_finds_a_planted_violation(tmp_path: Path, file: str, line: str) -> None:
    folders = {rule.folder.split("/")[0] for rule in check_layers.RULES}
    for folder in folders:
        if (check.TREE / folder).is_dir():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(check.TREE / folder, tmp_path / folder, ignore=ignored)
    before = check_layers.check(tmp_path)

    planted = tmp_path / file
    planted.parent.mkdir(parents=True, exist_ok=True)
    with planted.open("a", encoding="utf-8") as stream:
        stream.write(f"{line}\n")
    found = set(check_layers.check(tmp_path)) - set(before)
    assert len(found) == 1
    assert found.pop().startswith(f"{file}:")


def test_layer_check_names_file_and_line(tmp_path: Path) -> None:
    header = tmp_path / "firmware" / "core" / "motion.hpp"
    header.parent.mkdir(parents=True)
    header.write_text('#pragma once\n#include <array>\n#include "core/a.hpp"\n#include <heap>\n')
    assert check_layers.check(tmp_path) == [
        "firmware/core/motion.hpp:4: may not include <heap>: "
        "not in the layer's list of standard headers"
    ]
