"""The hand-written stubs of the extension module say what the module has."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from torsio import _torsio
from torsio_studies import _studies

TREE = Path(__file__).parents[2]
STUBS = TREE / "bindings" / "python" / "torsio" / "_torsio"
STUDIES_STUB = TREE / "studies" / "python" / "torsio_studies" / "_studies.pyi"


def test_stubs_and_module_have_the_same_names() -> None:
    result = subprocess.run(
        [
            *(sys.executable, "-m", "mypy.stubtest"),
            *("torsio._torsio", "torsio_studies._studies"),
            *("--allowlist", "tests/python/stubtest_allowlist.txt", "--concise"),
            *("--mypy-config-file", "pyproject.toml"),
        ],
        cwd=TREE,
        env={**os.environ, "MYPYPATH": f"{STUBS.parents[1]}{os.pathsep}{STUDIES_STUB.parents[1]}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr


def _arguments_of_stub(function: ast.FunctionDef) -> list[str]:
    """Give names in order; positional-only ones as pybind11 names them, self left out."""
    arguments = function.args
    names: list[str] = []
    for argument in [*arguments.posonlyargs, *arguments.args]:
        if argument.arg != "self":
            positional = argument in arguments.posonlyargs
            names.append(f"arg{len(names)}" if positional else argument.arg)
    if arguments.kwonlyargs:
        names.append("*")
    return names + [argument.arg for argument in arguments.kwonlyargs]


def _arguments_of_runtime(function: Any) -> list[str]:
    """Read the signature that pybind11 writes into the first line of the documentation."""
    signature = function.__doc__.splitlines()[0]
    names: list[str] = []
    depth, current = 0, ""
    for character in signature[signature.index("(") + 1 :]:
        if character in ")]" and depth == 0:
            break
        depth += (character in "([") - (character in ")]")
        if character == "," and depth == 0:
            names.append(current)
            current = ""
        else:
            current += character
    names = [name.split(":")[0].strip() for name in [*names, current]]
    return [name for name in names if name not in {"self", ""}]


def _functions() -> Iterator[tuple[str, list[str], Any]]:
    modules = {
        stub: _torsio if stub.stem == "__init__" else getattr(_torsio, stub.stem)
        for stub in sorted(STUBS.glob("*.pyi"))
    }
    module: Any
    for stub, module in {**modules, STUDIES_STUB: _studies}.items():
        for node in ast.parse(stub.read_text()).body:
            owner, nodes = module, [node]
            if isinstance(node, ast.ClassDef):
                owner, nodes = getattr(module, node.name), list(node.body)
            for function in nodes:
                if not isinstance(function, ast.FunctionDef) or function.decorator_list:
                    continue
                runtime = getattr(owner, function.name)
                name = f"{owner.__name__}.{function.name}"
                yield name, _arguments_of_stub(function), runtime


FUNCTIONS = list(_functions())


@pytest.mark.parametrize(
    ("stub", "runtime"),
    [case[1:] for case in FUNCTIONS],
    ids=[case[0].removeprefix("torsio._torsio.") for case in FUNCTIONS],
)
def test_stub_has_the_arguments_of_the_function(stub: list[str], runtime: Any) -> None:
    expected = _arguments_of_runtime(runtime)
    # pybind11 counts self where arguments have no names.
    offset = 1 if any(name == f"arg{len(stub)}" for name in expected) else 0
    unnamed = [f"arg{int(n[3:]) - offset}" if n.startswith("arg") else n for n in expected]
    assert stub == unnamed
