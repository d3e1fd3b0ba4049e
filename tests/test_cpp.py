"""Every C++ test, in every build that ``./dev test`` makes, as one pytest test each."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest

TREE = Path(__file__).parent.parent
PRESETS = ("asan-ubsan", "tsan")


def _ctest(preset: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = ["ctest", "--test-dir", f"build/{preset}", *arguments]
    return subprocess.run(command, cwd=TREE, capture_output=True, text=True, check=False)


def _tests(preset: str) -> list[str]:
    if not (TREE / "build" / preset / "CTestTestfile.cmake").exists():
        pytest.fail(f"build/{preset} is not built; run ./dev test", pytrace=False)
    listing = _ctest(preset, "--show-only=json-v1")
    names = [str(test["name"]) for test in json.loads(listing.stdout)["tests"]]
    if not names:
        pytest.fail(f"build/{preset} has no tests", pytrace=False)
    # What was not built is listed under this name.
    if missing := [name for name in names if name.endswith("_NOT_BUILT")]:
        pytest.fail(f"build/{preset} is not complete: {missing}; run ./dev test", pytrace=False)
    if len(set(names)) != len(names):
        twice = sorted({name for name in names if names.count(name) > 1})
        pytest.fail(f"build/{preset} has tests of the same name: {twice}", pytrace=False)
    return names


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    cases = [(preset, name) for preset in PRESETS for name in _tests(preset)]
    ids = [f"{preset}: {name}" for preset, name in cases]
    metafunc.parametrize(("preset", "name"), cases, ids=ids)


def test_cpp(preset: str, name: str) -> None:
    result = _ctest(preset, "-R", f"^{re.escape(name)}$", "--output-on-failure")
    # CTest also succeeds when it ran nothing or when the test is disabled.
    if result.returncode != 0 or "100% tests passed, 0 tests failed out of 1" not in result.stdout:
        pytest.fail(result.stdout + result.stderr, pytrace=False)
