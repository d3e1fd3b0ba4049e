"""Formatters and linters, each as one command; ``./dev check`` and the tests both use this list.

``python -m tools.check`` runs them all and exits with 1 if any complains; ``--fix`` applies what
the formatters would change.
"""

from __future__ import annotations

import functools
import os
import subprocess
import sys
import sysconfig
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pybind11

TREE = Path(__file__).parent.parent
CPP_FOLDERS = ("firmware", "emulator", "sdk", "bindings", "studies", "examples", "tests")
PYTHON_FOLDERS = ("bindings", "studies", "examples", "tests", "tools")
PACKAGE_FOLDERS = ("bindings/python", "studies/python")
MAX_LINES = 40
SHELL_FILES = ("dev", ".ci/run", "tests/vm/init.sh")

# The tools come with the virtual environment, which need not be activated.
_BIN = Path(sys.executable).parent

Command = list[str]


def cpp_files(*suffixes: str) -> list[str]:
    """Return the C++ files with these suffixes, as paths from the top of the tree."""
    files = (path for folder in CPP_FOLDERS for path in (TREE / folder).rglob("*"))
    return sorted(str(path.relative_to(TREE)) for path in files if path.suffix in suffixes)


def headers() -> list[str]:
    """Return every header; each must compile on its own."""
    return cpp_files(".hpp")


@functools.cache
def _sdl_include() -> tuple[str, ...]:
    command = ["pkg-config", "--variable=includedir", "sdl2"]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    return (f"{result.stdout.strip()}/SDL2",)


def compile_header(header: str) -> Command:
    """Return the command that compiles one header alone, on the include path of its layer."""
    roots: dict[str, tuple[str, ...]] = {
        "firmware": ("firmware",),
        "emulator": (".", "firmware"),
        "sdk/include": ("sdk/include",),  # what an installed SDK has
        "sdk/src": ("sdk/include", "sdk/src", "firmware", "."),
        "bindings": (
            *("sdk/include", "firmware", ".", "bindings/src"),
            *(pybind11.get_include(), sysconfig.get_path("include")),
        ),
        # Without the wide controller, which is made from the firmware's sources when it is built.
        "studies": (
            *("studies/src", "firmware", "."),
            *(pybind11.get_include(), sysconfig.get_path("include")),
        ),
        "examples": ("examples", "sdk/include", *_sdl_include()),
        "tests": ("tests/cpp", "tests/fuzz", "sdk/include", "studies/src", "firmware", "."),
    }
    layer = next(folder for folder in roots if header.startswith(folder + "/"))
    project = [f"-I{root}" for root in roots[layer] if not os.path.isabs(root)]
    system = [f"-isystem{root}" for root in roots[layer] if os.path.isabs(root)]
    command = ["g++", "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror"]
    if layer in ("bindings", "studies"):
        command.append("-fvisibility=hidden")  # as pybind11 compiles its modules
    return [*command, *project, *system, "-include", header, "-x", "c++", os.devnull]


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
    "includes": lambda: [sys.executable, "-m", "tools.check_layers"],
    "imports": lambda: import_linter(TREE),
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
    lines = result.stdout.splitlines()
    if len(lines) > MAX_LINES:
        lines[MAX_LINES:] = [f"... and {len(lines) - MAX_LINES} more lines"]
    return result.returncode == 0, "\n".join(lines)


def main(arguments: list[str]) -> int:
    """Run every fix if asked to, then every check; return 1 if any check complains."""
    if "--fix" in arguments:
        for fix in FIXES.values():
            run(fix())
    commands = {name: command() for name, command in CHECKS.items()}
    commands |= {f"header {header}": compile_header(header) for header in headers()}
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        results = dict(zip(commands, pool.map(run, commands.values()), strict=True))
    failures = {name: output for name, (passed, output) in results.items() if not passed}
    for name, output in failures.items():
        print(f"--- {name}\n{output}\n")
    print(f"{len(results) - len(failures)} of {len(results)} checks passed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
