"""The pages of hardware say what the firmware does."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

import torsio

DOCS = Path(__file__).parent.parent / "docs"
PAGE = DOCS / "reference/hardware.md"
GUIDES = [DOCS / f"how-to/{name}.md" for name in ("hardware", "first-power")]


def test_wiring_diagram_shows_the_default_pins() -> None:
    page = PAGE.read_text(encoding="utf-8")
    drawn = set(re.findall(r">(GP\d+) ", (DOCS / "wiring.svg").read_text(encoding="utf-8")))
    table = set(re.findall(r"\| (GP\d+) \|", page))
    assert table <= drawn
    # The second pins of the pairs, and a divider's pin, which no board has by default.
    assert drawn - table == {"GP3", "GP7", "GP9", "GP27"}


PROGRAMS = [
    program
    for guide in GUIDES
    for program in re.findall(
        r"^```python\n(.*?)^```$", guide.read_text(encoding="utf-8"), re.M | re.S
    )
]


def _run(program: str, monkeypatch: pytest.MonkeyPatch, options: torsio.EmulatorOptions) -> None:
    real = torsio.open
    monkeypatch.setattr(torsio, "open", lambda: real("emulated", emulator=options))
    exec(compile(program, "a guide of hardware", "exec"), {})


@pytest.mark.parametrize("program", PROGRAMS, ids=["other parts", "first power"])
def test_programs_of_the_guide_run(program: str, monkeypatch: pytest.MonkeyPatch) -> None:
    _run(program, monkeypatch, torsio.EmulatorOptions(seed=1))


@pytest.mark.parametrize("friction", [0.5, 1.0, 1.2])
def test_first_power_moves_the_knob_and_stays_below_the_speed_limit(
    friction: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On the reference actuator with its electrics, and on others that are configured rightly."""
    reference = torsio.PlantParams()
    plant = replace(
        reference,
        electrics=torsio.Electrics(),
        knob_coulomb_nm=friction * reference.knob_coulomb_nm,
        brake_drag_nm=friction * reference.brake_drag_nm,
    )
    told: list[tuple[float, float, tuple[str, ...]]] = []
    real_stop, real_sleep = torsio.Knob.stop, torsio.Knob.sleep

    def stop(knob: torsio.Knob) -> None:
        fastest = max(abs(knob.emulator.truth()["speed_rad_s"]))
        told.append((knob.position_rad(), fastest, knob.faults()))
        real_stop(knob)

    monkeypatch.setattr(torsio.Knob, "stop", stop)
    monkeypatch.setattr(torsio.Knob, "sleep", lambda knob, s: real_sleep(knob, min(s, 0.5)))
    options = torsio.EmulatorOptions(
        control_rate_hz=20e3, plant=plant, actuator=plant.matching_config(), log_truth=True
    )
    _run(PROGRAMS[1], monkeypatch, options)
    [(angle_rad, fastest_rad_s, faults)] = told
    assert faults == ()
    assert angle_rad > 0.05
    assert 0.5 < fastest_rad_s < 10.0


def test_first_power_turns_a_knob_backwards_whose_motor_is_swapped(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A law that brakes would hold it, and the step would tell nothing."""
    angles: list[float] = []
    real_stop, real_sleep = torsio.Knob.stop, torsio.Knob.sleep

    def stop(knob: torsio.Knob) -> None:
        angles.append(knob.position_rad())
        real_stop(knob)

    monkeypatch.setattr(torsio.Knob, "stop", stop)
    monkeypatch.setattr(torsio.Knob, "sleep", lambda knob, s: real_sleep(knob, min(s, 0.5)))
    plant = torsio.PlantParams(electrics=torsio.Electrics(motor_reversed=True))
    options = torsio.EmulatorOptions(control_rate_hz=20e3, plant=plant)
    _run(PROGRAMS[1], monkeypatch, options)
    assert angles[0] < -0.05


def test_pins_of_the_guides_example_are_free_on_either_board() -> None:
    pins = [int(pin) for program in PROGRAMS for pin in re.findall(r"_pin=(\d+)", program)]
    assert pins
    assert not {14, 15} & set(pins)  # GP15 is the RP2040's own, and 14 is the first of a pair
