"""Ctrl-C ends a waiting call at once and leaves the knob disarmed."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import pytest

import torsio

PROGRAM = """
import sys, torsio
with torsio.open("emulated", emulator=torsio.EmulatorOptions(paced=True)) as knob:
    knob.play(torsio.Wall(stiffness_nm_per_rad=1.0))
    knob.arm()
    print("ready", flush=True)
    try:
        {call}
    except KeyboardInterrupt:
        print("interrupted", knob.state, flush=True)
        raise
"""

CALLS = {
    "record": "knob.record(duration_s=60.0)",
    "read": "knob.read(timeout_s=60.0)",
    "sleep": "knob.sleep(60.0)",
    "wait_for": "knob.wait_for('fault', timeout_s=60.0)",
    "telemetry": "list(knob.telemetry(duration_s=60.0))",
    "advance": "knob.emulator.advance(60.0)",
    "play": "[knob.play(torsio.Wall(stiffness_nm_per_rad=0.1 + n % 9 / 10)) for n in range(10**6)]",
    "stream": "[knob.stream_local_model(deadline_s=60.0) for n in range(10**7)]",
    "unpaced": "torsio.open('emulated').sleep(1e7)",
    "opening": "[torsio.open('emulated').close() for n in range(10**6)]",
}


@pytest.mark.parametrize("call", CALLS)
def test_interrupt_ends_call_at_once(call: str) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM.format(call=CALLS[call])],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=20)  # a third of the calls' time
    finally:
        process.kill()
    assert "KeyboardInterrupt" in errors
    assert output.startswith("interrupted armed")  # closing then disarms
    assert process.returncode == -signal.SIGINT


@pytest.mark.parametrize("call", ["record", "sleep", "telemetry"])
def test_interrupt_from_within_the_process_ends_call_at_once(call: str) -> None:
    # The same as Ctrl-C on Windows, where no process can send it to another.
    timer = "threading.Timer(0.3, _thread.interrupt_main).start(); "
    program = "import _thread, threading" + PROGRAM.format(call=timer + CALLS[call])
    result = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True, text=True, timeout=40, check=False,
    )  # fmt: skip
    assert "KeyboardInterrupt" in result.stderr
    assert result.stdout.startswith("ready\ninterrupted armed")
    assert result.returncode != 0


IN_CALLBACK = """
import os, signal, torsio
knob = torsio.open("emulated")
def interrupt(event):
    knob.on_event(None)
    os.kill(os.getpid(), signal.SIGINT)
knob.on_event(interrupt)
try:
    knob.arm()
except KeyboardInterrupt:
    print("interrupted")
"""


def test_interrupt_in_an_event_callback_goes_on_to_the_program() -> None:
    result = subprocess.run(
        [sys.executable, "-c", IN_CALLBACK], capture_output=True, text=True, timeout=20, check=False
    )
    assert result.stdout == "interrupted\n", result.stderr
    assert result.stderr == ""


def test_no_python_code_runs_when_a_closed_knob_goes() -> None:
    # Python drops a Ctrl-C that falls into such code.
    knob = torsio.open("emulated")
    knob.close()
    called = []
    sys.setprofile(lambda frame, event, _: called.append(f"{event} {frame.f_code.co_name}"))
    del knob
    sys.setprofile(None)
    assert [call for call in called if call.startswith("call")] == []
