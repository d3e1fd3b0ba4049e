"""How long the documents' sentences are; ``./dev check`` refuses what is too long.

``python -m tools.prose`` prints words, words a sentence and the share of long sentences by page.
Code, printed tables and licences are no words; sentences are counted in the text alone, without
headings and tables.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

TREE = Path(__file__).parent.parent
LONG = 30  # words
MAX_MEAN = 15.0
MAX_LONG_SHARE = 0.05
MAX_WORDS = 45_000
PRINTED_PAGE = "docs/reference/protocol.md"
# Printed tables, comments, and the licences of parts by others.
_PRINTED = re.compile(
    r"^<!-- begin: .*?^<!-- end: .*?-->|<!--.*?-->|^## TinyUSB, .*\Z", re.M | re.S
)
# Fences, formulas, pictures, indented code; then tables and headings.
_CODE = re.compile(
    r"^ *(```|~~~).*?^ *\1|\$\$.*?\$\$|!\[[^\]]*\]\([^)]*\)"
    r"|(?<=\n\n) {4}(?! *[-*] ).*?(?=\n\n(?! {4})|\Z)",
    re.M | re.S,
)
_NO_PROSE = re.compile(r"^ *\|.*?$|^#.*?$|^\[[^\]]+\]: .*?$", re.M)
_WORD = re.compile(r"\S*\w\S*")
_LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")
_ONE_WORD = re.compile(r"`[^`]+`|\$[^$]+\$|<[^>\n]+>")
_ITEM = re.compile(r"^ *(?:[-*]|\d+\.) ", re.M)
_END = re.compile(r"(?<=[.!?])[)\"*]*\s+(?=[^a-z\s])|(?<=:)\n+\s*\n|\n\s*\n")


# Words that make a reader go back: a clause as subject, and pronouns for a noun far away.
_FAR = (
    r"\b(?:that|those) of\b|\bof (?:which|whose)\b|\bas the next\b|\bbeside others\b"
    r"|\bthe former\b|\bwhoever\b|\bbut for\b"
)
_RIDDLE = re.compile(rf"^(?:Who|What)\b(?!.*\?)|{_FAR}", re.I)

_COMMENT = re.compile(rf'(?:^ *\*|/\*|//|#|""").*?(?:{_FAR})', re.I)
_DOCSTRING = re.compile(r'^ *"""(.+)', re.M)
_NO_SUBJECT = re.compile(r"(?:Who(?:ever)?|What|Which|Of)\b")


class Measure(NamedTuple):
    """A page's words, words a sentence in the mean, and share of long sentences."""

    words: int
    mean: float
    long_share: float


def _text(markdown: str) -> str:
    """Leave out all but text; code between ticks is one word."""
    return _ONE_WORD.sub("Code", _LINK.sub(r"\1", _CODE.sub("\n\n", _PRINTED.sub("", markdown))))


def sentences(markdown: str) -> list[str]:
    """Split the prose of a page into sentences; the items of a list are apart."""
    parts = _END.split(_ITEM.sub("\n\n", _NO_PROSE.sub("\n\n", _text(markdown))))
    return [" ".join(part.split()) for part in parts if re.search(r"\w", part)]


def measure(markdown: str, printed: bool = False) -> Measure:
    """Measure a page. `printed` leaves out its tables. A page without prose has zeros."""
    lengths = [len(_WORD.findall(sentence)) for sentence in sentences(markdown)]
    words = sum(lengths) if printed else len(_WORD.findall(_text(markdown)))
    count = len(lengths) or 1
    return Measure(words, sum(lengths) / count, sum(n > LONG for n in lengths) / count)


def riddles() -> list[str]:
    """Tell which sentences have to be read twice."""
    found = []
    for file in _files():
        name = str(file.relative_to(TREE))
        for sentence in sentences(file.read_text(encoding="utf-8")):
            if words := _RIDDLE.search(sentence):
                found.append(f"{name}: '{words[0]}' in: {sentence[:80]}")
    return found


def comments() -> list[str]:
    """Tell which comments have to be read twice, and which docstrings hide their subject."""
    listed = ["git", "ls-files", *(f"*.{end}" for end in ("py", "cpp", "hpp", "h", "ts", "mjs"))]
    files = subprocess.run(listed, cwd=TREE, capture_output=True, text=True, check=True).stdout
    found = []
    for name in filter(lambda name: (TREE / name).exists(), files.split()):
        text = (TREE / name).read_text(encoding="utf-8")
        lines = [words for words in _DOCSTRING.findall(text) if _NO_SUBJECT.match(words)]
        lines += filter(_COMMENT.search, text.splitlines())
        found += [f"{name}: {line.strip()[:80]}" for line in lines]
    return found


def _files() -> list[Path]:
    return [*sorted(TREE.glob("*.md")), *sorted(TREE.glob("docs/**/*.md"))]


def pages() -> dict[str, Measure]:
    """Measure all documents, by their path from the top of the tree."""
    names = {str(file.relative_to(TREE)): file for file in _files()}
    return {
        name: measure(file.read_text(encoding="utf-8"), name == PRINTED_PAGE)
        for name, file in names.items()
    }


def complaints(measured: dict[str, Measure]) -> list[str]:
    """Tell which pages are too hard to read, and whether all are too long."""
    found = []
    for page, (_, mean, share) in measured.items():
        if mean > MAX_MEAN:
            found.append(f"{page}: {mean:.1f} words a sentence; at most {MAX_MEAN}")
        if share > MAX_LONG_SHARE:
            found.append(
                f"{page}: {share:.1%} of the sentences have more than {LONG} words; "
                f"at most {MAX_LONG_SHARE:.0%}"
            )
    total = sum(page.words for page in measured.values())
    if total > MAX_WORDS:
        found.append(f"all pages: {total} words; at most {MAX_WORDS}")
    return found


def main() -> int:
    """Print the table, and what is wrong with it."""
    measured = pages()
    for page, (words, mean, share) in measured.items():
        print(f"{page:32} {words:6} words {mean:5.1f} a sentence {share:6.1%} long")
    print(f"{'all':32} {sum(page.words for page in measured.values()):6} words")
    found = complaints(measured) + riddles() + comments()
    print(*found, sep="\n", end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
