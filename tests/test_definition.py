"""Printed files are up to date, and the field lists keep their promises."""

from __future__ import annotations

import inspect
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import torsio
import torsio.printed.told as printed_told
from emulator.definition import plant
from firmware.protocol.definition import (
    configurations,
    constants,
    effects,
    enumerations,
    reports,
    told,
)
from tools.definition import generate, markdown
from tools.definition.model import Enumeration, Value
from torsio import protocol

TREE = Path(__file__).parent.parent

# Names of values by number, as released devices and hosts know them: lists only grow at the end.
RELEASED = {
    "Side": ["above", "below"],
    "Waveform": ["sine", "square", "triangle", "sawtooth_up", "sawtooth_down"],
    "DetentProfile": ["sine", "linear", "click"],
    "Grain": ["sine", "square", "triangle", "noise"],
    "Ends": ["hold", "repeat"],
    "Law": ["paper", "compensated", "parallel", "motor_only", "calibrated"],
    "Toggle": ["off", "on"],
    "State": ["disarmed", "armed", "fault"],
    "Basis": ["assumed", "stated", "measured"],
    "Owner": ["none", "sdk", "game", "dial"],
    "Personality": ["game_controller", "dial"],
    "DialUse": [
        *("wheel", "pan", "volume", "radial"),
        *("wheel_or_pan", "wheel_or_volume", "volume_or_wheel"),
    ],
    "Centre": ["power_up", "awaits_index", "index"],
    "GameEffectKind": [
        *("none", "constant", "ramp", "square", "sine", "triangle", "sawtooth_up"),
        *("sawtooth_down", "spring", "damper", "inertia", "friction"),
    ],
    "GameEffectState": ["stopped", "playing", "set_aside"],
    "DisarmReason": [
        *("order", "watchdog", "deadline_missed", "fault", "game_idle", "disconnected"),
        *("unknown", "excitation_over", "excitation_stopped", "dial_idle"),
    ],
    "ResetCause": [
        *("unknown", "power", "brown_out", "reset_pin", "watchdog", "hard_fault", "stack"),
    ],
    "Op": [
        *("keep_alive", "arm", "disarm", "stop", "zero", "relax", "save", "load_defaults"),
        *("clear_fault", "bootloader"),
    ],
    "EventKind": [
        *("state_changed", "watchdog", "deadline_missed", "owner_changed"),
        *("excitation_over", "excitation_stopped"),
    ],
    "Status": [
        *("ok", "bad_length", "bad_padding", "unknown_report", "not_finite", "out_of_range"),
        *("inconsistent", "bad_axis", "empty_slot", "not_armed", "not_disarmed", "fault_latched"),
        *("fault_persists", "stale", "busy", "not_owner", "unsupported"),
    ],
}


@pytest.mark.parametrize("file", generate.contents)
def test_printed_file_is_what_the_field_lists_print(file: str) -> None:
    # Not compared by assert, which would print both in full.
    if (TREE / file).read_text(encoding="utf-8") != generate.made(file):
        pytest.fail(f"{file} is not what the field lists print; run ./dev generate", pytrace=False)


def test_law_and_effect_whose_costs_nobody_has_measured_are_printed(tmp_path: Path) -> None:
    for folder in ("firmware/protocol", "emulator/definition", "tools", "docs"):
        shutil.copytree(TREE / folder, tmp_path / folder)
    for file in generate.contents:
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(TREE / file, tmp_path / file)
    for name, place, text in (
        ("enumerations", '    Value("calibrated"', '    Value("trial", "a trial"),\n'),
        ("effects", "EFFECTS = (", 'TRIAL = _effect(0x2D, "Trial", "A trial.", TORQUE_LIMIT)\n'),
        ("effects", "    CURVE, IMPACT,", "    TRIAL,\n"),
    ):
        path = tmp_path / f"firmware/protocol/definition/{name}.py"
        old = path.read_text(encoding="utf-8")
        assert old.count(place) == 1
        path.write_text(old.replace(place, text + place), encoding="utf-8")
    run = [sys.executable, "-m", "tools.definition.generate"]
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "written: bindings/python/torsio/printed/scenes.py" in done.stdout, done.stderr


@pytest.mark.parametrize(
    "listed", [v for v in vars(enumerations).values() if isinstance(v, Enumeration)], ids=str
)
def test_enumeration_only_grows_at_its_end(listed: Enumeration) -> None:
    names = [value.name for value in listed.values]
    released = RELEASED[listed.name]
    assert names[: len(released)] == released


@pytest.mark.parametrize(
    "pattern",
    [
        r"[=*:(] *2\.873\b",  # N m/rad of the shaft
        r"(?<![\w.])2\.6e-5",  # N m s/rad of the knob
        r"(?i)counts\w*\W+(int = )?8['_]?192\b",  # in a turn
        r"(?i)(hz|rate)\w*\W+20(['_]?000(\.0)?|e3)\b",  # the fastest control
        r"(?i)control_period\w*\W+(int = )?1['_]?000['_]?000",
    ],
)
def test_number_of_the_reference_device_stands_in_the_field_lists_only(pattern: str) -> None:
    again = [
        f"{path.relative_to(TREE)}: {line.strip()}"
        for folder in ("firmware", "emulator", "sdk", "bindings", "studies")
        for path in sorted((TREE / folder).rglob("*.*"))
        if path.suffix in (".hpp", ".cpp", ".h", ".py", ".pyi") and "definition" not in path.parts
        if path.relative_to(TREE).as_posix() not in generate.contents
        for line in path.read_text(encoding="utf-8").splitlines()
        # Not what is told in comments and texts, such as the paper's own numbers.
        if re.search(pattern, re.sub(r"//.*|#.*|\"[^\"]*\"", "", line))
    ]
    assert not again


def test_fingerprint_in_the_page_is_the_one_that_firmware_and_library_compute() -> None:
    assert markdown.fingerprint(reports.ALL_REPORTS) == protocol.fingerprint()


@pytest.mark.parametrize(
    ("grown", "parts"), [(enumerations.EVENT_KIND, False), (enumerations.LAW, True)], ids=str
)
def test_new_value_parts_released_hosts_and_devices_only_where_they_would_refuse_it(
    grown: Enumeration, parts: bool
) -> None:
    more = replace(grown, values=(*grown.values, Value("another")))
    changed = [
        replace(of, fields=tuple(replace(f, of=more) if f.of is grown else f for f in of.fields))
        for of in reports.ALL_REPORTS
    ]
    before = markdown.fingerprint(reports.ALL_REPORTS)
    assert (markdown.fingerprint(changed) != before) == parts


def test_fingerprint_depends_on_every_report() -> None:
    fewer = reports.ALL_REPORTS[:-1]
    assert markdown.fingerprint(fewer) != markdown.fingerprint(reports.ALL_REPORTS)


def test_every_field_of_an_effect_has_words() -> None:
    bare = [
        f"{of.name}.{field.name}"
        for of in effects.EFFECTS
        for field in of.host_fields
        if not field.doc
    ]
    assert not bare


def _class(name: str) -> type:
    """Find a public class, or one that only comes back from a call."""
    found: type = getattr(torsio, name, None) or getattr(printed_told, name)
    return found


def test_every_data_class_has_words_for_its_fields() -> None:
    listed = (*configurations.CONFIGURATIONS, *told.TOLD, plant.PLANT_PARAMS)
    bare = [
        f"{of.name}.{field.name}"
        for of in listed
        for field in of.host_fields
        if f"\n{field.name}\n" not in (inspect.getdoc(_class(of.name)) or "")
    ]
    assert not bare


def test_ledger_counts_torques_in_the_unit_that_the_page_is_told() -> None:
    header = (TREE / "firmware/core/ledger.hpp").read_text(encoding="utf-8")
    found = re.search(r"kLedgerTorquesPerNm = (\w+)F;", header)
    assert found is not None
    assert 1.0 / float.fromhex(found[1]) == constants.LEDGER_TORQUE_NM


def test_fields_that_act_on_motion_have_the_names_that_the_warning_of_swings_looks_for() -> None:
    """Others would be judged at one frequency only; see sdk/conversion/swings.cpp."""
    local_models = (of for of in reports.ALL_REPORTS if of.name == "LocalModel")
    for effect in (*effects.EFFECTS, *local_models):
        for field in effect.fields:
            acts_on_motion = field.unit.startswith("N m s") or "kg" in field.unit
            assert field.name.endswith(("_s_per_rad", "_kg_m2")) == acts_on_motion, field.name
