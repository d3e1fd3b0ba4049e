"""What is printed from the field lists is what they print now, and they keep their promises."""

from __future__ import annotations

from pathlib import Path

import pytest

import torsio
from firmware.protocol.definition import enumerations, reports
from tools.definition import generate, markdown
from tools.definition.model import Enumeration
from torsio import protocol

TREE = Path(__file__).parent.parent

# Names of values by number, as released devices and hosts know them: lists only grow at the end.
RELEASED = {
    "Side": ["above", "below"],
    "Waveform": ["sine", "square", "triangle", "sawtooth_up", "sawtooth_down"],
    "DetentProfile": ["sine", "linear", "click"],
    "Grain": ["sine", "square", "triangle", "noise"],
    "Ends": ["hold", "repeat"],
    "Law": ["paper", "compensated", "parallel", "motor_only"],
    "Toggle": ["off", "on"],
    "State": ["disarmed", "armed", "fault"],
    "Owner": ["none", "sdk", "game"],
    "DisarmReason": [
        *("order", "watchdog", "deadline_missed", "fault", "game_idle", "disconnected"),
        "unknown",
    ],
    "Op": [
        *("keep_alive", "arm", "disarm", "stop", "zero", "relax", "save", "load_defaults"),
        *("clear_fault", "bootloader"),
    ],
    "EventKind": ["state_changed", "watchdog", "deadline_missed", "owner_changed"],
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


@pytest.mark.parametrize(
    "listed", [v for v in vars(enumerations).values() if isinstance(v, Enumeration)], ids=str
)
def test_enumeration_only_grows_at_its_end(listed: Enumeration) -> None:
    names = [value.name for value in listed.values]
    released = RELEASED[listed.name]
    assert names[: len(released)] == released


def test_fingerprint_in_the_page_is_the_one_that_firmware_and_library_compute() -> None:
    assert markdown.fingerprint(reports.ALL_REPORTS) == protocol.fingerprint()


def test_fingerprint_does_not_depend_on_the_names_of_values() -> None:
    # A new law or event must not part released hosts and devices; a new field must.
    renamed = [
        of.__class__(
            **{
                **vars(of),
                "fields": tuple(
                    f.__class__(**{**vars(f), "of": _with_one_more(f.of)})
                    if isinstance(f.of, Enumeration)
                    else f
                    for f in of.fields
                ),
            }
        )
        for of in reports.ALL_REPORTS
    ]
    assert markdown.fingerprint(renamed) == markdown.fingerprint(reports.ALL_REPORTS)
    shorter = [*reports.ALL_REPORTS[:-1]]
    assert markdown.fingerprint(shorter) != markdown.fingerprint(reports.ALL_REPORTS)


def _with_one_more(of: Enumeration) -> Enumeration:
    return Enumeration(of.name, (*of.values, of.values[0]), of.doc, of.open, of.public)


def test_every_data_class_has_words_for_its_fields() -> None:
    for name in ("ActuatorConfig", "ControlConfig", "BoardConfig", "GameConfig", "PlantParams"):
        documented = getattr(torsio, name).__doc__
        for field in getattr(torsio, name).__dataclass_fields__:
            assert field in ("_", "shaft_hardening", "brake_hysteresis", "belt", "cogging") or (
                f"\n    {field}\n" in documented
            ), f"{name}.{field} is not documented"
