"""Arrivals and departures of knobs, as a program is told of them."""

from __future__ import annotations

import queue

import pytest

import torsio
from tests.vm.guest.virtual_bus import VirtualBus

LONGEST_S = 30.0


@pytest.mark.kernel("6.12")
def test_watch_tells_of_arrival_and_departure_and_the_knob_opens_by_serial(
    bus: VirtualBus,
) -> None:
    bus.plug("OTHER")
    with torsio.watch() as watch:

        def next_event() -> tuple[str, str, str]:
            event = watch.next(timeout_s=LONGEST_S)
            assert event is not None
            return event.kind, event.device.serial, event.device.path

        assert next_event()[:2] == ("arrived", "OTHER")  # it was there already
        knob = bus.plug("MINE")
        for _ in range(2):
            path = str(knob.hidraw)
            assert next_event() == ("arrived", "MINE", path)
            with torsio.open("MINE") as opened:
                assert opened.info.serial == "MINE"
            knob.unplug()
            assert next_event() == ("departed", "MINE", path)
            knob.plug()
        assert next_event()[:2] == ("arrived", "MINE")
        assert watch.next(timeout_s=0.0) is None


@pytest.mark.kernel("6.12")
def test_watch_calls_back_for_each_of_two_knobs(bus: VirtualBus) -> None:
    events: queue.Queue[tuple[str, str]] = queue.Queue()
    with torsio.watch(lambda event: events.put((event.kind, event.device.serial))):
        first, second = bus.plug("FIRST"), bus.plug("SECOND")
        first.unplug()
        second.unplug()
        told = [events.get(timeout=LONGEST_S) for _ in range(4)]
    for serial in ("FIRST", "SECOND"):
        assert [kind for kind, who in told if who == serial] == ["arrived", "departed"]
