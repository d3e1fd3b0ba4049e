"""The codec against a second one written with ``struct``, and against garbage."""

from __future__ import annotations

import json
import math
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import torsio
from tests.golden.make_reports import GOLDEN, reports_json
from tests.python import wire
from torsio import _torsio, protocol
from torsio.closed_loop import LoopOptions, reports
from torsio.errors import MalformedReport

ROWS: list[dict[str, Any]] = json.loads(GOLDEN.read_text())
ROW_IDS = [f"{row['report']}-{n}" for n, row in enumerate(ROWS)]
DESCRIPTIONS = {report["name"]: report for report in protocol.reports()}


def test_golden_file_is_what_the_struct_codec_makes() -> None:
    assert GOLDEN.read_text() == reports_json(ROWS)


def test_golden_file_covers_every_report() -> None:
    assert {row["report"] for row in ROWS} == set(DESCRIPTIONS) == set(wire.REPORTS)


@pytest.mark.parametrize("row", ROWS, ids=ROW_IDS)
def test_struct_decoder_gives_the_golden_values(row: dict[str, Any]) -> None:
    assert wire.decode(bytes.fromhex(row["hex"])) == (row["report"], row["values"])


def _of_the_user(values: dict[str, Any]) -> dict[str, Any]:
    """Give a report's values by the names and in the units of the library's classes."""
    of: dict[str, Any] = {}
    for name, value in values.items():
        if name == "timing":
            of[name] = torsio.Timing(**value)
        elif name == "per_turn_q32":
            of["per_turn"] = value / 2**32
        elif name.endswith("_turns_q32"):
            of[name.replace("_turns_q32", "_rad")] = 2 * math.pi * value / 2**32
        elif name == "points":
            of["torque_nm"] = [0.5] * value
        elif name not in {"target", "sequence", "axis", "first_point"}:
            of[name] = {"on": True, "off": False}.get(value, value)
    return of


USERS = [
    name
    for name, report in DESCRIPTIONS.items()
    if name.endswith("_config")
    or (report["fields"][0]["name"] == "target" and name != "curve_points")
]
# Golden values that do not go with others.
OTHERS = {"actuator_config": {"counts_per_rev": 8192}, "curve": {"first_point": 0, "points": 2}}


@pytest.mark.parametrize("name", USERS)
def test_every_field_of_the_users_classes_travels_in_its_place(name: str) -> None:
    golden = next(row["values"] for row in ROWS if row["report"] == name)
    values = {**golden, **OTHERS.get(name, {})}
    made = getattr(torsio, name.title().replace("_", ""))(**_of_the_user(values))
    if "target" in values:
        data = reports(LoopOptions(scene=[made]))[3]
        values["target"] = dict.fromkeys(values["target"], 0)
    else:
        data = _torsio.Knob.encode_config(name, made)
        values["sequence"] = 0
    assert protocol.decode(data) == (name, values)


# Values that are in range, by the description of each field.


def _scalar(field: dict[str, Any]) -> st.SearchStrategy[Any]:
    if "choices" in field:
        return st.sampled_from(field["choices"])
    if field["type"] == "f32":
        return st.floats(field["min"], field["max"], width=32, allow_nan=False).map(
            lambda value: value + 0.0  # no negative zero: it would decode to another repr
        )
    return st.integers(field["min"], field["max"])


def _field(field: dict[str, Any]) -> st.SearchStrategy[Any]:
    element = _fields(field["fields"]) if "fields" in field else _scalar(field)
    if field["count"] == 1:
        return element
    return st.lists(element, min_size=field["count"], max_size=field["count"])


def _fields(fields: list[dict[str, Any]]) -> st.SearchStrategy[dict[str, Any]]:
    return st.fixed_dictionaries({field["name"]: _field(field) for field in fields})


@st.composite
def reports_in_range(draw: st.DrawFn) -> tuple[str, dict[str, Any]]:
    name = draw(st.sampled_from(sorted(DESCRIPTIONS)))
    return name, draw(_fields(DESCRIPTIONS[name]["fields"]))


@given(reports_in_range())
def test_codec_round_trips_and_agrees_with_struct(report: tuple[str, dict[str, Any]]) -> None:
    name, values = report
    data = protocol.encode(name, values)
    assert data == wire.encode(name, values)
    assert protocol.decode(data) == (name, values)


def test_every_float_that_is_not_finite_is_refused_and_named() -> None:
    for row in ROWS:
        good, at = bytes.fromhex(row["hex"]), 1
        for index, kind in enumerate(wire.REPORTS[row["report"]].formats):
            end = at + struct.calcsize(f"<{kind}")
            for place in range(at, end, 4) if kind.endswith("f") else ():
                for bad in (math.nan, math.inf, -math.inf):
                    with pytest.raises(MalformedReport) as caught:
                        protocol.decode(good[:place] + struct.pack("<f", bad) + good[place + 4 :])
                    assert (caught.value.status, caught.value.field) == ("not_finite", str(index))
            at = end


def test_decode_names_the_unknown_report() -> None:
    with pytest.raises(MalformedReport) as caught:
        protocol.decode(bytes([0x7F]).ljust(64, b"\0"))
    assert caught.value.status == "unknown_report"


@pytest.mark.parametrize(
    ("report", "values", "message"),
    [
        ("anvil", {}, "no report 'anvil'"),
        ("wall", {"colour": 1}, "colour"),
        ("wall", {"side": "beside"}, "side"),
        ("wall", {"target": {"slot": 256}}, "slot"),
        ("wall", {"target": 1}, "target"),
        ("curve_points", {"torque_nm": [0.0]}, "13 values"),
        ("commit", {"active": -1}, "active"),
    ],
)
def test_encode_refuses_what_does_not_fit(
    report: str, values: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        protocol.encode(report, values)


def test_event_that_is_not_known_yet_is_decoded_as_its_number() -> None:
    event = bytes([0x42, 200]).ljust(64, b"\0")  # kind is the first field
    assert protocol.decode(event)[1]["kind"] == 200


def test_fingerprint_is_a_hash_of_ids_names_and_types() -> None:
    """FNV-1a over the layouts as they are described, computed here once more."""
    text = bytearray()
    for report in protocol.reports():
        text.append(report["id"])
        text.append(("input", "output", "feature").index(report["direction"]))
        text += report["name"].encode() + b"\0"
        text += _layout(report["fields"])
    value = 2166136261
    for byte in text:
        value = (value ^ byte) * 16777619 % 2**32
    assert protocol.fingerprint() == value


def _layout(fields: list[dict[str, Any]]) -> bytes:
    text = b""
    for field in fields:
        text += field["name"].encode() + b"\0"
        # The description gives an array of one element as its element; no report has one.
        if field["count"] > 1:
            text += bytes([field["count"]])
        if "fields" in field:
            text += _layout(field["fields"])
        else:
            text += field["type"].encode() + b"\0"
            if choices := field.get("choices"):
                # Hosts take an event that they do not know; a law that they do not know is refused.
                text += bytes([0 if "state_changed" in choices else len(choices)])
    return text
