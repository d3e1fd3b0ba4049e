"""Force feedback as Linux's own driver and games get it."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import torsio
from tests.vm.guest import gamepad
from tests.vm.guest.gamepad import Effect, Envelope, Gamepad
from tests.vm.guest.virtual_bus import VirtualBus, VirtualKnob, wait_for

FULL_NM = 0.06
TICK_S = 1e-3
Floats = npt.NDArray[np.float64]
Form = Callable[[Floats], Floats]


def test_driver_takes_all_that_is_advertised(knob: VirtualKnob) -> None:
    pad = Gamepad(knob)
    # All but custom forces and autocenter. The kernel makes rumble of a sine.
    expected = {*range(gamepad.RUMBLE, gamepad.SAW_DOWN + 1), gamepad.GAIN}
    assert pad.bits(0x15) == expected
    assert pad.effects() == 40
    assert pad.bits(0x03) == {0}  # X alone
    assert pad.bits(0x01) == {0x120, 0x121}  # two buttons of a joystick, and none that is no button
    assert pad.axis() == (0, -32767, 32767)
    effect = Effect(gamepad.CONSTANT, gamepad.constant(1))
    numbers = [pad.upload(effect) for _ in range(40)]
    assert sorted(numbers) == list(range(40))
    with pytest.raises(OSError, match="No space left"):
        pad.upload(effect)
    pad.erase(numbers[7])

    def upload_again() -> list[int]:
        try:
            return [pad.upload(effect)]
        except OSError:
            return []

    # The free block goes over another endpoint than the new one: it may come late.
    assert wait_for("the block to be free", upload_again) == [numbers[7]]
    pad.close()


# What the motor gives ------------------------------------------------------------------------


def plug(bus: VirtualBus, tmp_path: Path, *, range_deg: float = 900) -> tuple[VirtualKnob, Path]:
    """Plug a knob in whose motor alone renders, and which logs what it truly gives."""
    log = tmp_path / "log"
    knob = bus.plug(options=["--status", "--log", str(log)])
    knob.say("still")
    with torsio.open(knob.serial) as opened:
        opened.configure(torsio.ControlConfig(law="motor_only"))
        opened.configure(torsio.GameConfig(torque_max_nm=FULL_NM, range_deg=range_deg))
    return knob, log


def let_pass(knob: VirtualKnob, duration_s: float) -> None:
    """Wait until so much of the knob's own time is over, which a busy machine makes slower."""
    assert knob.process.stdout is not None
    file = knob.process.stdout.fileno()
    os.set_blocking(file, False)
    end_s: float | None = None

    def is_over() -> bool:
        nonlocal end_s
        try:
            lines = os.read(file, 1 << 16).decode().splitlines()
        except BlockingIOError:
            return False
        words = [line.split() for line in lines]
        # The first and the last line may be parts of a line.
        times = [float(word[1]) for word in words if len(word) == 7 and word[0] == "status"]
        if not times:
            return False
        if end_s is None:
            # A line comes every 0.1 s, the last one may be as old.
            end_s = times[-1] + 0.1 + duration_s
        return times[-1] >= end_s

    wait_for("the knob's time to pass", is_over)


def read_log(bus: VirtualBus, log: Path) -> tuple[Floats, Floats, Floats]:
    """End all knobs and return time in s, angle, and the motor's torque as a share of full."""
    bus.end()
    data = np.loadtxt(log, delimiter=",", skiprows=1, usecols=(0, 1, 2))
    return data[:, 0] * 1e-9, data[:, 1], data[:, 2] / FULL_NM


def pieces(time_s: Floats, torque: Floats, pause_s: float) -> list[tuple[Floats, Floats]]:
    """Return what lies between pauses, each with a pause before and behind."""
    loud = np.flatnonzero(np.abs(torque) > 1e-4)
    cuts = np.flatnonzero(np.diff(time_s[loud]) > pause_s)
    firsts = loud[np.concatenate(([0], cuts + 1))]
    lasts = loud[np.concatenate((cuts, [loud.size - 1]))]
    return [
        (time_s[max(first - 20, 0) : last + 20], torque[max(first - 20, 0) : last + 20])
        for first, last in zip(firsts, lasts, strict=True)
    ]


def envelope(peak: float, length_s: float, shape: Envelope, t: Floats) -> Floats:
    """Straight lines from the attack's level and to the fade's."""
    attack_s, fade_s = shape.attack_ms / 1e3, shape.fade_ms / 1e3
    points = [(attack_s, peak), (length_s - fade_s, peak)]
    if attack_s:
        points.insert(0, (0.0, shape.attack_level / 32767))
    if fade_s:
        points.append((length_s, shape.fade_level / 32767))
    times, levels = np.array(points, dtype=np.float64).T
    found: Floats = np.interp(t, times, levels)
    return found


def sine(t: Floats) -> Floats:
    return np.sin(2 * np.pi * t)


def square(t: Floats) -> Floats:
    return np.where(t % 1 < 0.5, 1.0, -1.0)


def triangle(t: Floats) -> Floats:
    return 1 - 4 * np.abs((t + 0.25) % 1 - 0.5)


def saw_up(t: Floats) -> Floats:
    return 2 * (t % 1) - 1


def saw_down(t: Floats) -> Floats:
    return 1 - 2 * (t % 1)


WAVES = {
    gamepad.SQUARE: square,
    gamepad.TRIANGLE: triangle,
    gamepad.SINE: sine,
    gamepad.SAW_UP: saw_up,
    gamepad.SAW_DOWN: saw_down,
}


def scaled(
    wave: Form, period_s: float, amplitude: float, *, offset: float = 0, phase: float = 0
) -> Form:
    """Return a wave over time in s; the phase is in turns."""
    return lambda t: amplitude * wave(t / period_s + phase) + offset


FADING = Envelope(attack_ms=60, attack_level=0, fade_ms=80, fade_level=32767)


def cases() -> dict[str, tuple[Effect, int, float, Form]]:
    """Return effect, loops, whole length in s and torque, a share of full, by name."""
    kind, share = gamepad.CONSTANT, 20000 / 32767
    found: dict[str, tuple[Effect, int, float, Form]] = {
        "largest": (Effect(kind, gamepad.constant(32767), 100), 1, 0.1, np.ones_like),
        "smallest": (
            Effect(kind, gamepad.constant(-32767), 100),
            1,
            0.1,
            lambda t: -np.ones_like(t),
        ),
        "to the left": (
            Effect(kind, gamepad.constant(32767), 100, direction=gamepad.LEFT),
            1,
            0.1,
            lambda t: -np.ones_like(t),
        ),
        "from the north-west": (
            Effect(kind, gamepad.constant(32767), 100, direction=0xE000),
            1,
            0.1,
            lambda t: np.full_like(t, np.sqrt(0.5)),
        ),
        "envelope": (
            Effect(kind, gamepad.constant(20000, FADING), 300),
            1,
            0.3,
            lambda t: envelope(share, 0.3, FADING, t),
        ),
        "loops with delay": (
            Effect(kind, gamepad.constant(20000, FADING), 200, delay_ms=150),
            3,
            0.6,
            lambda t: envelope(share, 0.2, FADING, t % 0.2),
        ),
        "ramp": (
            Effect(gamepad.RAMP, gamepad.ramp(-32767, 32767), 300),
            1,
            0.3,
            lambda t: 2 * t / 0.3 - 1,
        ),
    }
    for code, wave in WAVES.items():
        found[f"{wave.__name__}, full"] = (
            Effect(gamepad.PERIODIC, gamepad.periodic(code, 32767, 100), 300),
            1,
            0.3,
            scaled(wave, 0.1, 1.0),
        )
        parameters = gamepad.periodic(code, 15000, 80, offset=-12000, phase=0x4000)
        found[f"{wave.__name__}, offset and phase"] = (
            Effect(gamepad.PERIODIC, parameters, 280),
            1,
            0.28,
            scaled(wave, 0.08, 15000 / 32767, offset=-12000 / 32767, phase=0.25),
        )
    return found


def error(time_s: Floats, torque: Floats, length_s: float, form: Form) -> tuple[float, float]:
    """Return the largest distance from a closed form, and the length's error in s.

    The beginning is not known to the tick: it is where the form fits best, within 4 ms before
    the first torque. Left out are 3 ms after the beginning, before the end, and on either side of
    the form's own jumps: there the device blends for 2 ms, and a tick is held for 1 ms.
    """
    loud = np.flatnonzero(np.abs(torque) > 1e-4)
    first, last = time_s[loud[0]], time_s[loud[-1]]
    best = np.inf
    for begin in first + np.arange(-4e-3, 1e-3, TICK_S / 4):
        t = time_s - begin
        counted = (t > 3e-3) & (t < length_s - 3e-3)
        for shift in (-3e-3, 3e-3):
            counted &= np.abs(form(t + shift) - form(t)) < 0.5
        best = min(best, float(np.abs(torque - form(t))[counted].max()))
    return best, float(last - first) - length_s


def test_timed_effects_have_their_closed_form(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path)
    pad = Gamepad(knob)
    pause_s = 0.08
    for effect, loops, length_s, _ in cases().values():
        number = pad.upload(effect)
        pad.play(number, loops)
        let_pass(knob, length_s + effect.delay_ms / 1e3 + 3 * pause_s)
        pad.erase(number)
    pad.close()
    time_s, _, torque = read_log(bus, log)
    found = pieces(time_s, torque, pause_s)
    assert len(found) == len(cases())
    errors = {
        name: error(*piece, length_s, form)
        for piece, (name, (_, _, length_s, form)) in zip(found, cases().items(), strict=True)
    }
    print({name: (round(a, 4), round(b, 4)) for name, (a, b) in errors.items()})
    # A tick late on the steepest line, which is 2 / 100 ms for a sawtooth, and on the sine.
    assert {name: e for name, (e, _) in errors.items() if e > 0.05} == {}
    assert {name: late for name, (_, late) in errors.items() if abs(late) > 5e-3} == {}


def test_playing_effect_is_changed_scaled_stopped_and_erased(
    bus: VirtualBus, tmp_path: Path
) -> None:
    knob, log = plug(bus, tmp_path)
    pad = Gamepad(knob)

    def show(level: int, number: int) -> int:
        return pad.upload(Effect(gamepad.CONSTANT, gamepad.constant(level), number=number))

    number = show(8000, -1)
    pad.play(number)
    let_pass(knob, 0.1)
    for level in (16000, -24000, 32767):
        show(level, number)
        let_pass(knob, 0.1)
    for gain in (0x8000, 0x0000, 0xFFFF):
        pad.set_gain(gain)
        let_pass(knob, 0.1)
    pad.play(number, 0)
    let_pass(knob, 0.1)
    pad.play(number)
    let_pass(knob, 0.1)
    pad.erase(number)
    let_pass(knob, 0.1)
    pad.close()
    _, _, torque = read_log(bus, log)
    # What is held for at least 50 ms, one after the other.
    steady = np.convolve(np.abs(np.diff(torque)) < 1e-5, np.ones(50), "valid") == 50
    levels = torque[:-50][steady]
    held = [levels[0], *levels[1:][np.abs(np.diff(levels)) > 1e-3]]
    expected = [0, 8000, 16000, -24000, 32767, 32767 / 2, 0, 32767, 0, 32767, 0]
    assert np.abs(np.array(held) - np.array(expected) / 32767).max() < 1e-3


# Conditions ----------------------------------------------------------------------------------


def follow(
    bus: VirtualBus,
    tmp_path: Path,
    effect: Effect,
    path: list[tuple[float, float]],
    *,
    range_deg: float = 900,
) -> tuple[Floats, Floats, Floats]:
    """Turn the knob along a path while an effect plays; return what `read_log` does."""
    knob, log = plug(bus, tmp_path, range_deg=range_deg)
    script = tmp_path / "script"
    script.write_text("motion_rad\n" + "".join(f"{t} {angle}\n" for t, angle in path))
    pad = Gamepad(knob)
    pad.play(pad.upload(effect))
    let_pass(knob, 0.1)
    knob.say(f"script {script}")
    let_pass(knob, path[-1][0] + 0.3)
    pad.close()
    return read_log(bus, log)


def test_spring_answers_to_the_angle_beyond_its_dead_band(bus: VirtualBus, tmp_path: Path) -> None:
    parameters = gamepad.condition(30000, saturation=0xC000, dead_band=0x1000)
    path = [(0.0, 0.0), (0.5, 0.75), (1.5, -0.75), (2.0, 0.0)]
    effect = Effect(gamepad.SPRING, parameters)
    _, angle, torque = follow(bus, tmp_path, effect, path, range_deg=90)
    x = angle / (np.pi / 4)
    band = 0x1000 / 0xFFFF
    beyond = np.sign(x) * np.maximum(np.abs(x) - band, 0)
    expected = np.clip(-30000 / 32767 * beyond, -0.75, 0.75)
    assert expected.max() > 0.74
    moving = np.abs(x) > 0.02
    # A tick late at 1.5 rad/s, twice.
    assert np.abs(torque - expected)[moving].max() < 0.01


def plateau(time_s: Floats, rate: Floats, torque: Floats, value: float) -> float:
    """Return the mean torque where a rate has had a value for 60 ms."""
    held = np.convolve(np.abs(rate - value) < 0.02 * abs(value), np.ones(60), "full")[: rate.size]
    assert (held > 59).sum() > 20
    return float(torque[held > 59].mean())


@pytest.mark.parametrize(
    ("kind", "share"), [(gamepad.DAMPER, 0.5 * 10 / 20), (gamepad.FRICTION, 0.5)]
)
def test_damper_and_friction_resist_the_motion(
    bus: VirtualBus, tmp_path: Path, kind: int, share: float
) -> None:
    path = [(0.0, 0.0), (0.3, 3.0), (0.4, 3.0), (0.7, 0.0), (1.0, 0.0)]
    effect = Effect(kind, gamepad.condition(16384))
    time_s, angle, torque = follow(bus, tmp_path, effect, path)
    speed = np.gradient(angle, time_s)
    assert plateau(time_s, speed, torque, 10.0) == pytest.approx(-share, rel=0.03)
    assert plateau(time_s, speed, torque, -10.0) == pytest.approx(share, rel=0.03)


def test_inertia_resists_the_acceleration(bus: VirtualBus, tmp_path: Path) -> None:
    t = np.arange(0, 0.2, 1e-3)
    path = [(float(s), float(150 * s**2)) for s in t]
    effect = Effect(gamepad.INERTIA, gamepad.condition(32767))
    time_s, angle, torque = follow(bus, tmp_path, effect, path)
    acceleration = np.gradient(np.gradient(angle, time_s), time_s)
    mean = plateau(time_s, acceleration, torque, 300.0)
    assert mean == pytest.approx(-300 / 3000, rel=0.1)


# When a game dies ----------------------------------------------------------------------------


def fall(time_s: Floats, torque: Floats) -> float:
    """Return the time in s from full torque to none for good."""
    full = np.flatnonzero(np.abs(torque) > 0.99)[-1]
    loud = np.flatnonzero(np.abs(torque) > 1e-4)[-1]
    return float(time_s[loud] - time_s[full])


def test_killed_game_leaves_no_force(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path)
    ready, done = os.pipe()
    game = os.fork()
    if game == 0:
        pad = Gamepad(knob)
        pad.play(pad.upload(Effect(gamepad.CONSTANT, gamepad.constant(32767))))
        os.write(done, b".")
        signal.pause()
    os.read(ready, 1)
    let_pass(knob, 0.3)
    os.kill(game, signal.SIGKILL)
    killed = time.monotonic()
    os.waitpid(game, 0)
    os.close(ready)
    os.close(done)
    with torsio.open(knob.serial) as opened:
        wait_for("the game to let go", lambda: opened.health().owner == "none")
        assert opened.state == "disarmed"
    assert time.monotonic() - killed < 20
    again = Gamepad(knob)  # all forty are free again
    assert (
        len({again.upload(Effect(gamepad.CONSTANT, gamepad.constant(1))) for _ in range(40)}) == 40
    )
    again.close()
    time_s, _, torque = read_log(bus, log)
    assert fall(time_s, torque) <= 4e-3  # blend_s and two ticks


@pytest.mark.pulls_cable
def test_unplugged_game_fades(bus: VirtualBus, tmp_path: Path) -> None:
    knob, log = plug(bus, tmp_path)
    pad = Gamepad(knob)
    pad.play(pad.upload(Effect(gamepad.CONSTANT, gamepad.constant(32767))))
    let_pass(knob, 0.3)
    knob.unplug()
    let_pass(knob, 0.3)
    pad.close()
    time_s, _, torque = read_log(bus, log)
    assert 0.045 < fall(time_s, torque) < 0.055  # passive_ramp_s
