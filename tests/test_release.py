"""What a release is made of: sdist, archives, checksums, list of parts, Pythons of others."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Sequence
from pathlib import Path

import pytest

from tools import (
    apt,
    hidapi_source,
    release,
    sdist,
    wheel_commands,
    wheel_compilers,
    wheel_oldest,
    wheel_pythons,
    wheel_trials,
    wheels,
)
from tools.dev import commands, fresh

TREE = Path(__file__).parent.parent


def test_checksums_are_as_sha256sum_reads_them(tmp_path: Path) -> None:
    (tmp_path / "a.whl").write_bytes(b"a")
    (tmp_path / "b c.uf2").write_bytes(b"b")
    (tmp_path / "SHA256SUMS").write_text(release.checksums(tmp_path))
    check = ["sha256sum", "--strict", "--check", "SHA256SUMS"]
    told = subprocess.run(check, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert told == "a.whl: OK\nb c.uf2: OK\n"


def test_wine_begins_when_the_one_before_has_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("wine", "wineserver", "other"):
        program = tmp_path / name
        program.write_text('#!/bin/sh\necho "${0##*/} $* $WINEPREFIX" >> "${0%/*}/begun"\n')
        program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    wheel_commands.finish("wine", "a.exe", WINEPREFIX="here")
    wheel_commands.finish("other", "b")
    begun = (tmp_path / "begun").read_text().splitlines()
    assert [line.rstrip() for line in begun] == [
        "wineserver --wait here",
        "wine a.exe here",
        "other b",
    ]


def test_wheel_that_another_commit_made_is_told_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wheel = tmp_path / "a.whl"
    with zipfile.ZipFile(wheel, "w") as files:
        files.writestr(zipfile.ZipInfo("a", (2026, 1, 2, 3, 4, 6)), "")
    # date --utc --date='2026-01-02 03:04:06' +%s says 1767323046; a zip counts pairs of seconds.
    for epoch_s, same in ((1767323046, True), (1767323047, True), (1767323048, False)):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", str(epoch_s))
        assert release.is_of_this_commit(wheel) == same
    with zipfile.ZipFile(wheel, "a") as files:
        files.writestr(zipfile.ZipInfo("b", (2026, 1, 2, 3, 4, 8)), "")
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1767323046")
    assert not release.is_of_this_commit(wheel)


def test_release_makes_the_wheels_that_are_missing_and_no_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(wheels, "OUT", tmp_path)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1767323046")
    made: list[Sequence[str]] = []

    def wheel(python: str, machine: str, second: int) -> None:
        name = f"torsio-{release.version()}-cp{python.replace('.', '')}-x-{machine}.whl"
        with zipfile.ZipFile(tmp_path / name, "w") as files:
            files.writestr(zipfile.ZipInfo("a", (2026, 1, 2, 3, 4, second)), "")

    def build(words: Sequence[str]) -> int:
        made.append(words)
        return 0

    monkeypatch.setattr(wheels, "main", build)
    for machine in wheels.ARCHITECTURES:
        for python in wheel_pythons.MAVEN:
            wheel(python, machine, 6)
    assert release.missing_wheels() == []
    wheel("3.12", "aarch64", 4)  # of another commit
    next(tmp_path.glob("*cp310*win_amd64*")).unlink()
    assert release.missing_wheels() == [("aarch64", "3.12"), ("win_amd64", "3.10")]

    release.make_wheels("T", ["3.10", "3.12"], wheels.ARCHITECTURES, "--no-try")
    assert made == [
        ["--tinyusb", "T", "--arch", "aarch64", "--python", "3.12", "--no-try"],
        ["--tinyusb", "T", "--arch", "win_amd64", "--python", "3.10", "--no-try"],
    ]
    made.clear()
    release.make_wheels("T", ["3.11", "3.12"], ["win_amd64"])
    assert made == []
    monkeypatch.setattr(wheels, "main", lambda _: 1)
    with pytest.raises(RuntimeError, match="the wheels for aarch64 cannot"):
        release.make_wheels("T", ["3.12"], ["aarch64"])


def test_release_that_was_made_twice_must_have_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    files = {"a.elf": b"\x7fELF", "a.uf2": b"UF2", "torsio.cdx.json": b"{}"}
    one, other = tmp_path / "one", tmp_path / "other"
    monkeypatch.setattr(release, "OUT", one)

    def fill(folder: Path, **changed: bytes) -> None:
        folder.mkdir(exist_ok=True)
        for name, content in files.items():
            (folder / name).write_bytes(changed.get(name.replace(".", "_"), content))
        (folder / "SHA256SUMS").write_text(release.checksums(folder))

    fill(one)
    fill(other)
    compare = ["--compare", str(other)]
    assert release.main(compare) == 0
    assert "3 files have the same bytes" in capsys.readouterr().out
    fill(other, a_elf=b"/home/me")
    assert release.main(compare) == 1
    assert "a.elf has other bytes\n" in capsys.readouterr().err
    fill(other)
    (other / "b.whl").touch()
    assert release.main(compare) == 1  # not in the list
    (other / "SHA256SUMS").write_text(release.checksums(other))
    assert release.main(compare) == 1
    assert "b.whl is in one only\n" in capsys.readouterr().err
    (other / "SHA256SUMS").unlink()
    assert release.main(compare) == 1


def test_release_is_made_twice_in_two_clones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ran: list[list[str]] = []

    def run(*words: object) -> int:
        ran.append([str(word) for word in words])
        return 0

    monkeypatch.setattr(commands, "BUILD", tmp_path)
    monkeypatch.setattr(commands, "_make_release", lambda words: run("first", *words))
    monkeypatch.setattr(commands, "run", run)
    monkeypatch.setattr(fresh, "clone", lambda folder: run("clone", folder))
    again = tmp_path / "release-again"
    assert commands.release(["--python", "3.11"]) == 0
    assert ran == [["first", "--python", "3.11"]]
    ran.clear()
    assert commands.release(["--twice"]) == 0
    assert ran[:2] == [["first"], ["clone", str(again)]]
    assert ran[2][:2] == ["env", "CCACHE_DISABLE=1"]
    assert ran[2][3:] == [str(again / "dev"), "release", "--no-try"]
    assert ran[3][-2:] == ["--compare", str(again / "out/release")]


def test_list_of_parts_names_version_and_licence_of_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sdk = tmp_path / "sdk"
    (sdk / "lib/tinyusb/src").mkdir(parents=True)
    numbers = "".join(
        f"#define TUSB_VERSION_{name}   {n}\n"
        for n, name in enumerate(("MAJOR", "MINOR", "REVISION"))
    )
    (sdk / "lib/tinyusb/src/tusb_option.h").write_text(numbers)
    lines = [f"set(PICO_SDK_VERSION_{name} 2)" for name in ("MAJOR", "MINOR", "REVISION")]
    (sdk / "pico_sdk_version.cmake").write_text("\n".join(lines))
    monkeypatch.setattr(hidapi_source, "locate", lambda _: Path("hidapi-hidapi-0.13.1"))
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    bill = json.loads(json.dumps(release.bill_of_materials(sdk)))
    assert bill["metadata"]["timestamp"] == "1970-01-02T00:00:00Z"
    versions = {part["name"]: part["version"] for part in bill["components"]}
    assert versions["hidapi"] == "0.13.1"
    assert versions["TinyUSB"] == "0.1.2"
    assert versions["pico-sdk"] == "2.2.2"
    assert all(part["licenses"][0]["expression"] for part in bill["components"])
    packages = {part["name"]: part["purl"] for part in bill["components"]}
    assert packages["hidapi"] == "pkg:github/libusb/hidapi@hidapi-0.13.1"
    refs = [part["bom-ref"] for part in bill["components"]]
    assert len(set(refs)) == len(refs)  # the schema asks for it
    assert bill["dependencies"] == [
        {"ref": bill["metadata"]["component"]["bom-ref"], "dependsOn": refs}
    ]
    assert bill == release.bill_of_materials(sdk)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86401")
    assert bill["serialNumber"] != release.bill_of_materials(sdk)["serialNumber"]

    (sdk / "lib/tinyusb/src/tusb_option.h").write_text("")
    with pytest.raises(RuntimeError, match="version of TinyUSB"):
        release.bill_of_materials(sdk)


def test_hidapi_that_is_there_is_not_fetched_again(tmp_path: Path) -> None:
    header = tmp_path / "hidapi-hidapi-9.8.7/hidapi/hidapi.h"
    header.parent.mkdir(parents=True)
    header.touch()
    assert hidapi_source.locate(tmp_path) == header.parent.parent


def test_wheels_are_built_with_what_the_tests_have() -> None:
    pins = wheels.BUILT_WITH.findall((TREE / "pyproject.toml").read_text(encoding="utf-8"))
    assert sorted(pin.partition("==")[0] for pin in pins) == ["pybind11", "scikit-build-core"]


def test_there_is_a_wheel_for_each_python_that_the_package_names() -> None:
    text = (TREE / "pyproject.toml").read_text(encoding="utf-8")
    named = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', text)
    assert named == [*wheel_pythons.MAVEN]
    assert f'requires-python = ">={named[0]}"' in text


def test_wheel_that_has_other_bytes_when_it_is_built_again_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CCACHE_DISABLE", raising=False)  # whoever runs the tests may have it
    wheel = tmp_path / "torsio-0.1.0-x.whl"
    content = [b"a wheel", b"a wheel", b"another"]

    def build_all(*_: object) -> list[Path]:
        wheel.write_bytes(content.pop(0))
        assert ("CCACHE_DISABLE" in os.environ) == (len(content) < 2)
        return [wheel]

    (tmp_path / "objects-x").mkdir()
    for name, value in {"OUT": tmp_path, "BUILD": tmp_path, "build_all": build_all}.items():
        monkeypatch.setattr(wheels, name, value)
    build_all()
    wheels.build_again("x", ["3.11"], "", tmp_path)
    assert "CCACHE_DISABLE" not in os.environ
    (tmp_path / "objects-x").mkdir()
    with pytest.raises(wheel_commands.Failed, match=f"{wheel.name} has other bytes"):
        wheels.build_again("x", ["3.11"], "", tmp_path)


def test_compilers_do_not_tell_cmake_what_is_in_zigs_cache(tmp_path: Path) -> None:
    prints = tmp_path / "python"
    prints.write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n')
    prints.chmod(0o755)
    compilers = wheel_compilers.compilers(tmp_path / "tools", "win_amd64", prints)
    for path in compilers.variables.values():
        asked = [path, "-v", "-c", "a b.cpp", "-v", "-o", "-verbose"]
        told = subprocess.run(asked, capture_output=True, text=True, check=True).stdout
        assert told.splitlines()[-4:] == ["-c", "a b.cpp", "-o", "-verbose"]
        assert "-v" not in told.splitlines()


def test_sources_that_apt_cannot_fetch_are_told_with_its_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    nowhere = apt.Archive(f"file:{tmp_path}/no archive".replace(" ", "%20"))
    monkeypatch.setattr(apt, "system_archive", lambda: nowhere)
    with pytest.raises(RuntimeError, match=r"(?s)apt-get -q failed.*no%20archive"):
        hidapi_source.locate(tmp_path)


def test_two_sdists_have_the_same_bytes_and_all_that_a_wheel_is_built_of(tmp_path: Path) -> None:
    made = []
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        made.append(sdist.make(tmp_path / name))
    assert made[0].read_bytes() == made[1].read_bytes()
    with tarfile.open(made[0]) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    # What `./dev build python` reads; the complete proof is that every wheel is built of an sdist.
    tracked = subprocess.run(
        ["git", "ls-files", "firmware", "emulator", "sdk", "bindings", "cmake"],
        cwd=TREE, capture_output=True, text=True, check=True,
    ).stdout.split()  # fmt: skip
    assert {name for name in tracked if (TREE / name).exists()} <= names
    assert not any(name.startswith(("tests/", "build/", "studio/")) for name in names)

    source = tmp_path / "source"
    assert sdist.unpack(made[0], source)
    assert not sdist.unpack(made[1], source)
    assert (source / "pyproject.toml").read_bytes() == (TREE / "pyproject.toml").read_bytes()


def test_archive_of_a_folder_forgets_when_and_by_whom_it_was_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    for name, time_s in (("one", 1e9), ("two", 1.5e9)):
        page = tmp_path / name / "pages/index.html"
        page.parent.mkdir(parents=True)
        page.write_text("a knob")
        os.utime(page, (time_s, time_s))
        (tmp_path / f"of-{name}").mkdir()
        release.pack(tmp_path / name, tmp_path / f"of-{name}/torsio-site.tar.gz")
    one, two = (tmp_path / f"of-{name}/torsio-site.tar.gz" for name in ("one", "two"))
    assert one.read_bytes() == two.read_bytes()
    with tarfile.open(one) as archive:
        (entry,) = archive.getmembers()
    assert (entry.name, entry.mtime, entry.uname) == ("torsio-site/pages/index.html", 86400, "")


def test_oldest_system_is_the_first_whose_c_library_python_takes() -> None:
    old = "python3.13: /lib/libm.so.6: version `GLIBC_2.38' not found (required by python3.13)"
    tried: list[str] = []

    def first(*answers: tuple[int, str]) -> str:
        tried.clear()

        def start(suite: str) -> subprocess.CompletedProcess[str]:
            tried.append(suite)
            return subprocess.CompletedProcess((), *answers[len(tried) - 1])

        return wheel_oldest.first_that_runs(["one", "two", "three"], start)

    assert first((0, "")) == "one"
    assert first((1, old), (1, old), (0, "")) == "three"
    assert tried == ["one", "two", "three"]
    with pytest.raises(wheel_commands.Failed, match="newer Linux than Debian three's"):
        first((1, old), (1, old), (1, old))
    with pytest.raises(wheel_commands.Failed, match=r"(?s)two Python does not.*no such file"):
        first((1, old), (127, "no such file"))


def test_part_of_an_archive_is_unpacked_without_its_folders(tmp_path: Path) -> None:
    archive = tmp_path / "python.jar"
    with zipfile.ZipFile(archive, "w") as files:
        files.writestr("org/python/windows/python.exe", "program")
        files.writestr("org/python/windows/lib/os.py", "library")
        files.writestr("org/python/linux/python", "another")
    wheel_pythons.unpack(archive, "/python/windows/", tmp_path)
    assert (tmp_path / "python.exe").read_text() == "program"
    assert (tmp_path / "lib/os.py").read_text() == "library"
    assert not list(tmp_path.rglob("python"))


def test_first_steps_succeed_with_the_package_that_is_installed(tmp_path: Path) -> None:
    steps = [sys.executable, "-W", "error", str(wheel_trials.FIRST_STEPS)]
    told = subprocess.run(steps, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    # 50 mN m into 1.4 N m/rad from 0.1 rad, less the knob's own friction: README says 0.130.
    assert "pushed the knob to 0.130 rad" in told


def test_doctor_of_a_wheel_is_asked_and_must_answer(tmp_path: Path) -> None:
    wheel_trials.ask_doctor(sys.executable, "-m", "torsio")
    silent = tmp_path / "silent.py"
    silent.write_text("raise SystemExit(1)")
    with pytest.raises(wheel_commands.Failed, match="torsio doctor"):
        wheel_trials.ask_doctor(sys.executable, silent)


def test_changes_that_are_in_no_commit_are_told(tmp_path: Path) -> None:
    subprocess.run(["git", "init", "-q", tmp_path], check=True)
    assert release.uncommitted(tmp_path) == []
    (tmp_path / "new").touch()
    assert release.uncommitted(tmp_path) == [
        "the tree has changes that are in no commit: git status"
    ]
