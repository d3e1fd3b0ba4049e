"""Every fault through the whole of first power; the released firmware names the early ones."""

from __future__ import annotations

import pytest

from tests.hardware.test_rehearsal import EARLY, rehearse
from tests.making.chip import binary
from torsio_hardware import faults, rehearsal
from torsio_hardware.first_power import KEEP, STEPS, Seen, alone, run
from torsio_hardware.knob import load

NAMES = [fault.name for fault in faults.FAULTS]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", [None, 1, 2])
def test_fault_is_named(name: str, seed: int | None) -> None:
    seen = rehearse(load(), name, seed)
    assert faults.named(name) in seen.causes
    if seed is None:
        assert seen.finding == faults.named(name).finding
        proposed = seen.finding in ("calibrate:drag", "calibrate:shaft_soft", KEEP)
        assert ("look for" in seen.text) is proposed


def test_knob_without_a_fault_passes_all_steps() -> None:
    told: list[Seen] = []
    with rehearsal.emulated(load(), faults.NONE) as bench:
        assert run(bench, told.append).finding == ""
    assert [seen.step for seen in told] == [title for title, *_ in STEPS]


@pytest.mark.parametrize("name", ["", *EARLY])
def test_released_firmware_in_its_chip_names_what_the_emulated_device_does(name: str) -> None:
    fault = faults.named(name)
    with binary(load(), fault) as bench:
        seen = run(bench, lambda seen: None, STEPS[:-2])
    assert seen.finding == fault.finding


@pytest.mark.parametrize("name", [name for name in NAMES if name not in EARLY])
def test_released_firmware_in_its_chip_is_calibrated_and_names_the_rest(name: str) -> None:
    fault = faults.named(name)
    with binary(load(), fault) as bench:
        # Only the whole calibration looks at the winding; the others would take four minutes each.
        bench.quick = name != "motor_contact"
        assert alone(bench) == fault.finding
