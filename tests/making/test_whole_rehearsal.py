"""Every fault through the whole of first power; some through the released firmware too."""

from __future__ import annotations

import pytest

from tests.hardware.test_rehearsal import rehearse
from tests.making.chip import binary
from torsio_hardware import faults, rehearsal
from torsio_hardware.knob import load

NAMES = [fault.name for fault in faults.FAULTS]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", [None, 1, 2])
def test_fault_is_named(name: str, seed: int | None) -> None:
    seen = rehearse(load(), name, seed)
    assert seen is not None
    assert name in seen.causes
    if seed is None:
        assert seen.finding == faults.named(name).finding


def test_knob_without_a_fault_passes_all_steps() -> None:
    assert rehearse(load(), "") is None


@pytest.mark.parametrize(
    "name", ["", "motor_swapped", "encoder_swapped", "encoder_off", "stop_open", "supply_24v"]
)
def test_released_firmware_in_its_chip_names_what_the_emulated_device_does(name: str) -> None:
    knob, fault = load(), faults.named(name) if name else None
    with binary(knob, fault) as bench:
        seen = rehearsal.run(bench, lambda seen: None, rehearsal.STEPS[:-2])
    assert (seen.finding if seen else "") == (fault.finding if fault else "")
