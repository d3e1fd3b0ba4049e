"""Every fault through the whole of first power; the released firmware names the early ones."""

from __future__ import annotations

import pytest

from tests.hardware.test_rehearsal import EARLY, rehearse
from tests.making.chip import binary
from torsio_hardware import faults, rehearsal
from torsio_hardware.knob import load

NAMES = [fault.name for fault in faults.FAULTS]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", [None, 1, 2])
def test_fault_is_named(name: str, seed: int | None) -> None:
    seen = rehearse(load(), name, seed)
    assert name in seen.causes
    if seed is None:
        assert seen.finding == faults.named(name).finding


def test_knob_without_a_fault_passes_all_steps() -> None:
    seen = rehearse(load(), "")
    assert (seen.step, seen.finding) == ("calibrate", "")


# Calibration takes minutes in the chip, whose world has no noise of the encoder.
@pytest.mark.parametrize("name", ["", *EARLY])
def test_released_firmware_in_its_chip_names_what_the_emulated_device_does(name: str) -> None:
    fault = faults.named(name)
    with binary(load(), fault) as bench:
        seen = rehearsal.run(bench, lambda seen: None, rehearsal.STEPS[:-2])
    assert seen.finding == fault.finding
