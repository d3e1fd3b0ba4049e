"""A program for Windows with the library takes the knob that is plugged in, under Wine.

The library's hidapi is the wheels' hidapi. It does not begin with Wine 8, which lacks functions of
Windows's ``cfgmgr32.dll``; ``tools/wine/cfgmgr32.c`` has them. ``./dev test games``.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.vm.guest.direct_input import PREFIX
from tests.vm.guest.virtual_bus import VirtualBus
from tests.vm.guest.wheel import PUSH
from tools import windows_games

pytestmark = [pytest.mark.kernel("6.1"), pytest.mark.games, pytest.mark.usefixtures("udev")]

ENVIRONMENT = {
    **os.environ,
    **windows_games.QUIET,
    "WINEPREFIX": str(PREFIX),
    "WINEDLLOVERRIDES": f"cfgmgr32=n,b;{windows_games.QUIET['WINEDLLOVERRIDES']}",
}


@contextmanager
def running() -> Iterator[subprocess.Popen[str]]:
    """Run the program; leave nothing of Wine behind."""
    command = ["wine", str(windows_games.LIBRARY / "plugged.exe")]
    with subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True) as program:
        yield program
        program.kill()
    subprocess.run(["wineserver", "-k"], env=ENVIRONMENT, check=False)


def read_until(program: subprocess.Popen[str], last: str) -> list[str]:
    """Return what the program says, up to and with a line."""
    assert program.stdout is not None
    told: list[str] = []
    while not told or told[-1] != last:
        line = program.stdout.readline()
        assert line, told
        told.append(line.strip())
    return told


@pytest.mark.pulls_cable
def test_windows_program_takes_the_knob_that_is_plugged_in(bus: VirtualBus, tmp_path: Path) -> None:
    knob = bus.plug("WINDOWS", hand="pushes")
    push = tmp_path / "push.hand"
    push.write_text(PUSH)
    with running() as program:
        told = read_until(program, "armed")
        assert told == ["listed hid WINDOWS", "opened WINDOWS", "busy", "armed"]
        knob.say(f"script {push}")
        recorded, _ = read_until(program, "pull")
        # 50 mN m into 1.4 N m/rad from 0.1 rad, less the knob's own friction: README says 0.130.
        assert recorded == "recorded 1500 samples, up to 0.130 rad"
        knob.unplug()
        rest, _ = program.communicate()
        assert "TORSIO_DISCONNECTED" in rest, rest
        assert program.returncode == 0
