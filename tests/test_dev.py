"""What ``./dev`` does with packages, requirements, stamps and other systems, without doing it."""

from __future__ import annotations

import io
import re
import shutil
import subprocess
import sys
from concurrent.futures import Future
from pathlib import Path

import pytest

from tools import apt, windows
from tools.dev import building, cli, commands, environment, fresh, groups, packages, running
from tools.dev.requirements import requirements

TREE = Path(__file__).parent.parent


def test_commands_are_those_that_the_help_tells() -> None:
    text = (TREE / "tools/dev/help.txt").read_text(encoding="utf-8")
    told = [
        line.split()[0] for line in text.splitlines() if line.startswith("  ") and line[2] != " "
    ]
    assert set(told) == {"help", *cli.COMMANDS}


def named_and_gone(text: str) -> set[str]:
    """Return the commands that a text names and that are not there, with what they are given."""
    named = re.findall(r"\./dev ([a-z]+)(?: ([a-z]+))?", text)
    given = {
        "bench": commands.benchmarks(),
        "build": [*building.PRESETS, "python"],
        "windows": [*windows.LAYERS, "python"],
    }
    return {
        f"{name} {word}".strip()
        for name, word in named
        if name not in ("help", *cli.COMMANDS) or (word and word not in given.get(name, [word]))
    }


def test_slow_script_runs_all_and_names_what_failed(tmp_path: Path) -> None:
    (tmp_path / ".ci").mkdir()
    shutil.copy(TREE / ".ci/slow", tmp_path / ".ci")
    stand_in = tmp_path / "dev"
    stand_in.write_text('#!/bin/sh\ncat\necho "ran $*"\n[ "$*" != macos ] && [ "$1" != ros ]\n')
    stand_in.chmod(0o755)
    result = subprocess.run(
        [tmp_path / ".ci/slow"], capture_output=True, text=True, check=False, cwd="/"
    )
    assert result.returncode == 1
    *told, first, second = result.stdout.splitlines()
    assert [first, second] == ["failed: ./dev macos", "failed: ./dev ros"]
    ran = {line.removeprefix("ran ") for line in told if line.startswith("ran ")}
    assert "windows python" in ran
    assert len(ran) == len(told) / 2
    # Each is a command that there is.
    assert named_and_gone("\n".join(f"./dev {command}" for command in ran)) == set()


def test_commands_need_nothing_but_the_standard_library() -> None:
    # -S leaves out everything that is installed; -I the user's own paths.
    program = "import sys; sys.path.insert(0, sys.argv[1]); import tools.dev.cli"
    result = subprocess.run(
        [sys.executable, "-I", "-S", "-c", program, TREE],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.stderr == ""


def test_every_test_is_in_a_group_that_runs_at_every_change_or_in_a_slow_one() -> None:
    files = {str(file.relative_to(TREE)) for file in (TREE / "tests").rglob("test_*.py")}
    inside = {file for file in files if file.startswith("tests/vm/guest/")}
    assert inside
    left = [file for file in files if not any(group.has(file) for group in groups.GROUPS.values())]
    assert left == []
    slow = set((TREE / ".ci/slow").read_text(encoding="utf-8").splitlines())
    assert {f"test {name}" for name, group in groups.GROUPS.items() if group.slow} <= slow


@pytest.fixture
def stamps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(groups, "BUILD", tmp_path)
    monkeypatch.setattr(building, "digest", lambda names: f"{len(list(names)):08x}")
    return tmp_path


def test_group_that_passed_whole_is_left_out_until_what_it_covers_changes(
    stamps: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = groups.plan([])
    assert (list(first.groups), first.left_out) == (groups.EVERY_CHANGE, ())
    groups.remember(
        first.run, ["tests/python/test_knob.py::test_x", "tests/test_checks.py::test_y"]
    )
    second = groups.plan([])
    assert second.groups == ("checks", "library")
    assert set(second.groups) | set(second.left_out) == set(groups.EVERY_CHANGE)
    assert list(groups.plan(["all"]).groups) == groups.EVERY_CHANGE
    monkeypatch.setattr(
        building, "digest", lambda names: f"{len(list(names)):08x}{'docs/c.md' in names or ''}"
    )
    third = groups.plan([])
    assert third.groups == ("checks", "library", "interfaces")


@pytest.mark.parametrize(
    ("words", "chosen", "needs"),
    [
        ("-k wall", "library cpp", "asan-ubsan python release studies"),
        ("tests/board -k wall", "board", "firmware python studies"),
        ("tests/python/test_knob.py::test_x -x", "library", "python release studies"),
        ("threads", "threads", "python tsan"),
        ("tests/board/test_guards.py", "guards", "firmware python studies unguarded"),
    ],
)
def test_words_behind_test_choose_groups_and_what_is_built(
    stamps: Path, words: str, chosen: str, needs: str
) -> None:
    plan = groups.plan(words.split())
    assert " ".join(plan.groups) == chosen
    assert " ".join(sorted(plan.needs)) == needs


def test_part_of_a_group_that_passed_says_nothing_of_the_group(stamps: Path) -> None:
    for words in (["library", "-k", "wall"], ["tests/python"], ["-x"], ["library", "--lf"]):
        assert groups.plan(words).run == {}
    assert list(groups.plan(["library", "--durations=9"]).run) == ["library"]


@pytest.mark.parametrize("name", groups.GROUPS)
def test_digest_of_a_group_is_of_files_that_are_there(name: str) -> None:
    group = groups.GROUPS[name]
    assert [path for path in (*group.covers, *group.tests) if not (TREE / path).exists()] == []


def test_file_that_a_test_reads_must_be_covered() -> None:
    test = "tests/c/test_calls.py::test_x"
    files = [
        "docs/c.md",
        "docs/cpp.md",
        "build/x",
        "sdk/c/src/structures.cpp",
        "tests/c/layouts.py",
    ]
    assert groups.not_covered(test, files) == ["docs/cpp.md"]


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(running, "LOGS", tmp_path)
    return tmp_path


def test_failed_command_shows_its_end_and_names_its_log(
    logs: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    script = "for n in $(seq 100); do echo line $n; done; exit 3"
    with pytest.raises(running.Failed, match=rf"^'sh -c .*' failed; full log: {logs}/x\.log$"):
        running.run_logged("x", ["sh", "-c", script])
    shown = capfd.readouterr()
    assert shown.out == ""
    assert shown.err.splitlines() == [f"line {n}" for n in range(61, 101)]
    assert len((logs / "x.log").read_text().splitlines()) == 100


def test_command_that_does_not_exist_fails_in_a_sentence(logs: Path) -> None:
    with pytest.raises(running.Failed, match="no-such-program"):
        running.run_logged("x", ["no-such-program"])
    assert "no-such-program: No such file" in (logs / "x.log").read_text()


def test_commands_after_a_failed_one_do_not_run(logs: Path, tmp_path: Path) -> None:
    with pytest.raises(running.Failed):
        running.run_logged("x", ["false"], ["touch", tmp_path / "made"])
    assert not (tmp_path / "made").exists()


@pytest.mark.parametrize("to_its_end", [True, False])
def test_what_must_come_to_its_end_is_waited_for(tmp_path: Path, *, to_its_end: bool) -> None:
    # As apt, which leaves a system that nobody can install on if it is ended half-way.
    program = (
        "import pathlib, sys, time; from tools.dev import running\n"
        "running.LOGS = pathlib.Path(sys.argv[1])\n"
        "script = 'touch begun; sleep 2; touch ended'\n"
        "running.later(running.run_logged, 'x', ['sh', '-c', f'cd {sys.argv[1]}; {script}'],\n"
        f"              to_its_end={to_its_end})\n"
        "while not (running.LOGS / 'begun').exists(): time.sleep(0.01)\n"
        "running.stop_all()\n"
    )
    subprocess.run([sys.executable, "-c", program, tmp_path], cwd=TREE, check=True, timeout=60)
    assert (tmp_path / "ended").exists() == to_its_end


def test_stamp_is_written_only_after_success(tmp_path: Path) -> None:
    stamp = tmp_path / "folder/stamp"
    with running.stamped(stamp, "key"):
        assert not running.stamp_is(stamp, "key")
    assert running.stamp_is(stamp, "key")
    assert not running.stamp_is(stamp, "another")
    with pytest.raises(KeyboardInterrupt), running.stamped(stamp, "key"):
        raise KeyboardInterrupt
    assert not running.stamp_is(stamp, "key")


def test_nobody_who_cannot_become_root_is_told_what_to_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("os.geteuid", lambda: 1000)
    monkeypatch.setattr(running, "succeeds", lambda *_: False)
    monkeypatch.setattr("sys.stdin", io.StringIO())
    with pytest.raises(running.Failed, match=r"^no package; run: sudo apt-get install it$"):
        running.become_root("no package", "apt-get install it")
    monkeypatch.setattr(running, "succeeds", lambda *_: True)
    assert running.become_root("no package", "apt-get install it") == ["sudo"]


def test_missing_packages_are_told_where_there_is_no_apt(monkeypatch: pytest.MonkeyPatch) -> None:
    some = {"base": (("there", lambda: True), ("gone", lambda: False), ("lost", lambda: False))}
    monkeypatch.setattr(packages, "groups", lambda: some)
    monkeypatch.setattr("shutil.which", lambda _: None)
    with pytest.raises(running.Failed, match=r"no apt-get; on Debian it would be: .* gone lost$"):
        packages.begin_set_up(("base",))


PROJECT = {
    "build-system": {"requires": ["builder"]},
    "project": {
        "dependencies": ["library>=1"],
        "optional-dependencies": {
            "plot": ["drawing"],
            "studio": ["server"],
            "studies": ["numbers"],
            "dev": ["library==1.5", "checker==2"],
        },
    },
}


def test_demo_ends_with_how_to_open_the_page(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    done: Future[None] = Future()
    done.set_result(None)
    coming = environment.SetUp(done, done)
    monkeypatch.setattr(environment, "begin", lambda *_, **__: coming)
    monkeypatch.setattr(building, "build_preset", lambda *_: None)
    monkeypatch.setattr(building, "build_python", lambda *_: None)
    monkeypatch.setattr(commands, "run", lambda *_: 0)
    assert commands.demo([]) == 0
    assert "./dev studio" in capfd.readouterr().out
    # Who sits at a terminal is given the page itself.
    started: list[str] = []
    monkeypatch.setattr(building, "begin_studio", lambda *_: done)
    monkeypatch.setattr(commands, "become", lambda *words: started.extend(map(str, words)))
    for stream in (sys.stdin, sys.stdout):
        monkeypatch.setattr(stream, "isatty", lambda: True, raising=False)
    commands.demo([])
    assert started[1:4] == ["studio", "--device", "emulated"]
    assert "open this page" in capfd.readouterr().out
    # What a program reads stays JSON alone.
    assert commands.demo(["--json"]) == 0
    assert "./dev studio" not in capfd.readouterr().out


def test_demo_requires_no_more_than_it_runs_with() -> None:
    assert requirements(PROJECT, "demo") == ["builder", "library>=1", "drawing"]
    assert requirements(PROJECT, "page") == ["builder", "library>=1", "drawing", "server"]
    assert requirements(PROJECT, "pins") == ["library==1.5", "checker==2"]
    everything = requirements(PROJECT, "all")
    assert set(everything) == {"builder", "library>=1", "drawing", "library==1.5", "checker==2"}


def test_digest_changes_with_content_and_name_of_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(building, "TREE", tmp_path)
    (tmp_path / "a").mkdir()
    file = tmp_path / "a/b"
    seen = set()
    for name, text in (("b", ""), ("b", "x"), ("c", "x")):
        file = file.rename(file.with_name(name)) if file.exists() else file
        file.write_text(text)
        seen.add(building.digest(["a"]))
        assert building.digest(["a", "not there"]) == building.digest(["a"])
    assert len(seen) == 3


def test_network_of_this_machine_is_told_to_another(tmp_path: Path) -> None:
    certificate, wheels = tmp_path / "ca.crt", tmp_path / "wheels"
    certificate.write_bytes(b"trust me")
    wheels.mkdir()
    environment = {"HTTPS_PROXY": "http://p:1", "PIP_CERT": str(certificate), "HOME": "/root"}
    pip = f"global.index-url='https://i.example/simple'\n:env:.find-links='{wheels}'\n"
    npm = {"registry": "https://r.example/", "proxy": "null"}
    found = fresh.network(environment, pip, npm)
    moved = found.variables.pop("PIP_CERT")
    assert found.files == {moved: b"trust me"}
    mounted = found.variables.pop("PIP_FIND_LINKS")
    assert found.folders == {mounted: wheels}
    assert found.variables == {
        "PIP_INDEX_URL": "https://i.example/simple",
        "npm_config_registry": "https://r.example/",
        "HTTPS_PROXY": "http://p:1",
    }


def test_fresh_system_has_its_packages_from_this_systems_archive() -> None:
    archive = apt.Archive("http://a.example/debian", "")
    assert fresh.sources(archive, "sid", "debian").splitlines()[0] == (
        "deb http://a.example/debian sid main"
    )
    dump = (
        'APT::Architecture "amd64";\nAcquire::http::Proxy "http://p:1";\n'
        'Acquire::https::CaInfo "";\nAcquire::Languages "none";\n'
    )
    assert fresh.apt_settings(dump) == 'Acquire::http::Proxy "http://p:1";\n'


@pytest.mark.parametrize("suite", ["", "../etc", "Trixie", "-x", "a b"])
def test_bad_suite_is_refused(suite: str) -> None:
    with pytest.raises(running.UsageError, match="no suite"):
        fresh.run_in(suite, [["demo"]])
