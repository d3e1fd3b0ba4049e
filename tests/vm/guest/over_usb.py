"""Runs Python tests that were written for the emulated device over USB, as they are.

``torsio.open("emulated", ...)`` opens a virtual USB knob that is plugged into this computer, and
the knob's ``emulator`` tells that knob's world. Used as a pytest plugin; what lies in
``tests/python`` is affected, nothing else.
"""

from __future__ import annotations

import itertools
import tempfile
import time
from collections.abc import Iterator
from typing import Any

import pytest

import torsio
from tests.vm.guest.virtual_bus import VirtualKnob
from torsio.knob import opening

FOLDER = "tests/python/"

_NO_DEVICE = "uses no device"
# Tests that cannot run on a knob outside the process, each with its reason.
NOT_OVER_USB = {
    "test_matching_config_is_the_default_for_the_default_plant": _NO_DEVICE,
    "test_scene_classes_compare_show_and_hash_by_value": _NO_DEVICE,
    "test_profiles_may_be_arrays_and_numbers": _NO_DEVICE,
    "test_errors_keep_their_attributes_when_pickled": _NO_DEVICE,
    "test_documented_dtypes_are_those_of_the_extension": _NO_DEVICE,
    "test_knob_says_who_and_how_it_is": "expects the emulated transport's path",
    "test_emulated_device_is_always_listed_last": _NO_DEVICE,
}

# Tests that a cable, kernel or second process may change; the rest runs with ``./dev test usb``.
IN_EVERY_RUN = {
    "test_stop_disarms_and_empties_the_scene",
    "test_disarm_keeps_the_scene",
    "test_record_at_a_rate_takes_every_nth_tick",
    "test_telemetry_iterator_gives_what_was_asked",
    "test_configuration_comes_back_as_it_was_set",
    "test_emergency_stop_is_a_latched_fault",
    "test_waiting_lets_other_threads_run",
    "test_update_changes_fields_and_keeps_the_rest",
}


@pytest.hookimpl(tryfirst=True)  # before a mark rules tests out
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in list(items):
        if not item.nodeid.startswith(FOLDER):
            continue
        item.add_marker(pytest.mark.kernel("6.12"))
        name = getattr(item, "originalname", "")
        if name in NOT_OVER_USB:
            items.remove(item)
        elif name not in IN_EVERY_RUN:
            item.add_marker(pytest.mark.whole)


class World:
    """Orders of the tests to the world around a knob."""

    def __init__(self, plugged: VirtualKnob, knob: torsio.Knob) -> None:
        self._plugged = plugged
        self._knob = knob

    def set_hand(self, hand: torsio.Hand) -> None:
        set_hand(self._plugged, hand)

    def unplug(self) -> None:
        self._plugged.unplug()

    def advance(self, duration_s: float) -> None:
        self._knob.sleep(duration_s)

    def set_emergency_stop(self, *, pressed: bool) -> None:
        self._plugged.say("emergency_stop " + ("pressed" if pressed else "released"))
        time.sleep(0.05)  # until the program has read it


def set_hand(plugged: VirtualKnob, hand: torsio.Hand | None) -> None:
    """Give the knob into a hand."""
    if isinstance(hand, torsio.TorqueHand):
        kind, knots = "torque_nm", hand.torque_nm
    elif isinstance(hand, torsio.PrescribedMotion):
        kind, knots = "motion_rad", hand.angle_rad
    else:
        assert hand is None or isinstance(hand, torsio.NoHand)
        plugged.say("free")
        return
    with tempfile.NamedTemporaryFile("w", suffix=".hand", delete=False) as file:
        file.write(kind + "\n")
        for time_s, value in knots:  # type: ignore[union-attr]
            file.write(f"{time_s!r} {value!r}\n")
    plugged.say(f"script {file.name}")


class Pool:
    """Knobs that stay plugged in from one test to the next."""

    def __init__(self) -> None:
        self.idle: list[tuple[tuple[Any, ...], VirtualKnob]] = []
        self.busy: list[tuple[tuple[Any, ...], VirtualKnob, torsio.Knob]] = []
        self.numbers = itertools.count(1)

    def open(self, selector: str | None = None, **options: Any) -> torsio.Knob:
        """Stand in for `torsio.open`."""
        if selector is None or selector.partition(":")[0] != "emulated":
            return opening.open(selector, **options)
        # Nothing here looks at seed and truth, and this knob is paced.
        emulator = options.pop("emulator", None) or torsio.EmulatorOptions()
        hand, control = emulator.hand, emulator.control
        rate_hz = round(emulator.control_rate_hz)
        kind = (selector, rate_hz)
        plugged = self._take(kind)
        knob = opening.open(str(plugged.hidraw), **options)
        self.busy.append((kind, plugged, knob))
        plugged.say("emergency_stop released")
        if selector == "emulated":  # a new one each time
            knob.stop()
            knob.load_defaults()
        if control is not None:
            knob.configure(control)
        set_hand(plugged, hand)
        knob.__dict__["_world"] = World(plugged, knob)
        return knob

    def _take(self, kind: tuple[Any, ...]) -> VirtualKnob:
        if any(not knob.is_open for _, _, knob in self.busy):
            self.give_back()
        for entry in self.idle:
            if entry[0] == kind:
                self.idle.remove(entry)
                return entry[1]
        plugged = VirtualKnob(f"POOL-{next(self.numbers)}", kind[1], "pushes")
        plugged.plug()
        return plugged

    def give_back(self) -> None:
        """Take back what has been closed; end what has been unplugged."""
        for entry in [entry for entry in self.busy if not entry[2].is_open]:
            self.busy.remove(entry)
            kind, plugged, _ = entry
            if plugged.is_plugged:
                self.idle.append((kind, plugged))
            else:
                plugged.end()

    def end(self) -> None:
        for _, plugged in self.idle:
            plugged.end()


@pytest.fixture(scope="session")
def _pool() -> Iterator[Pool]:
    pool = Pool()
    yield pool
    pool.end()


@pytest.fixture(autouse=True)
def _over_usb(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    if not request.node.nodeid.startswith(FOLDER):
        yield
        return
    pool: Pool = request.getfixturevalue("_pool")
    monkeypatch.setattr(torsio, "open", pool.open)
    monkeypatch.setattr(torsio.Knob, "emulator", property(lambda knob: knob._world))
    yield
    for _, _, knob in pool.busy:
        knob.close()
    pool.give_back()
