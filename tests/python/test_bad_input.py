"""Bad input gives a specific error, leaves the scene alone, and never hangs."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import torsio
from tests.python.processes import python
from torsio import (
    ActuatorConfig,
    BoardConfig,
    Constant,
    ControlConfig,
    Curve,
    Detents,
    InvalidArgument,
    Knob,
    LinkFaults,
    Periodic,
    PlantParams,
    PrescribedMotion,
    Texture,
    Timing,
    TorqueHand,
    Wall,
    _torsio,
)

WALL = Wall(stiffness_nm_per_rad=1.0)
BACKWARDS = TorqueHand(torque_nm=[(0, 1), (-1, 1)])
OLD_TORQUE_NM = 0.0123


@pytest.fixture
def playing() -> Iterator[Knob]:
    """Give an armed knob that plays a constant torque."""
    with torsio.open(
        "emulated", emulator=torsio.EmulatorOptions(hand=PrescribedMotion(angle_rad=0.0))
    ) as knob:
        knob.play(Constant(torque_nm=OLD_TORQUE_NM))
        knob.arm()
        knob.sleep(0.1)
        yield knob
        assert torque(knob) == pytest.approx(OLD_TORQUE_NM, abs=1e-5), "the old scene must go on"
        assert knob.state == "armed"


def torque(knob: Knob) -> float:
    return float(knob.record(duration_s=0.05)["desired_torque_nm"][-1])


# What only Python can give, and one of each way into the library; the rules are its own, and
# tests/cpp/sdk/test_sdk_scene.cpp has them all.
BAD_SCENES: list[tuple[Any, type[Exception], str]] = [
    (Wall(stiffness_nm_per_rad=math.nan), InvalidArgument, "stiffness_nm_per_rad is not a number"),
    (Wall(stiffness_nm_per_rad=1.0, side="beside"), InvalidArgument, "side"),  # type: ignore[arg-type]
    (Wall(stiffness_nm_per_rad="stiff"), TypeError, "stiffness_nm_per_rad"),  # type: ignore[arg-type]
    (Constant(torque_nm=0.1, timing=Timing(attack_level=2.0)), InvalidArgument, "attack_level"),
    (Detents(torque_nm=0.1), InvalidArgument, "exactly one of per_turn and pitch_rad"),
    (Texture(torque_nm=0.1, grains_per_turn=2.5), TypeError, "whole number"),  # type: ignore[arg-type]
    (Texture(torque_nm=0.1, grains_per_turn=9, seed=-1), InvalidArgument, "seed"),
    (Curve(torque_nm=np.zeros(1025)), InvalidArgument, "1025"),
    ([Curve(torque_nm=np.zeros(600))] * 2, InvalidArgument, "1024"),
    (Wall(stiffness_nm_per_rad=10**400), InvalidArgument, "stiffness_nm_per_rad is too large"),
    (itertools.repeat(Constant(torque_nm=0.1)), InvalidArgument, "17 effects"),
    (None, TypeError, "not an effect"),
    ([object()], TypeError, "not an effect"),
]


@pytest.mark.parametrize(("scene", "kind", "message"), BAD_SCENES)
def test_bad_scene_is_refused_by_name(
    playing: Knob, scene: Any, kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=message):
        playing.play(scene)


# Ranges and states are the C++ library's: tests/cpp/sdk/test_sdk_knob.cpp.
BAD_CALLS: list[tuple[Callable[[Knob], object], type[Exception], str]] = [
    (lambda k: k.stream_local_model(torque_nm=math.nan), InvalidArgument, "torque_nm"),
    (lambda k: k.start_telemetry(rate_hz=math.nan), InvalidArgument, "rate_hz"),
    (lambda k: k.record(duration_s=math.inf), InvalidArgument, "duration_s"),
    (lambda k: k.record_to("a\0.mcap"), InvalidArgument, "path cannot name a file: 'a.x00.mcap'"),
    (lambda k: torsio.load(""), InvalidArgument, "path cannot name a file: ''"),
    (lambda k: torsio.trade(WALL, parts="belt"), TypeError, "parts must be several names"),
    (lambda k: k.record_to("a.txt"), InvalidArgument, "ends in .mcap, and 'a.txt' does not"),
    (lambda k: k.read(max_samples=-1), InvalidArgument, "max_samples"),
    (lambda k: k.read(timeout_s=math.nan), InvalidArgument, "timeout_s"),
    (lambda k: k.wait_for("asleep"), InvalidArgument, "state"),  # type: ignore[arg-type]
    (lambda k: k.configure(ControlConfig(law="hope")), InvalidArgument, "law"),  # type: ignore[arg-type]
    (lambda k: k.configure(BoardConfig(light_pin=-1)), InvalidArgument, "light_pin is -1"),
    (lambda k: k.zero(), torsio.Refused, "disarm"),
    (lambda k: k.emulator.set_hand(TorqueHand(torque_nm=[])), InvalidArgument, "at least one knot"),
    (lambda k: k.emulator.set_hand(TorqueHand(torque_nm=math.nan)), InvalidArgument, "finite"),
    (lambda k: k.emulator.set_hand(BACKWARDS), InvalidArgument, "torque_nm: knot 1 is earlier"),
    (lambda k: k.emulator.set_link_faults(LinkFaults(drop_input="all")), TypeError, "drop_input"),  # type: ignore[arg-type]
    (lambda k: k.emulator.skip_ticks(count=-1), InvalidArgument, "count is -1"),
    (lambda k: k.emulator.jump_encoder(counts=2**70), InvalidArgument, "counts"),
    (lambda k: k.emulator.jump_encoder(counts=10**5000), InvalidArgument, "counts"),
    (lambda k: k.emulator.cut_power_in_next_save(after_bytes=-1), InvalidArgument, "after_bytes"),
    (lambda k: k.emulator.freeze_encoder(frozen=1), TypeError, "frozen"),  # type: ignore[arg-type]
    (lambda k: k.stream_local_model(torque_nm="a"), TypeError, "torque_nm"),  # type: ignore[arg-type]
    (lambda k: k.stream_local_model(torque_nm=10**400), InvalidArgument, "torque_nm"),
    (lambda k: k.record(duration_s="1"), TypeError, "duration_s"),  # type: ignore[arg-type]
    (lambda k: k.record(duration_s=0.1, rate_hz="a"), TypeError, "rate_hz"),  # type: ignore[arg-type]
    (lambda k: k.read(max_samples=1.5), TypeError, "max_samples must be a whole"),  # type: ignore[arg-type]
    (lambda k: k.sleep(None), TypeError, "duration_s"),  # type: ignore[arg-type]
    (lambda k: k.telemetry(duration_s=math.nan), InvalidArgument, "duration_s is nan"),
    (lambda k: k.telemetry(duration_s=math.inf), InvalidArgument, "duration_s is inf"),
    (lambda k: k.telemetry(duration_s=-1), InvalidArgument, "duration_s is -1"),
    (lambda k: k.telemetry(max_samples=0), InvalidArgument, "max_samples is 0"),
    (lambda k: k.telemetry(timeout_s=0), InvalidArgument, "timeout_s is 0"),
]


@pytest.mark.parametrize(("call", "kind", "message"), BAD_CALLS)
def test_bad_call_is_refused_by_name(
    playing: Knob, call: Callable[[Knob], object], kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=message):
        call(playing)


BAD_OPENS: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"control_rate_hz": math.nan}, InvalidArgument, "control_rate_hz"),
    ({"seed": -1}, InvalidArgument, "seed"),
    ({"seed": 1.5}, TypeError, "seed must be a whole number, is 1.5"),
    ({"control_rate_hz": "fast"}, TypeError, "control_rate_hz must be a number"),
    ({"serial": b"TS-0001"}, TypeError, "serial must be a string"),
    ({"paced": "yes"}, TypeError, "paced must be True or False"),
    ({"plant": 3}, TypeError, "plant must be a torsio.PlantParams, is 3"),
    ({"control": ActuatorConfig()}, TypeError, "control must be ControlConfig or None"),
    ({"hand": 3}, TypeError, "hand"),
    ({"control": ControlConfig(beta=-0.1)}, InvalidArgument, "beta"),
    ({"actuator": ActuatorConfig(brake_drag_nm=math.nan)}, InvalidArgument, "brake_drag_nm"),
]


@pytest.mark.parametrize(("options", "kind", "message"), BAD_OPENS)
def test_bad_option_of_an_emulated_knob_is_refused_by_name(
    options: dict[str, Any], kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=message):
        torsio.open("emulated", emulator=torsio.EmulatorOptions(**options))


@pytest.mark.parametrize(
    ("options", "kind", "message"),
    [
        ({"ring_samples": "a"}, TypeError, "ring_samples"),
        ({"ring_samples": 0}, InvalidArgument, "ring_samples"),
        ({"command_timeout_s": -1.0}, InvalidArgument, "command_timeout_s"),
    ],
)
def test_bad_argument_of_open_is_refused_by_name(
    options: dict[str, Any], kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=message):
        torsio.open("emulated", **options)


BAD_VALUES: list[tuple[Callable[[], object], type[Exception], str]] = [
    (lambda: torsio.open(5), TypeError, "a path, serial number or Transport, not 5"),  # type: ignore[arg-type]
    (lambda: torsio.open(""), InvalidArgument, "selector is empty"),
    (lambda: Constant(torque_nm=0.1, timing=None), TypeError, "timing"),  # type: ignore[arg-type]
    (lambda: Periodic(amplitude_nm=0.1, frequency_hz=1.0, timing=1.0), TypeError, "timing"),  # type: ignore[arg-type]
    (lambda: Curve(torque_nm="123"), TypeError, "torque_nm must be several numbers"),  # type: ignore[arg-type]
    (lambda: Curve(torque_nm=3), TypeError, "torque_nm must be several numbers"),  # type: ignore[arg-type]
    (lambda: Curve(torque_nm=["a", "b"]), TypeError, "torque_nm must be a number"),  # type: ignore[list-item]
    (lambda: Curve(torque_nm=np.zeros((2, 2))), TypeError, "torque_nm must be a number"),
    (lambda: Curve(torque_nm=[10**400, 0]), InvalidArgument, "torque_nm is too large"),
    (lambda: PlantParams(belt=3), TypeError, "belt"),  # type: ignore[arg-type]
    (lambda: TorqueHand(torque_nm="a"), TypeError, "torque_nm must be a number or knots"),  # type: ignore[arg-type]
    (lambda: TorqueHand(torque_nm=None), TypeError, "torque_nm must be a number or knots"),  # type: ignore[arg-type]
    (lambda: TorqueHand(torque_nm=[1, 2]), TypeError, "torque_nm, a profile's knot,"),  # type: ignore[list-item]
    (lambda: TorqueHand(torque_nm=[(1, 2, 3)]), InvalidArgument, "must be \\(time_s, value\\)"),
]


@pytest.mark.parametrize(("make", "kind", "message"), BAD_VALUES)
def test_value_that_no_play_could_use_is_refused_when_made(
    make: Callable[[], object], kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=message) as caught:
        make()
    assert len(str(caught.value).splitlines()) == 1


def test_numbers_of_numpy_are_numbers() -> None:
    hand = TorqueHand(torque_nm=np.float32(0.5))  # type: ignore[arg-type]
    assert hand.torque_nm == ((0.0, 0.5),)
    assert Curve(torque_nm=np.array([0.25, 0.5], np.float32)).torque_nm == (0.25, 0.5)
    with torsio.open(
        "emulated",
        emulator=torsio.EmulatorOptions(
            seed=np.uint8(3),  # type: ignore[arg-type]
            control_rate_hz=np.float64(2000),
        ),
    ) as knob:
        assert len(knob.record(duration_s=np.float32(0.5))) > 0  # type: ignore[arg-type]


@pytest.mark.parametrize("selector", ["/dev/hidraw250", "TS-9999", ""])
def test_device_that_is_not_there_is_named(selector: str) -> None:
    with pytest.raises(torsio.DeviceNotFound) as caught:
        torsio.open(selector or None)
    assert isinstance(caught.value, FileNotFoundError)
    assert selector in str(caught.value)
    assert "no knob is plugged in" in str(caught.value)


# The device itself, below the SDK: reports that the SDK would never send


def _bound_classes(module: ModuleType) -> Iterator[type]:
    for value in vars(module).values():
        if isinstance(value, ModuleType):
            yield from _bound_classes(value)
        elif type(value).__name__ == "pybind11_type":
            yield value


WITHOUT_INIT = """if True:
    import copy, pickle, sys
    from torsio import _torsio

    scope, _, name = sys.argv[1].rpartition(".")
    for part in scope.split(".")[2:]:
        _torsio = getattr(_torsio, part)
    kind = getattr(_torsio, name)
    made = kind.__new__(kind)
    for name in dir(kind):
        if name.startswith("__"):
            continue
        member = getattr(type(made), name)
        calls = [lambda: getattr(made, name)] if isinstance(member, property) else [
            lambda n=n: getattr(made, name)(*([0] * n)) for n in range(6)
        ]
        for call in calls:
            try:
                call()
            except TypeError:
                continue
            raise SystemExit(f"{name} did something")
    for copied in (
        copy.copy, copy.deepcopy, pickle.dumps, lambda made: pickle.dumps(made, 0), kind.__reduce__
    ):
        try:
            copied(made)
        except TypeError as error:
            assert "cannot pickle or copy" in str(error), error
            continue
        raise SystemExit(f"{copied} did something")
    del made
    print("done")
"""


def test_every_bound_class_is_known_to_the_next_test() -> None:
    assert len(CLASSES) >= 15


CLASSES = sorted(f"{kind.__module__}.{kind.__name__}" for kind in _bound_classes(_torsio))


@pytest.mark.parametrize("name", CLASSES)
def test_object_that_was_made_without_init_is_a_type_error(name: str) -> None:
    done = python(WITHOUT_INIT, name)
    assert done.stdout == "done\n", (done.returncode, done.stderr)


def test_sub_interpreter_is_refused() -> None:
    program = """if True:
        try:
            import _interpreters as interpreters
        except ImportError:
            import _xxsubinterpreters as interpreters
        other = interpreters.create()
        script = "try:\\n import torsio\\nexcept ImportError as error: print(error, flush=True)"
        told = interpreters.run_string(other, script)
        assert told is None, told
    """
    done = python(program)
    # Newer versions of Python say it themselves.
    words = "torsio works in the main interpreter only|does not support loading in subinterpreters"
    assert re.search(words, done.stdout), done.stderr
