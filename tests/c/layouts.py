"""Reads torsio.h as a second reader: its structures as ctypes has them, and its functions.

It knows C's rules of layout from ctypes and nothing of the field lists, the printer or the library.
``python -m tests.c.layouts > tests/c/agreed.txt`` keeps a checksum of the agreed header.
"""

from __future__ import annotations

import ctypes
import difflib
import hashlib
import re
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

TREE = Path(__file__).parents[2]
HEADERS = "sdk/c/include"
_SCALARS: dict[str, type[Any]] = {
    "bool": ctypes.c_bool,
    "double": ctypes.c_double,
    "float": ctypes.c_float,
    "int32_t": ctypes.c_int32,
    "int64_t": ctypes.c_int64,
    "size_t": ctypes.c_size_t,
    "uint8_t": ctypes.c_uint8,
    "uint16_t": ctypes.c_uint16,
    "uint32_t": ctypes.c_uint32,
    "uint64_t": ctypes.c_uint64,
}
_STRUCT = re.compile(r"typedef struct (\w+) \{(.*?)\n\} \1;", re.S)
_MEMBER = re.compile(r"(const )?(\w+)\s*(\*?)\s*(\w+)(?:\[(\w+)\])?$")
_FUNCTION = re.compile(r"TORSIO_API\s+([^;]+?)\s*\*?\s*(torsio_\w+)\(([^;]*)\);")


@dataclass(frozen=True)
class Function:
    """A function as it is declared."""

    name: str
    result: str
    parameters: tuple[str, ...]


@dataclass(frozen=True)
class Header:
    """Everything that a caller needs."""

    structures: dict[str, type[ctypes.Structure]]
    functions: dict[str, Function]
    numbers: dict[str, int]


def _structure(name: str, body: str, known: dict[str, Any]) -> type[ctypes.Structure]:
    fields: list[tuple[str, Any]] = []
    for line in filter(None, (part.strip() for part in body.split(";"))):
        match = _MEMBER.fullmatch(" ".join(line.split()))
        assert match, line
        _, kind, pointer, member, length = match.groups()
        if kind == "char" and not pointer:
            assert length == "TORSIO_TEXT_BYTES"
            fields.append((member, ctypes.c_char * 256))
        elif pointer:
            fields.append((member, ctypes.c_char_p if kind == "char" else ctypes.c_void_p))
        else:
            fields.append((member, known[kind]))
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def _now(name: str) -> str:
    return (TREE / name).read_text(encoding="utf-8")


def whole(read_file: Callable[[str], str] = _now) -> str:
    """Return the headers as one, without comments."""
    parts = ("torsio_base.h", "torsio_types.h", "torsio.h")
    text = "\n".join(read_file(f"{HEADERS}/{name}") for name in parts)
    text = re.sub(r"/\*.*?\*/|//[^\n]*|#include \"[^\n]*", "", text, flags=re.S)
    return re.sub(r"\s*\n(\s*\n)*", "\n", text.lstrip())


def checksum() -> str:
    """Return a checksum of the headers, which comments and line breaks do not change."""
    return hashlib.sha256(" ".join(whole().split()).encode()).hexdigest()


def changes() -> str:
    """Return what is different since the checksum was committed, for git's clones."""

    def git(*words: str) -> str:
        return subprocess.run(
            ["git", *words], cwd=TREE, capture_output=True, text=True, check=False
        ).stdout

    revision = git("log", "-1", "--format=%H", "--", "tests/c/agreed.txt").strip()
    old, new = (
        re.split("(?<=[;,]) ", " ".join(text.split()))
        for text in (whole(lambda name: git("show", f"{revision}:{name}")), whole())
    )
    return "\n".join(difflib.unified_diff(old, new, "agreed", "now", n=1))


def read(text: str) -> Header:
    """Read a header without comments."""
    known: dict[str, Any] = dict(_SCALARS)
    structures: dict[str, type[ctypes.Structure]] = {}
    for name, body in _STRUCT.findall(text):
        known[name] = structures[name] = _structure(name, body, known)
    functions = {}
    for result, name, listed in _FUNCTION.findall(text):
        pointer = "*" if f"*{name}(" in text.replace(" ", "").replace("\n", "") else ""
        whole = f"{' '.join(result.split())}{pointer}".replace("* ", "*")
        parameters = tuple(" ".join(part.split()) for part in listed.split(",") if part != "void")
        functions[name] = Function(name, whole.replace("**", "*"), parameters)
    numbers = {
        name: int(value, 0) if "<<" not in value else int(value[0]) << int(value.split("<<")[1])
        for name, value in re.findall(r"(TORSIO_\w+) =\s+([^,\n]+),", text)
    }
    return Header(structures, functions, numbers)


def hollow(text: str) -> str:
    """Return a C program with the functions of such a header, which do nothing."""
    lines = [text]
    for function in read(text).functions.values():
        listed = ", ".join(function.parameters) or "void"
        body = "" if function.result == "void" else "return 0;"
        lines.append(f"{function.result} {function.name}({listed}) {{ {body} }}")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(checksum())
