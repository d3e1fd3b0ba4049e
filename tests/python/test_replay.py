"""Replay: the device does the same again with the same inputs, and another thing with others.

The emulated device is what the replay is compared with; the two share the firmware's sources and
nothing of the way that the inputs take into them.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import torsio
from tests.python.processes import command
from torsio import emulator
from torsio.apps.cli import app

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


def test_one_count_that_is_different_is_found_where_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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
    monkeypatch.setattr(torsio, "load", lambda _: recorded)
    result = CliRunner().invoke(app, ["replay", str(file)])
    assert result.exit_code == 1
    assert "not the same: recorded with" in result.stderr


def test_changed_law_shows_what_the_device_would_have_done(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    with (
        torsio.open("emulated", emulator=_options(log_inputs=True)) as knob,
        knob.record_to(file),  # without the end, when it disarms
    ):
        knob.play(WALL)
        knob.arm()
        knob.sleep(1.0)
    replayed = torsio.replay(file, law="motor_only")
    assert not replayed.identical
    before, after = replayed.recorded, replayed.replayed
    np.testing.assert_array_equal(before["desired_torque_nm"], after["desired_torque_nm"])
    assert before["brake_capacity_nm"].max() > 0.05
    # Without a brake the motor gives all of it, up to its limit.
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
    with pytest.raises(torsio.InvalidArgument, match="the recording has no detents, so there is"):
        torsio.replay(file, **{"detents.torque_nm": 0.01, "wall.stiffness_nm_per_rad": 0.7})
    counted = replace(torsio.load(file), inputs=[])
    with pytest.raises(torsio.InvalidArgument, match="has no constant and no detents, so"):
        torsio.replay(counted, **{"detents.torque_nm": 0.01, "constant.torque_nm": 0.01})
    with pytest.raises(torsio.InvalidArgument, match="there is no effect walls, but wall, "):
        torsio.replay(file, **{"walls.stiffness_nm_per_rad": 1})
    with pytest.raises(torsio.InvalidArgument, match="you can change stiffness_nm"):
        torsio.replay(file, **{"wall.angle_rad": 1})
    with pytest.raises(
        torsio.InvalidArgument, match="no configuration has a field 'lawn'; there are law"
    ):
        torsio.replay(file, lawn=1)
    with pytest.raises(torsio.InvalidArgument, match="beta is 7, allowed are 0 to 1"):
        torsio.replay(file, beta=7)
    with pytest.raises(torsio.InvalidArgument, match=r"law is 'foo', allowed are paper, comp"):
        torsio.replay(file, law="foo")


def test_torn_recording_is_the_same_as_far_as_its_inputs_reach(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Each message goes to the disk alone, so that the file may be torn behind any of them.
    monkeypatch.setattr("torsio.recordings.writing._FLUSH_S", -1.0)
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


def _turned(*angles: tuple[float, float], **more: object) -> torsio.EmulatorOptions:
    """Give a knob that is held and turned along (time, angle)."""
    return torsio.EmulatorOptions(hand=torsio.PrescribedMotion(angle_rad=[(0, 0), *angles]), **more)  # type: ignore[arg-type]


@pytest.mark.parametrize("begin_rad", [0.05, -0.5, 30.0])
@pytest.mark.parametrize("is_reversed", [False, True])
def test_recording_may_begin_anywhere(tmp_path: Path, begin_rad: float, is_reversed: bool) -> None:
    file = tmp_path / "x.mcap"
    wall = replace(WALL, angle_rad=begin_rad + 0.1)
    sign = -1 if is_reversed else 1
    options = _turned(
        (1.0, sign * begin_rad),
        (4.0, sign * begin_rad),
        (4.5, sign * (begin_rad + 0.4)),
        actuator=torsio.ActuatorConfig(encoder_reversed=is_reversed),
    )
    with torsio.open("emulated", emulator=options) as knob:
        knob.sleep(2.5)
        with knob.record_to(file):
            knob.start_telemetry(1000.0)
            knob.play(wall)
            knob.arm()
            knob.sleep(2.5)
    replayed = torsio.replay(file)
    assert replayed.first_difference == ""
    assert abs(replayed.recorded["desired_torque_nm"]).max() > 0.1


def test_zero_in_a_recording_is_no_turn(tmp_path: Path) -> None:
    """Also while it turns, and twice."""
    file = tmp_path / "x.mcap"
    with torsio.open("emulated", emulator=_turned((0.5, 0.5), (2.0, 0.5), (4.0, 1.9))) as knob:
        knob.sleep(1.9)
        with knob.record_to(file):
            knob.start_telemetry(1000.0)
            knob.sleep(0.6)
            knob.zero()
            knob.sleep(0.5)
            knob.zero()
            knob.play(WALL)
            knob.arm()
            knob.sleep(1.2)
    replayed = torsio.replay(file)
    assert replayed.first_difference == ""
    # Each time it was 0.3 rad away from the zero; see the hand.
    jumps_rad = np.diff(replayed.recorded["angle_rad"])
    assert (jumps_rad < -0.3).sum() == 2
    assert replayed.recorded["motor_command_nm"].min() < -0.02


def test_zero_between_samples_loses_no_count(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    with torsio.open("emulated", emulator=_turned((0.5, 0.5), (1.0, 0.5), (3.0, 1.9))) as knob:
        knob.sleep(0.9)
        with knob.record_to(file):
            knob.start_telemetry(125.0)
            knob.sleep(0.6)
            knob.zero()
            knob.sleep(1.0)
    replayed = torsio.replay(file)
    assert replayed.largest_differences()["position_counts"] == 0


def test_zero_before_the_first_sample(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    with torsio.open("emulated", emulator=_turned((1.0, 0.5), (2.0, 2.5))) as knob:
        knob.sleep(1.5)
        with knob.record_to(file):
            knob.zero()
            knob.start_telemetry(1000.0)  # forgets the samples before
            knob.sleep(0.4)
    replayed = torsio.replay(file)
    assert replayed.recorded["position_counts"][0] > 0
    assert replayed.largest_differences()["position_counts"] == 0


SCENE = [
    WALL,
    torsio.Curve(angle_rad=-1.0, span_rad=2.0, torque_nm=list(np.linspace(-0.02, 0.02, 300))),
    torsio.Periodic(amplitude_nm=0.01, frequency_hz=3.7),
    *(torsio.Constant(torque_nm=0.001) for _ in range(13)),
]
"""As many effects as there may be, and points of several reports."""


def test_scene_that_plays_already_is_in_the_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "x.mcap"
    with torsio.open("emulated", emulator=_turned((4.0, 0.0), (4.5, 0.3))) as knob:
        knob.sleep(0.1)
        knob.play(torsio.Detents(torque_nm=0.02, per_turn=24))  # is in it no more
        knob.play(SCENE)
        knob.update(law="compensated")  # leaves the scene as it is
        knob.sleep(3.3)
        with knob.record_to(file):
            knob.start_telemetry(1000.0)
            knob.arm()
            knob.sleep(1.5)
    recorded = torsio.load(file)
    names = [torsio.protocol.decode(content)[0] for _, _, content in recorded.reports]
    assert names[: names.index("commit")].count("constant") == 13
    assert "detents" not in names
    replayed = torsio.replay(recorded)
    assert replayed.first_difference == ""
    assert replayed.recorded["desired_torque_nm"].min() < -0.2

    # One that was played too long ago to be simulated from there on begins later.
    monkeypatch.setattr("torsio.recordings.inputs._LONGEST_REST_S", 1.0)
    replayed = torsio.replay(recorded)
    difference_nm = abs(
        replayed.recorded["desired_torque_nm"] - replayed.replayed["desired_torque_nm"]
    )
    assert 0 < difference_nm.max() < 0.0201  # all that the sine can be off

    # One that this program does not know of cannot be there, and the difference says so.
    of_another = replace(
        recorded, reports=[r for r in recorded.reports if r[2] not in _scene(recorded)]
    )
    assert torsio.replay(of_another).first_difference.endswith(
        "; a scene that an earlier program has left in the knob is not in the recording"
    )


def _scene(recorded: torsio.Recorded) -> set[bytes]:
    commit = next(i for i, (_, _, content) in enumerate(recorded.reports)
                  if torsio.protocol.decode(content)[0] == "commit")  # fmt: skip
    return {content for _, _, content in recorded.reports[: commit + 1]}


@pytest.mark.parametrize("empty", [torsio.Knob.stop, lambda knob: knob.update(counts_per_rev=4096)])
def test_scene_that_plays_no_more_is_not_in_the_recording(
    tmp_path: Path, empty: Callable[[torsio.Knob], None]
) -> None:
    file = tmp_path / "x.mcap"
    with torsio.open("emulated") as knob:
        knob.play(WALL)
        empty(knob)
        with knob.record_to(file):
            knob.arm()
            knob.sleep(0.2)
    names = [torsio.protocol.decode(c)[0] for _, _, c in torsio.load(file).reports]
    assert "wall" not in names
    assert "commit" not in names


def test_second_recording_of_a_knob_is_replayed_from_its_counts(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    options = _turned((1.5, 0.0), (2.0, 0.3), log_inputs=True)
    with torsio.open("emulated", emulator=options) as knob:
        with knob.record_to(tmp_path / "first.mcap"):
            knob.sleep(0.5)
        with knob.record_to(file):
            knob.start_telemetry(1000.0)
            knob.play(WALL)
            knob.arm()
            knob.sleep(2.0)
    assert torsio.replay(tmp_path / "first.mcap").from_inputs
    replayed = torsio.replay(file)
    assert not replayed.from_inputs
    assert replayed.first_difference == ""
    assert replayed.recorded["desired_torque_nm"].min() < -0.1
    done = command("replay", file)
    assert done.returncode == 0, done.stderr
    assert "its inputs do not begin at power-up" in done.stderr
    assert "from the counts in the telemetry" in done.stdout


def test_keep_alives_that_pile_up_are_no_damage(tmp_path: Path) -> None:
    """As of a computer that reads nothing for a while; and nobody knows when the last ones came."""
    file = tmp_path / "x.mcap"
    options = _turned((1.0, 0.0), (1.5, 0.3))
    with torsio.open("emulated", emulator=options) as knob, knob.record_to(file):
        knob.start_telemetry(1000.0)
        knob.play(WALL)
        knob.arm()
        knob.sleep(2.0)
    recorded = torsio.load(file)
    keep_alive = torsio.protocol.encode("command", {"op": "keep_alive"})
    piled: list[tuple[int, bool, bytes]] = []
    for row in recorded.reports:
        piled += [row] * (20 if row[2] == keep_alive else 1)
    end = int(recorded.telemetry["tick"][-1])
    piled += [(end, True, keep_alive)] * 20
    assert len(piled) > len(recorded.reports) + 100
    replayed = torsio.replay(replace(recorded, reports=piled))
    assert replayed.first_difference == ""
    assert replayed.recorded["desired_torque_nm"].min() < -0.1


def test_who_streams_no_telemetry_keeps_the_knob_alive_all_the_same(tmp_path: Path) -> None:
    file = tmp_path / "x.mcap"
    options = _turned((3.0, 0.0), (3.5, 0.3))
    with torsio.open("emulated", emulator=options) as knob, knob.record_to(file):
        knob.start_telemetry(1000.0)
        knob.play(WALL)
        knob.arm()
        knob.stop_telemetry()
        knob.sleep(2.0)
        knob.start_telemetry(1000.0)
        knob.sleep(1.5)
    replayed = torsio.replay(file)
    assert replayed.first_difference == ""
    assert np.diff(replayed.recorded["tick"]).max() > 1900
    assert replayed.recorded["desired_torque_nm"].min() < -0.1


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


def test_commands_record_replay_and_report(tmp_path: Path) -> None:
    file, report = tmp_path / "x.mcap", tmp_path / "report.zip"
    done = command("record", file, "--device", "emulated", "--seconds", "0.5")
    assert done.returncode == 0, done.stderr
    done = command("replay", file)
    assert done.returncode == 0, done.stderr
    assert "the same, to the bit" in done.stdout
    done = command("replay", file, "--set", "law=motor_only")
    assert done.returncode == 0, done.stderr
    for wrong in ("law", "lawn=1", "beta=high"):
        done = command("replay", file, "--set", wrong)
        assert done.returncode == 1
        assert done.stderr.startswith("torsio: error: ")

    done = command("report", report, "--device", "emulated", "--recording", file)
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
