"""Programs that stand still for seconds, as with Ctrl-Z: the one that uses a knob, and a knob's."""

from __future__ import annotations

import os
import signal
import threading
import time
import warnings
from contextlib import suppress
from typing import TextIO

import pytest

import torsio
from tests.vm.guest.child import Child
from tests.vm.guest.virtual_bus import VirtualKnob

STOPPED_S = 2.0  # the knob's watchdog waits a quarter of a second of it
LATEST_S = 1.0


def test_program_that_was_stopped_is_told_that_its_knob_let_go_and_can_go_on(
    knob: VirtualKnob,
) -> None:
    def work(output: TextIO) -> None:
        with torsio.open(knob.serial) as opened:
            opened.arm()
            output.write("armed\n")
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                samples = opened.record(duration_s=1.0)
            assert opened.last_disarm is not None
            words = [opened.last_disarm.reason, str(opened.health().state), str(len(samples) > 100)]
            words += [warning.category.__name__ for warning in told]
            opened.arm()
            words.append(str(len(opened.record(duration_s=0.1))))
        output.write(" ".join(words))

    child = Child(work)
    assert child.output.readline() == "armed\n"
    time.sleep(0.3)
    os.kill(child.pid, signal.SIGSTOP)
    time.sleep(STOPPED_S)
    os.kill(child.pid, signal.SIGCONT)
    assert child.end().split() == ["watchdog", "disarmed", "True", "DisarmedWarning", "100"]


@pytest.mark.whole
def test_knob_that_stood_still_is_there_again(knob: VirtualKnob) -> None:
    with torsio.open(knob.serial, command_timeout_s=0.5) as opened:
        opened.arm()
        knob.process.send_signal(signal.SIGSTOP)
        # USB/IP's controller holds who writes until the knob goes on, a controller of silicon would
        # give up.
        go_on = threading.Timer(STOPPED_S, lambda: knob.process.send_signal(signal.SIGCONT))
        go_on.start()
        begin = time.monotonic()
        with suppress(torsio.Timeout):
            opened.disarm()
        assert time.monotonic() - begin < STOPPED_S + LATEST_S
        go_on.join()
        opened.disarm()
        opened.arm()
        assert len(opened.record(duration_s=0.1)) == 100
