"""Prints the TypeScript of the field lists: one table, which a page's codec and its forms read."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from tools.definition.cpp import GENERATED
from tools.definition.model import (
    Bits,
    Bound,
    Enumeration,
    Field,
    Structure,
    value_of,
    wire_size,
)

# Types of the wire whose values are no numbers in JavaScript: their bounds are printed as text.
_BIG = ("i64", "u64")


def module(doc: str, lists: str, constants: dict[str, Any]) -> str:
    """Put together one module of exported constants."""
    note = GENERATED.format(lists=lists)
    out = f'// {doc}\n//\n// {note}\n\nimport type {{ Bit, Report }} from "./fields";\n'
    for name, (kind, value) in constants.items():
        out += f"\nexport const {name}: {kind} = {_text(value)};\n"
    return out


def _text(value: Any, indent: str = "") -> str:
    """Write JSON, a line for each field."""
    flat = json.dumps(value, ensure_ascii=False)
    if len(indent) >= 6 or len(flat) < 96 or not isinstance(value, dict | list):
        return flat
    inner = indent + "  "
    if isinstance(value, list):
        return "[\n" + "".join(f"{inner}{_text(v, inner)},\n" for v in value) + indent + "]"
    lines = (f"{inner}{json.dumps(k)}: {_text(v, inner)},\n" for k, v in value.items())
    return "{\n" + "".join(lines) + indent + "}"


def values(of: Enumeration) -> list[str]:
    """Give the names of an enumeration's values on the wire."""
    return [value.name for value in of.values if not value.host_only]


def bits(of: Bits) -> list[dict[str, Any]]:
    """Give named bits with their words."""
    return [
        {"name": bit.name, "bit": place, "doc": bit.doc, "advice": bit.advice}
        for place, bit in enumerate(of.bits, of.first)
    ]


def _bound(bound: Bound | None, wire: str) -> Any:
    if bound is None:
        return None
    value = value_of(bound)
    return str(int(value)) if wire in _BIG else value


def _default(field: Field) -> Any:
    default = field.default
    if isinstance(default, str) and not isinstance(field.of, Enumeration):
        return None  # the name of a constant that only the device fills in
    if isinstance(default, bool | str) or default is None:
        return default
    return _bound(default, field.wire)


def _on_wire(of: Field) -> dict[str, Any]:
    if not of.wire:
        return {}
    out: dict[str, Any] = {"wire": of.name_on_wire}
    if isinstance(of.of, Structure):
        out["fields"] = [field(f) for f in of.of.fields]
    else:
        out["type"] = "u8" if isinstance(of.of, Enumeration) else of.wire
    if of.count != 1:
        out["count"] = int(value_of(of.count))
    return out


def _allowed(of: Field) -> dict[str, Any]:
    if isinstance(of.of, Enumeration):
        out = {"enumeration": of.of.name, "values": values(of.of)}
        return out | ({"open": True} if of.of.open else {})
    if of.low is None or of.high is None:
        return {}
    return {"low": _bound(of.low, of.wire), "high": _bound(of.high, of.wire)}


def field(of: Field) -> dict[str, Any]:
    """Describe a field: how it travels, and what a person is shown of it."""
    out = {"name": of.name, "kind": of.kind, "doc": of.doc, **_on_wire(of), **_allowed(of)}
    if of.unit:
        out["unit"] = of.unit
    if _default(of) is not None:
        out["default"] = _default(of)
    if of.host:
        out["shown"] = True
    if of.surface:
        out["surface"] = True
    if of.not_below:
        out["notBelow"] = of.not_below
    return out


def reports(listed: Iterable[Structure]) -> dict[str, Any]:
    """Describe reports by their names."""
    return {
        of.snake: {
            "id": of.id,
            "direction": of.direction,
            "title": of.name,
            "doc": of.doc,
            "notes": of.notes,
            "size": sum(map(wire_size, of.wire_fields)),
            "fields": [field(f) for f in of.fields],
            **({"example": of.example} if of.example is not None else {}),
        }
        for of in listed
    }
