"""Functions that need NumPy alone, and others that name the extra they lack."""

from __future__ import annotations

import subprocess
from importlib.metadata import requires
from pathlib import Path

import pytest

from tests.python.processes import python

USE = """
import torsio
hand = torsio.TorqueHand(torque_nm=0.03)
with torsio.open("emulated", emulator=torsio.EmulatorOptions(hand=hand)) as knob:
    knob.play(torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.4))
    knob.arm()
    print(len(knob.record(0.5)))
"""

BLOCK = """
import sys
class Block:
    def find_spec(self, name, path=None, target=None):
        if name in {without!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Block())
"""

WHICH = """
import sys
site = {"sitecustomize", "usercustomize"}  # a system may bring its own
print(*sorted({name.partition(".")[0] for name in sys.modules} - sys.stdlib_module_names - site))
"""

COMMAND = """
from torsio.__main__ import main
main()
"""


def run(
    program: str, *arguments: str, without: tuple[str, ...] = (), cwd: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a program for which some packages are not installed."""
    block = BLOCK.format(without=without)
    return python(block + program, *arguments, cwd=cwd)


def test_library_needs_numpy_alone() -> None:
    result = run(USE + WHICH)
    assert result.stderr == ""
    count, loaded = result.stdout.splitlines()
    assert count == "500"
    assert {name for name in loaded.split() if not name.startswith("_")} == {"numpy", "torsio"}
    always = [line for line in requires("torsio") or [] if "extra ==" not in line]
    assert [line.partition(">")[0] for line in always] == ["numpy"]


@pytest.mark.parametrize("missing", ["typer", "rich"])
def test_command_without_its_extra_says_how_to_install_it(missing: str) -> None:
    result = run(COMMAND, "list", without=(missing,))
    assert result.returncode == 1
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert line.startswith(f"torsio: error: the command line needs the Python package {missing};")
    assert line.endswith("[cli]'")


def test_demo_without_matplotlib_measures_and_says_how_to_get_its_picture(tmp_path: Path) -> None:
    arguments = ("demo", "wall", "--out", str(tmp_path))
    result = run(COMMAND, *arguments, without=("matplotlib",))
    assert result.returncode == 0, result.stderr
    assert "It feels like a wall" in result.stdout
    assert "without matplotlib: pip install '" in result.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["virtual_wall.json"]


@pytest.mark.parametrize("extra", ["cli", "gym", "plot", "record", "studio"])
def test_line_that_installs_an_extra_names_the_tree_that_the_package_came_from(extra: str) -> None:
    from torsio.common.extras import how_to_install

    place = how_to_install(extra).removeprefix("pip install '").removesuffix(f"[{extra}]'")
    assert (Path(place) / "pyproject.toml").is_file()
