"""pytest inside a guest: it watches the kernel and the clock."""

from __future__ import annotations

import faulthandler
import os
import signal
from collections.abc import Collection, Iterator
from types import FrameType

import pytest

from tests.vm import guests, kernel_log
from tools.kernels import EVERY_KERNEL_VARIABLE

# Limit of one test, in the guest's time, which runs ahead while files come from the host. A test
# with the mark "long" has the machine's own limit only.
LIMIT_S = 1000


class KernelLog:
    """The kernel's log from now on."""

    def __init__(self) -> None:
        self._file = os.open("/dev/kmsg", os.O_RDONLY | os.O_NONBLOCK)
        os.lseek(self._file, 0, os.SEEK_END)

    def complaints(self, marks: Collection[str] = ()) -> list[str]:
        """Return what the kernel has complained about since this was asked last.

        See `kernel_log.complaints` for `marks`.
        """
        lines: list[str] = []
        while True:
            try:
                record = os.read(self._file, 8192).decode(errors="replace")
            except BlockingIOError:
                return kernel_log.complaints("\n".join(lines), marks)
            prefix, _, text = record.partition(";")
            level = int(prefix.split(",")[0]) & 7
            lines.append(f"<{level}>{text.splitlines()[0] if text else ''}")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "kernel(name): where several are booted, on this one only")
    config.addinivalue_line("markers", "long: has a command of its own for its whole length")
    config.addinivalue_line("markers", "whole: one of many of a kind; runs with ./dev test usb")
    config.addinivalue_line("markers", "games: takes minutes; runs with ./dev test games")
    config.addinivalue_line("markers", "pulls_cable: unplugs a knob that is in use")
    config.addinivalue_line("markers", "kernels_own_tests: lets usbtest torment a knob")
    config.addinivalue_line("markers", "odd_trigger: names trigger buttons that do not exist")
    config.addinivalue_line("markers", "floods_queue: gives the kernel more than a knob can take")


def pytest_collection_finish(session: pytest.Session) -> None:
    """Tell the host which test is for which kernel; see `guests.guest_tests`."""
    if session.config.option.collectonly:
        for item in session.items:
            if item.get_closest_marker("whole") and EVERY_KERNEL_VARIABLE not in os.environ:
                continue
            mark = item.get_closest_marker("kernel")
            kernel = mark.args[0] if mark else guests.ANY_KERNEL
            if item.get_closest_marker("games"):
                kernel = guests.WITH_GAMES
            print(guests.TEST_LINE, kernel, item.nodeid)


@pytest.fixture(scope="session")
def _log() -> KernelLog:
    return KernelLog()


@pytest.fixture(autouse=True)
def _watched(_log: KernelLog, request: pytest.FixtureRequest) -> Iterator[None]:
    """Fail a test that takes for ever, and one that makes the kernel complain."""

    def late(_signal: int, _frame: FrameType | None) -> None:
        faulthandler.dump_traceback()
        raise TimeoutError(f"the test took more than {LIMIT_S} s")

    _log.complaints()
    signal.signal(signal.SIGALRM, late)
    signal.alarm(0 if request.node.get_closest_marker("long") else LIMIT_S)
    yield
    signal.alarm(0)
    marks = [
        name for name in kernel_log.HARMLESS_WITH_MARK if request.node.get_closest_marker(name)
    ]
    assert _log.complaints(marks) == []
