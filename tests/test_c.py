"""The C interface: what its library shows, how it answers good and bad calls, who uses it."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import subprocess
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.c import layouts
from tests.python.cpp_headers import read_sdk
from tests.test_guides import examples

TREE = Path(__file__).parent.parent
HEADER = layouts.read()
N = HEADER.numbers
SDK = read_sdk()
STRICT = ("-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic")
FELT = """\
the knob was pushed to 0.130 rad, into a wall at 0.1 rad,
which pushed back with 43 mN m
"""


def _run(*command: str | Path, **variables: str) -> str:
    result = subprocess.run(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        env={**os.environ, **variables},
    )
    if result.returncode != 0:
        pytest.fail(f"{command} failed:\n{result.stdout}", pytrace=False)
    return result.stdout


@pytest.fixture(scope="module")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the C interface alone; TORSIO_TEST_BUILD names another build of it."""
    prefix = tmp_path_factory.mktemp("c") / "prefix"
    build = os.environ.get("TORSIO_TEST_BUILD", str(TREE / "build/release"))
    _run("cmake", "--install", build, "--prefix", prefix, "--component", "c")
    return prefix


@pytest.fixture(scope="module")
def library(prefix: Path) -> Path:
    return prefix / "lib/libtorsio.so"


@pytest.fixture(scope="module")
def lib(library: Path) -> ctypes.CDLL:
    loaded = ctypes.CDLL(str(library))
    for function in HEADER.functions.values():
        known = getattr(loaded, function.name)
        if function.result == "void":
            known.restype = None
        elif function.result.startswith("const char"):
            known.restype = ctypes.c_char_p
        elif function.result.endswith("*"):
            known.restype = ctypes.c_void_p
        elif function.result in ("bool", "size_t"):
            known.restype = {"bool": ctypes.c_bool, "size_t": ctypes.c_size_t}[function.result]
    return loaded


def said(lib: ctypes.CDLL) -> str:
    text: bytes = lib.torsio_last_error()
    return text.decode()


def good(lib: ctypes.CDLL, result: int) -> None:
    assert result == N["TORSIO_OK"], said(lib)


def made(lib: ctypes.CDLL, name: str, **fields: Any) -> Any:
    structure = HEADER.structures[name]()
    good(lib, getattr(lib, f"{name}_init")(ctypes.byref(structure)))
    for field, value in fields.items():
        assert hasattr(structure, field)
        setattr(structure, field, value)
    return structure


@pytest.fixture
def knob(lib: ctypes.CDLL) -> Iterator[ctypes.c_void_p]:
    options = made(lib, "torsio_open_options")
    emulator = made(lib, "torsio_emulator_options", log_truth=True)
    options.emulator = ctypes.addressof(emulator)
    handle = ctypes.c_void_p()
    good(lib, lib.torsio_knob_open(b"emulated", ctypes.byref(options), ctypes.byref(handle)))
    yield handle
    lib.torsio_knob_free(handle)


@pytest.fixture
def scene(lib: ctypes.CDLL) -> Iterator[ctypes.c_void_p]:
    handle = ctypes.c_void_p()
    good(lib, lib.torsio_scene_new(ctypes.byref(handle)))
    yield handle
    lib.torsio_scene_free(handle)


# --- what the library shows ----------------------------------------------------------------------


def test_library_shows_exactly_what_the_header_declares(library: Path) -> None:
    shown = _run("nm", "--dynamic", "--defined-only", "--with-symbol-versions", library).split("\n")
    symbols = {line.split()[2] for line in shown if " T " in line}
    assert {name.partition("@@")[2] for name in symbols} == {"TORSIO_0.1"}
    assert {name.partition("@@")[0] for name in symbols} == set(HEADER.functions)
    others = [line for line in shown if line and " T " not in line and " A TORSIO_" not in line]
    assert others == []


def test_library_names_its_interface(library: Path) -> None:
    link = os.readlink(library)
    chain = [library.name, link, os.readlink(library.parent / link)]
    assert chain[:2] == ["libtorsio.so", "libtorsio.so.0.1"]
    assert re.fullmatch(r"libtorsio\.so\.0\.1\.\d+", chain[2])
    assert "[libtorsio.so.0.1]" in _run("readelf", "--dynamic", library)


def test_interface_is_the_released_one() -> None:
    """Functions, and names, offsets and types of all members, against what was written down."""
    released = (TREE / "tests/c/interface.txt").read_text(encoding="utf-8")
    assert layouts.interface() == released, (
        "the C interface has changed: programs that were linked with it may break. If it must be, "
        "run python -m tests.c.layouts > tests/c/interface.txt, and raise the minor version before "
        "the next release"
    )


def test_compiler_lays_out_structures_as_the_second_reader_does(tmp_path: Path) -> None:
    lines = ["#include <stdio.h>", "#include <torsio.h>", "int main(void) {"]
    expected = []
    for name, structure in HEADER.structures.items():
        lines.append(f'printf("%zu\\n", sizeof({name}));')
        expected.append(ctypes.sizeof(structure))
        for field, *_ in structure._fields_:
            lines.append(f'printf("%zu\\n", offsetof({name}, {field}));')
            expected.append(getattr(structure, field).offset)
    (tmp_path / "sizes.c").write_text("\n".join([*lines, "}"]))
    _run("gcc", "-std=c11", f"-I{layouts.HEADERS}", tmp_path / "sizes.c", "-o", tmp_path / "sizes")
    assert [int(word) for word in _run(tmp_path / "sizes").split()] == expected


def test_all_members_of_the_cpp_classes_have_a_twin() -> None:
    """Where the languages differ on purpose, a table says what C has instead."""
    instead = {
        "Knob.open": "torsio_knob_open",
        "Knob.events": "torsio_knob_next_event",
        "Knob.on_event": "torsio_knob_next_event",
        "Knob.configure": "torsio_knob_set_control_config",
        "Knob.update": "torsio_knob_set_control_config",
        "Knob.emulator": "torsio_emulator_advance",
        "Knob.Knob": "torsio_knob_open",
        "Emulator.set_hand": "torsio_emulator_set_torque_hand",
        "DeviceWatch.stop": "torsio_watch_free",
        "DeviceWatch.is_stopped": "torsio_watch_next",
    }
    without = {
        "Emulator.game",  # for the tests of drivers, in C++ and Python
        "Emulator.inputs",  # for recordings, which are Python's
        "Knob.tap",  # the same, and for pages that look on
        "Knob.feature",  # the same
    }
    prefixes = {"Knob": "torsio_knob", "Emulator": "torsio_emulator", "DeviceWatch": "torsio_watch"}
    for name, start in prefixes.items():
        for member in SDK.scopes[name].functions:
            own = f"{name}.{member}"
            if own not in without and own not in instead:
                assert f"{start}_{member}" in HEADER.functions, own
    assert set(instead.values()) <= set(HEADER.functions)


# --- good calls ----------------------------------------------------------------------------------


def test_defaults_are_those_of_cpp(lib: ctypes.CDLL) -> None:
    control = made(lib, "torsio_control_config")
    assert (control.beta, control.watchdog_s, control.autonomous) == (0.5, 0.25, False)
    texture = made(lib, "torsio_texture")
    assert (texture.grain, texture.grains_per_turn) == (N["TORSIO_GRAIN_NOISE"], 1)
    constant = made(lib, "torsio_constant")
    assert (constant.timing.attack_level, constant.timing.delay_s) == (1.0, 0.0)
    plant = made(lib, "torsio_plant_params")
    assert (plant.belt, plant.spring_and_brake) == (None, True)


def test_scene_of_all_effects_plays(
    lib: ctypes.CDLL, knob: ctypes.c_void_p, scene: ctypes.c_void_p
) -> None:
    points = (ctypes.c_double * 3)(0.0, 0.01, 0.0)
    address = ctypes.addressof(points)
    special: dict[str, dict[str, Any]] = {
        "curve": {"torque_nm": address, "torque_nm_count": 3},
        "detents": {"per_turn": 24.0},
        "end_stops": {"lower_rad": -1.0, "upper_rad": 1.0},
    }
    names = [name for name in HEADER.functions if name.startswith("torsio_scene_add_")]
    assert len(names) == 12
    for name in names:
        kind = name.removeprefix("torsio_scene_add_")
        effect = made(lib, f"torsio_{kind}", **special.get(kind, {}))
        if kind == "ramp":
            effect.timing.duration_s = 1.0
        good(lib, getattr(lib, name)(scene, ctypes.byref(effect)))
    assert lib.torsio_scene_count(scene) == 12
    good(lib, lib.torsio_knob_play(knob, scene))
    good(lib, lib.torsio_scene_clear(scene))
    assert lib.torsio_scene_count(scene) == 0


def test_configurations_are_read_changed_and_set(lib: ctypes.CDLL, knob: ctypes.c_void_p) -> None:
    changes = {
        "actuator_config": ("brake_drag_nm", 0.003),
        "control_config": ("law", N["TORSIO_LAW_PARALLEL"]),
        "board_config": ("motor_reversed", True),
        "game_config": ("range_deg", 720.0),
    }
    for kind, (field, value) in changes.items():
        config = made(lib, f"torsio_{kind}")
        good(lib, getattr(lib, f"torsio_knob_{kind}")(knob, ctypes.byref(config)))
        assert getattr(config, field) != pytest.approx(value)
        setattr(config, field, value)
        good(lib, getattr(lib, f"torsio_knob_set_{kind}")(knob, ctypes.byref(config)))
        again = made(lib, f"torsio_{kind}")
        good(lib, getattr(lib, f"torsio_knob_{kind}")(knob, ctypes.byref(again)))
        assert getattr(again, field) == pytest.approx(value, rel=1e-6)
    good(lib, lib.torsio_knob_save(knob))
    good(lib, lib.torsio_knob_load_defaults(knob))


def test_knob_tells_of_itself(lib: ctypes.CDLL, knob: ctypes.c_void_p) -> None:
    info = made(lib, "torsio_device_info")
    good(lib, lib.torsio_knob_info(knob, ctypes.byref(info)))
    assert (info.board, info.transport, info.effects) == (b"emulated", b"emulated", 16)
    good(lib, lib.torsio_knob_sleep(knob, ctypes.c_double(0.5)))
    clock = made(lib, "torsio_clock")
    good(lib, lib.torsio_knob_clock(knob, ctypes.byref(clock)))
    assert clock.time_s == pytest.approx(clock.tick / 1000.0)
    time_s = ctypes.c_double()
    good(lib, lib.torsio_emulator_time_s(knob, ctypes.byref(time_s)))
    assert time_s.value >= 0.5
    for name in ("health", "limits", "link_statistics", "game_status"):
        function = getattr(lib, f"torsio_knob_{name.removeprefix('link_')}")
        good(lib, function(knob, ctypes.byref(made(lib, f"torsio_{name}"))))
    stiffness = made(lib, "torsio_stable_stiffness")
    good(lib, lib.torsio_knob_stable_stiffness(knob, ctypes.byref(stiffness)))
    assert stiffness.stiffness_nm_per_rad > 1.0
    assert stiffness.limited_by in (b"rate", b"lag", b"counts")
    position_rad, count = ctypes.c_double(1.0), ctypes.c_size_t(7)
    good(lib, lib.torsio_knob_position_rad(knob, ctypes.byref(position_rad)))
    assert position_rad.value == 0.0
    size = ctypes.sizeof(HEADER.structures["torsio_game_effect"])
    good(
        lib, lib.torsio_knob_game_effects(knob, None, 0, ctypes.c_size_t(size), ctypes.byref(count))
    )
    assert count.value == 0
    assert lib.torsio_knob_is_open(knob)
    assert lib.torsio_knob_is_emulated(knob)
    # What it does not have, it says.
    assert lib.torsio_emulator_set_supply(knob, ctypes.c_double(12.0)) == N["TORSIO_ERROR"]
    assert "no electrics" in said(lib)
    assert lib.torsio_start_bootloader(b"emulated") == N["TORSIO_REFUSED"]


def test_emulated_knob_is_listed_last(lib: ctypes.CDLL) -> None:
    device = HEADER.structures["torsio_listed_device"]
    count = ctypes.c_size_t()
    size = ctypes.c_size_t(ctypes.sizeof(device))
    good(lib, lib.torsio_list_devices(None, 0, size, ctypes.byref(count)))
    listed = (device * count.value)()
    good(lib, lib.torsio_list_devices(listed, count, size, ctypes.byref(count)))
    assert listed[count.value - 1].path == b"emulated"


def test_fault_is_an_event_and_the_reason_of_the_disarm(
    lib: ctypes.CDLL, knob: ctypes.c_void_p
) -> None:
    disarm = made(lib, "torsio_disarm")
    assert lib.torsio_knob_last_disarm(knob, ctypes.byref(disarm)) == N["TORSIO_ERROR"]
    good(lib, lib.torsio_knob_arm(knob))
    good(lib, lib.torsio_emulator_set_emergency_stop(knob, True))
    good(lib, lib.torsio_knob_wait_for(knob, N["TORSIO_STATE_FAULT"], ctypes.c_double(1.0)))
    state, faults = ctypes.c_int32(), ctypes.c_uint32()
    good(lib, lib.torsio_knob_state(knob, ctypes.byref(state)))
    good(lib, lib.torsio_knob_faults(knob, ctypes.byref(faults)))
    assert lib.torsio_state_name(state) == b"fault"
    assert faults.value == N["TORSIO_FAULT_EMERGENCY_STOP"]
    good(lib, lib.torsio_knob_last_disarm(knob, ctypes.byref(disarm)))
    assert disarm.reason == N["TORSIO_DISARM_REASON_FAULT"]

    states = []
    event = made(lib, "torsio_event")
    while lib.torsio_knob_next_event(knob, ctypes.c_double(0.0), ctypes.byref(event)) == 0:
        if event.kind == b"state_changed":
            states.append(event.state)
    assert states == [N["TORSIO_STATE_ARMED"], N["TORSIO_STATE_FAULT"]]

    assert lib.torsio_knob_arm(knob) == N["TORSIO_REFUSED"]
    refusal = made(lib, "torsio_refusal")
    good(lib, lib.torsio_last_refusal(ctypes.byref(refusal)))
    assert (refusal.status, refusal.report) == (b"fault_latched", b"command")
    good(lib, lib.torsio_emulator_set_emergency_stop(knob, False))
    good(lib, lib.torsio_knob_clear_fault(knob))
    for name in ("zero", "relax", "arm", "disarm", "stop"):
        good(lib, getattr(lib, f"torsio_knob_{name}")(knob))


def test_hand_moves_the_knob_and_telemetry_and_truth_tell(
    lib: ctypes.CDLL, knob: ctypes.c_void_p
) -> None:
    knots = (HEADER.structures["torsio_knot"] * 2)()
    knots[1].time_s, knots[1].value = 0.5, 0.4
    motion = made(
        lib, "torsio_prescribed_motion", angle_rad=ctypes.addressof(knots), angle_rad_count=2
    )
    good(lib, lib.torsio_emulator_set_prescribed_motion(knob, ctypes.byref(motion)))
    recording = ctypes.c_void_p()
    duration_s, rate_hz = ctypes.c_double(0.6), ctypes.c_double(1000.0)
    good(lib, lib.torsio_knob_record(knob, duration_s, rate_hz, False, ctypes.byref(recording)))
    sample = HEADER.structures["torsio_telemetry_sample"]
    count = lib.torsio_recording_count(recording)
    assert count == 600
    samples = (sample * count).from_address(lib.torsio_recording_samples(recording))
    assert samples[count - 1].angle_rad == pytest.approx(0.4, abs=2e-3)
    assert samples[1].tick == samples[0].tick + 1
    assert not lib.torsio_recording_was_disarmed(recording, None)
    lib.torsio_recording_free(recording)

    truth = HEADER.structures["torsio_truth_sample"]
    size, written = ctypes.c_size_t(ctypes.sizeof(truth)), ctypes.c_size_t()
    first, rest = (truth * 100)(), (truth * 10000)()
    good(
        lib,
        lib.torsio_emulator_truth(knob, first, ctypes.c_size_t(100), size, ctypes.byref(written)),
    )
    assert written.value == 100
    good(
        lib,
        lib.torsio_emulator_truth(knob, rest, ctypes.c_size_t(10000), size, ctypes.byref(written)),
    )
    assert written.value > 400
    assert rest[0].time_s == pytest.approx(first[99].time_s + 0.001)
    assert rest[written.value - 1].angle_rad == pytest.approx(0.4, abs=1e-9)

    true_rate_hz = ctypes.c_double()
    good(lib, lib.torsio_knob_start_telemetry(knob, rate_hz, True, ctypes.byref(true_rate_hz)))
    assert true_rate_hz.value == 1000.0
    newest, taken = sample(), (sample * 8)()
    sample_size = ctypes.c_size_t(ctypes.sizeof(sample))
    good(lib, lib.torsio_knob_latest(knob, ctypes.byref(newest), sample_size))
    good(
        lib,
        lib.torsio_knob_read(
            knob,
            taken,
            ctypes.c_size_t(8),
            sample_size,
            ctypes.c_double(1.0),
            ctypes.byref(written),
        ),
    )
    assert 1 <= written.value <= 8
    good(lib, lib.torsio_knob_stop_telemetry(knob))
    good(lib, lib.torsio_emulator_release_knob(knob))
    grip = made(lib, "torsio_impedance_hand", stiffness_nm_per_rad=1.0, damping_nm_s_per_rad=0.01)
    good(lib, lib.torsio_emulator_set_impedance_hand(knob, ctypes.byref(grip)))
    good(lib, lib.torsio_emulator_advance(knob, ctypes.c_double(0.01)))


def test_recording_that_ends_early_has_what_came(lib: ctypes.CDLL, knob: ctypes.c_void_p) -> None:
    recording = ctypes.c_void_p()
    half_s = ctypes.c_double(0.5)
    args = (ctypes.c_double(0.0), False, ctypes.byref(recording))
    good(lib, lib.torsio_knob_record(knob, half_s, *args))
    lib.torsio_recording_free(recording)
    good(lib, lib.torsio_knob_arm(knob))
    good(lib, lib.torsio_emulator_set_actuator_fault(knob, True))
    ended = lib.torsio_knob_record(
        knob, half_s, ctypes.c_double(0.0), True, ctypes.byref(recording)
    )
    assert ended == N["TORSIO_DISARMED"]
    assert "fault" in said(lib)
    assert lib.torsio_recording_count(recording) < 500
    lib.torsio_recording_free(recording)


def test_steps_come_at_equal_distances(lib: ctypes.CDLL, knob: ctypes.c_void_p) -> None:
    steps = ctypes.c_void_p()
    good(lib, lib.torsio_knob_every(knob, ctypes.c_double(0.002), ctypes.byref(steps)))
    due_s, late, times = ctypes.c_double(), ctypes.c_uint64(), []
    for _ in range(3):
        good(lib, lib.torsio_steps_wait(steps, ctypes.byref(due_s), ctypes.byref(late)))
        times.append(due_s.value)
    assert times == pytest.approx([0.0, 0.002, 0.004])
    lib.torsio_steps_free(steps)


def test_local_model_is_streamed_to_an_armed_knob_only(
    lib: ctypes.CDLL, knob: ctypes.c_void_p
) -> None:
    model = made(lib, "torsio_local_model", torque_nm=0.01)
    send = lib.torsio_knob_stream_local_model
    assert send(knob, ctypes.byref(model)) == N["TORSIO_REFUSED"]
    good(lib, lib.torsio_knob_arm(knob))
    good(lib, send(knob, ctypes.byref(model)))


def test_unplugged_knob_says_so_and_closed_one_too(lib: ctypes.CDLL, knob: ctypes.c_void_p) -> None:
    good(lib, lib.torsio_emulator_unplug(knob))
    assert lib.torsio_knob_arm(knob) == N["TORSIO_DISCONNECTED"]
    lib.torsio_knob_close(knob)
    assert not lib.torsio_knob_is_open(knob)
    assert lib.torsio_knob_arm(knob) == N["TORSIO_CLOSED"]
    assert "closed" in said(lib)


def test_faults_of_the_world_are_taken(lib: ctypes.CDLL, knob: ctypes.c_void_p) -> None:
    good(lib, lib.torsio_emulator_freeze_encoder(knob, True))
    good(lib, lib.torsio_emulator_freeze_encoder(knob, False))
    good(lib, lib.torsio_emulator_jump_encoder(knob, 1))
    good(lib, lib.torsio_emulator_skip_ticks(knob, 1))
    nothing = [ctypes.c_double(0.0)] * 4
    good(lib, lib.torsio_emulator_set_link_faults(knob, *nothing))
    good(lib, lib.torsio_emulator_cut_power_in_next_save(knob, 3))
    assert lib.torsio_knob_save(knob) == N["TORSIO_DISCONNECTED"]


def test_watch_waits_and_ends(lib: ctypes.CDLL) -> None:
    watch, arrived = ctypes.c_void_p(), ctypes.c_bool()
    device = HEADER.structures["torsio_listed_device"]()
    good(lib, lib.torsio_watch_new(False, ctypes.byref(watch)))
    size = ctypes.c_size_t(ctypes.sizeof(device))
    args = (ctypes.byref(arrived), ctypes.byref(device), size)
    assert lib.torsio_watch_next(watch, ctypes.c_double(0.0), *args) == N["TORSIO_TIMEOUT"]
    lib.torsio_watch_free(watch)


def test_close_wakes_who_waits_in_another_thread(lib: ctypes.CDLL) -> None:
    options = made(lib, "torsio_open_options")
    emulator = made(lib, "torsio_emulator_options", paced=True)
    options.emulator = ctypes.addressof(emulator)
    handle, results = ctypes.c_void_p(), []
    good(lib, lib.torsio_knob_open(b"emulated", ctypes.byref(options), ctypes.byref(handle)))

    def wait() -> None:
        results.append((lib.torsio_knob_sleep(handle, ctypes.c_double(600.0)), said(lib)))

    waiting = threading.Thread(target=wait)
    waiting.start()
    lib.torsio_knob_close(handle)
    waiting.join()
    (result, sentence) = results[0]
    assert result == N["TORSIO_CLOSED"]
    assert "closed" in sentence
    lib.torsio_knob_free(handle)


# --- bad calls -----------------------------------------------------------------------------------

RESULTS = [f for f in HEADER.functions.values() if f.result == "torsio_result"]


@pytest.mark.parametrize("function", RESULTS, ids=lambda function: function.name)
def test_null_everywhere_is_refused_with_a_sentence(
    lib: ctypes.CDLL, function: layouts.Function
) -> None:
    zeros: list[Any] = []
    for parameter in function.parameters:
        if "*" in parameter:
            zeros.append(None)
        elif parameter.startswith("double"):
            zeros.append(ctypes.c_double(0.0))
        elif parameter == "size_t item_size":
            zeros.append(ctypes.c_size_t(0))
        else:
            zeros.append(0)
    assert getattr(lib, function.name)(*zeros) == N["TORSIO_INVALID_ARGUMENT"]
    assert re.search(r"is NULL|item_size is 0", said(lib)), said(lib)


def test_functions_without_a_result_take_null(lib: ctypes.CDLL) -> None:
    for function in HEADER.functions.values():
        if function.result == "torsio_result" or not any("*" in p for p in function.parameters):
            continue
        nothing = getattr(lib, function.name)(*[None] * len(function.parameters))
        assert not nothing, function.name


SIZED = sorted(n for n, s in HEADER.structures.items() if s._fields_[0][0] == "struct_size")


def taking(name: str) -> Iterator[tuple[layouts.Function, int]]:
    """Give the functions that take a pointer to a structure, and at which place."""
    for function in RESULTS:
        for place, parameter in enumerate(function.parameters):
            if re.match(rf"(const )?{name} ?\*", parameter) and not function.name.endswith("_init"):
                yield function, place


@pytest.mark.parametrize("name", SIZED)
def test_structure_of_a_wrong_size_is_refused_and_unchanged(
    lib: ctypes.CDLL, knob: ctypes.c_void_p, scene: ctypes.c_void_p, name: str
) -> None:
    for function, place in taking(name):
        structure = HEADER.structures[name]()
        ctypes.memset(ctypes.byref(structure), 0x55, ctypes.sizeof(structure))
        before = bytes(structure)
        first = knob if function.parameters[0].startswith("torsio_knob") else scene
        arguments: list[Any] = [first, *[None] * (len(function.parameters) - 1)]
        handle = ctypes.c_void_p()
        if function.name == "torsio_knob_open":
            arguments = [b"emulated", None, ctypes.byref(handle)]
        if function.name == "torsio_knob_next_event":
            arguments[1] = ctypes.c_double(0.0)
        arguments[place] = ctypes.byref(structure)
        assert getattr(lib, function.name)(*arguments) == N["TORSIO_INVALID_ARGUMENT"]
        assert re.search(rf"struct_size is {0x55555555}, .*call {name}_init\(\)", said(lib))
        assert bytes(structure) == before
        assert handle.value is None


def _wall(lib: ctypes.CDLL, knob: Any, scene: Any, **fields: Any) -> int:
    wall = made(lib, "torsio_wall", **fields)
    added: int = lib.torsio_scene_add_wall(scene, ctypes.byref(wall))
    played: int = lib.torsio_knob_play(knob, scene)
    return added or played


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda lib, knob, scene: _wall(lib, knob, scene, side=2), r"side is 2, .*0 to 1"),
        (lambda lib, knob, scene: _wall(lib, knob, scene, side=256), r"side is 256, .*0 to 1"),
        (
            lambda lib, knob, scene: _wall(lib, knob, scene, stiffness_nm_per_rad=-1.0),
            r"stiffness_nm_per_rad .*-1",
        ),
        (
            lambda lib, knob, scene: _wall(lib, knob, scene, angle_rad=float("nan")),
            r"angle_rad",
        ),
        (
            lambda lib, knob, scene: lib.torsio_scene_add_curve(
                scene, ctypes.byref(made(lib, "torsio_curve", torque_nm_count=3))
            ),
            r"torque_nm is NULL, and torque_nm_count is 3",
        ),
        (
            lambda lib, knob, scene: lib.torsio_scene_add_curve(
                scene,
                ctypes.byref(made(lib, "torsio_curve", torque_nm=1, torque_nm_count=2**60)),
            ),
            r"torque_nm_count is \d+; at most",
        ),
        (
            lambda lib, knob, scene: lib.torsio_knob_wait_for(knob, 9, ctypes.c_double(0.0)),
            r"state is 9",
        ),
        (
            lambda lib, knob, scene: lib.torsio_knob_sleep(knob, ctypes.c_double(-1.0)),
            r"-1",
        ),
    ],
)
def test_bad_value_is_refused_by_name(
    lib: ctypes.CDLL,
    knob: ctypes.c_void_p,
    scene: ctypes.c_void_p,
    call: Callable[..., int],
    sentence: str,
) -> None:
    assert call(lib, knob, scene) == N["TORSIO_INVALID_ARGUMENT"]
    assert re.search(sentence, said(lib)), said(lib)


def test_array_of_wrong_items_is_refused(lib: ctypes.CDLL, knob: ctypes.c_void_p) -> None:
    samples, count = (ctypes.c_uint8 * 640)(), ctypes.c_size_t(5)
    read = lib.torsio_knob_read
    tail = (ctypes.c_double(0.0), ctypes.byref(count))
    wrong = read(knob, samples, ctypes.c_size_t(8), ctypes.c_size_t(72), *tail)
    assert wrong == N["TORSIO_INVALID_ARGUMENT"]
    assert "item_size is 72, and this library's has 56 bytes" in said(lib)
    assert count.value == 5


def test_unknown_selector_is_not_found(lib: ctypes.CDLL) -> None:
    handle = ctypes.c_void_p(17)
    found = lib.torsio_knob_open(b"/dev/none", None, ctypes.byref(handle))
    assert found == N["TORSIO_DEVICE_NOT_FOUND"]
    assert "/dev/none" in said(lib)
    assert handle.value == 17  # left alone


def test_error_belongs_to_its_thread(lib: ctypes.CDLL) -> None:
    assert lib.torsio_scene_clear(None) == N["TORSIO_INVALID_ARGUMENT"]
    here, there = said(lib), []
    other = threading.Thread(target=lambda: there.append(said(lib)))
    other.start()
    other.join()
    assert "scene is NULL" in here
    assert there == [""]


def test_names_of_results_are_those_of_the_header(lib: ctypes.CDLL) -> None:
    for number in range(13):
        name = lib.torsio_result_name(number).decode()
        assert N[name] == number
    assert lib.torsio_result_name(13) is None
    assert lib.torsio_result_name(-1) is None
    assert lib.torsio_state_name(-1) is None
    assert lib.torsio_state_name(4) is None
    version = re.search(
        r"VERSION ([\d.]+)", (TREE / "CMakeLists.txt").read_text().split("project(torsio")[1]
    )
    assert version
    assert lib.torsio_version().decode() == version[1]


# --- programs ------------------------------------------------------------------------------------


def test_c_example_feels_the_wall(
    tmp_path: Path, prefix: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PKG_CONFIG_PATH", str(prefix / "lib/pkgconfig"))
    flags = _run("pkg-config", "--cflags", "--libs", "torsio-c").split()
    program = tmp_path / "feel_a_wall"
    _run("gcc", *STRICT, TREE / "examples/c/feel_a_wall.c", "-o", program, *flags)
    assert _run(program, LD_LIBRARY_PATH=str(prefix / "lib")) == FELT


def test_example_of_the_guide_prints_what_the_page_says(
    tmp_path: Path, prefix: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PKG_CONFIG_PATH", str(prefix / "lib/pkgconfig"))
    flags = _run("pkg-config", "--cflags", "--libs", "torsio-c").split()
    (example,) = examples("docs/c.md", "c")
    (tmp_path / "guide.c").write_text(example.code)
    program = tmp_path / "guide"
    _run("gcc", *STRICT, tmp_path / "guide.c", "-o", program, *flags)
    assert _run(program, LD_LIBRARY_PATH=str(prefix / "lib")) == example.output


def test_csharp_example_feels_the_same(tmp_path: Path, prefix: Path) -> None:
    program = tmp_path / "FeelAWall.exe"
    _run("mcs", "-warnaserror", f"-out:{program}", TREE / "examples/csharp/FeelAWall.cs")
    assert _run("mono", program, LD_LIBRARY_PATH=str(prefix / "lib"), LC_ALL="C") == FELT


def test_rust_example_feels_the_same(tmp_path: Path, prefix: Path) -> None:
    # The distribution's compiler, whatever else a user has installed.
    rustc = "/usr/bin/rustc" if Path("/usr/bin/rustc").exists() else shutil.which("rustc")
    assert rustc
    listed = ("--allowlist-function", "torsio_.*", "--allowlist-type", "torsio_.*")
    _run(
        "bindgen", *listed, "--allowlist-var", "TORSIO_.*", "-o", tmp_path / "torsio.rs",
        prefix / "include/torsio.h",
    )  # fmt: skip
    program = tmp_path / "feel_a_wall"
    source = TREE / "examples/rust/feel_a_wall.rs"
    _run(
        rustc, "--edition", "2021", source, "-o", program, "-L", prefix / "lib", "-l", "torsio",
        TORSIO_BINDINGS=str(tmp_path),
    )  # fmt: skip
    assert _run(program, LD_LIBRARY_PATH=str(prefix / "lib")) == FELT
