"""The declarations of the SDK's headers, read as text: enough of C++ for these headers."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

INCLUDE = Path(__file__).parents[2] / "sdk" / "include" / "torsio"
PLANT = INCLUDE.parents[2] / "emulator" / "include" / "torsio"


@dataclass
class Scope:
    """A namespace, class or enumeration."""

    kind: str
    is_public: bool = True
    members: set[str] = field(default_factory=set)
    """Names of data members, constants and enumerators."""
    functions: dict[str, list[tuple[str, ...]]] = field(default_factory=dict)
    """Names of the parameters of each overload."""
    scopes: dict[str, Scope] = field(default_factory=dict)


_IGNORED = re.compile(
    r"\b(?:TORSIO_EXPORT|virtual)\b|//[^\n]*|/\*.*?\*/|^[ \t]*#[^\n]*", re.S | re.M
)
_SCOPE = re.compile(r"(namespace|class|struct|enum class)\s+([\w:]+)[^()=]*$", re.S)
_NO_MEMBER = re.compile(
    r"^(friend|template|static_assert)\b|^using [\w:]+$|\boperator\b|^(class|struct) \w+$|= delete$"
)
_ACCESS = re.compile(r"^\s*(public|private|protected)\s*:(?!:)")


def _after_braces(text: str, at: int) -> int:
    """Give the place behind the brace that closes the one at `at`."""
    depth = 0
    for place in range(at, len(text)):
        depth += {"{": 1, "}": -1}.get(text[place], 0)
        if depth == 0:
            return place + 1
    raise AssertionError("a brace is not closed")


def _without_arguments(text: str) -> str:
    """Take the template arguments out, whose brackets and commas would be in the way."""
    while (shorter := re.sub(r"<[^<>]*>", "", text)) != text:
        text = shorter
    return text


def _last_name(declaration: str) -> str:
    """Give what is declared; empty if it has no name, as a parameter may."""
    words = re.sub(r"\[\w*\]$", "", declaration.split("=")[0].split("{")[0].strip())
    match = re.search(r"(\w+)$", words)
    return match[1] if match else ""


def _take(declaration: str, scope: Scope, name: str) -> None:
    """Enter what one declaration declares in the scope of this name."""
    while access := _ACCESS.match(declaration):
        scope.is_public = access[1] == "public"
        declaration = declaration[access.end() :]
    declaration = _without_arguments(re.sub(r"\[\[\w+\]\]", "", declaration)).strip()
    if not declaration or not scope.is_public or _NO_MEMBER.search(declaration):
        return
    if using := re.match(r"using (\w+) =", declaration):
        scope.members.add(using[1])
    elif function := re.match(r"[^=({]*?(~?\w+)\s*\(([^()]*)\)", declaration):
        if function[1].strip("~") != name:
            parameters = tuple(_last_name(piece) for piece in function[2].split(",") if piece)
            scope.functions.setdefault(function[1], []).append(parameters)
    else:
        scope.members.add(_last_name(declaration))


def _read(text: str, scope: Scope, name: str = "") -> None:
    """Enter everything that stands between a scope's braces."""
    declaration, brackets, at = "", 0, 0
    while at < len(text):
        character = text[at]
        if character == "{":
            opened = _SCOPE.search(declaration) if brackets == 0 else None
            end = _after_braces(text, at)
            if opened and opened[1] == "enum class":
                if scope.is_public:
                    names = {_last_name(piece) for piece in text[at + 1 : end - 1].split(",")}
                    scope.scopes[opened[2]] = Scope("enum", members=names - {""})
                declaration = ""
            elif opened:
                while access := _ACCESS.match(declaration):
                    scope.is_public = access[1] == "public"
                    declaration = declaration[access.end() :]
                inner = scope.scopes.get(opened[2]) or Scope(opened[1])
                inner.is_public = opened[1] != "class"
                _read(text[at + 1 : end - 1], inner, opened[2])
                if scope.is_public:
                    scope.scopes[opened[2]] = inner
                declaration = ""
            elif brackets == 0 and re.search(r"\)[^()=]*$", declaration):
                _take(declaration, scope, name)  # a function with its body
                declaration = ""
            else:
                declaration += "{}"
            at = end
            continue
        brackets += (character == "(") - (character == ")")
        if character == ";" and brackets == 0:
            _take(declaration, scope, name)
            declaration = ""
        else:
            declaration += character
        at += 1


def read_sdk() -> Scope:
    """Read all public headers; give the namespace torsio."""
    everything = Scope("namespace")
    for header in sorted([*INCLUDE.glob("*.hpp"), *PLANT.glob("*.hpp")]):
        if "field" in header.name:  # lists of the others
            continue
        _read(_IGNORED.sub("", header.read_text(encoding="utf-8")), everything)
    return everything.scopes["torsio"]
