"""Check that no source of the product that is written by hand is longer than `MAX_LINES`.

``python -m tools.lengths`` prints one line per file that is, and exits with 1 if any is.
"""

from __future__ import annotations

import sys
from pathlib import Path

TREE = Path(__file__).parent.parent
MAX_LINES = 450
FOLDERS = (
    "firmware",
    "emulator",
    "sdk",
    "bindings",
    "studies",
    "studio/src",
    "studio/wasm",
    "hardware",
    "examples",
    "tools",
)
SUFFIXES = (".hpp", ".cpp", ".h", ".py", ".ts")
PRINTED = "Printed from the field lists"  # at the beginning of each printed file


def main() -> int:
    """Print every file that is too long."""
    found = 0
    for path in sorted(path for folder in FOLDERS for path in (TREE / folder).rglob("*.*")):
        if path.suffix in SUFFIXES:
            text = path.read_text(encoding="utf-8")
            lines = text.count("\n")
            if lines > MAX_LINES and PRINTED not in text[:450]:
                print(f"{path.relative_to(TREE)}: {lines} lines, more than {MAX_LINES}")
                found += 1
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
