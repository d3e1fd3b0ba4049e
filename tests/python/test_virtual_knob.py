"""``torsio emulate`` as it is installed: what it prints, refuses, and how it ends."""

from __future__ import annotations

import contextlib
import os
import pty
import re
import select
import signal
import socket
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import torsio
from torsio import virtual_knob
from torsio.virtual_knob import terminal
from torsio.virtual_knob.terminal import Key, KeyboardHand, Mouse, MouseHand

TORSIO = str(Path(sys.executable).with_name("torsio"))
EMULATE = (TORSIO, "emulate")


@contextmanager
def emulated(*arguments: str) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """Run a virtual knob on a free port; yield the process and the port."""
    process = subprocess.Popen(
        [*EMULATE, "--port", "0", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        assert process.stdout is not None
        first = process.stdout.readline()
        match = re.fullmatch(r"listening \S+:(\d+) 1-1\n", first)
        assert match, first + (process.stderr.read() if process.stderr else "")
        yield process, int(match.group(1))
    finally:
        # With the program underneath, which holds the same pipes.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def end(process: subprocess.Popen[str], how: signal.Signals = signal.SIGINT) -> tuple[str, str]:
    process.send_signal(how)
    process.wait(timeout=30)
    # communicate() would miss the text that readline() has buffered.
    assert process.stdout is not None
    assert process.stderr is not None
    return process.stdout.read(), process.stderr.read()


def attach(port: int) -> socket.socket:
    client = socket.create_connection(("127.0.0.1", port))
    client.sendall(struct.pack(">HHI32s", 0x0111, 0x8003, 0, b"1-1"))
    answer = b""
    client.settimeout(20)
    while len(answer) < 320:
        part = client.recv(4096)
        if not part:
            raise ConnectionResetError
        answer += part
    assert answer[:8] == struct.pack(">HHI", 0x0111, 0x0003, 0)
    return client


def refused(*arguments: str) -> str:
    result = subprocess.run(
        [*EMULATE, *arguments], capture_output=True, text=True, timeout=60, check=False
    )
    assert result.returncode == 2, result.stdout + result.stderr
    assert "Traceback" not in result.stderr
    assert result.stdout == ""
    return result.stderr


def test_it_prints_the_command_that_attaches_it_and_ends_on_ctrl_c() -> None:
    with emulated() as (process, port):
        output, errors = end(process)
    assert process.returncode == 0
    assert errors == ""
    command = f"sudo usbip --tcp-port {port} attach -r 127.0.0.1 -b 1-1"
    assert f"sudo modprobe vhci-hcd; {command}" in output


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_cleanly_with_a_client_attached(how: signal.Signals) -> None:
    with emulated() as (process, port), attach(port) as client:
        assert process.stdout is not None
        while not re.fullmatch(r"attached 127\.0\.0\.1:\d+\n", process.stdout.readline()):
            assert process.poll() is None
        _, errors = end(process, how)
        client.settimeout(20)
        assert client.recv(1) == b""
    assert process.returncode == 0
    assert errors == ""


def test_killed_it_leaves_nothing_that_listens() -> None:
    with emulated() as (process, port):
        process.kill()
        process.wait()
        deadline = time.monotonic() + 30
        with contextlib.suppress(ConnectionRefusedError):
            while True:
                socket.create_connection(("127.0.0.1", port)).close()
                assert time.monotonic() < deadline
                time.sleep(0.02)


def test_it_goes_on_though_nobody_reads_its_output() -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(writer, bytes(4096))
    os.set_blocking(writer, True)
    program = [str(virtual_knob.program_path()), "--port", str(port), "--status"]
    with subprocess.Popen(program, stdin=subprocess.DEVNULL, stdout=writer) as process:
        try:
            deadline = time.monotonic() + 30
            for _ in range(3):  # it has told of its port, and then of each that came and went
                while True:
                    assert time.monotonic() < deadline
                    with contextlib.suppress(ConnectionError), attach(port):
                        break
                    time.sleep(0.05)
                time.sleep(0.2)
        finally:
            process.terminate()
            process.wait(20)
            os.close(writer)
            os.close(reader)


def test_program_that_is_killed_is_said() -> None:
    with emulated() as (process, port), attach(port):
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        os.kill(int(children[0]), signal.SIGKILL)
        assert process.wait(30) == 1
        assert process.stderr is not None
        errors = process.stderr.read()
    assert errors.startswith("torsio: error: SIGKILL ended the knob's program")


def test_port_in_use_is_said_with_status_2() -> None:
    with emulated() as (_, port):
        assert f"port {port} is in use" in refused("--port", str(port))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--port", "70000"), "--port"),
        (("--hand", "keyboard"), "needs a terminal"),
        (("--hand", "mouse"), "needs a terminal"),
        (("--port", "0", "--address", "localhost"), "not an IPv4 address"),
        (("--port", "0", "--serial", "seventeen letters"), "serial"),
        (("--port", "0", "--hand", "scripted:/nowhere/hand.txt"), "/nowhere/hand.txt"),
    ],
)
def test_what_cannot_be_is_refused_with_status_2(arguments: tuple[str, ...], words: str) -> None:
    assert words in refused(*arguments)


def test_another_address_than_loopback_is_warned_of() -> None:
    with emulated("--address", "0.0.0.0") as (process, _):
        output, errors = end(process)
    assert "warning: anybody who reaches 0.0.0.0 can use this knob" in errors
    assert "attach -r 127.0.0.1" in output


def test_log_holds_the_truth_at_every_control_tick(tmp_path: Path) -> None:
    script, log = tmp_path / "hand.txt", tmp_path / "truth.csv"
    script.write_text("motion_rad\n0 0\n1 0.5 # rad\n")
    with emulated("--hand", f"scripted:{script}", "--log", str(log), "--rate-hz", "2000") as (
        process,
        _,
    ):
        deadline = time.monotonic() + 30
        while log.stat().st_size < 10_000 and time.monotonic() < deadline:
            time.sleep(0.1)
        end(process)
    header, *rows = log.read_text().splitlines()
    assert header == "time_ns,angle_rad,motor_torque_nm,brake_torque_nm,hand_torque_nm"
    assert len(rows) > 100
    for n, row in enumerate(rows):
        time_ns, angle, *_ = row.split(",")
        assert int(time_ns) == 500_000 * n
        assert float(angle) == pytest.approx(min(0.5e-9 * int(time_ns), 0.5), abs=1e-9)


def test_storage_goes_to_the_program_which_refuses_what_is_none(tmp_path: Path) -> None:
    bad = tmp_path / "bad"
    bad.write_text("no storage")
    assert "is no file that a virtual knob has written" in refused("--storage", str(bad))
    with emulated("--storage", str(tmp_path / "new")) as (process, _):
        end(process)
    assert process.returncode == 0


def test_log_that_cannot_be_written_is_said_with_status_1() -> None:
    result = subprocess.run(
        [*EMULATE, "--port", "0", "--log", "/nowhere/truth.csv"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert result.returncode == 1
    assert "/nowhere/truth.csv" in result.stderr


# A person at a terminal --------------------------------------------------------------------------


@pytest.mark.parametrize("system", ["win32", "darwin"])
def test_other_system_is_told_to_run_the_program_on_linux(
    monkeypatch: pytest.MonkeyPatch, system: str
) -> None:
    monkeypatch.setattr(sys, "platform", system)
    with pytest.raises(torsio.Error, match="program for Linux: run it there"):
        virtual_knob.program_path()


def test_terminal_input_is_read_in_pieces_of_any_size() -> None:
    data = b"\x1b[C\x1b[D \x1b[<0;10;3M\x1b[<32;12;3M\x1b[<0;12;3m\x1b[15~q\x1bOA"
    expected = [
        Key("right"),
        Key("left"),
        Key(" "),
        Mouse("press", 10),
        Mouse("move", 12),
        Mouse("release", 12),
        Key("q"),
        Key("up"),
    ]
    assert list(terminal.Input().feed(data)) == expected
    reader = terminal.Input()
    assert [event for byte in data for event in reader.feed(bytes([byte]))] == expected


def test_keys_push_harder_and_space_lets_go() -> None:
    hand = KeyboardHand()
    assert hand.follow(Key("right"), 0.0) == "torque 0.005"
    assert hand.follow(Key("right"), 0.0) == "torque 0.010"
    assert hand.follow(Key(" "), 0.0) == "free"
    assert hand.follow(Key("left"), 0.0) == "torque -0.005"
    assert hand.follow(Key("x"), 0.0) is None
    commands = [hand.follow(Key("left"), 0.0) for _ in range(50)]
    assert commands[-1] == "torque -0.100"


def test_mouse_turns_the_knob_from_where_it_is_taken() -> None:
    hand = MouseHand()
    assert hand.follow(Mouse("press", 40), 1.0) == "angle 1.000000"
    assert hand.follow(Mouse("move", 41), 1.0) == "angle 1.052360"
    assert hand.follow(Mouse("move", 39), 1.0) == "angle 0.947640"
    assert hand.follow(Mouse("release", 39), 1.0) == "free"
    assert hand.follow(Key("right"), 1.0) is None


def _read_until(master: int, pattern: bytes, timeout_s: float = 30) -> bytes:
    seen = b""
    deadline = time.monotonic() + timeout_s
    while not re.search(pattern, seen):
        assert time.monotonic() < deadline, seen
        if select.select([master], [], [], 0.5)[0]:
            seen += os.read(master, 4096)
    return seen


@pytest.mark.parametrize("hand", ["keyboard", "mouse"])
def test_person_at_a_terminal_turns_the_knob_and_gets_the_terminal_back(hand: str) -> None:
    master, slave = pty.openpty()
    before = termios.tcgetattr(slave)
    process = subprocess.Popen(
        [*EMULATE, "--port", "0", "--hand", hand],
        stdin=slave,
        stdout=slave,
        stderr=slave,
        start_new_session=True,
    )
    try:
        seen = _read_until(master, rb"hand +[-0-9.]+ mN")
        assert (b"\x1b[?1002h\x1b[?1006h" in seen) == (hand == "mouse")
        if hand == "keyboard":
            os.write(master, b"\x1b[C" * 8)
        else:
            os.write(master, b"\x1b[<0;10;5M\x1b[<32;30;5M")
        seen += _read_until(master, rb" [1-9][0-9]*\.[0-9]\xc2\xb0")  # it has turned
        assert b"disarmed" in seen
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=30) == 0
        if hand == "mouse":
            _read_until(master, rb"\x1b\[\?1006l\x1b\[\?1002l")
        assert termios.tcgetattr(slave) == before
    finally:
        process.kill()
        process.wait()
        os.close(master)
        os.close(slave)
