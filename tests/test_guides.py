"""The examples of README and guides run, and print what the pages say they print."""

from __future__ import annotations

import functools
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import typer

from tests.pages import examples
from tools.dev import environment
from torsio.apps import cli

TREE = Path(__file__).parent.parent
BETWEEN = "-- next example --"


def outputs(command: list[str | Path], folder: Path) -> list[str]:
    """Run a program and give what each example printed."""
    result = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    return result.stdout.split(BETWEEN + "\n")[:-1]


def run_python(page: str, folder: Path) -> list[str]:
    program = folder / "program.py"
    end = f"\nprint({BETWEEN!r}, flush=True)\n"
    program.write_text("".join(example.code + end for example in examples(page, "python")))
    return outputs([sys.executable, "-W", "error", program], folder)


def cpp_program(page: str) -> str:
    """Make one program of a page's blocks: a page's own one, or of statements one."""
    blocks = [example.code for example in examples(page, "cpp")]
    end = f'std::puts("{BETWEEN}");\nstd::fflush(stdout);\n'
    if any("int main()" in block for block in blocks):
        (whole,) = blocks
        return "#include <cstdio>\n" + whole.rstrip().removesuffix("}") + end + "}\n"
    include = re.compile(r"^#include .*\n", re.M)
    head = "".join(line for block in blocks for line in include.findall(block))
    body = "".join(include.sub("", block) + end for block in blocks)
    return f"{head}\nint main() {{\n{body}}}\n"


@pytest.fixture(scope="module")
def cpp_programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the C++ programs of the pages against the installed SDK, as a user would."""
    folder = tmp_path_factory.mktemp("guides")
    lines = [
        "cmake_minimum_required(VERSION 3.25)",
        "project(guides LANGUAGES CXX)",
        "find_package(torsio REQUIRED)",
        "add_compile_options(-Wall -Wextra -Werror)",
    ]
    for page in CPP_PAGES:
        name = Path(page).stem
        (folder / f"{name}.cpp").write_text(cpp_program(page))
        lines += [
            f"add_executable({name} {name}.cpp)",
            f"target_link_libraries({name} PRIVATE torsio::sdk)",
        ]
    (folder / "CMakeLists.txt").write_text("\n".join(lines) + "\n")
    prefix = folder / "prefix"
    commands: list[list[str | Path]] = [
        ["cmake", "--install", TREE / "build/release", "--prefix", prefix],
        ["cmake", "-S", folder, "-B", folder, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}"],
        ["cmake", "--build", folder],
    ]
    for command in commands:
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        if result.returncode != 0:
            pytest.fail(f"{command} failed:\n{result.stdout}{result.stderr}", pytrace=False)
    return folder


TUTORIALS = ("first-wall", "volume-knob", "game", "calibrate")
PYTHON_PAGES = [
    *("README.md", "docs/reference/python.md", "docs/reference/studio.md"),
    "docs/how-to/how-exact.md",
    "docs/explanation/threads.md",
    *(f"docs/tutorials/{name}.md" for name in TUTORIALS),
]
CPP_PAGES = ["docs/reference/cpp.md"]


@pytest.mark.parametrize("page", PYTHON_PAGES)
def test_python_examples_print_what_the_page_says(page: str, tmp_path: Path) -> None:
    assert run_python(page, tmp_path) == [example.output for example in examples(page, "python")]


def _pyright(*words: str | Path) -> subprocess.CompletedProcess[str]:
    """Run pyright as an editor does, whose Python is this one."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    command = [environment.make_pyright(), "-m", "pyright", *words]
    env = {**os.environ, "PATH": path}
    return subprocess.run(command, env=env, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_editors_know_the_type_of_every_public_name() -> None:
    told = _pyright("--verifytypes", "torsio", "--ignoreexternal")
    assert told.returncode == 0, told.stdout


@pytest.mark.slow
def test_editors_find_nothing_wrong_in_readmes_program(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text("# pyright: strict\n" + examples("README.md", "python")[0].code)
    told = _pyright(program)
    assert told.returncode == 0, told.stdout


@pytest.mark.parametrize("page", CPP_PAGES)
def test_cpp_examples_print_what_the_page_says(page: str, cpp_programs: Path) -> None:
    printed = outputs([cpp_programs / Path(page).stem], cpp_programs)
    assert printed == [example.output for example in examples(page, "cpp")]


def test_tests_of_the_tutorial_pass(tmp_path: Path) -> None:
    program, *others = examples("docs/tutorials/test-your-program.md", "python")
    (tmp_path / "ratchet.py").write_text(program.code)
    for number, other in enumerate(others):
        (tmp_path / f"test_{number}.py").write_text(other.code)
    command = [sys.executable, "-m", "pytest", "-q", "-W", "error"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "4 passed" in done.stdout, done.stdout


@functools.cache
def _commands() -> dict[str, Any]:
    return dict(vars(typer.main.get_command(cli.app))["commands"])


def test_page_of_commands_names_them_all() -> None:
    page = (TREE / "docs/reference/commands.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([\w-]+)", " ".join(re.findall(r"^\| (`.*?) \|", page, re.M))))
    assert named == set(_commands())


def _unknown(line: str) -> list[str]:
    """Give the words of a command line that the command `torsio` does not know."""
    words = line.split()
    if words[0].startswith("-") or words[0] in ("study", "rehearse"):
        return []  # a module of the program, or an optional package
    command = _commands().get(words.pop(0))
    if command is None:
        return [line]
    while words and words[0] in vars(command).get("commands", {}):
        command = vars(command)["commands"][words.pop(0)]
    known = {name for parameter in command.params for name in parameter.opts}
    known |= {name for parameter in command.params for name in parameter.secondary_opts}
    return [word for word in words if word.startswith("--") and word not in {*known, "--help"}]


def test_commands_in_the_documents_are_there_with_their_options() -> None:
    lost, found = [], 0
    for page in (*TREE.glob("[!N]*.md"), *TREE.glob("docs/**/*.md")):
        text = page.read_text(encoding="utf-8")
        lines = re.findall(r"`torsio ([^`]+)`", text)
        lines += re.findall(r"^ {4,}torsio (.*?)(?:  +#.*)?$", text, re.M)
        found += len(lines)
        lost += [f"{page.name}: {word}" for line in lines for word in _unknown(line)]
    assert found > 100
    assert lost == []
    assert _unknown("list --nothing") == ["--nothing"]
