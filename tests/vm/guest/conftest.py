"""Fixtures of the tests inside a guest."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from tests.vm.guest.udev import running as running_udev
from tests.vm.guest.virtual_bus import VirtualBus, VirtualKnob
from tests.vm.guests import GUEST_VARIABLE


@pytest.fixture(scope="session")
def kernel() -> str:
    """Name of the kernel: 6.1, 6.12."""
    return os.environ[GUEST_VARIABLE]


@pytest.fixture
def udev() -> Iterator[None]:
    """Run udev; ask for it before a knob."""
    with running_udev():
        yield


@pytest.fixture
def bus() -> Iterator[VirtualBus]:
    """Give knobs to plug in; they are all unplugged and ended after the test."""
    bus = VirtualBus()
    yield bus
    bus.end()


@pytest.fixture
def knob(bus: VirtualBus) -> VirtualKnob:
    """Give a knob that is plugged in."""
    return bus.plug()
