"""Changes of product lines that nobody has chosen, in C++, Python and TypeScript."""

from __future__ import annotations

import hashlib
import random
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

TREE = Path(__file__).parent.parent.parent
# What runs on a knob, in a user's program or in his browser, and can be built and tried on one
# machine. What is printed from the field lists is compared as a whole by another test.
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


@dataclass(frozen=True)
class Change:
    """One line of the product that says something else."""

    file: str
    number: int
    before: str
    after: str

    @property
    def key(self) -> str:
        """What it is kept by: it stays where lines above it come or go."""
        text = f"{self.file}\n{self.before.strip()}\n{self.after.strip()}"
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
        line = text.splitlines()[number - 1]
        code = masked(text, suffix).splitlines()[number - 1]
        if options := list(changes_of(line, code, suffix)):
            yield Change(file, number, line, source.choice(options))
