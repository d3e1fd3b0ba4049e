"""The project's own machinery: the script, the version, the rules of the test suite."""

from __future__ import annotations

import ast
import importlib.metadata
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tools import prose

TREE = Path(__file__).parent.parent


def test_version_of_the_package_is_the_one_in_cmake() -> None:
    lists = (TREE / "CMakeLists.txt").read_text(encoding="utf-8")
    match = re.search(r"^project\(torsio VERSION ([0-9.]+)", lists, re.M)
    assert match
    assert importlib.metadata.version("torsio") == match.group(1)


def test_suite_counts_a_skip_as_a_failure(pytester: pytest.Pytester) -> None:
    pytester.makeconftest((TREE / "tests" / "conftest.py").read_text(encoding="utf-8"))
    pytester.makepyfile(
        test_one="import pytest\ndef test_a(): pytest.skip('why')",
        test_two="import pytest\n@pytest.mark.skip\ndef test_b(): pass",
        test_three="import pytest\npytest.importorskip('no_such_module')\ndef test_c(): pass",
        test_four="import pytest\n@pytest.mark.xfail\ndef test_d(): assert False",
    )
    outcomes = pytester.runpytest("--continue-on-collection-errors").parseoutcomes()
    assert outcomes == {"failed": 1, "errors": 2, "xfailed": 1}


@pytest.mark.parametrize(
    "pattern",
    [
        pytest.param(
            r"system_clock|gettimeofday|CLOCK_REALTIME|\btime\(nullptr\)",
            id="a clock that somebody may set measures no duration",
        ),
        # Its results depend on the system: sdk/conversion/turns.hpp.
        pytest.param(r"\blong double\b", id="what is not the same everywhere computes nothing"),
    ],
)
def test_sources_do_without(pattern: str) -> None:
    found = [
        file
        for folder in ("firmware", "emulator", "sdk", "bindings/src")
        for file in (TREE / folder).rglob("*.[ch]pp")
        if re.search(pattern, re.sub("//.*", "", file.read_text(encoding="utf-8")))
    ]
    assert found == []


# Modules that a function may import inside; CONTRIBUTING.md says why.
LATE = {
    # Optional packages, and our modules that need one ...
    *("mcap.records", "mcap.stream_reader", "mcap.writer", "pyarrow", "zstandard"),
    *("mujoco", "mujoco.rollout", "pydrake.all", "distributed"),
    *("torsio.apps.cli", "torsio.studio.server", "torsio.studio.live_page"),
    *("torsio.calibration.figure", "torsio.demos.wall_figure", "torsio.apps.stability_figure"),
    *("torsio.common.plots", "torsio.trading.figure", "torsio_studies.enclosure.balls"),
    "torsio.apps",  # by the fixtures of pytest
    # ... and the imports that slow the other commands down.
    *("torsio_studies.execution", "f'torsio_studies.{name}.study'"),
    *("importlib.metadata", "urllib.parse", "urllib.request"),
}


def _imported_in_functions(file: Path) -> Iterator[str]:
    tree = ast.parse(file.read_text(encoding="utf-8"))
    functions = [
        node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]
    for node in (inner for function in functions for inner in ast.walk(function)):
        match node:
            case ast.Import(names):
                yield from (name.name for name in names)
            case ast.ImportFrom(module=str(module)):
                yield module
            case ast.Call(func=ast.Attribute(attr="import_module"), args=[ast.Constant(str(name))]):
                yield name
            case ast.Call(func=ast.Attribute(attr="import_module"), args=[name]):
                yield ast.unparse(name)


def test_imports_stand_at_the_top_but_for_optional_packages_and_slow_starts() -> None:
    found = {
        module
        for folder in ("bindings/python", "studies/python")
        for file in (TREE / folder).rglob("*.py")
        for module in _imported_in_functions(file)
    }
    assert found == LATE


def test_only_tests_of_the_studies_import_the_studies() -> None:
    imports = re.compile(r"^\s*(from|import) (torsio_studies|tests\.studies)\b", re.MULTILINE)
    found = [
        file
        for file in (TREE / "tests").rglob("*.py")
        if TREE / "tests/studies" not in file.parents
        and imports.search(file.read_text(encoding="utf-8"))
    ]
    assert found == []


def test_comments_are_read_once() -> None:
    assert prose.comments() == []
