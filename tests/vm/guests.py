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

from tests.vm import results
from tests.vm.machine import GuestFailed, Machine

TREE = Path(__file__).parent.parent.parent
KERNELS = TREE / "build/kernels"
GUEST_VARIABLE = "TORSIO_GUEST"  # set inside a guest: the kernel's name
# A guest takes a minute or two on an idle machine without KVM; a busy one may take its time, but
# a guest that hangs must not hang the tests.
LIMIT_S = 900.0
# What runs there: tests of its own, and those of the Python API, over USB.
PATHS = "tests/vm/guest tests/python/test_knob.py tests/python/test_bad_input.py"
_PLUGINS = "-p tests.vm.guest.plugin -p tests.vm.guest.over_usb -p no:cacheprovider"


def kernels() -> list[str]:
    """Return the names of the kernels that ``./dev`` has fetched."""
    return sorted(file.parent.name for file in KERNELS.glob("*/complete"))


def pytest_command(arguments: str) -> list[str]:
    """Return the command that runs pytest on the guest's tests."""
    return [sys.executable, "-m", "pytest", "-n", "0", *_PLUGINS.split(), *arguments.split()]


@functools.cache
def guest_tests(kernel: str) -> list[str]:
    """Return the node ids of all tests for a kernel."""
    command = pytest_command(f"--collect-only -q {PATHS}")
    environment = {**os.environ, GUEST_VARIABLE: kernel}
    for name in ("PYTEST_XDIST_WORKER", "PYTEST_CURRENT_TEST", "PYTEST_ADDOPTS"):
        environment.pop(name, None)
    result = subprocess.run(
        command, cwd=TREE, env=environment, capture_output=True, text=True, check=False
    )
    if result.returncode != 0:
        raise GuestFailed(f"the guest's tests cannot be collected:\n{result.stdout}{result.stderr}")
    return [line for line in result.stdout.splitlines() if "::" in line]


def share(kernel: str) -> Path:
    """Return the folder that a kernel's guest writes to."""
    return TREE / "build/vm" / kernel


def junit(kernel: str) -> Path:
    """Return where the results of a kernel are kept."""
    return TREE / f"out/junit-usb-{kernel}.xml"


def _command(kernel: str) -> str:
    run = shlex.join(
        pytest_command("-v --color=no --junitxml=/torsio-share/junit.xml @/torsio-share/tests")
    )
    return f"""\
export HOME=/tmp PYTHONUNBUFFERED=1 PATH=/usr/sbin:/usr/bin:/sbin:/bin {GUEST_VARIABLE}={kernel}
export LD_LIBRARY_PATH={shlex.quote(os.environ.get("LD_LIBRARY_PATH", ""))}
cd {shlex.quote(str(TREE))} || exit 2
{run}
status=$?
# Failed tests are told by name in the results; anything else is the guest's failure.
[ $status -eq 1 ] && status=0
exit $status
"""


def run_guest(kernel: str, tests: Sequence[str]) -> str:
    """Run tests in one guest. Returns what is wrong with the guest itself, empty if nothing is."""
    shutil.rmtree(share(kernel), ignore_errors=True)
    share(kernel).mkdir(parents=True)
    junit(kernel).parent.mkdir(exist_ok=True)
    junit(kernel).unlink(missing_ok=True)
    (share(kernel) / "tests").write_text("".join(f"{test}\n" for test in tests))
    machine = Machine(KERNELS / kernel, share(kernel))
    try:
        machine.run(_command(kernel), limit_s=LIMIT_S)
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
