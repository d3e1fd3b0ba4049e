"""What `tests/python/test_bad_input.py` asks of an emulated knob, of one that the kernel has.

One knob takes it all, one after the other, for nothing of it may change anything. What is refused
before there is a device (options of `torsio.open`, values of scenes) is not repeated here.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

import torsio
from tests.python.test_bad_input import BAD_CALLS, BAD_SCENES, OLD_TORQUE_NM, torque
from tests.vm.guest.virtual_bus import VirtualKnob

pytestmark = pytest.mark.kernel("6.1")


def is_about_the_emulator(call: Callable[[torsio.Knob], object]) -> bool:
    return "emulator" in call.__code__.co_names


def test_every_bad_scene_and_call_is_refused_by_name_and_the_old_scene_goes_on(
    knob: VirtualKnob,
) -> None:
    knob.say("still")
    with torsio.open(knob.serial) as opened:
        opened.play(torsio.Constant(torque_nm=OLD_TORQUE_NM))
        opened.arm()
        opened.sleep(0.1)
        for scene, kind, message in BAD_SCENES:
            with pytest.raises(kind, match=message):
                opened.play(scene)
        for call, kind, message in BAD_CALLS:
            # There is no world to be told anything.
            expected = (torsio.Error, "real hardware") if is_about_the_emulator(call) else ()
            error, words = expected or (kind, message)
            with pytest.raises(error, match=words):
                call(opened)
        assert torque(opened) == pytest.approx(OLD_TORQUE_NM, abs=1e-5)
        assert opened.state == "armed"
        assert opened.health().reports_refused <= len(BAD_CALLS)


def test_knob_can_be_open_once(knob: VirtualKnob) -> None:
    with torsio.open(knob.serial):
        for selector in (knob.serial, str(knob.hidraw)):
            with pytest.raises(torsio.DeviceBusy, match=knob.hidraw.name):
                torsio.open(selector)
    torsio.open(knob.serial).close()


def test_knob_that_is_not_there_is_named_with_those_that_are(knob: VirtualKnob) -> None:
    for selector in ("/dev/hidraw250", "TS-9999"):
        with pytest.raises(torsio.DeviceNotFound, match=selector) as caught:
            torsio.open(selector)
        assert isinstance(caught.value, FileNotFoundError)


def test_close_may_be_called_twice_and_ends_everything(knob: VirtualKnob) -> None:
    opened = torsio.open(knob.serial)
    opened.arm()
    opened.close()
    opened.close()
    assert not opened.is_open
    calls: list[Callable[[], object]] = [
        opened.arm,
        opened.clock,
        lambda: opened.play(torsio.Constant(torque_nm=0.0)),
        lambda: opened.record(duration_s=0.1),
        opened.__enter__,
    ]
    for call in calls:
        with pytest.raises(torsio.Closed, match="open it again"):
            call()
