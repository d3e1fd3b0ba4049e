"""The knob as Windows games get it under Wine: its DirectInput drives the reports by itself.

Wine's driver for HID devices and its `dinput` parse the report descriptor and write the reports
over hidraw, without Linux's driver. Told to, it takes the event device instead. Takes minutes:
``./dev test games``.
"""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.vm.guest import effect_forms
from tests.vm.guest.direct_input import (
    DIRECT_INPUT,
    HALF,
    LENGTH_MS,
    PLAYED,
    PREFIX,
    PUSHED,
    SATURATED,
    Game,
    acquired,
    environment,
)
from tests.vm.guest.torque_log import Floats, held, let_pass, pieces, plug, read_log, turn
from tests.vm.guest.virtual_bus import VirtualBus

pytestmark = [pytest.mark.kernel("6.1"), pytest.mark.games, pytest.mark.usefixtures("udev")]


@pytest.fixture
def wine() -> Iterator[None]:
    """Leave nothing of Wine running."""
    yield
    subprocess.run(["wineserver", "-k"], env=environment(), check=False)


@pytest.fixture
def wine_over_evdev(wine: None) -> Iterator[None]:
    """Have Wine take event devices, and no hidraw."""
    registry = PREFIX / "system.reg"
    text = registry.read_text(errors="surrogateescape")
    changed = text.replace('"DisableHidraw"=dword:00000000', '"DisableHidraw"=dword:00000001')
    changed = changed.replace('"DisableInput"=dword:00000001', '"DisableInput"=dword:00000000')
    registry.write_text(changed, errors="surrogateescape")
    yield
    subprocess.run(["wineserver", "-k", "-w"], env=environment(), check=False)
    registry.write_text(text, errors="surrogateescape")


@pytest.fixture(params=["wine", "wine_over_evdev"])
def way(request: pytest.FixtureRequest) -> str:
    """Have Wine take hidraw, and then event devices."""
    name = str(request.param)
    request.getfixturevalue(name)
    return name


SPEED_RAD_S = 10.0
SPEED_FULL_RAD_S = 20.0
ACCELERATION_RAD_S2 = 50.0
ANGLE_RAD = np.pi / 8  # half of the half range of 90 degrees


def steady(pieces_: list[tuple[Floats, Floats]], where: int) -> float:
    """Return the torque in the middle third of a piece."""
    torque = pieces_[where][1]
    return float(np.mean(torque[torque.size // 3 : 2 * torque.size // 3]))


def test_each_effect_of_direct_input_is_felt_as_it_was_made(
    bus: VirtualBus, tmp_path: Path, way: str
) -> None:
    # Over event devices Wine keeps the number of an effect that was released, and Linux takes no
    # other kind of effect under it (bus_udev.c: effect_ids; ff-core.c: check_effects_compatible).
    options = ("keep",) if way == "wine_over_evdev" else ()
    knob, log = plug(bus, tmp_path, range_deg=90)
    with acquired(*DIRECT_INPUT, *options) as game:
        for name, (words, _) in PLAYED.items():
            game.play(name, words)
        turn(knob, tmp_path, [(0.0, 0.0), (0.05, ANGLE_RAD)])
        game.play("spring", f"spring {LENGTH_MS} {PUSHED}")
        # The speed goes up and down between -50 and 50 rad/s, in two seconds each, and falls from
        # the first second on. All begins where the knob stands: a jump would be a fault.
        times = np.arange(0, 4, 2e-3, dtype=np.float64)
        angle = ANGLE_RAD + np.cumsum(50 * effect_forms.triangle(times / 4)) * 2e-3
        turn(knob, tmp_path, list(zip(times.tolist(), angle.tolist(), strict=True)))
        let_pass(knob, 1.2)
        game.play("inertia", f"inertia {LENGTH_MS} 10000 1 0 10000 {SATURATED}")
        let_pass(knob, 4.0)
        # To and fro, so that it lasts until the program has heard of it.
        turns = [(n * 3.0, ANGLE_RAD + n % 2 * 3.0 * SPEED_RAD_S) for n in range(8)]
        turn(knob, tmp_path, turns)
        game.play("damper", f"damper {LENGTH_MS} {PUSHED}")
        game.play("friction", f"friction {LENGTH_MS} {PUSHED}")
    time_s, _, torque = read_log(bus, log)
    found = pieces(time_s, torque, 0.1)
    told = "; ".join(f"{t[0]:.2f} s: {np.mean(x):.3f}" for t, x in found)
    assert len(found) == len(PLAYED) + 4, told
    errors = {}
    for (name, (_, form)), (t, x) in zip(PLAYED.items(), found, strict=False):
        errors[name] = float(effect_forms.residual(t, x, form).max())
        assert abs(effect_forms.length_error_s(t, x, form)) < 8e-3, name
    print("worst distance from the closed forms:", errors)
    assert max(errors.values()) < 0.03
    spring, inertia, damper, friction = range(len(PLAYED), len(found))
    assert steady(found, spring) == pytest.approx(-0.25, abs=0.01)
    resisting = steady(found, inertia)
    assert resisting == pytest.approx(ACCELERATION_RAD_S2 / 3000, rel=0.1)
    expected = 0.5 * SPEED_RAD_S / SPEED_FULL_RAD_S
    assert abs(steady(found, damper)) == pytest.approx(expected, rel=0.05)
    assert abs(steady(found, friction)) == pytest.approx(0.5, rel=0.05)


@pytest.mark.usefixtures("way")
def test_playing_effect_follows_its_updates_and_ends_with_the_game(
    bus: VirtualBus, tmp_path: Path
) -> None:
    knob, log = plug(bus, tmp_path, range_deg=90)
    with acquired(*DIRECT_INPUT) as game:
        game.play("levels", f"follow 200 {HALF} -2500 0 10000 -{HALF} 1000")
    # Nobody has stopped it but the game's end.
    let_pass(knob, 0.5)
    _, _, torque = read_log(bus, log)
    expected = [0, -0.5, 0.25, 0, -1, 0.5, -0.1, 0]
    assert held(torque) == pytest.approx(expected, abs=2e-3)


@pytest.mark.usefixtures("way")
def test_force_of_a_game_that_is_killed_ends(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path, range_deg=90)
    game = Game(*DIRECT_INPUT)
    game.hear("acquired")
    game.play("push", f"follow 100 {HALF}")
    game.kill()
    let_pass(knob, 15)
    time_s, _, torque = read_log(bus, log)
    ((when_s, what),) = pieces(time_s, torque, 0.1)
    assert float(what.min()) == pytest.approx(-0.5, abs=2e-3)
    # Long before the knob lets go after 10 s of silence.
    assert time_s[-1] - when_s[-1] > 8
