"""Mistakes of a new user's first hour, and the errors that explain them."""

from __future__ import annotations

import io
import json
import math
import os
import pickle
import re
import subprocess
import sys
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from rich.console import Console

import torsio
from tests.python.processes import python
from torsio import batch, calibration
from torsio.common import checks, screen

WALL = torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.0)
HAND = torsio.EmulatorOptions(hand=torsio.TorqueHand(torque_nm=0.03))


def _stream(knob: torsio.Knob) -> None:
    knob.start_telemetry()
    knob.stop_telemetry()


READINGS: list[Callable[[torsio.Knob, Path], object]] = [
    lambda knob, _: knob.record(0.01),
    lambda knob, file: knob.record_to(file).close(),
    lambda knob, _: list(knob.telemetry(0.01)),
    lambda knob, _: next(knob.telemetry()),  # and then broken off
    lambda knob, _: _stream(knob),
]


@pytest.mark.parametrize("read", READINGS)
def test_reading_of_a_scene_that_was_never_armed_names_arm_once(
    tmp_path: Path, read: Callable[[torsio.Knob, Path], object]
) -> None:
    file = tmp_path / "a.mcap"
    with torsio.open("emulated", emulator=HAND) as knob:
        read(knob, file)  # nothing plays: who looks on needs no torque
        knob.play(WALL)
        with pytest.warns(torsio.DisarmedWarning, match=r"nothing was felt: call arm\(\)") as told:
            read(knob, file)
        assert [warning.filename for warning in told] == [__file__]
        read(knob, file)  # it was said
        knob.play(WALL)
        knob.arm()
        knob.disarm()
        read(knob, file)  # on purpose
        knob.play(WALL)
        knob.stop()
        read(knob, file)  # the scene is gone


def test_close_names_arm_where_telemetry_of_a_scene_was_read() -> None:
    for is_read in (False, True):
        with warnings.catch_warnings(record=True) as told, torsio.open("emulated") as knob:
            warnings.simplefilter("always")
            knob.play(WALL)
            if is_read:
                knob.start_telemetry()
                knob.latest()
        assert [warning.category for warning in told] == [torsio.DisarmedWarning] * is_read


def test_reading_that_an_error_ends_tells_of_that_error_alone(tmp_path: Path) -> None:
    with torsio.open("emulated", emulator=HAND) as knob:
        recording = knob.record_to(tmp_path / "a.mcap")
        knob.play(WALL)
        with pytest.raises(ZeroDivisionError), recording:
            raise ZeroDivisionError


def test_call_that_is_wrong_says_how_it_is_right() -> None:
    made: Any = torsio  # type checkers say it too
    calls: list[tuple[Callable[[], object], str]] = [
        (lambda: made.Knob("emulated"), r"opened by torsio\.open\('emulated'\)"),
        (lambda: made.Wall(0.1, 1.4), r"by name, in SI units: Wall\(stiffness_nm_per_rad=\.\.\.,"),
        (lambda: made.Wall(angle_deg=10.0), r"no field 'angle_deg'.*angle_rad=torsio\.deg"),
        (lambda: made.ControlConfig(beat=4.0), "no field 'beat'; its fields are"),
        (lambda: made.Hand(0.03), "Hand has no values itself; there are NoHand, TorqueHand, "),
        (lambda: batch.LoopOptions(WALL), r"LoopOptions\(scene=\.\.\.\)"),  # type: ignore[misc]
        (lambda: made.Emulator(3), "has its Emulator as knob.emulator"),
        (lambda: made.TorqueHand(0.03), r"TorqueHand\(torque_nm=\.\.\.\)"),
        (lambda: made.EmulatorOptions(7), "EmulatorOptions takes its values by name"),
    ]
    for call, said in calls:
        with pytest.raises(TypeError, match=said):
            call()


def test_angle_may_be_given_in_degrees() -> None:
    assert torsio.deg(180) == pytest.approx(3.141592653589793, rel=1e-15)
    with pytest.raises(TypeError, match="degrees must be a number"):
        torsio.deg("180")  # type: ignore[arg-type]
    with warnings.catch_warnings(), torsio.open("emulated") as knob:
        warnings.simplefilter("error")
        knob.play(
            torsio.EndStops(
                lower_rad=torsio.deg(-150), upper_rad=torsio.deg(150), stiffness_nm_per_rad=1.0
            )
        )


MOTOR_NM, BRAKE_NM = 0.085, 0.11  # of the emulated knob, docs/reference/configuration.md
PUSH_NM = 0.5 * MOTOR_NM + 0.01
LATER = torsio.Timing(delay_s=1.0)
ENDED = torsio.Timing(duration_s=1.0)
GIVEN = (
    r"this knob's motor gives 0\.085, and its brake 0\.11 more.*desired_torque_nm ends at 0\.3277"
)


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        (torsio.Detents(per_turn=24, torque_nm=30), f"30 N m; {GIVEN}"),
        (torsio.Curve(torque_nm=[0.0, -3.0], span_rad=1.0), f"3 N m; {GIVEN}"),
        # What only the brake gives, which pushes nothing.
        (torsio.Constant(torque_nm=-0.09), f"0.09 N m; {GIVEN}"),
        (torsio.Friction(torque_nm=MOTOR_NM + BRAKE_NM + 0.01), f"0.205 N m; {GIVEN}"),
        # Sums.
        ([torsio.Constant(torque_nm=PUSH_NM)] * 2, f"0.105 N m; {GIVEN}"),
        (torsio.Periodic(amplitude_nm=0.05, offset_nm=-0.05, frequency_hz=1), f"0.1 N m; {GIVEN}"),
        (
            [
                torsio.Texture(torque_nm=0.05, grains_per_turn=9),
                torsio.Ramp(start_torque_nm=0, end_torque_nm=0.05, timing=ENDED),
            ],
            f"0.1 N m; {GIVEN}",
        ),
        ([torsio.Constant(torque_nm=PUSH_NM, timing=LATER)] * 2, "0.105 N m; "),
        ([torsio.Constant(torque_nm=0.08), torsio.Friction(torque_nm=0.12)], "0.2 N m; "),
        # Degrees.
        (
            [WALL, torsio.EndStops(lower_rad=-150, upper_rad=150, stiffness_nm_per_rad=0.5)],
            r"lower_rad is -150 radians, 23\.9 turns; .*lower_rad=torsio\.deg\(-150\)",
        ),
        (torsio.Wall(angle_rad=15, stiffness_nm_per_rad=1), r"Wall: .*angle_rad=torsio\.deg\(15\)"),
        (torsio.Wall(angle_rad=30.0, stiffness_nm_per_rad=1), r"torsio\.deg\(30\)"),
        (torsio.Wall(angle_rad=22.5, stiffness_nm_per_rad=1), r"torsio\.deg\(22\.5\)"),
        (torsio.Wall(angle_rad=137.5, stiffness_nm_per_rad=1), r"torsio\.deg\(137\.5\)"),
        (torsio.Detents(torque_nm=0.02, pitch_rad=15), r"pitch_rad=torsio\.deg\(15\)"),
        (torsio.Detents(torque_nm=0.02, pitch_rad=5), r"pitch_rad=torsio\.deg\(5\)"),
        (torsio.Spring(deadband_rad=10, stiffness_nm_per_rad=1), r"deadband_rad=torsio\.deg"),
        (torsio.Curve(torque_nm=[0, 0.01], span_rad=90), r"span_rad=torsio\.deg\(90\)"),
    ],
)
@pytest.mark.filterwarnings("ignore::torsio.StiffnessWarning")
def test_scene_that_is_hardly_meant_is_told(scene: torsio.Scene, said: str) -> None:
    with torsio.open("emulated") as knob, pytest.warns(torsio.SceneWarning, match=said):
        knob.play(scene)


@pytest.mark.parametrize(
    "scene",
    [
        # A knob may get these.
        torsio.Constant(torque_nm=MOTOR_NM),
        torsio.Friction(torque_nm=MOTOR_NM + BRAKE_NM),
        [torsio.Constant(torque_nm=0.05), torsio.Constant(torque_nm=-0.08)],
        [torsio.Constant(torque_nm=0.08, timing=each) for each in (ENDED, LATER)],
        # Wheels of three turns.
        torsio.EndStops(
            lower_rad=-torsio.deg(1080),
            upper_rad=1080.0 / 180.0 * math.pi,
            stiffness_nm_per_rad=1.0,
        ),
        torsio.Detents(torque_nm=0.02, pitch_rad=1),
    ],
)
def test_scene_that_a_knob_can_give_needs_no_words(scene: torsio.Scene) -> None:
    with warnings.catch_warnings(), torsio.open("emulated") as knob:
        warnings.simplefilter("error")
        knob.play(scene)


def test_package_that_was_copied_without_its_metadata_works() -> None:
    code = (
        "from importlib import metadata\n"
        "def missing(name): raise metadata.PackageNotFoundError(name)\n"
        "metadata.distribution = metadata.metadata = metadata.version = missing\n"
        "import torsio\n"
        "from torsio.common import documents, extras\n"
        "print(torsio.__version__, extras.source_folder(), documents.entry('encoder'))\n"
    )
    told = python(code, check=True)
    entry = "docs/reference/troubleshooting.md#encoder"
    assert told.stdout.split() == [torsio.__version__, "None", entry]


def test_plug_is_pulled_at_a_chosen_moment() -> None:
    with torsio.open("emulated") as knob:
        knob.emulator.unplug(after_s=0.2)
        with pytest.raises(torsio.Disconnected) as caught:
            knob.record(1.0)
        samples = caught.value.samples  # type: ignore[attr-defined]
        assert samples["time_s"][-1] == pytest.approx(0.2, abs=0.02)


def test_recording_is_short_in_words_and_a_picture_in_notebooks(tmp_path: Path) -> None:
    with torsio.open("emulated", emulator=HAND) as knob:
        knob.play(WALL)
        knob.arm()
        log = knob.record(0.2)
    recorded = torsio.Recorded(log, [{"kind": "play"}])
    assert repr(recorded) == "<torsio.Recorded 200 samples, 0.199 s, 0 lost, 1 events>"
    shown = ElementTree.fromstring(f"<div>{recorded._repr_html_()}</div>")
    assert len(shown.findall("svg/g/polyline")) == 2
    assert torsio.Recorded(log[:0])._repr_html_().startswith("<p>")
    table = tmp_path / "table.csv"
    recorded.save(table, separator=";", decimal=",")
    last = table.read_text().splitlines()[-1].replace(",", ".").split(";")
    assert [float(cell) for cell in last] == pytest.approx(list(map(float, log[-1].tolist())))
    for wrong in ({"decimal": ","}, {"separator": "5"}, {"separator": ";;"}, {"decimal": "x"}):
        with pytest.raises(torsio.InvalidArgument, match=r"separator and decimal are .*; allowed"):
            recorded.save(table, **wrong)


def test_what_is_no_knob_or_no_scene_is_told_with_what_to_write() -> None:
    with pytest.raises(TypeError, match=r"opened by torsio.open\(\)"):
        torsio.Knob(1)  # type: ignore[arg-type]
    with torsio.open("emulated") as knob:
        for wrong in ("wall", b"x", torsio.Wall, {"wall": 1}, [[WALL]]):
            with pytest.raises(TypeError, match=r"not an effect: .*; give one as torsio.Wall"):
                knob.play(wrong)  # type: ignore[arg-type]
        with pytest.raises(TypeError, match=r"not a hand: .*; give one as torsio.TorqueHand"):
            knob.emulator.set_hand(lambda *_: 0.0)  # type: ignore[arg-type]
        with pytest.raises(TypeError, match=r"^Knob\.record\(\) got an unexpected"):
            knob.record(seconds=1.0)  # type: ignore[call-arg]
        with pytest.raises(AttributeError, match=r'its column is log\["angle_rad"\]'):
            _ = knob.record(0.01).angle_rad  # type: ignore[attr-defined]


KNOTS = torsio.TorqueHand(torque_nm=[(1.0, 0.0)] * 99)


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (torsio.Curve(torque_nm=[0.01] * 1000), r"^Curve\(torque_nm=<tuple of 1000>\)$"),
        (torsio.EmulatorOptions(hand=KNOTS), r"hand=TorqueHand\(torque_nm=<tuple of 99>\)\)$"),
        (calibration.Fit("t", "x", "y", *[np.zeros(1000)] * 3), "x=<ndarray of 1000>, "),
        (batch.LoopOptions(scene=[WALL] * 9), r"LoopOptions\(scene=<list of 9>"),
        (batch.Knobs(9), "^<torsio.batch.Knobs 9 of 1 kinds, actions 'none', at 0 s>$"),
        # These can be pasted.
        (torsio.ControlConfig(beta=0.4), r"^ControlConfig\(beta=0.4\)$"),
        (torsio.Timing(delay_s=1.0), "fade_s=0.0"),
    ],
)
def test_repr_is_short_whatever_it_holds(made: object, said: str) -> None:
    assert len(repr(made)) < 200
    assert re.search(said, repr(made))
    if "<" not in repr(made):
        assert eval(repr(made), vars(torsio)) == made


def _svg_points(shown: str) -> list[tuple[float, float]]:
    """Give the corners of the only curve."""
    (line,) = ElementTree.fromstring(f"<div>{shown}</div>").iter("polyline")
    return [(float(x), float(y)) for x, y in (p.split(",") for p in line.attrib["points"].split())]


def test_wall_shows_itself_as_a_slope_from_its_angle_on() -> None:
    points = _svg_points(WALL._repr_html_())
    # From half a radian before angle 0 to as far behind the wall's 0.1 rad, 480 wide, 120 high.
    begin = 480 * (0.5 + WALL.angle_rad) / (1.0 + WALL.angle_rad)
    for x, y in points:
        assert y == pytest.approx(max(0.0, 120 * (x - begin) / (480 - begin)), abs=0.5)
    damped = torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.0, damping_nm_s_per_rad=0.1)
    assert _svg_points(damped._repr_html_()) == points
    square = torsio.Periodic(amplitude_nm=0.02, frequency_hz=2.0, waveform="square")
    assert {y for _, y in _svg_points(square._repr_html_())} == {0.0, 120.0}
    assert "<svg" not in torsio.Damper(damping_nm_s_per_rad=1e-3)._repr_html_()
    assert "allowed are 0 to" in torsio.Spring(stiffness_nm_per_rad=-5.0)._repr_html_()


@pytest.mark.parametrize("width", [0.25, 1.0])
def test_click_shows_itself_as_steep_as_its_width_says(width: float) -> None:
    detents = torsio.Detents(per_turn=4, torque_nm=0.02, profile="click", width=width)
    angle_rad, torque_nm, _ = detents._course()
    share = angle_rad / (math.pi / 2.0)  # of the pitch, from the only notch that is shown
    wanted = -0.02 * np.clip(2.0 * share / width, -1.0, 1.0)
    assert torque_nm == pytest.approx(wanted, abs=2e-4)


def test_knob_telemetry_and_calibration_show_themselves() -> None:
    with torsio.open("emulated", emulator=HAND) as knob:
        log = knob.record(0.1)
        shown = ElementTree.fromstring(f"<div>{knob._repr_html_()}</div>")
        (pointer,) = shown.iter("line")
        up, across = (50 - float(pointer.attrib["y2"]), float(pointer.attrib["x2"]) - 50)
        assert math.atan2(across, up) == pytest.approx(knob.position_rad() % 6.2832, abs=0.02)
    assert "closed" in knob._repr_html_()
    assert type(log["angle_rad"]) is np.ndarray
    for same in (log, log[5:], pickle.loads(pickle.dumps(log))):
        assert isinstance(same, torsio.Telemetry)
        assert "samples, 0.0" in str(same._repr_html_())
    with pytest.raises(ValueError, match=r"no column 'angle'; there are tick, .*angle_rad"):
        log["angle"]
    columns: Any = log[["tick", "flags"]]
    assert columns._repr_html_() is None
    with torsio.open("emulated") as knob:
        found = calibration.calibrate(knob, drift=True)
    assert len(repr(found)) < 100
    assert all(f"<td>{name}</td>" in found._repr_html_() for name in found.quantities)
    for figure in (log.plot(), WALL.plot(), found.plot(), torsio.Recorded(log).plot()):
        assert figure._repr_png_().startswith(b"\x89PNG")  # type: ignore[attr-defined]
    with pytest.raises(torsio.InvalidArgument, match="Damper gives torque in motion alone"):
        torsio.Damper(damping_nm_s_per_rad=1e-3).plot()


def _json_of(*arguments: str | Path) -> list[dict[str, Any]]:
    """Run the command line; give its lines of JSON, or the one value that they are together."""
    program = (sys.executable, "-m", "torsio")
    done = subprocess.run([*program, *arguments, "--json"], capture_output=True, check=True)
    try:
        return [json.loads(done.stdout)]
    except json.JSONDecodeError:
        return [json.loads(line) for line in done.stdout.splitlines()]


def test_commands_that_show_what_a_knob_does_tell_it_in_json_too(tmp_path: Path) -> None:
    file = tmp_path / "a.mcap"
    emulated = ("--device", "emulated", "--seconds", "0.3")
    (recorded,) = _json_of("record", file, *emulated)
    assert recorded == {
        "file": str(file),
        "samples": len(torsio.load(file).telemetry),
        "samples_lost": 0,
    }
    (replayed,) = _json_of("replay", file)
    assert replayed["identical"] is True
    assert replayed["samples"] == recorded["samples"]
    report = tmp_path / "r.zip"
    (told,) = _json_of("report", report, "--device", "emulated", "--recording", file)
    assert set(told["contents"]) == set(zipfile.ZipFile(report).namelist())
    lines = _json_of("monitor", *emulated)
    assert lines[-1]["health"]["state"] == "disarmed"
    assert lines[-1]["newest"]["angle_rad"] == 0.0
    # In a terminal a record of any length shows some rows.
    log = torsio.load(file).telemetry
    assert len(repr(log).splitlines()) < 12 > len(str(log).splitlines())


def test_reader_that_has_enough_is_no_error() -> None:
    words = ("-m", "torsio", "monitor", "--device", "emulated", "--seconds", "60", "--json")
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, *words], **pipes) as process:  # type: ignore[call-overload]
        process.stdout.readline()
        process.stdout.close()
        assert "error" not in process.stderr.read()
    assert process.returncode == 1


def test_record_tells_on_a_terminal_how_it_does_and_how_it_ends(tmp_path: Path) -> None:
    file = tmp_path / "a.mcap"
    done = subprocess.run(
        [sys.executable, "-m", "torsio", "record", file, "--device", "emulated", "--seconds", "1"],
        env={**os.environ, "FORCE_COLOR": "1", "TERM": "xterm"},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "Ctrl-C ends it earlier" in done.stderr
    told = re.findall(r"(\d+) samples, 0 lost, (\d) s left", done.stderr)
    assert told, done.stderr
    assert max(int(samples) for samples, _ in told) <= len(torsio.load(file).telemetry)


def test_table_cuts_no_name_on_a_narrow_terminal() -> None:
    headings = ("quantity", "value +- standard uncertainty", "to a finger", "what it is")
    made = screen.table(*headings, words=4)
    name = "motor_torque_constant_nm_per_a"
    made.add_row(
        name, "0.05 +- 0.001", "of the motor, as long as nobody has measured it otherwise " * 2
    )
    text = io.StringIO()
    Console(file=text, width=80).print(made)
    assert name in text.getvalue()


def test_every_data_class_that_may_hold_much_is_shown_in_short() -> None:
    classes, seen = [checks.ShortRepr], []
    while classes:
        seen.append(classes.pop())
        classes += seen[-1].__subclasses__()
    assert len(seen) > 10
    assert [one for one in seen if one.__repr__ is not checks.ShortRepr.__repr__] == []
