"""What pytest does inside a guest: chooses the tests for its kernel, and watches the kernel."""

from __future__ import annotations

import faulthandler
import os
import signal
from collections.abc import Iterator
from types import FrameType

import pytest

from tests.vm import guests, kernel_log
from tools import kernels

LIMIT_S = 300  # of one test; on an idle machine none takes longer than a minute and a half


class KernelLog:
    """The kernel's log from now on."""

    def __init__(self) -> None:
        self._file = os.open("/dev/kmsg", os.O_RDONLY | os.O_NONBLOCK)
        os.lseek(self._file, 0, os.SEEK_END)

    def complaints(self) -> list[str]:
        """Return what the kernel has complained about since this was asked last."""
        lines: list[str] = []
        while True:
            try:
                record = os.read(self._file, 8192).decode(errors="replace")
            except BlockingIOError:
                return kernel_log.complaints("\n".join(lines))
            prefix, _, text = record.partition(";")
            level = int(prefix.split(",")[0]) & 7
            lines.append(f"<{level}>{text.splitlines()[0] if text else ''}")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "kernel(name): runs on this kernel only, of all there are")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    kernel = os.environ[guests.GUEST_VARIABLE]
    # Where the distribution brings but one kernel, that one runs everything.
    if kernel not in kernels.DEBIAN:
        return
    for item in list(items):
        mark = item.get_closest_marker("kernel")
        if mark is not None and mark.args[0] != kernel:
            items.remove(item)


@pytest.fixture(scope="session")
def _log() -> KernelLog:
    return KernelLog()


@pytest.fixture(autouse=True)
def _watched(_log: KernelLog) -> Iterator[None]:
    """Fail a test that takes for ever, and one that makes the kernel complain."""

    def late(_signal: int, _frame: FrameType | None) -> None:
        faulthandler.dump_traceback()
        raise TimeoutError(f"the test took more than {LIMIT_S} s")

    _log.complaints()
    signal.signal(signal.SIGALRM, late)
    signal.alarm(LIMIT_S)
    yield
    signal.alarm(0)
    assert _log.complaints() == []
