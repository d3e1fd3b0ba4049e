"""How a program ends while the library is at work: exit, fork, signals, what is left of data."""

from __future__ import annotations

import gc
import signal
import subprocess
import sys
import threading
import time
import weakref
from contextlib import suppress

import pytest

import torsio
from tests.faults.knobs import device
from tests.python.processes import python
from torsio.common.worker import Worker

OPEN = """
import os, signal, sys, threading, time, torsio
paced = torsio.EmulatorOptions(paced=True)
# CPython itself aborts if threads print their last words while it ends.
threading.excepthook = lambda arguments: None
"""

# Each leaves threads inside the library when the interpreter ends.
AT_EXIT = {
    "watch": "w = torsio.watch(lambda event: None)",
    "recording": """
knob = torsio.open("emulated", emulator=paced)
knob.arm()
threading.Thread(target=lambda: knob.record(60.0), daemon=True).start()
time.sleep(0.1)
""",
    "asking": """
knob = torsio.open("emulated", emulator=paced)
def ask():
    while True:
        knob.health()
for _ in range(4):
    threading.Thread(target=ask, daemon=True).start()
time.sleep(0.1)
""",
    "many": """
def use():
    while True:
        with torsio.open("emulated") as knob:
            knob.play(torsio.Constant(torque_nm=0.01))
            knob.record(0.05)
for _ in range(4):
    threading.Thread(target=use, daemon=True).start()
time.sleep(0.2)
""",
    "generator": """
def begin():
    knob = torsio.open("emulated", emulator=paced)
    knob.arm()
    return knob.telemetry()
outlives = begin()
next(outlives)
""",
    "waiting": """
sys.setswitchinterval(10.0)  # who waits for Python's lock has it when Python ends
def use():
    while True:
        try:
            with torsio.open("emulated") as knob:
                knob.sleep(100.0)
        except torsio.Error:
            pass
for _ in range(4):
    threading.Thread(target=use, daemon=True).start()
time.sleep(0.2)
end = time.monotonic() + 0.1
while time.monotonic() < end:
    pass
""",
    "closing": """
sys.setswitchinterval(1e-6)
def use():
    while True:
        torsio.open("emulated").close()
for _ in range(4):
    threading.Thread(target=use, daemon=True).start()
time.sleep(0.1)
""",
    "callback": """
knob = torsio.open("emulated", emulator=paced)
knob.on_event(lambda event: time.sleep(0.001))
def toggle():
    while True:
        knob.arm()
        knob.disarm()
threading.Thread(target=toggle, daemon=True).start()
time.sleep(0.2)
""",
    "batch": """
from torsio.batch import Knobs, LoopOptions
hand = torsio.FeedbackHand(torque_nm=lambda *_: 0.0)
asleep = Knobs(64, threads=4)
asleep.step(100)
def step(knobs):
    while True:
        knobs.step()
for options in (None, LoopOptions(hand=hand)):
    threading.Thread(target=step, args=[Knobs(1024, options, threads=3)], daemon=True).start()
time.sleep(0.2)
""",
}


def run(program: str, timeout_s: float = 60.0) -> subprocess.CompletedProcess[str]:
    return python(OPEN + program, timeout=timeout_s)


@pytest.mark.parametrize("kind", AT_EXIT)
def test_interpreter_ends_well_with_threads_inside_the_library(kind: str) -> None:
    for _ in range(3):
        result = run(AT_EXIT[kind])
        assert result.returncode == 0, result.stderr
        assert "Fatal" not in result.stderr
        assert "terminate" not in result.stderr


def test_open_knob_is_disarmed_at_exit_though_a_thread_uses_it() -> None:
    # The last to be told is a function that was registered first.
    result = run(
        """
import atexit
knob = torsio.open("emulated", emulator=paced)
kept = []
knob.on_event(lambda event: kept.append(event.state))
knob.arm()
threading.Thread(target=lambda: knob.sleep(60), daemon=True).start()
time.sleep(0.1)
from torsio.knob import knob as module
module._close_all()
print(kept[-1], knob.is_open)
"""
    )
    assert result.stdout.split() == ["disarmed", "False"], result.stderr


@pytest.mark.parametrize(
    "begin", ["threading.Thread(target=wait).start()", "ThreadPoolExecutor().submit(wait)"]
)
def test_exception_that_ends_the_main_thread_disarms_though_a_thread_waits(begin: str) -> None:
    ended = run(
        f"""
from concurrent.futures import ThreadPoolExecutor
knob = torsio.open("emulated", emulator=paced)
knob.arm()
def wait():
    try:
        knob.wait_for("fault", timeout_s=1e6)
    except torsio.Closed:
        print("closed")
{begin}
raise MemoryError
"""
    )
    assert ended.stdout == "closed\n"
    assert ended.stderr.count("Traceback") == 1


def test_thread_that_outlives_the_main_thread_keeps_its_knob() -> None:
    ended = run(
        """
knob = torsio.open("emulated", emulator=paced)
knob.arm()
def go_on():
    time.sleep(0.5)
    print(knob.health().state)
threading.Thread(target=go_on).start()
"""
    )
    assert (ended.stdout, ended.stderr) == ("armed\n", "")


def test_watch_that_ends_with_python_waits_for_nobody() -> None:
    done = run("""
import time, torsio
def watching():
    with torsio.watch(print) as watch:
        yield watch
ends_last = watching()
next(ends_last)
""")
    assert done.returncode == 0, done.stderr


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_worker_that_raises_has_ended() -> None:
    def work() -> None:
        raise MemoryError

    worker = Worker(work)
    worker.start()
    worker.join()
    assert not worker.runs


def test_worker_works_while_another_thread_sets_its_trace_function() -> None:
    done = threading.Event()
    worker = Worker(done.set)

    class Tracer:
        def __call__(self, *_: object) -> None: ...

        def __del__(self) -> None:  # within the call that sets another one
            worker.start()
            worker.join()

    before = sys.gettrace()
    threading.settrace(lambda *_: None)
    sys.settrace(Tracer())
    sys.settrace(before)
    threading.settrace(None)
    assert done.is_set()


def test_forked_child_with_an_open_knob_ends_and_may_open_its_own() -> None:
    result = run(
        """
knob = torsio.open("emulated", emulator=paced)
watch = torsio.watch(lambda event: None)
knob.arm()
child = os.fork()
if child == 0:
    words = [str(knob.is_open), str(watch.is_stopped)]
    try:
        knob.health()
    except torsio.Closed as error:
        words.append("forked" if "forked" in str(error) else str(error))
    with torsio.open("emulated", emulator=paced) as own:
        words.append(str(len(own.record(0.05))))
    print(*words, flush=True)
    sys.exit(3)
_, status = os.waitpid(child, 0)
print(os.waitstatus_to_exitcode(status), knob.health().state)
"""
    )
    assert result.stdout.split() == ["False", "True", "forked", "50", "3", "armed"], result.stderr


def test_child_that_an_event_callback_forks_ends() -> None:
    result = run(
        """
told = threading.Event()
children = []
def fork(event):
    if not children:
        children.append(os.fork())
        told.set()
knob = torsio.open("emulated", emulator=paced)
knob.on_event(fork)
knob.arm()
told.wait()
_, status = os.waitpid(children[0], 0)
print(os.waitstatus_to_exitcode(status), knob.health().state)
"""
    )
    assert result.stdout.split() == ["0", "armed"], result.stderr


def test_interrupted_recording_has_its_samples() -> None:
    result = run(
        """
with torsio.open("emulated", emulator=paced) as knob:
    threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    try:
        knob.record(60.0)
    except KeyboardInterrupt as error:
        print(len(error.samples) > 100, error.samples["tick"][0] >= 0)
    print(len(knob.read(timeout_s=0.0)) > 100)
    knob.read()
    time.sleep(0.1)
    print(len(knob.read(timeout_s=0.05)))
"""
    )
    assert result.stdout.split() == ["True", "True", "True", "0"], result.stderr


def test_recording_without_its_torque_says_so() -> None:
    with torsio.open("emulated") as knob:
        knob.arm()
        knob.stream_local_model(torque_nm=0.01, deadline_s=0.02)
        with pytest.warns(torsio.DisarmedWarning, match="deadline_missed"):
            assert len(knob.record(0.2)) == 200
        assert knob.last_disarm is not None
        assert knob.last_disarm.reason == "deadline_missed"
        knob.arm()
        knob.stream_local_model(torque_nm=0.01, deadline_s=0.02)
        with pytest.raises(torsio.Disarmed, match="deadline") as caught:
            knob.record(10.0, must_stay_armed=True)
        assert caught.value.reason == "deadline_missed"
        assert 10 < len(caught.value.samples) < 1000  # type: ignore[attr-defined]
        with pytest.raises(torsio.Refused) as refused:
            knob.stream_local_model(torque_nm=0.01)
        assert refused.value.reason == "deadline_missed"


def test_events_and_callback_tell_the_same() -> None:
    told: list[torsio.Event] = []
    with torsio.open("emulated") as knob:
        knob.on_event(told.append)
        knob.arm()
        knob.emulator.set_actuator_fault(present=True)
        assert knob.wait_for("fault")
        taken = knob.events()
        assert taken == told
        assert [event.state for event in taken] == ["armed", "fault"]
        assert taken[-1].faults == ("actuator",)
        knob.on_event(None)
        with pytest.raises(TypeError, match="callback"):
            knob.on_event(3)  # type: ignore[arg-type]


# In a process of its own: a hang in here would keep the interpreter from ending.
CLOSING = """
knob = torsio.open("emulated", emulator=torsio.EmulatorOptions(paced={paced}))
told = threading.Event()
def hear(event):
    told.set()
    time.sleep(0.05)
    knob.close()
knob.on_event(hear)
try:
    knob.arm()
    told.wait()
    if {also}: knob.close()
    while True: knob.sleep(0.01)
except torsio.Closed:
    print("closed")
"""


@pytest.mark.parametrize("paced", [True, False])
@pytest.mark.parametrize("also", [True, False])
def test_callback_may_close_its_knob_also_while_others_do(also: bool, paced: bool) -> None:
    ended = run(CLOSING.format(paced=paced, also=also))
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "closed\n", "")


@pytest.mark.parametrize("paced", [True, False])
@pytest.mark.parametrize("closed", [True, False])
def test_knob_whose_callback_has_it_goes_with_the_last_who_knows_it(
    closed: bool, paced: bool
) -> None:
    knob = torsio.open("emulated", emulator=torsio.EmulatorOptions(paced=paced))

    def hear(_: torsio.Event, knob: torsio.Knob = knob) -> None:
        with suppress(torsio.Closed):  # while it is told
            knob.health()

    knob.on_event(hear)
    knob.arm()
    if closed:
        knob.close()
    gone: list[weakref.ref[object]] = [weakref.ref(knob), weakref.ref(hear)]
    del knob, hear
    until = time.monotonic() + 10.0  # the callback may be at work
    while any(reference() for reference in gone) and time.monotonic() < until:
        gc.collect()
    assert [reference() for reference in gone] == [None, None]


def test_a_thousand_knobs_in_reference_cycles_stay_small() -> None:
    result = run(
        """
import gc, re
from pathlib import Path
gc.disable()
def cycle():
    knob = torsio.open("emulated")
    knob.me = knob
    knob.record(0.01)
for _ in range(300):
    cycle()
# Not `ru_maxrss`, which a program has from the one that began it.
print(int(re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())[1]) // 1024)
""",
        timeout_s=300,
    )
    # 300 filled rings would be 1.1 GB.
    assert int(result.stdout) < 500, result.stderr


def test_a_thousand_open_knobs_touch_little_memory() -> None:
    result = run(
        """
import resource
torsio.open("emulated").close()
def pages():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt
before = pages()
knobs = [torsio.open("emulated") for _ in range(1000)]
print((pages() - before) * resource.getpagesize())
""",
    )
    # The kernel's search for memory would make it slow: 3.6 MB each if rings were filled.
    assert int(result.stdout) < 1000 * 300_000, result.stderr


@pytest.mark.parametrize("stop", [signal.SIGTERM, signal.SIGINT])
def test_signal_ends_a_program_at_once(stop: signal.Signals) -> None:
    program = (
        OPEN + "k = torsio.open('emulated', emulator=paced)\nprint(1, flush=True)\nk.sleep(60)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.send_signal(stop)
        assert process.wait(20) == -stop


def test_what_a_callback_raises_is_shown_and_ends_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    shown: list[object] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda args: shown.append(args.exc_value))

    def fail(_: torsio.Event) -> None:
        raise RuntimeError("of the callback")

    with torsio.open("emulated") as knob:
        knob.on_event(fail)
        knob.arm()
        knob.disarm()
        knob.on_event(None)
    assert [str(error) for error in shown] == ["of the callback"] * 2


@pytest.mark.parametrize("paced", [False, True])
@pytest.mark.parametrize("in_thread", [False, True])
def test_what_is_no_exception_goes_on_from_a_callback_to_the_main_thread(
    in_thread: bool, paced: bool
) -> None:
    def leave(_: torsio.Event) -> None:
        knob.on_event(None)
        raise SystemExit(7)

    def use() -> None:
        knob.arm()
        knob.sleep(30.0)

    def keep() -> None:
        try:
            use()
        except BaseException as error:
            ended.append(error)

    def run() -> None:
        knob.update(watchdog_s=60.0)
        knob.on_event(leave)
        if not in_thread:
            use()
        threading.Thread(target=keep, daemon=True).start()
        while time.monotonic() - begin_s < 10.0:
            pass

    made = device(paced=paced)
    ended: list[BaseException] = []
    begin_s = time.monotonic()
    with torsio.open(made) as knob, pytest.raises(SystemExit, match="7"):
        run()
    assert time.monotonic() - begin_s < 10.0
    assert not made.is_armed
    assert not any(isinstance(error, SystemExit) for error in ended)
