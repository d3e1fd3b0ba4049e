"""Prints the documents of the field lists: docs/reference/protocol.md and the table of a board's wiring."""

from __future__ import annotations

from collections.abc import Iterable

from tools.definition.model import (
    SCALARS,
    Bits,
    Bound,
    Enumeration,
    Field,
    Structure,
    value_of,
    wire_size,
)

INTRODUCTION = """\
# Protocol

This page is printed from the field lists in `firmware/protocol/definition/`. Do not edit it; run
`./dev generate`.

Torsio talks HID. A report has 64 bytes: its id, its fields without gaps in little-endian order, and
zeros. Floats are IEEE 754 binary32. Angles that may lie many turns away are 64-bit integers in units
of 2^-32 turn. Torques act on the knob, positive along positive angle.

- **Output** reports go from the host to the device and **input** reports come back. The host reads
  **feature** reports, and sets some of them, by control requests.
- The device checks every report: length, padding, finite numbers, ranges, then the fields against
  each other. A report that fails changes nothing.
- The device answers every output report and every setting of a feature report with an
  `acknowledgement` and its sequence number. It does not answer `keep_alive` commands and accepted
  `local_model` reports.
- Both sides compute a fingerprint of the ids, names and types of all reports. The host knows
  its own and the ones of released firmware that it drives. It stops at any other. The first two
  fields of `identity` are the same in every version.
- New values go to the end of their enumeration. New boards, events and statuses do not change the
  fingerprint, and a host shows an unknown one as a number. New laws and waveforms change it.
- A scene is written effect by effect into slots, then committed. The whole change takes effect between
  two ticks of the control loop.
- An armed device expects the host within `watchdog_s` of `control_config`. If the host is silent, or a
  `local_model` passes its deadline, the device *fails passive*. The motor goes to zero in
  `passive_ramp_s`, the brake holds `passive_brake_nm` meanwhile, then the device disarms.
"""


def number_text(value: Bound) -> str:
    """Write a number as briefly as it can be without loss in binary32."""
    plain = value_of(value)
    return str(plain) if isinstance(plain, int) else f"{plain:g}"


def _range(field: Field) -> str:
    if isinstance(field.of, Enumeration):
        values = [v for v in field.of.values if not v.host_only]
        return ", ".join(f"{index} {value.name}" for index, value in enumerate(values))
    if isinstance(field.of, Structure):
        return f"see `{field.of.snake}`"
    if field.low is None or field.high is None:
        return "any"
    if field.kind == "angle":
        return f"+-2^{(int(value_of(field.high)) - 1).bit_length()}"
    return f"{number_text(field.low)} to {number_text(field.high)}"


def _type(field: Field) -> str:
    one = "u8" if isinstance(field.of, Enumeration) else field.wire
    if isinstance(field.of, Structure):
        one = field.of.snake
    return one if field.count == 1 else f"{one}[{value_of(field.count)}]"


def _rows(of: Structure, offset: int) -> str:
    index = 0
    out = ""

    def visit(structure: Structure, prefix: str) -> None:
        nonlocal index, offset, out
        for field in structure.wire_fields:
            name = prefix + field.name_on_wire
            if isinstance(field.of, Structure) and field.count == 1:
                visit(field.of, name + ".")
                continue
            out += (
                f"| {index} | {offset} | `{name}` | {_type(field)} | {_range(field)} | "
                f"{field.wire_unit or field.unit} | {field.doc} |\n"
            )
            index += 1
            offset += wire_size(field)

    visit(of, "")
    return "\n| # | byte | field | type | range | unit | |\n|--:|--:|---|---|---|---|---|\n" + out


def _bits(of: Bits) -> str:
    return "| bit | name | meaning |\n|---|---|---|\n" + "".join(
        f"| 0x{1 << place:02X} | `{bit.name}` | {bit.doc} |\n"
        for place, bit in enumerate(of.bits, of.first)
    )


def _values(of: Structure) -> str:
    """Explain the values that only this report has."""
    out = ""
    for field in of.wire_fields:
        if isinstance(field.of, Enumeration) and not field.of.public and field.of.doc:
            out += f"\n| `{field.name_on_wire}` | meaning |\n|---|---|\n" + "".join(
                f"| {value.name} | {value.doc} |\n" for value in field.of.values
            )
    return out


def protocol(
    reports: Iterable[Structure],
    parts: Iterable[Structure],
    status: Enumeration,
    faults: Bits,
    flags: Bits,
    version: int,
) -> str:
    """Write docs/reference/protocol.md."""
    reports = list(reports)
    out = INTRODUCTION
    out += f"\nProtocol version {version}, fingerprint `0x{fingerprint(reports):08X}`.\n"
    out += "\n## Reports\n\n| id | report | direction | bytes |\n|---|---|---|--:|\n"
    for of in reports:
        out += f"| 0x{of.id:02X} | [{of.snake}](#{of.snake}) | {of.direction} | {1 + of.wire_size()} |\n"
    out += "\n## Status codes\n\n| code | name | meaning |\n|--:|---|---|\n"
    for code, value in enumerate(status.values):
        out += f"| {code} | `{value.name}` | {value.doc} |\n"
    out += f"\n## Bits\n\n`faults`, latched until `clear_fault`:\n\n{_bits(faults)}"
    out += (
        "\n`flags` of telemetry. Bits 0 and 1 are the state: 0 disarmed, 1 armed, 2 fault.\n\n"
        f"{_bits(flags)}"
    )
    out += (
        "\n## Fields\n\n`#` is the index that an acknowledgement names, `byte` counts from the "
        "report's id.\n"
    )
    for of in reports:
        out += f"\n### {of.snake}\n\n{of.wire_doc or of.doc}\n{_rows(of, 1)}{_values(of)}"
    for of in parts:
        out += f"\n### {of.snake}\n\n{of.doc} Bytes count from its start.\n{_rows(of, 0)}"
    return out


def fingerprint(reports: Iterable[Structure]) -> int:
    """Compute what firmware and library compute when they are compiled; see registry.hpp."""
    value = 2166136261

    def add(data: bytes) -> None:
        nonlocal value
        for byte in data:
            value = (value ^ byte) * 16777619 & 0xFFFFFFFF

    def add_type(field: Field) -> None:
        if field.count != 1:
            add(bytes([int(value_of(field.count))]))
        if isinstance(field.of, Structure):
            add_fields(field.of)
        else:
            add((("u8" if isinstance(field.of, Enumeration) else field.wire) + "\0").encode())
            if isinstance(field.of, Enumeration):
                named = sum(not value.host_only for value in field.of.values)
                add(bytes([0 if field.of.open else named]))

    def add_fields(of: Structure) -> None:
        for field in of.wire_fields:
            add(field.name_on_wire.encode() + b"\0")
            add_type(field)

    for of in reports:
        assert of.id is not None
        add(bytes([of.id, ("input", "output", "feature").index(of.direction)]))
        add(of.snake.encode() + b"\0")
        add_fields(of)
    return value


def wiring(of: Structure) -> str:
    """Write the table of pins and electrical values in docs/reference/hardware.md."""
    out = "| field | default | unit | what |\n|---|---|---|---|\n"
    for field in of.host_fields:
        out += f"| `{field.name}` | {_default(field)} | {field.unit} | {field.doc} |\n"
    return out


def configuration(configurations: Iterable[Structure]) -> str:
    """Write the tables of docs/reference/configuration.md."""
    out = ""
    for of in configurations:
        out += f"\n## `{of.snake}`\n\n{of.doc} {of.notes}\n\n"
        out += "| field | default | allowed | unit | what |\n|---|---|---|---|---|\n"
        for field in of.host_fields:
            allowed = "on, off" if field.kind == "switch" else _range(field)
            if field.kind == "choice" and isinstance(field.of, Enumeration):
                allowed = ", ".join(f"`{v.name}`" for v in field.of.values if not v.host_only)
            out += (
                f"| `{field.name}` | {_default(field)} | {allowed} | {field.unit} | {field.doc} |\n"
            )
    return out + "\n"


def _default(field: Field) -> str:
    if field.kind == "switch":
        return "on" if field.default else "off"
    if field.name.endswith("_pin"):
        return f"GP{field.default}" if field.default else "none"
    return field.default if isinstance(field.default, str) else number_text(field.default or 0)


__all__ = ["SCALARS", "configuration", "fingerprint", "protocol", "wiring"]
