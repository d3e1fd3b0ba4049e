"""Formatters, linters, types, layers: the checks of ``./dev check``, and that they can fail."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

from tools import check, check_layers


@pytest.mark.parametrize("name", sorted(check.CHECKS.keys() - {"headers", "prose"}))
def test_check_passes(name: str) -> None:
    # `./dev check` and `.ci/slow` take the types of the tests too, which doubles the time.
    command = [word for word in check.CHECKS[name]() if (name, word) != ("mypy", "tests")]
    passed, output = check.run(command)
    if not passed:
        pytest.fail(output, pytrace=False)


@dataclass(frozen=True)
class LayeredTree:
    """A copy of all folders that have rules."""

    path: Path
    violations: set[str]


@pytest.fixture(scope="module")
def layered(tmp_path_factory: pytest.TempPathFactory) -> LayeredTree:
    """Give a tree in which a line is planted, and taken out again."""
    path = tmp_path_factory.mktemp("layered")
    for folder in {rule.folder.split("/")[0] for rule in check_layers.RULES}:
        if (check.TREE / folder).is_dir():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(check.TREE / folder, path / folder, ignore=ignored)
    return LayeredTree(path, set(check_layers.check(path)))


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("firmware/core/planted.hpp", '#include "protocol/reports.hpp"'),
        ("firmware/core/planted.cpp", "#include <vector>"),
        ("firmware/device/dial/planted.cpp", '#include "device/game/forces.hpp"'),
        ("firmware/boards/board.hpp", "#include <hardware/gpio.h>"),
        ("emulator/planted.cpp", '#include "torsio/knob.hpp"'),
        ("emulator/usbip/bus.cpp", "#include <sys/socket.h>"),
        ("firmware/somewhere/planted.cpp", ""),
        ("sdk/include/torsio/planted.hpp", '#include "protocol/reports.hpp"'),
        ("sdk/src/hid_transport.cpp", '#include "emulator/plant/plant.hpp"'),
        ("sdk/src/planted.cpp", "#include PLANTED"),
        ("sdk/src/link.hpp", '#include "requests.hpp"'),
        ("examples/game/planted.cpp", '#include "torsio/knob.hpp"'),
    ],
)
def test_layer_check_finds_a_planted_violation(layered: LayeredTree, file: str, line: str) -> None:
    planted = layered.path / file
    there = planted.read_bytes() if planted.exists() else None
    new_folder = not planted.parent.exists()
    planted.parent.mkdir(parents=True, exist_ok=True)
    with planted.open("a", encoding="utf-8") as stream:
        stream.write(f"{line}\n")
    try:
        found = set(check_layers.check(layered.path)) - layered.violations
    finally:
        if there is None:
            planted.unlink()
        else:
            planted.write_bytes(there)
        if new_folder:
            planted.parent.rmdir()
    assert len(found) == 1
    assert found.pop().startswith(f"{file}:")
