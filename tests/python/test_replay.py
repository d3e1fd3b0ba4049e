"""Replay: the device does the same again with the same inputs, and another thing with others.

The emulated device is what the replay is compared with; the two share the firmware's sources and
nothing of the way that the inputs take into them.
"""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import torsio
from torsio import emulator

RUN = "import sys; from torsio.__main__ import main; main()"
WALL = torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.4, damping_nm_s_per_rad=0.002)
HAND = torsio.ImpedanceHand(
    inertia_kg_m2=2e-5,
    stiffness_nm_per_rad=0.8,
    damping_nm_s_per_rad=8e-3,
    intended_angle_rad=[(0.0, 0.0), (0.5, 0.4), (1.0, 0.4), (1.5, -0.2), (3.0, 0.6)],
)


def _options(**more: object) -> torsio.EmulatorOptions:
    options = torsio.EmulatorOptions(seed=3, control_rate_hz=4000.0, hand=HAND)
    return replace(options, **more)  # type: ignore[arg-type]


def _eventful(file: Path, options: torsio.EmulatorOptions) -> None:
    """Do with a knob whatever one can, and record it."""
    with torsio.open("emulated", emulator=options) as knob:
        knob.record_to(file)
        knob.start_telemetry()
        knob.play([WALL, torsio.Texture(grains_per_turn=120, torque_nm=0.004)])
        knob.arm()
        knob.sleep(0.7)
        knob.play([WALL, torsio.Periodic(waveform="sine", amplitude_nm=0.01, frequency_hz=20.0)])
        for _ in range(20):
            knob.stream_local_model(stiffness_nm_per_rad=0.05, deadline_s=0.05)
            knob.sleep(0.005)
        knob.emulator.set_emergency_stop(pressed=True)
        knob.sleep(0.1)
        knob.emulator.set_emergency_stop(pressed=False)
        knob.clear_fault()
        knob.update(law="compensated", beta=0.5)
        knob.save()
        knob.start_telemetry()
        knob.zero()
        knob.play(torsio.Detents(torque_nm=0.02, per_turn=24))
        knob.arm()
        knob.emulator.skip_ticks(2)
        knob.sleep(0.6)
        knob.close()


def test_replay_of_the_inputs_gives_the_same_to_the_bit(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    _eventful(file, _options(log_inputs=True))
    recorded = torsio.load(file)
    kinds = {given.kind for given in recorded.inputs}
    assert {"stored", "power", "output", "feature", "counts", "emergency_stop"} <= kinds
    assert "missed_ticks" in kinds
    replayed = torsio.replay(file)
    assert replayed.first_difference == ""
    assert replayed.identical
    assert replayed.from_inputs
    assert len(replayed.replayed) == len(recorded.telemetry) > 2500
    assert replayed.answers == sum(not sent for _, sent, _ in recorded.reports) > 15
    # It did something.
    assert np.ptp(recorded.telemetry["motor_command_nm"]) > 0.02
    np.testing.assert_array_equal(replayed.replayed, replayed.recorded)


def test_one_count_that_is_different_is_found_where_it_is(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    _eventful(file, _options(log_inputs=True))
    recorded = torsio.load(file)
    # In the middle of a block of counts, while the wall is felt.
    index = next(
        i for i, g in enumerate(recorded.inputs)
        if g.kind == "counts" and g.tick > 1500 and len(g.bytes) > 400
    )  # fmt: skip
    given = recorded.inputs[index]
    counts = np.frombuffer(given.bytes, "<u4").copy()
    counts[40] += 1
    recorded.inputs[index] = replace(given, bytes=counts.tobytes())
    replayed = torsio.replay(recorded)
    assert not replayed.identical
    assert replayed.first_difference.startswith(f"tick {given.tick + 40} ")
    assert "position_counts" in replayed.first_difference
    assert replayed.largest_differences()["position_counts"] == 1


def test_changed_law_shows_what_the_device_would_have_done(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    with torsio.open("emulated", emulator=_options(log_inputs=True)) as knob:
        knob.record_to(file)
        knob.play(WALL)
        knob.arm()
        knob.sleep(1.0)
    replayed = torsio.replay(file, law="motor_only")
    assert not replayed.identical
    before, after = replayed.recorded, replayed.replayed
    np.testing.assert_array_equal(before["desired_torque_nm"], after["desired_torque_nm"])
    assert before["brake_capacity_nm"].max() > 0.05
    # Without a brake the motor is asked for all of it, up to what it can give.
    felt = after["desired_torque_nm"] < -0.03
    limit = torsio.ActuatorConfig().motor_torque_max_nm
    wanted = np.clip(after["desired_torque_nm"], -limit, limit)
    assert felt.sum() > 100
    np.testing.assert_allclose(after["motor_command_nm"][felt], wanted[felt], atol=2e-5)
    # Another scene: the wall's law with another stiffness, at the same counts.
    softer = {"wall.stiffness_nm_per_rad": 0.7, "wall.damping_nm_s_per_rad": 0.0}
    other = torsio.replay(file, **softer).replayed
    depth = np.maximum(other["angle_rad"] - WALL.angle_rad, 0.0)
    step_nm = 0.7 * 2 * np.pi / 8192 + 2e-5
    settled = other["tick"] > 1000  # past the ramp after arming
    np.testing.assert_allclose(
        other["desired_torque_nm"][settled], -0.7 * depth[settled], atol=step_nm
    )
    with pytest.raises(torsio.InvalidArgument, match="there is no effect walls, but wall, "):
        torsio.replay(file, **{"walls.stiffness_nm_per_rad": 1})
    with pytest.raises(torsio.InvalidArgument, match="can be changed of wall is stiffness_nm"):
        torsio.replay(file, **{"wall.angle_rad": 1})
    with pytest.raises(torsio.InvalidArgument, match="no field lawn"):
        torsio.replay(file, lawn=1)
    with pytest.raises(torsio.InvalidArgument, match="beta is 7"):
        torsio.replay(file, beta=7)
    with pytest.raises(torsio.InvalidArgument, match=r"law is 'foo': .* one of 'paper', 'comp"):
        torsio.replay(file, law="foo")


def test_torn_recording_is_the_same_as_far_as_its_inputs_reach(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Each message goes to the disk by itself, so that the file may be torn behind any of them.
    monkeypatch.setattr("torsio.recording._FLUSH_S", -1.0)
    file = tmp_path / "x.mcap"
    options = _options(log_inputs=True)
    with torsio.open("emulated", emulator=options) as knob, knob.record_to(file):
        knob.play(WALL)
        knob.arm()
        for _ in range(4):
            knob.sleep(0.1)
    whole = file.read_bytes()
    lengths = set()
    for end in range(len(whole) // 4, len(whole), len(whole) // 16):
        file.write_bytes(whole[:end])
        torn = torsio.load(file)
        assert torn.inputs
        replayed = torsio.replay(torn)
        assert replayed.first_difference == ""
        lengths.add(len(replayed.replayed))
    assert len(lengths) >= 3


def test_counts_in_the_telemetry_are_enough_for_a_replay(tmp_path: Path) -> None:
    """As from hardware, whose inputs nobody logs: every tick a sample, from rest."""
    file = tmp_path / "x.mcap"
    hand = replace(HAND, intended_angle_rad=[(0.0, 0.0), (0.5, 0.4), (1.5, 0.4), (2.0, -0.2)])
    with torsio.open("emulated", emulator=_options(hand=torsio.NoHand())) as knob:
        knob.sleep(1.0)
        with knob.record_to(file):
            knob.start_telemetry(4000.0)
            knob.emulator.set_hand(hand)
            knob.play([WALL, torsio.Texture(grains_per_turn=120, torque_nm=0.004)])
            knob.arm()
            knob.sleep(0.7)
            knob.disarm()
            # What happens while no sample is sent nobody knows, so nothing does.
            knob.sleep(0.6)
            knob.update(law="compensated")
            knob.start_telemetry(4000.0)
            knob.play(WALL)
            knob.arm()
            knob.sleep(0.8)
    recorded = torsio.load(file)
    assert recorded.inputs == []
    replayed = torsio.replay(recorded)
    assert not replayed.from_inputs
    assert replayed.first_difference == ""
    assert len(replayed.replayed) > 5000
    assert torsio.replay(recorded, law="motor_only").first_difference != ""


def test_recording_that_begins_armed_cannot_be_replayed_without_inputs(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    with torsio.open("emulated") as knob:
        knob.play(WALL)
        knob.arm()
        with knob.record_to(file):
            knob.sleep(0.2)
    with pytest.raises(torsio.Error, match="begins while the knob is armed"):
        torsio.replay(file)


def test_recording_of_another_protocol_names_the_version_that_can_replay_it(
    tmp_path: Path,
) -> None:
    file = tmp_path / "x.mcap"
    with torsio.open("emulated") as knob, knob.record_to(file):
        knob.sleep(0.1)
    recorded = torsio.load(file)
    recorded.metadata["versions"].update(fingerprint=1, protocol=9, torsio="9.8.7")
    with pytest.raises(torsio.Error, match=r"\(version 9\).*replay it with Torsio 9\.8\.7"):
        torsio.replay(recorded)


def test_replayed_device_refuses_what_is_no_input() -> None:
    device = emulator.ReplayedDevice()
    for kind, content in (("power", b""), ("counts", b"\0"), ("stored", b"x"), ("buttons", b"")):
        with pytest.raises(ValueError, match=f"an input '{kind}' has"):
            device.take(kind, content)
    with pytest.raises(ValueError, match="no input 'nonsense'"):
        device.take("nonsense", b"")
    # Without power nothing happens.
    device.take("counts", bytes(40))
    assert device.ticks == 0
    assert device.take_outputs() == []


def _torsio(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", RUN, *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_commands_record_replay_and_report(tmp_path: Path) -> None:
    file, report = tmp_path / "x.mcap", tmp_path / "report.zip"
    done = _torsio("record", file, "--device", "emulated", "--seconds", "0.5")
    assert done.returncode == 0, done.stderr
    done = _torsio("replay", file)
    assert done.returncode == 0, done.stderr
    assert "the same, to the bit" in done.stdout
    done = _torsio("replay", file, "--set", "law=motor_only")
    assert done.returncode == 0, done.stderr
    for wrong in ("law", "lawn=1", "beta=high"):
        done = _torsio("replay", file, "--set", wrong)
        assert done.returncode == 1
        assert done.stderr.startswith("torsio: error: ")

    done = _torsio("report", report, "--device", "emulated", "--recording", file)
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(report) as archive:
        assert archive.read("recording.mcap") == file.read_bytes()
        found = json.loads(archive.read("doctor.json"))
        assert found[0]["device"] == "emulated"
        assert "library" in json.loads(archive.read("versions.json"))
        for name in ("doctor.json", "versions.json"):
            assert str(Path.home()) not in archive.read(name).decode()


@pytest.mark.parametrize(
    ("there", "instead"),
    [
        (b"control_rate_hz", b"control_rate_hx"),
        (b"ActuatorConfig", b"ActuatorConfix"),
        (b'{"motor_torque_max_nm', b'{"motor_torque_max_nx'),
        (b"1000.0", b"[1000]"),
    ],
)
def test_damage_where_the_device_is_described_is_one_error(
    tmp_path: Path, there: bytes, instead: bytes
) -> None:
    file = tmp_path / "damaged.mcap"
    with torsio.open("emulated") as knob, knob.record_to(file):
        knob.start_telemetry()
        knob.sleep(0.1)
    content = file.read_bytes()
    assert there in content
    assert torsio.replay(file).identical
    file.write_bytes(content.replace(there, instead))
    with pytest.raises(torsio.Error, match="the recording is damaged"):
        torsio.replay(file)
