"""Changes of product lines that nobody has chosen, in C++, Python and TypeScript."""

from __future__ import annotations

import hashlib
import itertools
import random
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

TREE = Path(__file__).parent.parent.parent
# Code of knobs, user's programs and browsers that one machine can build and try. Another test
# compares printed files as a whole.
PRODUCT = (
    *("firmware/core/**/*.[ch]pp", "firmware/device/**/*.[ch]pp", "firmware/protocol/*.[ch]pp"),
    *("emulator/**/*.[ch]pp", "sdk/**/*.[ch]pp", "bindings/src/*.[ch]pp"),
    *("bindings/python/torsio/**/*.py", "studio/src/*.ts"),
)
_PRINTED = "Printed from the field lists"
_CPP_ASIDE = r'"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'|//[^\n]*|/\*[\s\S]*?\*/'
# Strings and comments.
_ASIDE = {
    ".cpp": _CPP_ASIDE,
    ".hpp": _CPP_ASIDE,
    ".ts": _CPP_ASIDE + r"|`(?:\\.|[^`\\])*`",
    ".py": r'"""[\s\S]*?"""|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|#[^\n]*',
}
_TWINS = (
    *((" < ", " <= "), (" > ", " >= "), (" == ", " != "), (" + ", " - "), (" * ", " / ")),
    *((" && ", " || "), (" and ", " or "), (" += ", " -= "), (" === ", " !== ")),
    *((" is None", " is not None"), ("min(", "max("), ("true", "false"), ("True", "False")),
    *((" << ", " >> "), (" & ", " | ")),
)
# Each pattern, and what stands there instead.
_WORDS = {**dict(_TWINS), **{b: a for a, b in _TWINS}}
_WORD = re.compile(
    "|".join(
        re.escape(word) if word[0] == " " else rf"(?<![\w]){re.escape(word)}(?![\w])"
        for word in sorted(_WORDS, key=len, reverse=True)
    )
)
_NUMBER = re.compile(r"(?<![\w.'])(\d+)(\.\d+)?(?![\d.'a-zA-EG-Z_])")
_NOT = re.compile(r"!(?=[\w(])|\bnot (?!in\b)")
_CONDITION = {
    ".py": re.compile(r"^\s*(?:el)?if ()(.+)():$"),
    "": re.compile(r"\bif (\()([^;]+)(\)) (?:\{$|return|continue|break|throw|[a-z_.]+[ (])"),
}
_STATEMENT = {
    ".py": re.compile(
        r"^\s+([\w.\[\]]+(?: [-+*/|&]?= .+|\(.*\))|(?:raise|return|continue|break)\b.*)$"
    ),
    "": re.compile(r"^\s+([\w.#\->\[\]():*]+(?: [-+*/|&]?= .*|\(.*\)|\+\+)?;)$"),
}


# C++ that only the compiler computes, and words that may stand before a statement.
_COMPILED = re.compile(r"\b(?:constexpr|consteval|static_assert|enum|template|requires|using)\b")
_BEFORE_STATEMENT = re.compile(r"(?:[;{})]|\belse)\s*\Z")


@dataclass(frozen=True)
class Change:
    """One line of the product that says something else."""

    file: str
    number: int
    before: str
    after: str
    twins: int = 0  # equal lines above it

    @property
    def key(self) -> str:
        """The key of its result: it stays where other lines come or go."""
        text = f"{self.file}\n{self.before.strip()}\n{self.after.strip()}"
        text += f"\n{self.twins}" if self.twins else ""
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def __str__(self) -> str:
        return f"{self.file}:{self.number}: {self.before.strip()}  ->  {self.after.strip()}"


def masked(text: str, suffix: str) -> str:
    """Return a source of the same length, with blanks for its strings and comments."""
    return re.sub(_ASIDE[suffix], lambda found: re.sub(r"\S", " ", found[0]), text)


def _is_balanced(text: str) -> bool:
    return all(text.count(pair[0]) == text.count(pair[1]) for pair in ("()", "{}", "[]"))


def changes_of(line: str, code: str, suffix: str) -> Iterator[str]:
    """Yield what a line may become, given also with blanks for what is no code."""
    for found in _WORD.finditer(code):
        if suffix == ".py" and found[0] in (" & ", " | "):
            continue  # mostly of types
        yield line[: found.start()] + _WORDS[found[0]] + line[found.end() :]
    for found in _NUMBER.finditer(code):
        new = f"{2 * float(found[0]) or 1.0}" if found[2] else f"{int(found[1]) + 1}"
        yield line[: found.start()] + new + line[found.end() :]
    for found in _NOT.finditer(code):
        yield line[: found.start()] + line[found.end() :]
    kind = suffix if suffix == ".py" else ""
    condition = _CONDITION[kind].search(code)
    if condition and _is_balanced(condition[2]):
        begin, end = condition.span(2)
        negated = f"not ({line[begin:end]})" if kind else f"!({line[begin:end]})"
        yield line[:begin] + negated + line[end:]
    statement = _STATEMENT[kind].match(code.rstrip())
    if statement and _is_balanced(code):
        yield line[: statement.start(1)] + ("pass" if kind else ";")


def _end_of_expression(code: str, at: int, step: int) -> int:
    """Go from a place in C++ to where its expression begins (step -1) or ends (1)."""
    opening, closing = ("([{", ")]}") if step > 0 else (")]}", "([{")
    depth = 0
    while 0 <= at < len(code):
        here, around = code[at], code[max(at - 1, 0) : at + 2]
        ends = here in closing or (here in ",;?:" and "::" not in around)
        if step < 0:
            ends |= here == "}" and code[at + 1 : at + 2].isspace()  # end of a block
            ends |= here == "=" and "==" not in around and around[0] not in "<>!"
            ends |= re.search(r"\breturn\s\Z", code[max(at - 7, 0) : at + 1]) is not None
        if ends and depth == 0:
            break
        depth += (here in opening) - (here in closing)
        at += step
    return at


def _shared(one: str, other: str) -> int:
    """Return how many letters two texts begin with alike."""
    pairs = zip(one, other, strict=False)
    return sum(1 for _ in itertools.takewhile(lambda pair: pair[0] == pair[1], pairs))


def choice_of(change: Change, text: str) -> tuple[int, int, str] | None:
    """Return which piece of a C++ source may be a choice at run time, and what it becomes.

    None if only the compiler computes it, or if it is no expression and no statement.
    """
    before, after = change.before, change.after
    lines = text.split("\n")
    begin = sum(len(line) + 1 for line in lines[: change.number - 1])
    code = masked(text, ".cpp")
    start = max(code.rfind(mark, 0, begin + len(before) - len(before.lstrip())) for mark in ";{}")
    if _COMPILED.search(code[start + 1 : begin + len(before)]) or before.lstrip()[:5] == "case ":
        return None
    line = code[begin : begin + len(before)].rstrip()
    if _STATEMENT[""].match(line):
        first = begin + len(line) - len(line.lstrip())
        is_one = _BEFORE_STATEMENT.search(code[:first]) and _is_balanced(line)
        new = after[: len(masked(after, ".cpp").rstrip())].strip()
        return (first, begin + len(line), new) if is_one else None
    shared = _shared(before, after)
    behind = _shared(before[shared:][::-1], after[shared:][::-1])
    left = _end_of_expression(code, begin + shared - 1, -1) + 1
    right = _end_of_expression(code, begin + len(before) - behind, 1)
    # A bracket that closes a negation may look like the one behind it.
    while behind > 0 and not _is_balanced(code[left:right]):
        behind -= 1
        right = _end_of_expression(code, begin + len(before) - behind, 1)
    piece = text[left:right].lstrip()
    left, piece = right - len(piece), piece.rstrip()
    right = left + len(piece)
    if left > begin + shared or "//" in piece or not _is_balanced(code[left:right]):
        return None
    old_end = begin + len(before) - behind
    changed = after[shared : len(after) - behind]
    return left, right, text[left : begin + shared] + changed + text[old_end:right]


def product_lines(tree: Path) -> list[tuple[str, int]]:
    """Return the lines that have code, by file and number from 1."""
    found = []
    for path in sorted({path for pattern in PRODUCT for path in tree.glob(pattern)}):
        text = path.read_text(encoding="utf-8")
        if _PRINTED in text[:1000]:
            continue
        for number, code in enumerate(masked(text, path.suffix).splitlines(), 1):
            if code.strip() and not re.match(r"\s*(#|import |from |using |namespace )", code):
                found.append((str(path.relative_to(tree)), number))
    return found


def drawn(seed: int, tree: Path = TREE) -> Iterator[Change]:
    """Yield changes without end, the same ones for the same seed and sources."""
    source = random.Random(seed)
    lines = product_lines(tree)
    while True:
        file, number = source.choice(lines)
        text = (tree / file).read_text(encoding="utf-8")
        suffix = Path(file).suffix
        *above, line = text.splitlines()[:number]
        code = masked(text, suffix).splitlines()[number - 1]
        if options := list(changes_of(line, code, suffix)):
            twins = sum(other.strip() == line.strip() for other in above)
            yield Change(file, number, line, source.choice(options), twins)
