"""Runs the tests in ``guest/`` inside virtual machines, one for each kernel."""

from __future__ import annotations

import functools
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import MappingProxyType

from tests.determinism.determinism import Run
from tests.once import once
from tests.vm import results
from tests.vm.machine import GuestFailed, Machine
from tools.dev.groups import TURN_VARIABLE
from tools.kernels import DEBIAN, EVERY_KERNEL_VARIABLE, GAMES_VARIABLE

TREE = Path(__file__).parent.parent.parent
KERNELS = TREE / "build/kernels"
GUEST_VARIABLE = "TORSIO_GUEST"  # set inside a guest: the kernel's name
NEWEST_KERNELS = TREE / "build/newest-kernels"
# How collecting the guest's tests tells of them: this word, the kernel, the node id.
TEST_LINE, ANY_KERNEL, WITH_GAMES = "guest-test", "any", "games"
# Much longer than a guest needs on an idle processor without KVM, see docs/reference/usb.md. A busy
# host may take its time, but a guest that hangs must not hang the tests.
LIMIT_S = 1800.0
PATHS = "tests/vm/guest"  # tests that run there
# Programs that they start.
PROGRAMS = "build/release/emulator/usbip/torsio_virtual_knob"
# The lives of some knobs, and where a guest finds the number that they come to on the host.
LIFE = TREE / "build/release/tests/determinism/torsio_life"
LIFE_SIZE = (1, 1)  # seconds, knobs
LIFE_NUMBER = Path("/torsio-share/number")
_PLUGINS = "-p tests.vm.guest.plugin -p no:cacheprovider"
# Importing the other packages takes an emulated processor longer than all the rest.
_NO_OTHER_PLUGINS = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}


def _fetched(folder: Path) -> list[str]:
    return sorted(file.parent.name for file in folder.glob("*/complete"))


def kernels() -> list[str]:
    """Return the names of the kernels to boot: all that are there, or the one whose turn it is."""
    known = _fetched(KERNELS)
    if GAMES_VARIABLE in os.environ:
        return known[:1] + _fetched(NEWEST_KERNELS)
    if EVERY_KERNEL_VARIABLE in os.environ or not known:
        return known
    # The number's last bit chooses the board: each is to meet each kernel.
    return [known[int(os.environ.get(TURN_VARIABLE, -1)) // 2 % len(known)]]


def pytest_command(arguments: str) -> list[str]:
    """Return the command that runs pytest on the guest's tests."""
    return [sys.executable, "-m", "pytest", *_PLUGINS.split(), *arguments.split()]


@functools.cache
def _collected() -> list[tuple[str, str]]:
    """Return the kernel and the node id of all tests."""
    return [(kernel, test) for kernel, test in once(share("session") / "tests.json", _collect)]


def _collect() -> list[tuple[str, str]]:
    command = pytest_command(f"--collect-only -q {PATHS}")
    environment = {**os.environ, **_NO_OTHER_PLUGINS, GUEST_VARIABLE: ANY_KERNEL}
    for name in ("PYTEST_XDIST_WORKER", "PYTEST_CURRENT_TEST", "PYTEST_ADDOPTS"):
        environment.pop(name, None)
    result = subprocess.run(
        command, cwd=TREE, env=environment, capture_output=True, text=True, check=False
    )
    if result.returncode != 0:
        raise GuestFailed(f"the guest's tests cannot be collected:\n{result.stdout}{result.stderr}")
    lines = [line.split(" ", 2) for line in result.stdout.splitlines()]
    return [(line[1], line[2]) for line in lines if line[0] == TEST_LINE]


def guest_tests(kernel: str) -> list[str]:
    """Return the node ids of all tests for a kernel."""
    if GAMES_VARIABLE in os.environ:
        if kernel in _fetched(KERNELS):
            return [test for wanted, test in _collected() if wanted == WITH_GAMES]
        # Tests for which one kernel is enough run on these too.
        games = [test for wanted, test in _collected() if wanted != WITH_GAMES]
        return [test for test in games if "/test_game" in test or "/test_dial" in test]
    # Where only one kernel is booted, it runs everything.
    accepted = {ANY_KERNEL, *([kernel] if kernel in DEBIAN and len(kernels()) > 1 else DEBIAN)}
    return [test for wanted, test in _collected() if wanted in accepted]


def share(kernel: str) -> Path:
    """Return the folder that a kernel's guest writes to."""
    return TREE / "build/vm" / kernel


def junit(kernel: str) -> Path:
    """Return where the results of a kernel are kept."""
    return TREE / f"out/junit-usb-{kernel}.xml"


def _command(kernel: str, variables: Mapping[str, str]) -> str:
    run = shlex.join(
        pytest_command("-v --color=no --junitxml=/torsio-share/junit.xml @/torsio-share/tests")
    )
    variables = {**_NO_OTHER_PLUGINS, GUEST_VARIABLE: kernel, **variables}
    above = {*TREE.parents, *Path(sys.base_prefix).resolve().parents}
    return f"""\
# The tests' nobody must reach tree and interpreter, also in a home folder closed to others.
chmod a+x {shlex.join(sorted(map(str, above)))}
export {" ".join(f"{name}={value}" for name, value in variables.items())}
export HOME=/tmp PYTHONUNBUFFERED=1 PATH=/usr/sbin:/usr/bin:/sbin:/bin
export LD_LIBRARY_PATH={shlex.quote(os.environ.get("LD_LIBRARY_PATH", ""))}
cd {shlex.quote(str(TREE))} || exit 2
# Load it into memory before the tests, so that none waits for the disk.
cat {PROGRAMS} >/dev/null
{run}
status=$?
# Failed tests are told by name in the results; anything else is the guest's failure.
[ $status -eq 1 ] && status=0
exit $status
"""


def run_guest(
    kernel: str,
    tests: Sequence[str],
    variables: Mapping[str, str] = MappingProxyType({}),
    limit_s: float = LIMIT_S,
) -> str:
    """Run tests in one guest. Returns what is wrong with the guest itself, empty if nothing is.

    The variables are in the tests' environment.
    """
    shutil.rmtree(share(kernel), ignore_errors=True)
    share(kernel).mkdir(parents=True)
    junit(kernel).parent.mkdir(exist_ok=True)
    junit(kernel).unlink(missing_ok=True)
    (share(kernel) / "tests").write_text("".join(f"{test}\n" for test in tests))
    if any("test_determinism" in test for test in tests):
        seconds, knobs = map(str, LIFE_SIZE)
        life = Run("host", (str(LIFE), "--seconds", seconds, "--knobs", knobs))
        (share(kernel) / LIFE_NUMBER.name).write_text(life.number())
    folder = KERNELS if kernel in _fetched(KERNELS) else NEWEST_KERNELS
    machine = Machine(folder / kernel, share(kernel))
    try:
        machine.run(_command(kernel, variables), limit_s=limit_s)
    except GuestFailed as failure:
        return str(failure)
    try:
        results.read_junit(share(kernel) / "junit.xml")
    except ValueError as error:
        return f"{error}; its console's end:\n{machine.console_tail()}"
    shutil.copy(share(kernel) / "junit.xml", junit(kernel))
    return ""


def run_guests(tests: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Run each kernel's tests, all guests at once; see `run_guest`."""
    with ThreadPoolExecutor(len(tests)) as pool:
        return dict(zip(tests, pool.map(run_guest, tests, tests.values()), strict=True))
