"""Formatters and linters, each as one command; ``./dev check`` and the tests both use this list.

``python -m tools.check`` runs them all and exits with 1 if any complains; ``--fix`` applies what
the formatters would change.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

TREE = Path(__file__).parent.parent
CPP_FOLDERS = (
    "firmware",
    "emulator",
    "sdk",
    "bindings",
    "studies",
    "examples",
    "studio/wasm",
    "tests",
)
PYTHON_FOLDERS = ("bindings", "studies", "hardware", "examples", "tests", "tools")
PACKAGE_FOLDERS = ("bindings/python", "studies/python", "hardware/python")
MAX_LINES = 40
PLAIN_TABLES = "tools/plain_tables.txt"
SHELL_FILES = ("dev", ".ci/run", "tests/vm/init.sh")

# The tools come with the virtual environment, which need not be activated.
_BIN = Path(sys.executable).parent

_PROGRESS = re.compile(r"\[\d+/\d+\] ")  # of a build

Command = list[str]


def cpp_files(*suffixes: str) -> list[str]:
    """Return the C++ files with these suffixes, as paths from the top of the tree."""
    files = (path for folder in CPP_FOLDERS for path in (TREE / folder).rglob("*"))
    return sorted(str(path.relative_to(TREE)) for path in files if path.suffix in suffixes)


def _tool(name: str, *arguments: str) -> Command:
    return [str(_BIN / name), *arguments]


def import_linter(tree: Path) -> Command:
    """Return the command that looks for cycles and wrong layers in a tree's Python packages."""
    path = os.pathsep.join(str(tree / folder) for folder in PACKAGE_FOLDERS)
    # Before those that are installed.
    linter = _tool("lint-imports", "--no-cache", "--no-logo")
    return ["env", f"PYTHONPATH={path}", *linter]


def _python_folders() -> list[str]:
    return [folder for folder in PYTHON_FOLDERS if any((TREE / folder).rglob("*.py"))]


CHECKS: dict[str, Callable[[], Command]] = {
    "clang-format": lambda: _tool(
        "clang-format", "--dry-run", "--Werror", *cpp_files(".hpp", ".cpp")
    ),
    "ruff format": lambda: _tool("ruff", "format", "--check", *_python_folders()),
    "ruff lint": lambda: _tool("ruff", "check", *_python_folders()),
    "mypy": lambda: _tool("mypy", *_python_folders()),
    "shellcheck": lambda: _tool("shellcheck", *SHELL_FILES),
    "headers": lambda: ["cmake", "--workflow", "--preset", "headers"],
    "complexity": lambda: _tool(
        *("lizard", "-l", "cpp", "-l", "python", "-l", "typescript", "-C", "12", "-w"),
        *("-W", PLAIN_TABLES),
        *("firmware", "emulator", "sdk", "bindings", "studies", "hardware", "tools"),
        *("studio/src", "studio/wasm"),
    ),
    "lengths": lambda: [sys.executable, "-m", "tools.lengths"],
    "includes": lambda: [sys.executable, "-m", "tools.check_layers"],
    "imports": lambda: import_linter(TREE),
    "prose": lambda: [sys.executable, "-m", "tools.prose"],
}

FIXES: dict[str, Callable[[], Command]] = {
    "clang-format": lambda: _tool("clang-format", "-i", *cpp_files(".hpp", ".cpp")),
    "ruff lint": lambda: _tool("ruff", "check", "--fix", *_python_folders()),
    "ruff format": lambda: _tool("ruff", "format", *_python_folders()),
}


def run(command: Command) -> tuple[bool, str]:
    """Run a command at the top of the tree; return its success and the start of its output."""
    result = subprocess.run(
        command, cwd=TREE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    lines = [line for line in result.stdout.splitlines() if not _PROGRESS.match(line)]
    if len(lines) > MAX_LINES:
        lines[MAX_LINES:] = [f"... and {len(lines) - MAX_LINES} more lines"]
    return result.returncode == 0, "\n".join(lines)


def main(arguments: list[str]) -> int:
    """Run every fix if asked to, then every check; return 1 if any check complains."""
    if "--fix" in arguments:
        for fix in FIXES.values():
            run(fix())
    commands = {name: command() for name, command in CHECKS.items()}
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        results = dict(zip(commands, pool.map(run, commands.values()), strict=True))
    failures = {name: output for name, (passed, output) in results.items() if not passed}
    for name, output in failures.items():
        print(f"--- {name}\n{output}\n")
    print(f"{len(results) - len(failures)} of {len(results)} checks passed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
