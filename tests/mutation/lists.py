"""The lists of mutants, and sources in which each mutant is a choice at run time."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).parent
_BEFORE_STATEMENT = re.compile(r"(?:[;:{})]|\belse|\bdo)\s*\Z|\A\s*\Z")
_COMMENT = re.compile(r"//[^\n]*|/\*[\s\S]*?\*/")


class BadList(Exception):
    """A list of mutants does not fit the sources; says which line, and what to do."""


@dataclass(frozen=True)
class Mutant:
    """One change of one place.

    Attributes
    ----------
    number
        By which it is switched on; from 1, in the order of the lists.
    file
        Of the source, from the top of the tree.
    original, replacement
        What stands there, and what would stand there instead.
    where
        Line of the list, for messages.
    equivalent
        Why no test can tell it from the original; empty if one must.
    """

    number: int
    file: str
    original: str
    replacement: str
    where: str
    equivalent: str = ""

    @property
    def key(self) -> str:
        """The key of its result: it stays when mutants come or go."""
        text = f"{self.file}\n{squeezed(self.original)}\n{squeezed(self.replacement)}"
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def __str__(self) -> str:
        new = squeezed(self.replacement) or "(nothing)"
        return f"{self.number}: {self.file}: {squeezed(self.original)}  ->  {new}"


@dataclass
class Replacement:
    """The new text, the list's note on it, and its line in the list."""

    text: str
    where: str
    equivalent: str = ""


@dataclass
class Place:
    """A piece of a source and all its mutants."""

    file: str
    context: str
    where: str
    replacements: list[Replacement] = field(default_factory=list)


def squeezed(text: str) -> str:
    """Return a text with one blank wherever it has some."""
    return " ".join(text.split())


def read_list(path: Path) -> list[Place]:
    """Read one list.

    ``file NAME``, then ``-`` lines with what stands there, ``+`` lines with one mutant each, and
    behind a mutant ``=`` why it is equivalent.
    """
    places: list[Place] = []
    file = ""
    last = ""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        where = f"{path.name}:{number}"
        kind, text = line[:1], line[2:]
        if line.startswith("file "):
            file = line.removeprefix("file ").strip()
        elif kind == "-":
            if last == "-":
                places[-1].context += f"\n{text}"
            else:
                places.append(Place(file, text, where))
        elif kind == "+" and places:
            places[-1].replacements.append(Replacement(text, where))
        elif kind == "=" and places and places[-1].replacements:
            mutant = places[-1].replacements[-1]
            mutant.equivalent = f"{mutant.equivalent} {text}".strip()
        elif line and kind != "#":
            raise BadList(f"{where}: begin a line with 'file ', '- ', '+ ', '= ' or '# '")
        last = kind
    for place in places:
        _check(place)
    return places


def _check(place: Place) -> None:
    for text in (_marked(place)[1], *(one.text for one in place.replacements)):
        if any(text.count(pair[0]) != text.count(pair[1]) for pair in ("()", "{}", "[]")):
            raise BadList(f"{place.where}: '{text}' opens a bracket that it does not close")
    if not place.file:
        raise BadList(f"{place.where}: say which file first, in a line 'file NAME'")
    if not place.replacements:
        raise BadList(f"{place.where}: a place without a mutant; add a line that begins with +")


def read_lists(folder: Path = HERE / "mutants") -> list[Place]:
    """Read all lists, in the order of their names."""
    return [place for path in sorted(folder.glob("*.txt")) for place in read_list(path)]


def mutants_of(places: Iterable[Place]) -> list[Mutant]:
    """Number the mutants of places."""
    found: list[Mutant] = []
    for place in places:
        found += [
            Mutant(
                len(found) + 1 + n,
                place.file,
                place.context,
                one.text,
                one.where,
                one.equivalent,
            )
            for n, one in enumerate(place.replacements)
        ]
    keys = [mutant.key for mutant in found]
    for mutant in found:
        if keys.count(mutant.key) > 1:
            raise BadList(f"{mutant.where}: this mutant is there twice; leave one")
    return found


def _marked(place: Place) -> tuple[str, str, str]:
    """Return what stands before, in and behind the marks ``@{`` and ``}@``."""
    before, mark, rest = place.context.partition("@{")
    if not mark:
        return "", place.context, ""
    inside, _, behind = rest.partition("}@")
    return before, inside, behind


def _pattern(text: str) -> str:
    return r"\s*".join(re.escape(word) for word in text.split())


def _switched(original: str, numbered: Sequence[tuple[int, str]]) -> str:
    """Return C++ that does what the original does, or what the mutant does that is switched on."""
    if all(text.rstrip().endswith((";", "}")) for text in (original, *(r for _, r in numbered))):
        code = original
        for number, text in reversed(numbered):
            code = f"if (torsio_mutant_is({number})) {{ {text} }} else {{ {code} }}"
        return code
    code = f"({original})"
    for number, text in reversed(numbered):
        if text == f"!({original})" or original == f"!{text}":
            # A pointer and a truth have no common type.
            code = f"(torsio_mutant_is({number}) != static_cast<bool>{code})"
        else:
            code = f"(torsio_mutant_is({number}) ? ({text}) : {code})"
    return code


def with_choices(text: str, cuts: Mapping[tuple[int, int], Sequence[tuple[int, str]]]) -> str:
    """Return a source in which pieces, from where to where, have these numbered mutants."""
    for (begin, end), numbered in sorted(cuts.items(), reverse=True):
        text = text[:begin] + _switched(text[begin:end], numbered) + text[end:]
    return text


def mutate_source(text: str, places: Sequence[tuple[Place, Sequence[int]]]) -> str:
    """Return a source with the mutants of these places in it.

    Raises
    ------
    BadList
        If a place is not there, or there twice, or two of them overlap.
    """
    cuts: dict[tuple[int, int], list[tuple[int, str]]] = {}
    for place, numbers in places:
        before, inside, behind = _marked(place)
        pattern = rf"{_pattern(before)}(\s*){_pattern(inside)}(\s*){_pattern(behind)}"
        found = list(re.finditer(pattern, text))
        if len(found) != 1:
            problem = "is not in" if not found else f"stands {len(found)} times in"
            raise BadList(
                f"{place.where}: '{squeezed(place.context)}' {problem} {place.file}; "
                "write what stands there now, with as much before and behind as makes it the only "
                "one and @{...}@ round what is mutated"
            )
        begin, end = found[0].end(1), found[0].start(2)
        if any(begin < other_end and other < end for other, other_end in cuts):
            raise BadList(f"{place.where}: overlaps another place; put its + lines there")
        replacements = [one.text for one in place.replacements]
        is_statement = all(one.rstrip().endswith((";", "}")) for one in (inside, *replacements))
        if is_statement and not _BEFORE_STATEMENT.search(_COMMENT.sub("", text[:begin])):
            raise BadList(f"{place.where}: no whole statement; write the expression in it alone")
        if any(re.search(r"[-+*/&|=<,]\s*$", one) for one in (inside, *replacements)):
            raise BadList(f"{place.where}: no whole expression: it ends with an operator")
        cuts[begin, end] = list(zip(numbers, replacements, strict=True))
    return with_choices(text, cuts)


def put(path: Path, content: bytes) -> None:
    """Write a file unless it says so already, so that nothing is compiled twice."""
    if path.exists() and path.read_bytes() == content:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
