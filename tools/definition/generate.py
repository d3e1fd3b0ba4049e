"""Writes the files that are printed from the field lists; ``--check`` only says which are stale.

``python -m tools.definition.generate [--check]``, or ``./dev generate``. To print for another language, write its
printer and a module of its files beside this one, and name the module in `contents`.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from tools.definition import c_files, cpp_files, page_files, python_files, wire_files
from tools.definition.shared import TREE

contents: dict[str, Callable[[], str]] = {
    **wire_files.FILES,
    **cpp_files.FILES,
    **c_files.FILES,
    **python_files.FILES,
    **page_files.FILES,
}
"""Every printed file, and what writes it."""


def _formatted(file: str, text: str) -> str:
    """Lay a text out as the formatters want it."""
    tools = Path(sys.executable).parent
    command: list[str | Path]
    if file.endswith((".h", ".hpp", ".cpp")):
        command = [tools / "clang-format", f"--assume-filename={TREE / file}"]
    elif file.endswith(".py"):
        command = [tools / "ruff", "format", f"--stdin-filename={TREE / file}", "-"]
    else:
        return text
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{file}: {done.stderr}")
    return done.stdout


def made(file: str) -> str:
    """Give a printed file as it must be."""
    return _formatted(file, contents[file]())


def main(arguments: list[str]) -> int:
    """Write every file whose content has changed, or with ``--check`` say which would change."""
    stale = []
    for file in contents:
        path, text = TREE / file, made(file)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            stale.append(file)
            if "--check" not in arguments:
                path.write_text(text, encoding="utf-8")
    verb = "stale" if "--check" in arguments else "written"
    print("\n".join(f"{verb}: {file}" for file in stale) or "every printed file is up to date")
    return 1 if stale and "--check" in arguments else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
