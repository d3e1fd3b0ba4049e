"""The language of the field lists: enumerations, bits, structures, and the fields in them.

A field is stated once, as a person writes it: name with the unit as suffix, unit, range, default,
sentence. How it travels and what it is in C++ and Python follows from its kind:

=========== ==================== ======================= ==================
kind        on the wire          C++                     Python
=========== ==================== ======================= ==================
number      f32                  double                  float
whole       u8, u16, u32, ...    int or std::uint32_t    int
angle       i64, 2^-32 turn      double, in rad          float
switch      u8, off or on        bool                    bool
choice      u8                   an enumeration          a Literal
=========== ==================== ======================= ==================

A field of only one side says so: `wire` ones are filled in by the library, `host` ones are turned
into others by a rule across fields.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

Number = int | float

SCALARS = {
    "u8": ("std::uint8_t", 1),
    "u16": ("std::uint16_t", 2),
    "u32": ("std::uint32_t", 4),
    "u64": ("std::uint64_t", 8),
    "i8": ("std::int8_t", 1),
    "i16": ("std::int16_t", 2),
    "i32": ("std::int32_t", 4),
    "i64": ("std::int64_t", 8),
    "f32": ("float", 4),
}
"""Types on the wire: how C++ writes them, and their size in bytes."""


@dataclass(frozen=True)
class Constant:
    """A number with a name, used as a bound, a default or a size. `-constant` is one too."""

    name: str
    value: Number
    cpp_type: str = "float"
    cpp_value: str = ""
    """How C++ writes the value, if not as a plain literal."""
    doc: str = ""
    negated: bool = False

    def __neg__(self) -> Constant:
        """Give the same name with a minus."""
        return replace(self, value=-self.value, negated=not self.negated)


Bound = Number | Constant


def value_of(bound: Bound) -> Number:
    """Give the number behind a bound or default."""
    return bound.value if isinstance(bound, Constant) else bound


@dataclass(frozen=True)
class Value:
    """One value of an enumeration, or one bit."""

    name: str
    doc: str = ""
    advice: str = ""
    """For the user whom it stops: what it means and what to do about it."""
    host_only: bool = False
    """Never on the wire: the library's own."""


@dataclass(frozen=True)
class Enumeration:
    """Named values that count from 0 without a hole. New ones go to the end."""

    name: str
    values: tuple[Value, ...]
    doc: str = ""
    open: bool = False
    """A host takes a number that it does not know yet, and shows it as a number."""
    public: bool = True
    """Users of the libraries see it."""

    def index(self, name: str) -> int:
        """Give the number of a value."""
        return [value.name for value in self.values].index(name)


def enumeration(
    name: str, doc: str, *values: str | Value, open: bool = False, public: bool = True
) -> Enumeration:
    """Make an enumeration; a plain string is a value that needs no words."""
    listed = tuple(Value(v) if isinstance(v, str) else v for v in values)
    return Enumeration(name, listed, doc, open, public)


@dataclass(frozen=True)
class Bits:
    """Names of the bits of a whole number, from `first` on."""

    name: str
    type: str
    bits: tuple[Value, ...]
    doc: str = ""
    first: int = 0


Kind = Literal[
    "number", "whole", "angle", "switch", "choice", "group", "array", "numbers", "profile", "text",
    "texts", "optional", "function", "hand", "bytes",
]  # fmt: skip


@dataclass(frozen=True)
class Field:
    """One field of a structure, on the wire, in the hands of a user, or both."""

    name: str
    kind: Kind
    doc: str = ""
    unit: str = ""
    low: Bound | None = None
    high: Bound | None = None
    """None: every value of the type has a meaning."""
    default: Bound | str | bool | None = None
    """None: Python's users must give it."""
    wire: str = ""
    """Type on the wire; empty: it does not travel by itself."""
    host: str = ""
    """Type in C++; empty: users do not see it."""
    wire_name: str = ""
    """If it is not the name: 2^-32 turns instead of radians."""
    wire_unit: str = ""
    count: int | Constant = 1
    of: Enumeration | Structure | None = None
    rule: str = ""
    """The range in words, where no two numbers bound it: > 0."""
    surface: bool = False
    """Something solid begins at this angle: the studio marks it on its dial."""
    not_below: str = ""
    """The field that it must not be below, which the studio tells while one types."""

    @property
    def name_on_wire(self) -> str:
        """The field's name in the report."""
        return self.wire_name or self.name


@dataclass(frozen=True)
class Structure:
    """A report, a part of one, a configuration, a record or a set of parameters."""

    name: str
    doc: str
    fields: tuple[Field, ...]
    notes: str = ""
    """More for the user, after the first sentence."""
    wire_doc: str = ""
    """For the protocol's page, if users are told something else."""
    id: int | None = None
    direction: Literal["input", "output", "feature", ""] = ""
    wire_name: str = ""
    base: str = ""
    """Python's base class, which may hold methods."""
    array_record: bool = False
    """Many of them are a NumPy structured array in Python; one has no class."""
    comparable: bool = False
    checked: bool = False
    """Python asks for the kinds of all values when one is made; else where it is used."""
    example: Mapping[str, object] | None = None
    """Values that the studio begins with, so that an effect can be felt at once; None: empty fields."""

    @property
    def snake(self) -> str:
        """Its name as the wire and messages have it: end_stops."""
        return self.wire_name or "".join(
            ("_" if c.isupper() and i else "") + c.lower() for i, c in enumerate(self.name)
        )

    @property
    def wire_fields(self) -> list[Field]:
        """The fields that travel, in order."""
        return [f for f in self.fields if f.wire]

    @property
    def host_fields(self) -> list[Field]:
        """The fields that users see, in order."""
        return [f for f in self.fields if f.host]

    def wire_size(self) -> int:
        """Bytes on the wire, without the report's id."""
        return sum(wire_size(f) for f in self.wire_fields)


def wire_size(field: Field) -> int:
    """Bytes that a field takes."""
    if isinstance(field.of, Structure):
        one = field.of.wire_size()
    else:
        one = 1 if isinstance(field.of, Enumeration) else SCALARS[field.wire][1]
    return one * int(value_of(field.count))


# --- kinds of fields -----------------------------------------------------------------------------


def number(
    name: str,
    unit: str,
    low: Bound,
    high: Bound,
    doc: str = "",
    *,
    default: Bound | None = 0.0,
    required: bool = False,
) -> Field:
    """Make a quantity in SI units. A `required` one has no default: users must give it."""
    return Field(
        name, "number", doc, unit, low, high, None if required else default,
        wire="f32", host="double",
    )  # fmt: skip


def whole(
    name: str,
    wire: str,
    low: Bound,
    high: Bound,
    doc: str = "",
    *,
    default: int | None = 0,
    unit: str = "",
) -> Field:
    """Make a whole number. Its type in C++ is int unless it needs more."""
    host = "std::uint32_t" if wire == "u32" else "int"
    return Field(name, "whole", doc, unit, low, high, default, wire=wire, host=host)


def any_whole(name: str, wire: str, doc: str = "", *, default: int = 0) -> Field:
    """Make a whole number without a range: every value has a meaning."""
    return Field(name, "whole", doc, default=default, wire=wire, host=SCALARS[wire][0])


def angle(name: str, doc: str, bound: Constant) -> Field:
    """Make an angle that may lie many turns away: it travels as fixed-point turns."""
    assert name.endswith("_rad")
    return Field(
        name, "angle", doc, "rad", -bound, bound, 0.0,
        wire="i64", host="double",
        wire_name=name.removesuffix("_rad") + "_turns_q32", wire_unit="2^-32 turn",
    )  # fmt: skip


def switch(name: str, toggle: Enumeration, doc: str = "", *, default: bool = False) -> Field:
    """Make a yes or no."""
    return Field(name, "switch", doc, default=default, wire="u8", host="bool", of=toggle)


def choice(name: str, of: Enumeration, doc: str = "", *, default: str = "") -> Field:
    """Make one value of an enumeration; by default its first."""
    return Field(
        name, "choice", doc, default=default or of.values[0].name, wire="u8", host=of.name, of=of
    )


def group(name: str, of: Structure, doc: str = "", *, count: int | Constant = 1) -> Field:
    """Make a structure inside another, or an array of them."""
    return Field(name, "group", doc, wire=of.name, host=of.name, of=of, count=count)


def raw(
    name: str,
    wire: str,
    doc: str = "",
    unit: str = "",
    low: Bound | None = None,
    high: Bound | None = None,
    *,
    default: Bound | str = 0,
    count: int | Constant = 1,
) -> Field:
    """Make a number that is only on the wire, as it stands there."""
    return Field(name, "whole", doc, unit, low, high, default, wire=wire, count=count)


def on_wire(field: Field) -> Field:
    """Hide a field from users."""
    return replace(field, host="")


def required(field: Field) -> Field:
    """Have users give it."""
    return replace(field, default=None)


def surface(field: Field) -> Field:
    """Have something solid begin at an angle."""
    return replace(field, surface=True)


def not_below(other: str, field: Field) -> Field:
    """Have a field be at least another one."""
    return replace(field, not_below=other)


def for_hosts(field: Field) -> Field:
    """Keep a field from travelling by itself."""
    return replace(field, wire="")


# --- kinds of fields that never travel -----------------------------------------------------------


def optional_number(name: str, unit: str, doc: str) -> Field:
    """Make a quantity that may be left out."""
    return Field(name, "optional", doc, unit, host="std::optional<double>")


def optional_group(name: str, of: Structure, doc: str = "") -> Field:
    """Make a part that may be left out."""
    return Field(name, "optional", doc, host=f"std::optional<{of.name}>", of=of)


def numbers(name: str, unit: str, doc: str) -> Field:
    """Make several numbers of one quantity."""
    return Field(name, "numbers", doc, unit, host="std::vector<double>")


def profile(name: str, unit: str, doc: str, most: float, *, default: str = "") -> Field:
    """Make a piecewise-linear function of time, with values from -most to most."""
    return Field(name, "profile", doc, unit, -most, most, default=default or None, host="Profile")


def function(name: str, host: str, doc: str) -> Field:
    """Make a function that the user brings."""
    return Field(name, "function", doc, host=host)


def hand(name: str, doc: str) -> Field:
    """Make a place for one of the emulated knob's hands; nobody by default."""
    return Field(name, "hand", doc, host="Hand", default="NoHand{}")


def binary(name: str, doc: str) -> Field:
    """Make bytes."""
    return Field(name, "bytes", doc, host="std::vector<std::uint8_t>")


def text(name: str, doc: str = "") -> Field:
    """Make a string."""
    return Field(name, "text", doc, host="std::string", default="")


def texts(name: str, doc: str = "") -> Field:
    """Make several strings."""
    return Field(name, "texts", doc, host="std::vector<std::string>")


def told(name: str, host: str, doc: str = "", unit: str = "", *, default: Number = 0) -> Field:
    """Make a number that the library tells."""
    kind: Kind = "number" if host in ("double", "float") else "whole"
    return Field(name, kind, doc, unit, default=default, host=host)


@dataclass(frozen=True)
class ReportUnit:
    """A unit that a report counts in. Users get SI units."""

    ending: str = ""
    """End of the name in the report."""
    told_ending: str = ""
    """End of the name that users see."""
    in_si: str = ""
    """In C++, of `counted`, a `Number`; `device` has identified itself."""


REPORT_UNITS = {
    "ns": ReportUnit("_ns", "_s", "Number{1e-9} * counted"),
    "ms": ReportUnit("_ms", "_s", "Number{1e-3} * counted"),
    "torque_step_nm": ReportUnit("", "_nm", "counted * Number{device.torque_step_nm}"),
    "speed_step_rad_s": ReportUnit("", "_rad_s", "counted * Number{device.speed_step_rad_s}"),
    "2^-14 of the supply": ReportUnit(in_si="counted * Number{0x1p-14}"),
    "1/32767": ReportUnit(in_si="counted / Number{32767}"),
}


def told_of(report: Structure, *names: str, host: str = "double") -> tuple[Field, ...]:
    """Tell users fields of a report in its words; what it counts in units of its own as `host`."""
    return tuple(_told(field, host) for field in named(report.fields, *names))


def named(fields: Iterable[Field], *names: str) -> tuple[Field, ...]:
    """Choose fields by their names, in the order of these."""
    by_name = {field.name: field for field in fields}
    return tuple(by_name[name] for name in names)


def _told(field: Field, host: str) -> Field:
    if isinstance(field.of, Enumeration):
        return for_hosts(replace(field, host="bool" if field.kind == "switch" else field.of.name))
    if unit := REPORT_UNITS.get(field.unit):
        return told(field.name.removesuffix(unit.ending) + unit.told_ending, host, field.doc)
    if field.wire == "f32":
        return told(field.name, "double", field.doc)
    return told(
        field.name, "int" if SCALARS[field.wire][1] < 4 else SCALARS[field.wire][0], field.doc
    )
