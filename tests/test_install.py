"""An installed SDK, or one among a project's own sources, serves a project outside this tree."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import textwrap
from pathlib import Path

import pytest

TREE = Path(__file__).parent.parent
PROJECT = TREE / "examples" / "project"
# The compiler's time matters here, the program's does not.
QUICK = ("-G", "Ninja", "-DCMAKE_CXX_FLAGS_RELEASE=-O0", "-DCMAKE_UNITY_BUILD=ON")
ALONE = ("-DTORSIO_BUILD_TESTS=OFF", "-DTORSIO_BUILD_EXAMPLES=OFF")


def _run(*command: str | Path) -> str:
    result = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    if result.returncode != 0:
        pytest.fail(f"{command} failed:\n{result.stdout}", pytrace=False)
    return result.stdout


def _installed(prefix: Path) -> set[str]:
    return {str(path.relative_to(prefix)) for path in prefix.rglob("*") if not path.is_dir()}


def _build_user(tmp_path: Path, prefix: Path) -> Path:
    """Build the user's project with find_package; return its program."""
    source, build = tmp_path / "source", tmp_path / "build"
    shutil.copytree(PROJECT, source)
    _run("cmake", "-S", source, "-B", build, *QUICK, f"-DCMAKE_PREFIX_PATH={prefix}")
    _run("cmake", "--build", build)
    return build / "my_knob"


def _compile_with_pkg_config(tmp_path: Path, prefix: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = next(prefix.rglob("torsio.pc")).parent
    monkeypatch.setenv("PKG_CONFIG_PATH", str(folder))
    flags = _run("pkg-config", "--cflags", "--libs", "torsio").split()
    program = tmp_path / "by_pkg_config"
    _run("g++", "-std=c++20", PROJECT / "main.cpp", "-o", program, *flags)
    return program


def test_static_install_serves_find_package_and_pkg_config(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    prefix = tmp_path / "prefix"
    _run("cmake", "--install", TREE / "build" / "release", "--prefix", prefix)
    files = _installed(prefix)
    assert {"share/doc/torsio/LICENSE", "share/doc/torsio/NOTICES.md"} <= files
    assert "lib/udev/rules.d/60-torsio.rules" in files
    # Installed headers must not need anything that was left behind.
    include = prefix / "include"
    names = sorted(path.relative_to(include) for path in include.rglob("*.hpp"))
    (tmp_path / "all.cpp").write_text("".join(f'#include "{name}"\n' for name in names))
    _run("g++", "-std=c++20", "-fsyntax-only", "-I", include, tmp_path / "all.cpp")
    # 50 mN m by 1 N m/rad; friction holds up to 10 mN m.
    for program in (
        _build_user(tmp_path, prefix),
        _compile_with_pkg_config(tmp_path, prefix, monkeypatch),
    ):
        told = re.fullmatch(r"2000 samples, (.*) rad inside the wall\n", _run(program))
        assert told
        assert 0.04 < float(told[1]) < 0.06


@pytest.mark.slow
def test_no_compiler_process_of_the_python_module_takes_more_than_600_mb(tmp_path: Path) -> None:
    commands = json.loads((TREE / "build" / "release" / "compile_commands.json").read_text())
    sources = [entry for entry in commands if "/_torsio.dir/" in entry["command"]]
    used_mb = {}
    for entry in sources:
        words = shlex.split(entry["command"])
        words[words.index("-o") + 1] = str(tmp_path / "object.o")
        child = subprocess.Popen(
            words, cwd=entry["directory"], env={**os.environ, "CCACHE_DISABLE": "1"}
        )
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        assert child.returncode == 0
        used_mb[Path(entry["file"]).name] = used.ru_maxrss / 1000
    assert max(used_mb.values()) <= 600, used_mb


@pytest.mark.slow
def test_shared_install_is_one_library_that_shows_only_the_sdk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    prefix, tree = tmp_path / "prefix", tmp_path / "tree"
    _run("cmake", "-S", TREE, "-B", tree, *QUICK, *ALONE, "-DTORSIO_SHARED=ON")
    _run("cmake", "--build", tree, "--target", "torsio_sdk")
    _run("cmake", "--install", tree, "--prefix", prefix, "--component", "sdk")

    libraries = sorted(path for path in prefix.rglob("lib*") if path.name.startswith("libtorsio"))
    names = [path.name for path in libraries]
    full, soname = names[2], names[1]
    assert re.fullmatch(r"libtorsio_sdk\.so\.\d+\.\d+\.\d+", full)
    assert names == ["libtorsio_sdk.so", full.rpartition(".")[0], full]
    assert os.readlink(libraries[0]) == soname
    assert os.readlink(libraries[1]) == full
    assert f"[{soname}]" in _run("readelf", "--dynamic", libraries[2])

    shown = _run("nm", "--dynamic", "--demangle", "--defined-only", libraries[2])
    assert "torsio::Knob::arm()" in shown
    assert not re.findall(r".*torsio::(?:core|device|emulator|protocol)::.*", shown)

    assert "inside the wall" in _run(_build_user(tmp_path, prefix))
    monkeypatch.setenv("LD_LIBRARY_PATH", str(libraries[0].parent))
    assert "inside the wall" in _run(_compile_with_pkg_config(tmp_path, prefix, monkeypatch))


def _fetched(tmp_path: Path, *options: str) -> Path:
    """Configure a copy of the user's project that fetches this tree; return its build."""
    source, build = tmp_path / "source", tmp_path / "build"
    shutil.copytree(PROJECT, source)
    of_tree = f"-DFETCHCONTENT_SOURCE_DIR_TORSIO={TREE}"  # in place of a download
    _run("cmake", "-S", source, "-B", build, *QUICK, of_tree, *options)
    return build


def test_subproject_serves_its_parent_and_changes_and_installs_nothing_of_it(
    tmp_path: Path,
) -> None:
    lines = (PROJECT / "CMakeLists.txt").read_text(encoding="utf-8")
    guide = (TREE / "docs/reference/cpp.md").read_text(encoding="utf-8")
    (fetched,) = re.findall(r"^  include.*\n(?:  FetchContent.*\n)+", lines, re.M)
    assert textwrap.indent(textwrap.dedent(fetched), "    ") in guide
    prefix, build = tmp_path / "prefix", _fetched(tmp_path)
    cache = (build / "CMakeCache.txt").read_text(encoding="utf-8")
    assert "CMAKE_BUILD_TYPE:STRING=\n" in cache
    _run("cmake", "--install", build, "--prefix", prefix)
    assert not _installed(prefix)
    # Its program alone, which finds the headers; the libraries take their time.
    _run("ninja", "-C", build, "CMakeFiles/my_knob.dir/Unity/unity_0_cxx.cxx.o")
    linked = _run("ninja", "-C", build, "-t", "query", "my_knob")
    assert "libtorsio_sdk.a" in linked
    assert "libtorsio_emulator.a" in linked


@pytest.mark.slow
def test_project_links_and_runs_as_it_is_printed(tmp_path: Path) -> None:
    """With its own download, of a branch main, and no line changed but the path."""
    clone, source = tmp_path / "clone", tmp_path / "source"
    clone.mkdir()
    commit = "git -c user.name=x -c user.email=x commit -qm x"
    _run(
        "bash", "-ec",
        f"cd {TREE}; git ls-files -z | xargs -0 cp --parents -t {clone};"
        f"cd {clone}; git init -qb main; git add -A; {commit}",
    )  # fmt: skip
    shutil.copytree(PROJECT, source)
    lines = (source / "CMakeLists.txt").read_text(encoding="utf-8")
    assert "/path/to/torsio" in lines
    (source / "CMakeLists.txt").write_text(lines.replace("/path/to/torsio", str(clone)))
    guide = (TREE / "docs/reference/cpp.md").read_text(encoding="utf-8")
    (commands,) = re.findall(r"run there:\n\n((?:    .*\n)+)", guide)
    told = _run("bash", "-ec", f"cd {source}\n{commands}")
    assert re.search(r"2000 samples, 0\.0[45]\d* rad inside the wall\n$", told)


@pytest.mark.slow
def test_subproject_without_emulator_links_and_says_what_it_lacks(tmp_path: Path) -> None:
    build = _fetched(tmp_path, "-DTORSIO_WITH_EMULATOR=OFF")
    _run("cmake", "--build", build)
    told = subprocess.run([build / "my_knob"], capture_output=True, text=True, check=False)
    assert (told.returncode, told.stdout) == (1, "")
    assert "TORSIO_WITH_EMULATOR" in told.stderr


# Like the part of hidapi's own CMake files that matters here; the target's name is its backend's.
HIDAPI_PACKAGE = """
add_library(hidapi::include INTERFACE IMPORTED)
set_target_properties(hidapi::include PROPERTIES
  INTERFACE_INCLUDE_DIRECTORIES "${{CMAKE_CURRENT_LIST_DIR}}/../../../include/hidapi")
add_library(hidapi::{0} INTERFACE IMPORTED)
set_target_properties(hidapi::{0} PROPERTIES INTERFACE_LINK_LIBRARIES hidapi::include)
"""
HIDAPI_PKG_CONFIG = """
Name: hidapi-hidraw
Description: stands for hidapi
Version: 0.14.0
Cflags: -I${pcfiledir}/../../include/hidapi
"""
HIDAPI_USER = f"""
cmake_minimum_required(VERSION 3.25)
project(user LANGUAGES C)
include("{TREE}/cmake/TorsioHidapi.cmake")
add_executable(user user.c)
target_link_libraries(user PRIVATE hidapi::hidraw)
"""


@pytest.mark.parametrize("kind", ["hidraw", "winapi", "darwin", "pkg-config"])
def test_hidapi_is_found_in_a_prefix(tmp_path: Path, kind: str) -> None:
    prefix, source = tmp_path / "prefix", tmp_path / "source"
    files = {
        prefix / "include/hidapi/hidapi.h": '#define WHICH "the one in the prefix"\n',
        source / "CMakeLists.txt": HIDAPI_USER,
        source / "user.c": "#include <hidapi.h>\n#include <stdio.h>\n"
        "int main(void) { return puts(WHICH) < 0; }\n",
    }
    if kind == "pkg-config":
        files[prefix / "lib/pkgconfig/hidapi-hidraw.pc"] = HIDAPI_PKG_CONFIG
    else:
        files[prefix / "lib/cmake/hidapi/hidapi-config.cmake"] = HIDAPI_PACKAGE.format(kind)
    for path, text in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    build = tmp_path / "build"
    _run("cmake", "-S", source, "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}")
    _run("cmake", "--build", build)
    assert _run(build / "user") == "the one in the prefix\n"
