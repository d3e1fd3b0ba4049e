"""Programs in other languages, which call the installed C interface and feel the same wall."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.c.calling import TREE, run
from tests.pages import examples

STRICT = ("-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic")
FELT = """\
the knob was pushed to 0.130 rad, into a wall at 0.1 rad,
which pushed back with 41 mN m
"""


@pytest.fixture(scope="module")
def flags(prefix: Path) -> list[str]:
    """A compiler's options from pkg-config."""
    where = str(prefix / "lib/pkgconfig")
    return run("pkg-config", "--cflags", "--libs", "torsio-c", PKG_CONFIG_PATH=where).split()


def test_c_example_feels_the_wall(tmp_path: Path, prefix: Path, flags: list[str]) -> None:
    program = tmp_path / "feel_a_wall"
    run("gcc", *STRICT, TREE / "examples/c/feel_a_wall.c", "-o", program, *flags)
    assert run(program, LD_LIBRARY_PATH=str(prefix / "lib")) == FELT


def test_example_of_the_guide_prints_what_the_page_says(
    tmp_path: Path, prefix: Path, flags: list[str]
) -> None:
    (example,) = examples("docs/reference/c.md", "c")
    (tmp_path / "guide.c").write_text(example.code)
    program = tmp_path / "guide"
    run("gcc", *STRICT, tmp_path / "guide.c", "-o", program, *flags)
    assert run(program, LD_LIBRARY_PATH=str(prefix / "lib")) == example.output


def test_csharp_example_feels_the_same(tmp_path: Path, prefix: Path) -> None:
    program = tmp_path / "FeelAWall.exe"
    run("mcs", "-warnaserror", f"-out:{program}", TREE / "examples/csharp/FeelAWall.cs")
    assert run("mono", program, LD_LIBRARY_PATH=str(prefix / "lib"), LC_ALL="de_DE.UTF-8") == FELT


def test_rust_example_feels_the_same(tmp_path: Path, prefix: Path) -> None:
    # The distribution's compiler, whatever else a user has installed.
    system = Path("/usr/bin/cargo"), Path("/usr/bin/rustc")
    is_there = all(program.exists() for program in system)
    cargo, rustc = system if is_there else (shutil.which("cargo"), shutil.which("rustc"))
    assert cargo
    assert rustc
    crate = tmp_path / "rust"  # a copy, for cargo writes beside it
    shutil.copytree(TREE / "examples/rust", crate)
    printed = run(
        cargo, "run", "--quiet", "--offline", "--manifest-path", crate / "Cargo.toml",
        RUSTC=str(rustc), RUSTFLAGS="-D warnings", CARGO_TARGET_DIR=str(tmp_path / "target"),
        PKG_CONFIG_PATH=str(prefix / "lib/pkgconfig"), LD_LIBRARY_PATH=str(prefix / "lib"),
    )  # fmt: skip
    assert printed == FELT


def test_octave_example_feels_the_same(tmp_path: Path, prefix: Path, flags: list[str]) -> None:
    folder = TREE / "examples/octave"
    module = tmp_path / "torsio_mex.mex"
    run("mkoctfile", "--mex", "-o", module, folder / "torsio_mex.c", *flags)
    octave = ("octave-cli", "--norc", "--no-history", "--path", tmp_path)
    # A home where no program has run yet: there Octave 7 ends with an error if it keeps a history.
    where = {"LD_LIBRARY_PATH": str(prefix / "lib"), "HOME": str(tmp_path)}
    assert run(*octave, folder / "feel_a_wall.m", **where) == FELT
    wrong = (
        ("torsio_mex('arm')", "knob is NULL"),
        ("torsio_mex('open', 'nothing')", "nothing"),
        ("torsio_mex('open', 'emulated'); torsio_mex('wall', 0, -1)", "stiffness_nm_per_rad"),
        ("torsio_mex('dance')", "open, wall, push, arm, record or close"),
    )
    for calls, sentence in wrong:
        told = run(*octave, "--eval", f"try, {calls}, catch e, disp(e.message), end", **where)
        assert sentence in told
