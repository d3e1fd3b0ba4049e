"""Good calls of the C interface: what each does, seen through ctypes."""

from __future__ import annotations

import ctypes
import math
import threading
from typing import Any

import pytest

from tests.c.calling import HEADER, N, good, made, said


def test_defaults_are_those_of_cpp(lib: ctypes.CDLL) -> None:
    control = made(lib, "torsio_control_config")
    assert (control.beta, control.watchdog_s, control.autonomous) == (0.5, 0.25, False)
    texture = made(lib, "torsio_texture")
    assert (texture.grain, texture.grains_per_turn) == (N["TORSIO_GRAIN_NOISE"], 0)
    constant = made(lib, "torsio_constant")
    assert math.isnan(constant.torque_nm)  # must be given
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
        "texture": {"grains_per_turn": 1},
    }
    names = [name for name in HEADER.functions if name.startswith("torsio_scene_add_")]
    assert len(names) == 13
    for name in names:
        kind = name.removeprefix("torsio_scene_add_")
        effect = made(lib, f"torsio_{kind}", **special.get(kind, {}))
        for field, *_ in effect._fields_:
            if isinstance(value := getattr(effect, field), float) and math.isnan(value):
                setattr(effect, field, 0.0)
        if kind == "ramp":
            effect.timing.duration_s = 1.0
        good(lib, getattr(lib, name)(scene, ctypes.byref(effect)))
    assert lib.torsio_scene_count(scene) == 13
    good(lib, lib.torsio_knob_play(knob, scene))
    good(lib, lib.torsio_scene_clear(scene))
    assert lib.torsio_scene_count(scene) == 0


def test_configurations_are_read_changed_and_set(lib: ctypes.CDLL, knob: ctypes.c_void_p) -> None:
    changes = {
        "actuator_config": ("brake_drag_nm", 0.003),
        "control_config": ("law", N["TORSIO_LAW_PARALLEL"]),
        "board_config": ("motor_reversed", True),
        "game_config": ("range_deg", 720.0),
        "shaft_config": ("knee_4_nm_per_rad", 720.0),
        "calibration_config": ("ambient_k", 294.0),
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
    for name in ("health", "energies", "motor_current", "limits", "link_statistics", "game_status"):
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
    # It names what it lacks.
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


def test_recording_of_nothing_leaves_the_pointer_as_it_was(
    lib: ctypes.CDLL, knob: ctypes.c_void_p
) -> None:
    recording = ctypes.c_void_p(0x1234)
    args = (ctypes.c_double(0.0), False, ctypes.byref(recording))
    for duration_s in (-1.0, float("nan")):
        refused = lib.torsio_knob_record(knob, ctypes.c_double(duration_s), *args)
        assert refused == N["TORSIO_INVALID_ARGUMENT"]
        assert recording.value == 0x1234


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
    good(lib, lib.torsio_emulator_unplug(knob, ctypes.c_double(0.05)))
    good(lib, lib.torsio_emulator_advance(knob, ctypes.c_double(0.04)))
    good(lib, lib.torsio_knob_arm(knob))
    late = lib.torsio_emulator_advance(knob, ctypes.c_double(0.02))
    assert (late, lib.torsio_knob_arm(knob)) == (N["TORSIO_DISCONNECTED"],) * 2
    lib.torsio_knob_close(knob)
    assert not lib.torsio_knob_is_open(knob)
    assert lib.torsio_knob_arm(knob) == N["TORSIO_CLOSED"]
    assert "closed" in said(lib)


def test_faults_of_the_world_are_taken(lib: ctypes.CDLL, knob: ctypes.c_void_p) -> None:
    good(lib, lib.torsio_emulator_freeze_encoder(knob, True))
    good(lib, lib.torsio_emulator_freeze_encoder(knob, False))
    good(lib, lib.torsio_emulator_jump_encoder(knob, 1))
    good(lib, lib.torsio_emulator_skip_ticks(knob, 1))
    faults = made(lib, "torsio_link_faults", drop_input=0.0)
    good(lib, lib.torsio_emulator_set_link_faults(knob, ctypes.byref(faults)))
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


def test_scene_that_may_swing_is_warned_of(
    lib: ctypes.CDLL, knob: ctypes.c_void_p, scene: ctypes.c_void_p
) -> None:
    spring = made(lib, "torsio_spring", stiffness_nm_per_rad=8.0)
    good(lib, lib.torsio_scene_add_spring(scene, ctypes.byref(spring)))
    good(lib, lib.torsio_knob_play(knob, scene))
    assert b"may swing" in lib.torsio_last_warning()
    good(lib, lib.torsio_scene_clear(scene))
    good(lib, lib.torsio_knob_play(knob, scene))
    assert lib.torsio_last_warning() == b""
    good(lib, lib.torsio_knob_arm(knob))
    model = made(lib, "torsio_local_model", stiffness_nm_per_rad=50.0)
    good(lib, lib.torsio_knob_stream_local_model(knob, ctypes.byref(model)))
    assert b"may swing" in lib.torsio_last_warning()
