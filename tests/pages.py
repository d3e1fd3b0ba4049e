"""The examples of a page of the documents."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

TREE = Path(__file__).parent.parent

_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.M | re.S)


class Example(NamedTuple):
    """A block of code, and the block of text behind it, empty if there is none."""

    code: str
    output: str


def examples(page: str, language: str) -> list[Example]:
    """Give a page's examples in one language, in order."""
    found: list[Example] = []
    last = ""
    for kind, text in _BLOCK.findall((TREE / page).read_text(encoding="utf-8")):
        if kind == language:
            found.append(Example(text, ""))
        elif kind == "text" and last == language:
            found[-1] = Example(found[-1].code, text)
        last = kind
    assert found
    return found
