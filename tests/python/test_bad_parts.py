"""Numbers without end, parts of the wrong kind, torques of no hand: one sentence, and soon."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import torsio
from tests.python.processes import command
from torsio import Constant, PrescribedMotion, TorqueHand, Wall, batch

LONG: Any = 10**5000  # Python does not even print it


def forced(effect: Constant, name: str, value: object) -> Constant:
    """Give it a value past its own checks, as a subclass or a copy may."""
    object.__setattr__(effect, name, value)
    return effect


@pytest.mark.parametrize(
    ("effect", "kind", "words"),
    [
        (lambda: forced(Constant(torque_nm=0.1), "timing", 3), TypeError, "no Timing"),
        (lambda: Constant(torque_nm=[LONG]), TypeError, "torque_nm"),  # type: ignore[arg-type]
    ],
)
def test_effect_is_refused_in_one_sentence(effect: Any, kind: type[Exception], words: str) -> None:
    with torsio.open("emulated") as knob, pytest.raises(kind, match=words) as caught:
        knob.play(effect())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "much", [1e9, 1e200, 1e290, 1e308, -1e308, float("inf"), LONG], ids=lambda _: ""
)
def test_hand_that_is_none_is_refused_at_once(much: float) -> None:
    with torsio.open("emulated") as knob:
        hands: tuple[Callable[[], torsio.Hand], ...] = (
            lambda: TorqueHand(torque_nm=much),
            lambda: TorqueHand(torque_nm=[(0.0, 0.0), (1.0, much)]),
            lambda: PrescribedMotion(angle_rad=[(0.0, 0.0), (1e-3, much)]),
            lambda: torsio.ImpedanceHand(stiffness_nm_per_rad=much, intended_angle_rad=0.0),
        )
        for make in hands:
            with pytest.raises(torsio.InvalidArgument):
                knob.emulator.set_hand(make())
        knob.sleep(0.01)  # time goes on with the old hand
        assert knob.emulator.time_s > 0.0


SEVERAL = np.array([1.0, 2.0])
HALF: Any = "\ud800"  # no UTF-8 has it


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda knob: knob.play(LONG), "not an effect: very long"),
        (lambda knob: knob.play([LONG]), "not an effect: very long"),
        (lambda knob: knob.configure(LONG), r"configuration: very long; give torsio\.C"),
        (lambda knob: knob.on_event(LONG), "callback must be .*, is very long"),
        (lambda knob: knob.emulator.set_hand(LONG), "not a hand: very long"),
        (lambda knob: knob.emulator.game.write(LONG), "report must be bytes, is very long"),
        (lambda knob: torsio.watch(LONG), "callback must be .*, is very long"),
        (lambda knob: batch.Knobs(1, actions=LONG), "actions is very long"),
        (lambda knob: TorqueHand(torque_nm=[(0, 0, LONG)]), "torque_nm.* is too large"),
        (lambda knob: knob.play(Wall(stiffness_nm_per_rad=1.0, side=HALF)), r"side .*ud800"),
        (lambda knob: knob.update(law=HALF), r"law must be one of .*ud800"),
        (lambda knob: knob.wait_for(HALF), "state"),
        (lambda knob: torsio.open(HALF), "selector"),
        (lambda knob: torsio.EmulatorOptions(serial=HALF), "serial"),
        (lambda knob: knob.update(encoder_reversed=SEVERAL), "encoder_reversed must be True or"),
    ],
)
def test_value_that_cannot_be_shown_is_told_all_the_same(
    call: Callable[[torsio.Knob], object], words: str
) -> None:
    with (
        torsio.open("emulated") as knob,
        pytest.raises((torsio.InvalidArgument, TypeError), match=words) as caught,
    ):
        call(knob)
    assert "\n" not in str(caught.value)
    str(caught.value).encode()


@pytest.mark.parametrize("arguments", [("demo", "wall"), ("list",), ("info",)])
def test_commands_print_where_letters_are_few(arguments: tuple[str, ...], tmp_path: Path) -> None:
    few = {"PYTHONIOENCODING": "ascii"}
    # Without them Python 3.13 loads no extension, not even NumPy's.
    if sys.prefix.isascii():
        few |= {"LC_ALL": "C", "PYTHONUTF8": "0"}
    result = command(*arguments, cwd=tmp_path, env={**os.environ, **few})
    assert result.returncode == 0, result.stderr
    assert "Traceback" not in result.stderr
    assert result.stdout.isascii()
