"""Prints the C++ of the field lists.

That is the wire's structures for firmware and library, and the library's own for users.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from tools.definition.model import (
    SCALARS,
    Bits,
    Bound,
    Constant,
    Enumeration,
    Field,
    ReportUnit,
    Structure,
    value_of,
)

WIDTH = 95  # of a line with a comment behind it
GENERATED = "Printed from the field lists in {lists} by `./dev generate`; change those instead."


def literal(value: Bound | str | bool, cpp_type: str) -> str:
    """Write a number as C++ does, with the suffix of its type."""
    if isinstance(value, Constant):
        return f"{'-' if value.negated else ''}{value.name}"
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "true" if value else "false"
    if cpp_type in ("float", "double"):
        text = float_text(float(value))
        is_fraction = "." in text or "e" in text
        if cpp_type == "double":
            return text if is_fraction else text + ".0"
        return text + "F" if is_fraction else text
    return _whole(int(value), cpp_type)


def _whole(value: int, cpp_type: str) -> str:
    if abs(value) > 0xFFFFFFFF:
        shift = (value & -value).bit_length() - 1
        sign = "u" if cpp_type.startswith("std::u") else ""
        return f"std::{sign}int64_t{{{value >> shift}}} << {shift}"
    if value > 0xFFFF and value & (value - 1) == 0:
        return f"1U << {value.bit_length() - 1}"
    return str(value)


def float_text(value: float) -> str:
    """Write a float exactly, in the form that is easiest to read: 0.002, 1e6, 2.6e-5."""
    plain = (
        repr(value).removesuffix(".0").replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")
    )
    if plain == "0" or "e" in plain:
        return plain
    digits = next(f"{value:.{n}e}" for n in range(17) if float(f"{value:.{n}e}") == value)
    mantissa, _, exponent = digits.partition("e")
    scientific = f"{mantissa}e{int(exponent)}"
    return scientific if len(scientific) <= len(plain) - 2 else plain


def quoted(text: str) -> str:
    """Write a string literal."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def comment(text: str, mark: str = "///") -> str:
    """Write a comment; clang-format breaks it into lines."""
    return f"{mark} {text}\n" if text else ""


def header(doc: str, lists: str, includes: Iterable[str], namespace: str, body: str) -> str:
    """Put together one header."""
    lines = "".join(
        f"#include {name if name.startswith('<') else quoted(name)}\n" for name in includes
    )
    return (
        f"/// @file\n{comment(doc)}///\n{comment(GENERATED.format(lists=lists))}#pragma once\n\n"
        f"{lines}\nnamespace {namespace} {{\n\n{body}\n}}  // namespace {namespace}\n"
    )


# --- on the wire ---------------------------------------------------------------------------------


def constant(of: Constant) -> str:
    """Write a named number."""
    value = of.cpp_value or literal(of.value, of.cpp_type)
    line = f"inline constexpr {of.cpp_type} {of.name} = {value};"
    if len(line) + len(of.doc) > WIDTH:
        return comment(of.doc[0].upper() + of.doc[1:] + ".", "//") + line + "\n"
    return f"{line}  // {of.doc}\n" if of.doc else f"{line}\n"


def _values(names: Sequence[str]) -> tuple[str, str]:
    return f"std::array<std::string_view, {len(names)}>", ", ".join(map(quoted, names))


def wire_enumeration(of: Enumeration) -> str:
    """Write an enumeration and the names of its values."""
    values = [v for v in of.values if not v.host_only]
    listed = "".join(
        f"{v.name},{'  // ' + v.doc if v.doc else ''}\n" if any(v.doc for v in values)
        else f"{v.name}, "
        for v in values
    ).removesuffix(", ")  # fmt: skip
    nodiscard = "[[nodiscard]] " if of.name == "Status" else ""
    kind, names = _values([v.name for v in values])
    out = f"{comment(of.doc)}enum class {nodiscard}{of.name} : std::uint8_t {{ {listed} }};\n"
    out += f"template <>\nstruct Enumerators<{of.name}> {{\n"
    out += f"static constexpr {kind} names{{{names}}};\n"
    if any(v.advice for v in values):
        kind, texts = _values([v.advice for v in values])
        out += f"/// For the user whom it stops.\nstatic constexpr {kind} advice{{{texts}}};\n"
    out += f"static constexpr bool open = {literal(of.open, 'bool')};\n}};\n\n"
    return out


def bits(of: Bits, *, with_names: bool = True) -> str:
    """Write named bits."""
    kind, names = _values([bit.name for bit in of.bits])
    note = "//" if with_names else "///<"
    cpp_type = SCALARS[of.type][0]
    out = f"{comment(of.doc)}namespace {of.name} {{\n"
    if of.first:
        mask = f"state_mask = {hex((1 << of.first) - 1)}"
        out += f"inline constexpr {cpp_type} {mask};  {note} the state\n"
    for place, bit in enumerate(of.bits, of.first):
        out += f"inline constexpr {cpp_type} {bit.name} = 1 << {place};  {note} {bit.doc}\n"
    if with_names:
        out += f"inline constexpr {kind} names{{{names}}};  // from bit {of.first} on\n"
    return out + f"}}  // namespace {of.name}\n\n"


def _wire_type(field: Field) -> str:
    one = field.of.name if field.of else SCALARS[field.wire][0]
    if field.count == 1:
        return one
    return f"std::array<{one}, {literal(field.count, 'int')}>"


def _wire_default(field: Field) -> str:
    if isinstance(field.of, Enumeration):
        if field.kind == "switch":
            return f"= Toggle::{'on' if field.default else 'off'}"
        return f"= {field.of.name}::{field.default}"
    if isinstance(field.of, Structure):
        return "{}" if field.count != 1 else ""
    if field.count != 1:
        return "{}"
    default = field.default
    if default is None:
        default = 0 if field.low is None or field.kind != "whole" else value_of(field.low)
    if field.kind == "angle":
        default = 0
    return f"= {literal(default, SCALARS[field.wire][0])}"


def _layout_line(field: Field, owner: str) -> str:
    member = f"&{owner}::{field.name_on_wire}"
    name = quoted(field.name_on_wire)
    doc = quoted(field.doc)
    if isinstance(field.of, Structure):
        return f"group({name}, {member}, {doc}),\n"
    if isinstance(field.of, Enumeration):
        return f"choice({name}, {member}, {doc}),\n"
    unit = quoted(field.wire_unit or field.unit)
    if field.low is None or field.high is None:
        return f"any_number({name}, {member}, {unit}, {doc}),\n"
    cpp_type = SCALARS[field.wire][0]
    low, high = literal(field.low, cpp_type), literal(field.high, cpp_type)
    return f"number({name}, {member}, {unit}, {low}, {high}, {doc}),\n"


def wire_structure(of: Structure) -> str:
    """Write a structure as it travels, and its layout."""
    out = f"{comment(of.wire_doc or of.doc)}struct {of.name} {{\n"
    for field in of.wire_fields:
        out += f"{_wire_type(field)} {field.name_on_wire} {_wire_default(field)};\n"
    out += f"}};\ntemplate <>\nstruct Layout<{of.name}> {{\n"
    if of.id is not None:
        out += f"static constexpr std::uint8_t id = 0x{of.id:02X};\n"
        out += f"static constexpr Direction direction = Direction::{of.direction};\n"
    out += f"static constexpr std::string_view name = {quoted(of.snake)};\n"
    out += f"static constexpr std::string_view doc = {quoted(of.wire_doc or of.doc)};\n"
    out += "static constexpr FieldList fields{\n"
    out += "".join(_layout_line(field, of.name) for field in of.wire_fields)
    return out + "};\n};\n\n"


def wire_sizes(structures: Iterable[Structure]) -> str:
    """Write the sizes as literals: a change of the wire must be seen in a diff."""
    out = "// The sizes as literals: a change of the wire must be seen in a diff.\n"
    for of in structures:
        if of.id is not None:
            out += f"static_assert(wire_size<{of.name}>() == {of.wire_size()});\n"
    return out


def report_list(
    name: str, doc: str, structures: Iterable[Structure], kind: str = "std::tuple"
) -> str:
    """Write a list of types."""
    return f"{comment(doc)}using {name} = {kind}<{', '.join(s.name for s in structures)}>;\n\n"


_LINE = 90  # longer notes stand above what they explain


def report_units(units: Mapping[str, ReportUnit]) -> str:
    """Write how numbers are told that reports count in units of their own."""
    rows = "".join(
        f'{{"{unit}", "{of.ending}", "{of.told_ending}"}},\n' for unit, of in units.items()
    )
    cases = "".join(
        f"if constexpr (index == {index}) return {of.in_si};\n"
        for index, of in enumerate(units.values())
    )
    return (
        "/// How users know a number that a report counts in a unit of its own.\n"
        "struct ReportUnit {\nstd::string_view unit;\n"
        "std::string_view ending;  ///< of the name in the report\n"
        "std::string_view told_ending;  ///< of the name in SI units\n};\n\n"
        f"inline constexpr std::array<ReportUnit, {len(units)}> kReportUnits{{{{\n{rows}}}}};\n\n"
        "/// The number in SI units; it is counted in unit `index` of kReportUnits, or in none of them.\n"
        "template <std::size_t index, class Number>\n"
        "Number in_si(Number counted, [[maybe_unused]] const protocol::Identity& device) {\n"
        f"{cases}return counted;\n}}\n"
    )


# --- for users -----------------------------------------------------------------------------------


def host_enumeration(of: Enumeration) -> str:
    """Write an enumeration for users."""
    listed = "".join(
        f"{v.name},{'  ///< ' + v.doc if v.doc else ''}\n" if any(v.doc for v in of.values)
        else f"{v.name}, "
        for v in of.values
    ).removesuffix(", ")  # fmt: skip
    return f"{comment(of.doc)}enum class {of.name} : std::uint8_t {{ {listed} }};\n\n"


def _range_text(field: Field) -> str:
    if field.rule:
        return field.rule
    if field.kind not in ("number", "whole") or field.low is None or field.high is None:
        return ""
    low, high = (float_text(float(f"{value_of(b):.9g}")) for b in (field.low, field.high))
    return f"{low} to {high}"


def _host_default(field: Field) -> str:
    if field.kind in ("group", "optional", "numbers", "text", "texts", "function", "bytes"):
        return "{}"
    if field.kind == "hand":
        return f"= {field.default}"
    if field.kind == "profile":
        return f"{{{field.default}}}" if field.default else "{}"
    if field.kind == "choice":
        assert isinstance(field.of, Enumeration)
        return f"= {field.of.name}::{field.default}"
    if is_required(field):
        # None that any range allows.
        return "= 0" if field.kind == "whole" else "= std::numeric_limits<double>::quiet_NaN()"
    default = field.default
    if isinstance(default, Constant):
        default = default.value
    return f"= {literal(default, field.host)}"  # type: ignore[arg-type]


def is_required(field: Field) -> bool:
    """Whether a number has no default, so that users must give it."""
    return field.default is None and field.kind in ("number", "angle", "whole")


def host_note(field: Field, *, required: bool = False) -> str:
    """Say what a field is, its unit where the name has none, and its range."""
    parts = ["must be given" if is_required(field) and required else ""]
    parts += [field.doc.replace("on: ", "true: ").replace("off: ", "false: "), _range_text(field)]
    return "; ".join(part for part in parts if part)


def host_structure(of: Structure) -> str:
    """Write a structure for users."""
    out = comment(" ".join(part for part in (of.doc, of.notes) if part))
    out += f"struct {of.name} {{\n"
    for field in of.host_fields:
        note = host_note(field, required=True)
        default = "" if of.array_record else _host_default(field)
        line = f"{field.host} {field.name} {default};"
        if len(line) + len(note) > _LINE:
            out += f"{comment(note)}{line}\n"
        else:
            out += f"{line}{'  ///< ' + note if note else ''}\n"
    if of.comparable:
        out += f"\nfriend bool operator==(const {of.name}&, const {of.name}&) = default;\n"
    return out + "};\n\n"


def names(of: Enumeration) -> str:
    """Write the names of an enumeration's values, for users."""
    kind, listed = _values([v.name for v in of.values])
    return (
        f"template <>\nstruct Names<{of.name}> {{\n"
        f"static constexpr {kind} values{{{listed}}};\n}};\n"
    )


def field_list(of: Structure) -> str:
    """Write the list of a structure's fields, for users."""
    out = f"template <>\nstruct Fields<{of.name}> {{\n"
    out += f"static constexpr std::string_view name = {quoted(of.name)};\n"
    out += "template <class Visit>\nstatic constexpr decltype(auto) apply(Visit&& visit) {\nreturn visit(\n"
    fields = []
    for field in of.host_fields:
        bounded = field.low is not None and field.high is not None and field.kind != "angle"
        low, high = (
            (literal(float(value_of(b)), "double") for b in (field.low, field.high))  # type: ignore[arg-type]
            if bounded
            else ("-kNoLimit", "kNoLimit")
        )
        fields.append(
            f"field({quoted(field.name)}, &{of.name}::{field.name}, {quoted(field.unit)}, "
            f"{low}, {high}, {quoted(field.doc)})"
        )
    return out + ",\n".join(fields) + ");\n}\n};\n"
