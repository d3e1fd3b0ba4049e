"""Recorded reports of real hosts to the game interface, against the torque that must come.

The reports are those that Wine's DirectInput and Linux's driver make of effects, kept by
``python -m tests.vm.record_hosts``: a short form of ``./dev test games``.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import torsio
from tests.vm.guest import direct_input, effect_forms
from tests.vm.guest.effect_forms import Case
from tests.vm.guest.torque_log import FULL_NM, QUIET, Floats

FILE = Path(__file__).parents[1] / "golden/hosts.json"
HOSTS: dict[str, dict[str, Any]] = json.loads(FILE.read_text())
FORMS: dict[str, dict[str, Case]] = {
    "wine": {name: form for name, (_, form) in direct_input.PLAYED.items()},
    "linux": effect_forms.cases(),
}
TIMED = [(host, name) for host, forms in FORMS.items() for name in forms]
CONDITIONS = ("spring", "damper", "friction")
EFFECT_OPERATION, CREATE, START = 0x1A, 0x21, 1
RATE_HZ = 1000
SPEED_RAD_S, SPEED_FULL_RAD_S = 10.0, 20.0
ANGLE_RAD = np.pi / 8  # half of the half range of 90 degrees


def split(reports: Sequence[bytes]) -> int:
    """Return where what starts the effect is over."""
    return next(n for n, r in enumerate(reports) if r[0] == EFFECT_OPERATION and r[2] == START) + 1


def felt(
    host: str, name: str, length_s: float, hand: torsio.PrescribedMotion
) -> tuple[Floats, Floats]:
    """Play an effect back; return time and the motor's torque as a share of full."""
    options = torsio.EmulatorOptions(
        control_rate_hz=RATE_HZ,
        control=torsio.ControlConfig(law="motor_only"),
        game=torsio.GameConfig(torque_max_nm=FULL_NM, range_deg=90, spring_gain=1),
        hand=hand,
        log_truth=True,
    )
    with torsio.open("emulated", emulator=options) as knob:

        def say(reports: Sequence[bytes]) -> None:
            for report in reports:
                if report[0] >= CREATE:
                    assert knob.emulator.game.set_feature(report)
                else:
                    knob.emulator.game.write(report)

        recorded = HOSTS[host]["reports"]
        say([bytes.fromhex(line) for line in recorded["begin"]])
        knob.emulator.advance(0.05)
        reports = [bytes.fromhex(line) for line in recorded[name]]
        begun = split(reports)
        say(reports[:begun])
        knob.emulator.advance(length_s)
        say(reports[begun:])
        knob.emulator.advance(0.1)
        assert knob.game_status().effects == 0
        truth = knob.emulator.truth()
        return np.array(truth["time_s"]), np.array(truth["motor_torque_nm"]) / FULL_NM


@pytest.mark.parametrize(("host", "name"), TIMED)
def test_effect_of_a_real_host_has_its_closed_form(host: str, name: str) -> None:
    case = FORMS[host][name]
    whole_s = case.length_s + case.effect.delay_ms / 1e3
    still = torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (9.0, 0.0)])
    time_s, torque = felt(host, name, whole_s + 0.1, still)
    # A tick late on the steepest line.
    assert effect_forms.residual(time_s, torque, case).max() < 0.05
    assert abs(effect_forms.length_error_s(time_s, torque, case)) < 5e-3
    assert np.abs(torque[-50:]).max() < QUIET


@pytest.mark.parametrize("host", HOSTS)
@pytest.mark.parametrize("name", CONDITIONS)
def test_condition_of_a_real_host_is_felt_on_both_sides(host: str, name: str) -> None:
    sides = []
    for way in (1, -1):
        path = [(0.0, 0.0), (0.03, way * ANGLE_RAD), (9.0, way * ANGLE_RAD)]
        if name != "spring":
            path = [(0.0, 0.0), (9.0, way * 9.0 * SPEED_RAD_S)]
        _, torque = felt(host, name, 0.25, torsio.PrescribedMotion(angle_rad=path))
        sides.append(float(np.median(torque[np.abs(torque) > QUIET])))
    share = {"spring": 0.25, "damper": 0.5 * SPEED_RAD_S / SPEED_FULL_RAD_S, "friction": 0.5}[name]
    assert sides == pytest.approx([-share, share], rel=0.03)


def test_springs_of_linux_push_as_far_on_either_side() -> None:
    # Its saturation is three quarters, which half a coefficient exceeds far beyond the axis.
    for way in (1, -1):
        path = [(0.0, 0.0), (0.2, way * 2.0), (9.0, way * 2.0)]
        _, torque = felt("linux", "spring", 0.25, torsio.PrescribedMotion(angle_rad=path))
        assert np.abs(torque).max() == pytest.approx(0.75, rel=0.01)
