"""Prints the Python of the field lists: frozen data classes with documentation and types."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

from tools.definition.cpp import host_note
from tools.definition.model import Bits, Constant, Enumeration, Field, Structure, value_of

WIDTH = 100


def module(doc: str, lists: str, body: str, exported: Iterable[str]) -> str:
    """Put together one module."""
    names = "".join(f'    "{name}",\n' for name in sorted(exported, key=_rank))
    return (
        f'"""{doc}\n"""\n\n'
        f"# Printed from the field lists in {lists} by `./dev generate`;\n"
        "# change those instead.\n"
        f"\n{body.format(all=f'__all__ = [{chr(10)}{names}]')}"
    )


def _rank(name: str) -> tuple[int, str]:
    """Sort as linters do: constants, then classes, then the rest."""
    return (0 if name.isupper() else 1 if name[0].isupper() else 2, name)


def literal_type(of: Enumeration) -> str:
    """Write the type of an enumeration's names."""
    return "Literal[" + ", ".join(f'"{value.name}"' for value in of.values) + "]"


def _type(field: Field) -> str:
    if isinstance(field.of, Enumeration) and field.kind == "choice":
        return literal_type(field.of)
    if field.kind == "optional":
        return f"{field.of.name if field.of else 'float'} | None"
    if isinstance(field.of, Structure):
        return field.of.name
    return {
        "number": "float",
        "angle": "float",
        "whole": "int",
        "switch": "bool",
        "numbers": "Iterable[float]",
        "profile": "Profile",
        "function": field.host,
        "hand": field.host,
        "bytes": "bytes",
        "text": "str",
        "texts": "tuple[str, ...]",
    }[field.kind]


def _default(field: Field, told: bool) -> str:
    if told:
        return ""
    if field.kind == "optional":
        return " = None"
    if field.kind in ("profile", "numbers", "function", "bytes"):
        return ""
    if field.kind == "hand":
        return " = NoHand()"
    if isinstance(field.of, Structure):
        return f" = {field.of.name}()"
    default = field.default
    if default is None:
        return ""
    if isinstance(default, Constant):
        return f" = {default.name.upper()}"
    if isinstance(default, str):
        return f' = "{default}"'
    if field.kind in ("number", "angle"):
        return f" = {float(default)!r}"
    return f" = {default!r}"


# By the kind of a field: what its class asks of a value, and what it asks of a plain value too.
_ASKED = {
    "hand": 'checks.kind("{name}", {own}, {of}, "a torsio.{of}")\n',
    "group": 'checks.kind("{name}", {own}, {of}, "a torsio.{of}")\n',
    "optional": 'if {own} is not None:\n    checks.kind("{name}", {own}, {of}, "{of} or None")\n',
    "function": 'checks.function("{name}", {own})\n',
    "numbers": 'object.__setattr__(self, "{name}", checks.numbers("{name}", {own}))\n',
    "profile": 'object.__setattr__(self, "{name}", checks.knots("{name}", {own}))\n',
}
_ASKED_OF_PLAIN = {
    "number": 'checks.number("{name}", {own})\n',
    "switch": 'checks.flag("{name}", {own})\n',
    "text": 'checks.text("{name}", {own})\n',
    "whole": 'checks.whole("{name}", {own}, {low}, {high})\n',
}


def _checks(field: Field, *, all_kinds: bool = False) -> str:
    """Write what the class asks of a value when it is made; ranges are asked when it is used."""
    asked = _ASKED | (_ASKED_OF_PLAIN if all_kinds else {})
    low, high = (0, (1 << 64) - 1) if field.low is None else (field.low, field.high)
    of = field.host if field.kind == "hand" else getattr(field.of, "name", "")
    if field.kind == "optional" and not of:
        return ""
    return asked.get(field.kind, "").format(
        name=field.name, own=f"self.{field.name}", of=of, low=low, high=high
    )


def _docstring(of: Structure) -> str:
    lines = textwrap.wrap(of.doc, WIDTH - 7)
    text = of.doc if len(lines) == 1 else _first_sentence_and_rest(of.doc)
    if of.notes:
        text += "\n\n" + textwrap.fill(of.notes, WIDTH - 4)
    told = [(f.name, _note(f)) for f in of.host_fields if _note(f)]
    if told:
        text += "\n\nAttributes\n----------\n"
        for name, note in told:
            text += f"{name}\n{textwrap.indent(textwrap.fill(note, WIDTH - 8), '    ')}\n"
        text = text.rstrip()
    ends = "\n" if "\n" in text else ""
    return textwrap.indent(f'"""{text}{ends}"""', "    ") + "\n"


def _first_sentence_and_rest(doc: str) -> str:
    """Break a long sentence where its first half says enough by itself."""
    for mark in (". ", ": ", "; "):
        head, found, rest = doc.partition(mark)
        if found and len(head) < WIDTH - 9:
            return f"{head}.\n\n" + textwrap.fill(rest[0].upper() + rest[1:], WIDTH - 4)
    head, _, rest = doc.partition(", ")
    return f"{head}.\n\n" + textwrap.fill(rest[0].upper() + rest[1:], WIDTH - 4)


def _note(field: Field) -> str:
    note = host_note(field).replace("true: ", "True: ").replace("false: ", "False: ")
    return note[:1].upper() + note[1:] + ("." if note and note[-1] not in ".)" else "")


def _field_lines(of: Structure, told: bool) -> list[str]:
    required = [f for f in of.host_fields if _default(f, told) == ""]
    others = [f for f in of.host_fields if _default(f, told) != ""]
    lines = [f"{f.name}: {_type(f)}{_default(f, told)}" for f in (*required, *others)]
    if lines and not told:
        # A single function needs no name at the call; numbers do.
        lines.insert(sum(f.host == "HandFunction" for f in required), "_: KW_ONLY")
    return lines


def data_class(of: Structure, *, told: bool = False) -> str:
    """Write a data class. With `told` only the library makes it, so it has no defaults."""
    # The base classes that are named derive from this one too.
    base = of.base or ("" if told else "checks.ByName")
    short = "" if told else ", repr=False"  # it is of checks.ByName
    out = f"\n\n@dataclass(frozen=True{short})\nclass {of.name}{f'({base})' if base else ''}:\n{_docstring(of)}\n"
    out += "".join(f"    {line}\n" for line in _field_lines(of, told))
    checks = "".join(_checks(field, all_kinds=of.checked) for field in of.host_fields)
    if checks and not told:
        out += (
            "\n    def __post_init__(self) -> None:\n"
            '        """Ask for the right kinds, and keep sequences so that they compare by value."""\n'
            + textwrap.indent(checks, "        ")
        )
    return out


def flags(of: Bits) -> str:
    """Write the bits as constants."""
    mask = (1 << of.first) - 1
    out = f"\nFLAG_STATE_MASK: Final = 0x{mask:02X}\n"
    out += '"""The two lowest bits: 0 disarmed, 1 armed, 2 fault."""\n'
    for place, bit in enumerate(of.bits, of.first):
        out += f'FLAG_{bit.name.upper()}: Final = 1 << {place}\n"""{bit.doc.capitalize()}."""\n'
    return out


_FORMATS = {
    "std::uint64_t": "<u8",
    "std::int64_t": "<i8",
    "std::uint32_t": "<u4",
    "std::uint8_t": "u1",
    "bool": "?",
    "double": "<f8",
    "float": "<f4",
}


def record_type(name: str, of: Structure) -> str:
    """Write the type of a structured array's rows."""
    doc = textwrap.fill(f'"""{of.doc}"""', WIDTH)
    out = f"\n{name}: Final[np.dtype[Any]] = np.dtype(\n    [\n"
    for field in of.host_fields:
        note = f"  # {field.doc}" if field.doc else ""
        out += f'        ("{field.name}", "{_FORMATS[field.host]}"),{note}\n'
    return out + f"    ],\n    align=True,\n)\n{doc}\n"


def number(of: Constant, doc: str) -> str:
    """Write a named number."""
    return f'\n{of.name.upper()} = {value_of(of)!r}\n"""{doc}"""\n'
