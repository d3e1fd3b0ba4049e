"""The groups of the tests: what each proves, what must be built for it, and which files it covers.

``./dev test`` runs the groups that have changed since they last passed; see ``plans.py``.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Any

from tools.dev import building
from tools.kernels import EVERY_KERNEL_VARIABLE, GAMES_VARIABLE

# Tells the tests' conftest.py which groups run, and the digests of those that run whole.
RUN_VARIABLE = "TORSIO_TEST_RUN"
# A number that chooses the board and the kernel whose turn it is. It follows from the change.
TURN_VARIABLE = "TORSIO_TEST_TURN"
# Builds whose C++ tests run, and boards whose firmware runs: names with blanks between them.
PRESETS_VARIABLE, BOARDS_VARIABLE = "TORSIO_TEST_PRESETS", "TORSIO_TEST_BOARDS"

# Has those tests run that are marked as slow, and no others.
SLOW_VARIABLE = "TORSIO_TEST_SLOW"
# Has those tests run that switch guards of the firmware off.
UNGUARDED_VARIABLE = "TORSIO_TEST_UNGUARDED"

# Folders without sources, at the top of the tree or below.
_MADE = {
    *("build", "out", "dist", "node_modules", "__pycache__"),
    *(".venv", ".git", ".hypothesis", ".mypy_cache", ".pytest_cache", ".ruff_cache"),
}
_BUILDING = (
    *("CMakeLists.txt", "CMakePresets.json", "cmake"),
    *("pyproject.toml", "tests/conftest.py", "tests/once.py"),
)
_FIRMWARE = ("firmware/core", "firmware/protocol", "firmware/device")
_LIBRARIES = (*_BUILDING, *_FIRMWARE, "firmware/usb", "firmware/boards", "emulator", "sdk")
# What other tests import of the library's.
_PYTHON_TESTS = (
    *(f"tests/python/{name}.py" for name in ("wire", "reference", "game", "plant_oracle")),
    *(f"tests/python/{name}.py" for name in ("hid_fields", "parts_oracle", "buzzing")),
)
_PYTHON = (*_LIBRARIES, "bindings", "tests/golden", *_PYTHON_TESTS)
_CODE = (
    *_PYTHON,
    *("firmware", "studies", "hardware", "studio", "examples", "tests", "tools", "dev", ".ci"),
    *(".clang-format", ".editorconfig", ".gitignore"),
)
_BOARD_PAGES = ("docs/results.md", "docs/results/paper.md")
_MAKING_PAGES = (
    "README.md",
    *(f"docs/how-to/{name}.md" for name in ("build", "first-power", "wire")),
    *("docs/reference/hardware.md", "docs/reference/reference-knob.md"),
)
_PAGES = ("docs", "README.md", "CONTRIBUTING.md", "CHANGELOG.md", "NOTICES.md", "LICENSE")


@dataclass(frozen=True)
class Group:
    """Tests that need the same.

    Attributes
    ----------
    proves
        In a few words, for the table in ``CONTRIBUTING.md``.
    tests
        Files and folders, from the top of the tree.
    needs
        Steps of the build; see ``commands.test``.
    covers
        Files and folders whose change may make a test fail, beside the tests themselves.
    variables
        For the environment of the tests.
    slow
        Runs only when it is named, and in ``.ci/slow``.
    """

    proves: str
    tests: tuple[str, ...]
    needs: tuple[str, ...]
    covers: tuple[str, ...]
    variables: Mapping[str, str] = field(default_factory=dict)
    slow: bool = False

    @property
    def all(self) -> tuple[str, ...]:
        """All that the group covers."""
        return (*self.covers, *self.tests)

    def digest(self) -> str:
        """Return a checksum of all that the group covers."""
        return building.digest(self.all)

    def has(self, test: str) -> bool:
        """Tell whether a test is in it, given as a path or as pytest's node id."""
        path = PurePosixPath(test.partition("::")[0])
        return any(path.is_relative_to(own) for own in self.tests)


# Folders of tests that tests of other folders import.
_TESTS_USED = (
    *("tests/faults", "tests/bench", "tests/vm/guest", "tests/mutation", "tests/board"),
    *("tests/recordings.py", "tests/pages.py"),
)
_COVERED_BY_CPP = (
    *(*_LIBRARIES, "firmware", "studies/CMakeLists.txt", "studies/src", "examples", "tools"),
    *("tests/cpp", "tests/fuzz", "tests/mutation", "tests/determinism", "tests/endurance"),
    *("tests/golden", "tests/bench", "tests/vm", "docs/explanation/architecture.md"),
)
_COVERED_BY_BOARDS = (*(*_PYTHON, "firmware", "tools", "tests/mutation", "tests/bench"),)
_COVERED_BY_KERNELS = (
    *(
        *_PYTHON,
        # The guests run the one, and import the other.
        *("tests/python/test_knob.py", "tests/python/test_interrupt.py"),
        "examples",
        "studio",
        "tools",
        "docs/reference/protocol.md",
        "tests/studio/browser.py",
    ),
    *("tests/determinism", "tests/bench", "tests/endurance", "tests/cpp"),
)
# Tests that run the boards' binaries and current loops for minutes.
FIGURES = ("tests/studies/test_binary.py", "tests/studies/test_bench_stiffness.py")
FIREFOX = "tests/studio/test_firefox.py"  # to start a second browser takes as long as all others
_BOARD_NEEDS = ("firmware", "python")
_EVERY_BOARD = {BOARDS_VARIABLE: " ".join(building.BOARDS)}

GROUPS = {
    "checks": Group(
        "format, lint, types, layers; the tools' own tests",
        (
            *("tests/test_checks.py", "tests/test_dev.py", "tests/test_project.py"),
            *("tests/test_stack_bound.py", "tests/test_mutation.py"),
        ),
        ("release", "python", "studies"),
        _CODE,
    ),
    "library": Group(
        "the Python package: driver, emulated device, physics against their oracles",
        ("tests/python", "tests/test_faults.py"),
        ("release", "python"),
        (
            *(*_PYTHON, "examples", "tools", *_TESTS_USED),
            *("docs/how-to/testing.md", "docs/reference/testing.md"),
        ),
    ),
    "cpp": Group(
        "C++ with address and undefined-behaviour sanitizers; fuzzing, mutants, lives",
        (
            *("tests/test_cpp.py", "tests/test_fuzz.py", "tests/test_mutants.py"),
            *("tests/test_determinism.py", "tests/test_endurance.py"),
        ),
        ("release", "asan-ubsan", "python"),
        _COVERED_BY_CPP,
        {PRESETS_VARIABLE: "asan-ubsan"},
    ),
    "interfaces": Group(
        "installed C and C++ libraries, and programs of other languages",
        ("tests/c", "tests/test_install.py", "tests/test_other_systems.py"),
        ("release", "languages", "python"),
        (
            *(*_LIBRARIES, "examples", "docs/reference/c.md", "docs/reference/cpp.md", "tools"),
            "tests/pages.py",
        ),
    ),
    "board": Group(
        "the firmware's binary in an emulated chip; budgets of instructions, stack and RAM",
        ("tests/board", "tests/mcu"),
        _BOARD_NEEDS,
        _COVERED_BY_BOARDS,
    ),
    "kernels": Group(
        "virtual USB knobs in real Linux kernels",
        ("tests/vm",),
        ("release", "asan-ubsan", "python", "kernels"),
        _COVERED_BY_KERNELS,
    ),
    "page": Group(
        "the studio's page in Chromium, the emulated device as WebAssembly",
        ("tests/studio",),
        ("python", "page"),
        (
            *(*_PYTHON, "studio", "docs/reference", "docs/how-to", "tools"),
            *("tests/faults/lines.py", "tests/recordings.py"),
        ),
    ),
    "studies": Group(
        "the paper's experiments, rival actuators, design, extremes, accuracy, calibration",
        ("tests/studies",),
        ("python", "studies"),
        (
            *(*_PYTHON, "studies", "tools", *_TESTS_USED, "docs/results", "docs/results.md"),
            *("tests/python/test_readers.py", "tests/python/test_firmware.py"),
        ),
    ),
    "hardware": Group(
        "the knob to build: closed forms, parts, what a rehearsal finds",
        ("tests/hardware",),
        ("python", "studies", "hardware"),
        (*_PYTHON, "studies", "hardware", "tools", *_MAKING_PAGES),
    ),
    "claims": Group(
        "names that pages and sources share, printed files, the udev rule",
        ("tests/test_claims.py", "tests/test_definition.py", "tests/test_udev.py"),
        ("release", "python"),
        (*_CODE, *_PAGES),
    ),
    "documents": Group(
        "guides that run, links, what pages say of the code",
        (
            *("tests/test_guides.py", "tests/test_hardware_guide.py", "tests/test_site.py"),
            *("tests/test_troubleshooting.py", "tests/test_results.py"),
        ),
        ("release", "python", "hardware", "page", "documents"),
        (
            *_PAGES,
            *_LIBRARIES,
            "bindings",
            "examples",
            "studio",
            "tools",
            "tests/c",
            "tests/bench",
            *("tests/vm/guest", "tests/pages.py"),
        ),
    ),
    "threads": Group(
        "the library's threads with the thread sanitizer",
        ("tests/test_cpp.py",),
        ("tsan", "python"),
        _COVERED_BY_CPP,
        {PRESETS_VARIABLE: "tsan"},
        slow=True,
    ),
    "guards": Group(
        "what each guard stands against: both boards, with it and without",
        ("tests/board/test_guards.py",),
        (*_BOARD_NEEDS, "unguarded"),
        (*_COVERED_BY_BOARDS, *_BOARD_PAGES),
        {**_EVERY_BOARD, building.EVERY_BOARD_VARIABLE: "1", UNGUARDED_VARIABLE: "1"},
        slow=True,
    ),
    "figures": Group(
        "binaries beside the emulated device; how stiff their current loops can be",
        FIGURES,
        ("release", *_BOARD_NEEDS, "studies"),
        (*_COVERED_BY_BOARDS, *_BOARD_PAGES, "studies", "tests/studies", "tests/board"),
        _EVERY_BOARD,
        slow=True,
    ),
    "making": Group(
        "the knob to build: finite elements of two programs, solids, drawings, every rehearsal",
        ("tests/making",),
        (*_BOARD_NEEDS, "studies", "hardware", "making", "page"),
        (
            *(
                *_COVERED_BY_BOARDS,
                "studies",
                "hardware",
                "studio",
                "tests/hardware",
                "tests/studio",
            ),
            *_MAKING_PAGES,
        ),
        {BOARDS_VARIABLE: "pico2"},
        slow=True,
    ),
    "slow": Group(
        "builds of other kinds, studies on a cluster, learning, what editors know of types",
        ("tests/test_install.py", "tests/test_guides.py", "tests/python", "tests/studies"),
        ("release", "python", "studies"),
        (*_COVERED_BY_BOARDS, "studies", "examples", *_PAGES),
        {SLOW_VARIABLE: "1"},
        slow=True,
    ),
    "boards": Group(
        "the firmware's binaries, each test on both boards",
        ("tests/board", "tests/mcu"),
        _BOARD_NEEDS,
        (*_COVERED_BY_BOARDS, *_BOARD_PAGES),
        {**_EVERY_BOARD, building.EVERY_BOARD_VARIABLE: "1"},
        slow=True,
    ),
    "usb": Group(
        "tests with kernels, on both or the one they name",
        ("tests/vm",),
        ("release", "asan-ubsan", "python", "kernels"),
        _COVERED_BY_KERNELS,
        {EVERY_KERNEL_VARIABLE: "1"},
        slow=True,
    ),
    "games": Group(
        "a Windows game under Wine, Debian's newest kernels, Firefox",
        ("tests/vm", FIREFOX),
        ("release", "asan-ubsan", "python", "kernels", "page", "windows games"),
        _COVERED_BY_KERNELS,
        {EVERY_KERNEL_VARIABLE: "1", GAMES_VARIABLE: "1"},
        slow=True,
    ),
}
EVERY_CHANGE = [name for name, group in GROUPS.items() if not group.slow]


def table() -> str:
    """Print the groups for ``CONTRIBUTING.md``."""
    rows = [
        f"| `{name}`{' (slow)' if group.slow else ''} | {group.proves} | {', '.join(group.needs)} |"
        for name, group in GROUPS.items()
    ]
    return "\n".join(["| group | proves | builds |", "|---|---|---|", *rows]) + "\n"


def sums(stats: Mapping[str, Sequence[Any]], chosen: Iterable[str]) -> list[str]:
    """Return a line for each group: how many tests passed and failed, and what they took.

    Parameters
    ----------
    stats
        pytest's reports by outcome.
    chosen
        Groups that run whole; where none does, each test counts for the first that has it.
    """
    known = [*chosen] or [*GROUPS]
    count: Counter[tuple[str, str]] = Counter()
    seconds: dict[str, float] = defaultdict(float)
    for outcome in ("passed", "failed", "error", ""):  # without a name: setting up, and the like
        for report in stats.get(outcome, []):
            name = next((name for name in known if GROUPS[name].has(report.nodeid)), "")
            count[name, outcome] += 1
            seconds[name] += getattr(report, "duration", 0.0)
    return [
        f"{name:10} {count[name, 'passed']:5} passed "
        f"{count[name, 'failed'] + count[name, 'error']:3} failed {seconds[name]:6.0f} s"
        for name in known
        if seconds[name]
    ]


def not_covered(test: str, files: Iterable[str], chosen: Iterable[str] = ()) -> list[str]:
    """Return the files of the tree that no chosen group with this test covers, if any has it.

    One is enough: its variables have the test read what the others do not cover.
    """
    covered = [own for group in _groups_with(test, set(chosen)) for own in group.all]
    return [
        str(path)
        for path in map(PurePosixPath, files if covered else ())
        if not _MADE & set(path.parts) and not any(path.is_relative_to(own) for own in covered)
    ]


def _groups_with(test: str, chosen: set[str]) -> list[Group]:
    """Return the chosen groups with a test, else those that are not slow, else all."""
    names = [name for name, group in GROUPS.items() if group.has(test)]
    names = [name for name in names if name in chosen] or names
    found = [GROUPS[name] for name in names]
    if chosen.isdisjoint(names):
        found = [group for group in found if not group.slow] or found
    return found
