"""Prints the C interface of the field lists: its structures, and their way to C++'s and back."""

from __future__ import annotations

from collections.abc import Iterable

from tools.definition.cpp import GENERATED, comment, host_note, quoted
from tools.definition.model import Bits, Enumeration, Field, Structure, value_of

# Whole numbers as C writes them.
_WHOLE = {
    "int": "int32_t",
    "std::uint8_t": "uint8_t",
    "std::uint16_t": "uint16_t",
    "std::uint32_t": "uint32_t",
    "std::uint64_t": "uint64_t",
    "std::int64_t": "int64_t",
}
# They come in arrays, whose functions are told the size of an element.
IN_ARRAYS = ("TelemetrySample", "TruthSample", "ListedDevice", "GameEffect")
# The library tells them, so that they have no defaults worth naming.
TOLD = (
    *IN_ARRAYS,
    "DeviceInfo",
    "Clock",
    "Health",
    "Energies",
    "MotorCurrent",
    "Limits",
    "StableStiffness",
    "GameStatus",
    "LinkStatistics",
    "Event",
    "Disarm",
    "ElectricsState",
)
# Part of others, which have the size.
INSIDE = ("Timing",)
# A hand is given by functions, and nobody asks in C what entered a device.
_NOT_IN_C = ("hand", "log_inputs")


def snake(name: str) -> str:
    """Write a name of C++ as C does: EndStops, end_stops."""
    return "".join(("_" if c.isupper() and i else "") + c.lower() for i, c in enumerate(name))


def c_name(of: Structure | Enumeration | Bits) -> str:
    """Give the name of a type."""
    return f"torsio_{snake(of.name)}"


def has_size(of: Structure) -> bool:
    """Say whether the structure begins with its size."""
    return of.name not in (*IN_ARRAYS, *INSIDE)


def members(of: Structure) -> list[Field]:
    """Give the fields that C has."""
    return [field for field in of.host_fields if field.name not in _NOT_IN_C]


def _is_pointer(field: Field) -> bool:
    """Say whether a part is given by its address: where it may be left out, or has a size of its own."""
    is_part = isinstance(field.of, Structure)
    return is_part and (field.kind == "optional" or has_size(field.of))  # type: ignore[arg-type]


def header(doc: str, lists: str, includes: Iterable[str], guard: str, body: str) -> str:
    """Put together one header for C and C++."""
    lines = "".join(f"#include {name}\n" for name in includes)
    return (
        f"/// @file\n{comment(doc)}///\n{comment(GENERATED.format(lists=lists))}"
        f"#ifndef {guard}\n#define {guard}\n\n{lines}\n"
        '#ifdef __cplusplus\nextern "C" {\n#endif\n\n'
        f"{body}\n#ifdef __cplusplus\n}}\n#endif\n\n#endif\n"
    )


# --- what C's users see --------------------------------------------------------------------------


def enumeration(of: Enumeration) -> str:
    """Write an enumeration, and what gives the names of its values."""
    name = c_name(of)
    out = f"{comment(of.doc)}typedef enum {name} {{\n"
    for number, value in enumerate(of.values):
        note = f"  ///< {value.doc}" if value.doc else ""
        out += f"{name.upper()}_{value.name.upper()} = {number},{note}\n"
    out += f"}} {name};\n"
    return out + f"TORSIO_API const char *{name}_name(int32_t value);\n\n"


def bits(of: Bits, prefix: str = "") -> str:
    """Write named bits."""
    name = (prefix or c_name(of)).upper()
    out = comment(of.doc) + "enum {\n"
    if of.first:
        out += f"{name}_STATE_MASK = {hex((1 << of.first) - 1)},\n"
    for place, bit in enumerate(of.bits, of.first):
        out += f"{name}_{bit.name.upper()} = 1 << {place},  ///< {bit.doc}\n"
    return out + "};\n\n"


def _member(field: Field, *, told: bool) -> str:
    if isinstance(field.of, Structure) and _is_pointer(field):
        return f"const {c_name(field.of)} *{field.name};"
    if isinstance(field.of, Structure):
        return f"{c_name(field.of)} {field.name};"
    if field.kind == "numbers":
        return f"const double *{field.name}; size_t {field.name}_count;"
    if field.kind == "profile":
        return f"const torsio_knot *{field.name}; size_t {field.name}_count;"
    kinds = {
        "number": "float" if field.host == "float" else "double",
        "angle": "double",
        "optional": "double",
        "switch": "bool",
        "choice": "int32_t",
        "whole": _WHOLE.get(field.host, ""),
        "texts": "uint32_t",
    }
    if field.kind == "text":
        return f"char {field.name}[TORSIO_TEXT_BYTES];" if told else f"const char *{field.name};"
    return f"{kinds[field.kind]} {field.name};"


def _note(field: Field) -> str:
    note = host_note(field, required=True)
    if field.kind == "choice" and field.of:
        return f"a torsio_{snake(field.of.name)}" + (f": {note}" if note else "")
    if field.kind == "texts":
        return "TORSIO_FAULT_...: " + note.partition(":")[0].replace("names of the", "the")
    if field.kind == "optional":
        return f"{note}; {'NULL' if field.of else '0'}: without".removeprefix("; ")
    if isinstance(field.of, Structure) and _is_pointer(field):
        return f"{note}; NULL: as torsio_{snake(field.of.name)}_init() has it"
    if field.kind == "profile":
        return f"{note}; none: 0 for ever"
    return note


def _default_note(field: Field) -> str:
    default = field.default
    if field.kind not in ("number", "whole", "angle", "switch", "choice") or default in (None, 0):
        return ""
    if isinstance(default, bool):
        return "at first true" if default else ""
    if isinstance(default, str):
        return "" if not isinstance(field.of, Enumeration) else f"at first {default}"
    return f"at first {value_of(default):g}"  # type: ignore[arg-type]


def structure(of: Structure) -> str:
    """Write a structure and what fills in its defaults."""
    name = c_name(of)
    out = comment(" ".join(part for part in (of.doc, of.notes) if part))
    out += f"typedef struct {name} {{\n"
    if has_size(of):
        out += f"uint32_t struct_size;  ///< bytes of a {name}\n"
    for field in members(of):
        told = [_note(field)]
        if of.name not in TOLD:
            told.append(_default_note(field))
        note = "; ".join(part for part in told if part)
        out += f"{comment(note)}{_member(field, told=of.name in TOLD)}\n"
    out += f"}} {name};\n"
    if has_size(of):
        out += f"TORSIO_API torsio_result {name}_init({name} *structure);\n"
    return out + "\n"


def adder(of: Structure) -> str:
    """Declare what puts an effect into a scene."""
    return (
        f"TORSIO_API torsio_result torsio_scene_add_{snake(of.name)}("
        f"torsio_scene *scene, const {c_name(of)} *effect);\n"
    )


def configuration(of: Structure) -> str:
    """Declare what reads and sets a configuration."""
    name = snake(of.name)
    return (
        f"TORSIO_API torsio_result torsio_knob_{name}(torsio_knob *knob, {c_name(of)} *config);\n"
        f"TORSIO_API torsio_result torsio_knob_set_{name}("
        f"torsio_knob *knob, const {c_name(of)} *config);\n"
    )


# --- their way to C++'s and back -----------------------------------------------------------------


def _read(field: Field) -> str:
    """Write how C++ gets a field."""
    own = f"from.{field.name}"
    if isinstance(field.of, Structure) and _is_pointer(field):
        return (
            f"if ({own} != nullptr) to.{field.name} = "
            f"from_c(need_sized({own}, {quoted(field.name)}, {quoted(c_name(field.of))}));"
        )
    if isinstance(field.of, Structure):
        return f"to.{field.name} = from_c({own});"
    if field.kind in ("numbers", "profile"):
        return f"take(to.{field.name}, {own}, {own}_count, {quoted(field.name)});"
    if field.kind == "optional":
        return f"if ({own} != 0.0) to.{field.name} = {own};"
    if field.kind == "choice":
        return f"to.{field.name} = choice<{field.host}>({own}, {quoted(field.name)});"
    if field.kind == "switch":
        return f"to.{field.name} = flag({own});"
    if field.kind == "text":
        return f"if ({own} != nullptr) to.{field.name} = {own};"
    return f"to.{field.name} = {own};"


def _write(field: Field, *, told: bool) -> str:
    """Write how C gets a field."""
    own = f"from.{field.name}"
    if isinstance(field.of, Structure) and _is_pointer(field):
        return f"to.{field.name} = nullptr;"
    if isinstance(field.of, Structure):
        return f"to.{field.name} = to_c({own});"
    if field.kind in ("numbers", "profile"):
        return f"to.{field.name} = nullptr; to.{field.name}_count = 0;"
    if field.kind == "optional":
        return f"to.{field.name} = {own}.value_or(0.0);"
    if field.kind == "choice":
        return f"to.{field.name} = static_cast<std::int32_t>({own});"
    if field.kind == "text" and not told:
        return f"to.{field.name} = nullptr;"
    if field.kind == "text":
        return f"copy(to.{field.name}, {own});"
    if field.kind == "texts":
        return f"to.{field.name} = fault_bits({own});"
    return f"to.{field.name} = {own};"


def reader(of: Structure) -> str:
    """Write what makes C++'s structure of C's."""
    out = f"inline {of.name} from_c(const {c_name(of)}& from) {{\n{of.name} to;\n"
    return out + "".join(_read(field) + "\n" for field in members(of)) + "return to;\n}\n"


def writer(of: Structure) -> str:
    """Write what makes C's structure of C++'s."""
    name = c_name(of)
    out = f"inline {name} to_c([[maybe_unused]] const {of.name}& from) {{\n{name} to{{}};\n"
    if has_size(of):
        out += f"to.struct_size = sizeof({name});\n"
    told = of.name in TOLD
    written = "".join(_write(field, told=told) + "\n" for field in members(of))
    return out + written + "return to;\n}\n"


def same_layout(of: Structure) -> str:
    """Assert that both languages have the same bytes."""
    name = c_name(of)
    out = f"static_assert(sizeof({name}) == sizeof({of.name}));\n"
    for field in of.host_fields:
        out += (
            f"static_assert(offsetof({name}, {field.name}) == offsetof({of.name}, {field.name}));\n"
        )
    return out


def definition(declaration: str, body: str) -> str:
    """Write a function of the library."""
    head = declaration.strip().removeprefix("TORSIO_API ").removesuffix(";")
    return f"{head} {{ {body} }}\n"
