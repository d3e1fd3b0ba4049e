"""A computer's clock that is set, forward and back, while a knob is in use."""

from __future__ import annotations

import threading
import time

import torsio
from tests.vm.guest.virtual_bus import VirtualKnob

DAY_S = 86_400.0


def test_clock_that_is_set_disturbs_nobody(knob: VirtualKnob) -> None:
    over = threading.Event()
    jumps = 0

    def jump() -> None:
        nonlocal jumps
        while not over.wait(0.05):
            step_s = DAY_S if jumps % 2 == 0 else -DAY_S
            time.clock_settime(time.CLOCK_REALTIME, time.time() + step_s)
            jumps += 1

    jumping = threading.Thread(target=jump)
    with torsio.open(knob.serial) as opened:
        opened.configure(torsio.ControlConfig(watchdog_s=0.2))
        opened.arm()
        opened.start_telemetry(1000.0)
        jumping.start()
        try:
            log = opened.record(1.0)
            late = opened.every(0.01)
            ticks = [tick for _, tick in zip(range(20), late, strict=False)]
            opened.play(torsio.Spring(stiffness_nm_per_rad=0.01))
        finally:
            over.set()
            jumping.join()
        assert jumps >= 10
        assert len(log) == 1000
        assert len(ticks) == 20
        assert opened.state == "armed"
        assert opened.last_disarm is None
