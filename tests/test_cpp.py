"""Every C++ test, in each build that is asked for, as one pytest test each.

The cases of one source file run in one process, which its first case starts. Where that process
does not end well, each of them runs again alone, to be told by name with what it prints.
"""

from __future__ import annotations

import functools
import json
import os
import re
import subprocess
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.once import once
from tools.dev import groups

TREE = Path(__file__).parent.parent
PRESETS = os.environ.get(groups.PRESETS_VARIABLE, "asan-ubsan").split()
RESULTS = TREE / "build/cpp-tests"
CASES = "doctest"  # the label of programs that have many cases
# How long the cases of a file may take together: each may take as long as CTest gives the program.
LIMIT_S = 600.0


@dataclass(frozen=True)
class Case:
    """One test of one build.

    Attributes
    ----------
    test
        The name that CTest has for the program.
    source
        File of the case; empty if the program is the test.
    name
        Of the case.
    """

    preset: str
    test: str
    command: tuple[str, ...]
    limit_s: float
    source: str = ""
    name: str = ""

    @property
    def id(self) -> str:
        return f"{self.preset}: {self.test}" + (f":{self.name}" if self.name else "")


def _cases_of(program: Case) -> list[Case]:
    listing = subprocess.run(
        [*program.command, "--list-test-cases", "--no-skip", "--reporters=xml"],
        capture_output=True,
        check=True,
    ).stdout
    found = [
        Case(program.preset, program.test, program.command, program.limit_s, file, name)
        for case in ElementTree.fromstring(listing).iter("TestCase")
        if (file := case.get("filename")) and (name := case.get("name"))
    ]
    if not found:
        pytest.fail(f"{program.id} has no cases", pytrace=False)
    return found


def _tests(preset: str) -> list[Case]:
    folder = TREE / "build" / preset
    if not (folder / "CTestTestfile.cmake").exists():
        pytest.fail(f"build/{preset} is not built; run ./dev test", pytrace=False)
    command = ["ctest", "--test-dir", str(folder), "--show-only=json-v1"]
    listing = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    cases: list[Case] = []
    for test in json.loads(listing)["tests"]:
        words = tuple(test.get("command", ()))
        if not words or not Path(words[0]).exists():
            name = test["name"]
            pytest.fail(f"build/{preset} is not complete: {name}; run ./dev test", pytrace=False)
        properties = {entry["name"]: entry["value"] for entry in test["properties"]}
        program = Case(preset, test["name"], words, properties["TIMEOUT"])
        cases += _cases_of(program) if CASES in properties.get("LABELS", ()) else [program]
    if not cases:
        pytest.fail(f"build/{preset} has no tests", pytrace=False)
    names = [case.id for case in cases]
    if len(set(names)) != len(names):
        twice = sorted({name for name in names if names.count(name) > 1})
        pytest.fail(f"tests of the same name: {twice}", pytrace=False)
    return cases


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "case" in metafunc.fixturenames:
        cases = [case for preset in PRESETS for case in _tests(preset)]
        metafunc.parametrize("case", cases, ids=[case.id for case in cases])


def _run(command: tuple[str, ...], limit_s: float) -> str:
    """Run a program; return what it has printed if it does not end well, else nothing."""
    try:
        result = subprocess.run(
            command,
            cwd=TREE / "build",
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=limit_s,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        return f"{(error.stdout or b'').decode(errors='replace')}\ndid not end in {limit_s:g} s"
    if result.returncode == 0:
        return ""
    return f"{result.stdout.decode(errors='replace')}\nended with status {result.returncode}"


def _pattern(name: str) -> str:
    """Return what doctest takes for this name in a list."""
    return name.replace("\\", "\\\\").replace(",", "\\,")


def run_cases(cases: list[Case], report: Path) -> dict[str, str]:
    """Run cases of one file; return what is wrong with each, which is nothing if it passed."""
    # Nothing is skipped, whatever its decorators say.
    command, limit_s = (*cases[0].command, "--no-skip"), cases[0].limit_s
    names = ",".join(_pattern(case.name) for case in cases)
    together = _run(
        (*command, f"--test-case={names}", "--reporters=xml", f"--out={report}"), LIMIT_S
    )
    if not together:
        results = {
            case.get("name"): case.find("OverallResultsAsserts")
            for case in ElementTree.parse(report).iter("TestCase")
            if not case.get("skipped")
        }
        problems = {}
        for case in cases:
            result = results.get(case.name)
            passed = result is not None and result.get("test_case_success") == "true"
            problems[case.name] = "" if passed else "did not run, or did not say that it passed"
        return problems
    alone = {
        case.name: _run((*command, f"--test-case={_pattern(case.name)}"), limit_s) for case in cases
    }
    if any(alone.values()):
        return alone
    told = report.read_text(encoding="utf-8", errors="replace") if report.exists() else ""
    seen = "\n".join(
        re.findall(r"<(?:Expression|Exception).*?</(?:Expression|Exception)>", told, re.S)
    )
    return {
        case.name: f"fails only with the others of its file:\n{together}\n{seen}" for case in cases
    }


@functools.cache
def _problems(cases: tuple[Case, ...]) -> dict[str, str]:
    """Run the cases of one file, once for all workers of a run."""
    first = cases[0]
    file = RESULTS / f"{first.preset}-{first.test}-{Path(first.source).stem}.json"
    problems: dict[str, str] = once(file, lambda: run_cases(list(cases), file.with_suffix(".xml")))
    return problems


@pytest.fixture(scope="session")
def files(request: pytest.FixtureRequest) -> dict[tuple[str, str, str], tuple[Case, ...]]:
    """Give the selected cases of each file."""
    selected: dict[tuple[str, str, str], tuple[Case, ...]] = {}
    for item in request.session.items:
        case = getattr(getattr(item, "callspec", None), "params", {}).get("case")
        if isinstance(case, Case):
            key = (case.preset, case.test, case.source)
            selected[key] = (*selected.get(key, ()), case)
    return selected


def test_cpp(
    files: dict[tuple[str, str, str], tuple[Case, ...]],
    case: Case,
) -> None:
    if case.name:
        problem = _problems(files[case.preset, case.test, case.source])[case.name]
    else:
        problem = _run(case.command, case.limit_s)
    if problem:
        pytest.fail(problem, pytrace=False)
