"""Every file operation fails once: run by ``faults.py`` in a process that has ``failing.c`` in it.

``python -m tests.faults.files EVERY SCENARIO...`` prints a line of JSON for each injection.
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import json
import os
import signal
import sys
import tempfile
import threading
import traceback
import warnings
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

import torsio
from tests.faults.knobs import Device
from tests.python.test_firmware import StandIn, image
from torsio import calibration
from torsio.apps import bug_report
from torsio.apps.cli import app
from torsio.calibration import keeping
from torsio.trading.runs import Kept

OLD = "of yesterday"
ERRORS = {
    "no space": errno.ENOSPC,
    "I/O error": errno.EIO,
    "permission": errno.EACCES,
    "half written": 0,
    "blocks": -1,  # until a signal, or in another thread for good
    "slow": -2,
}
INTERRUPTS = 4  # leave the program's lines, end the wait; two come while it does what it must


class Failing:
    """The library that makes a call fail."""

    def __init__(self) -> None:
        self._library = ctypes.CDLL(None)
        self._library.fail_files.argtypes = [ctypes.c_char_p, ctypes.c_long, ctypes.c_int]
        self._library.file_calls.restype = ctypes.c_long
        self._library.file_failed.restype = ctypes.c_bool
        self._library.file_stands.restype = ctypes.c_bool

    def arm(self, folder: Path, at: int, error: int) -> None:
        """Let the call with this number fail that touches a file under the folder."""
        self._library.fail_files(str(folder).encode(), at, error)

    def stands(self) -> bool:
        """Whether a call stands still now."""
        return bool(self._library.file_stands())

    def disarm(self, at: int) -> int:
        """Give how many there were, but none if one had to fail and could not."""
        count = int(self._library.file_calls()) if self._library.file_failed() or at < 0 else 0
        self._library.fail_files(b"", -1, 0)
        return count


def interrupts(error: BaseException | None) -> bool:
    """Whether it is an interrupt."""
    return isinstance(error, KeyboardInterrupt)


class Interrupts:
    """Ctrl-C for the main thread while a file stands still, until it ends what it does."""

    def __init__(self, stands: Callable[[], bool]) -> None:
        self.count = 0
        self._stands, self._ended = stands, threading.Event()
        self._thread = threading.Thread(target=self._run)

    def _run(self) -> None:
        while not self._ended.wait(0.5 if self._stands() else 0.01):
            if self._stands():
                self.count += 1
                signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)

    def _handle(self, *_: object) -> None:
        if not self._ended.is_set():
            raise KeyboardInterrupt

    def during(self, act: Callable[[], Any]) -> None:
        before = signal.signal(signal.SIGINT, self._handle)
        self._thread.start()
        try:
            try:
                act()
            finally:
                self._ended.set()  # where one more may come
        finally:
            self._ended.set()
            self._thread.join()
            signal.signal(signal.SIGINT, before)


# Each works in a folder, then says what is wrong after this error.
Wrong = Callable[[BaseException | None], str]
Scenario = Callable[[Path], tuple[Callable[[], Any], Wrong]]


def sentence(raised: BaseException | None) -> str:
    """Say whether an error is neither the library's nor the system's with the file's name."""
    if raised is None or isinstance(raised, torsio.Error | KeyboardInterrupt):
        return ""
    if isinstance(raised, OSError) and raised.strerror and raised.filename:
        return ""
    return f"told by {type(raised).__name__}: {raised}"


def old_or_new(
    file: Path, act: Callable[[], Any], is_whole: Callable[[], Any]
) -> tuple[Callable[[], Any], Wrong]:
    """Do something that takes the place of a file: the old one stays, or the new one is whole."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(OLD)

    def wrong(raised: BaseException | None) -> str:
        if [path.name for path in file.parent.iterdir()] != [file.name]:
            return "something is left beside it"
        if file.read_bytes() == OLD.encode():
            return sentence(raised) if raised else "nothing was raised, nothing written"
        return sentence(raised) if is_whole() else "the new file is not whole"

    return act, wrong


def recording(folder: Path) -> tuple[Callable[[], Any], Wrong]:
    devices, file = [Device(), Device()], folder / "x.mcap"
    outer, knob = map(torsio.open, devices)
    recordings: list[torsio.RecordingFile] = []
    armed: list[bool] = []

    def act() -> None:
        outer.arm()
        try:
            with outer, knob, knob.record_to(file) as recording:
                recordings.append(recording)
                knob.arm()
                knob.sleep(0.2)
        finally:
            armed.extend(device.is_armed or not device.is_closed for device in devices)

    def is_whole_unless_told() -> bool:
        told = [error for error in raised_last if not (recordings and interrupts(error))]
        return torsio.load(file).whole or bool(told)

    raised_last: list[BaseException] = []
    act_and, wrong_file = old_or_new(file, act, is_whole_unless_told)

    def wrong(raised: BaseException | None) -> str:
        for recording in recordings:
            with contextlib.suppress(OSError):  # told already
                recording.close()  # what was interrupted is written by now
        if any(armed):
            return "armed"
        raised_last[:] = [raised] if raised else []
        return wrong_file(raised)

    return act_and, wrong


def configuration(folder: Path) -> tuple[Callable[[], Any], Wrong]:
    file = folder / "knob.json"
    with torsio.open("emulated") as knob:
        file.write_text(torsio.dump_config(knob), encoding="utf-8")

    def act() -> None:
        _command("config", "load", str(file), "--device", "emulated")

    return act, sentence


def _command(*arguments: str) -> None:
    result = CliRunner().invoke(app, list(arguments))
    told = [line for line in result.stderr.splitlines() if line.startswith("torsio: error: ")]
    if result.exit_code == 1 and len(told) == 1 and "Traceback" not in result.output:
        raise torsio.Error(told[0])
    if result.exit_code == 130:
        raise KeyboardInterrupt
    if result.exit_code != 0:
        raise result.exception or RuntimeError(result.output)


def _found() -> calibration.Calibration:
    if not _FOUND:
        with torsio.open("emulated") as knob:
            _FOUND.append(calibration.calibrate(knob, drift=True))
    return _FOUND[0]


_FOUND: list[calibration.Calibration] = []


def calibration_report(folder: Path) -> tuple[Callable[[], Any], Wrong]:
    found = _found()
    os.environ["XDG_DATA_HOME"] = str(folder)
    serial = str(found.conditions["serial"])
    return old_or_new(
        keeping.place_of(serial), lambda: keeping.keep(found), lambda: keeping.kept(serial)
    )


def report(folder: Path) -> tuple[Callable[[], Any], Wrong]:
    file = folder / "report.zip"
    return old_or_new(
        file,
        lambda: bug_report.collect("emulated", file, duration_s=0.1),
        lambda: zipfile.ZipFile(file).testzip() is None,
    )


def table(folder: Path) -> tuple[Callable[[], Any], Wrong]:
    file = folder / "x.csv"
    with torsio.open("emulated") as knob:
        recorded = torsio.Recorded(knob.record(0.05))
    return old_or_new(
        file, lambda: recorded.save(file), lambda: len(file.read_text().splitlines()) == 51
    )


def trade(folder: Path) -> tuple[Callable[[], Any], Wrong]:
    file, rows = folder / "kept.json", {"a": {"cpu_s": 1.0}, "b": {"cpu_s": 2.0}}
    Kept(file).get("old", lambda: rows["a"])
    stores: list[Kept] = []
    told: list[str] = []

    def act() -> None:
        stores.append(Kept(file))
        with warnings.catch_warnings(record=True) as caught:
            for name, row in rows.items():
                assert stores[0].get(name, partial(dict, row)) == row
        told.extend(str(warning.message) for warning in caught)

    def wrong(raised: BaseException | None) -> str:
        if raised and stores and not interrupts(raised):
            return f"a result is lost by {raised!r}"
        kept = {name: Kept(file).get(name, lambda: {}) for name in ("old", *rows)}
        if kept["old"] != rows["a"]:
            return "what was kept is gone"
        if raised:
            return sentence(raised)
        is_whole = kept == {"old": rows["a"], **rows}
        return "" if is_whole or any(str(file) in text for text in told) else "not told"

    return act, wrong


class _Board(StandIn):
    """Takes what is copied when it is looked for, in no thread: operations have an order."""

    def list_devices(self) -> list[torsio.ListedDevice]:
        copied = self.mount / "torsio.uf2"
        if copied.is_file() and copied.stat().st_size == len(image()):
            self._take()
        return super().list_devices()


def firmware_update(folder: Path) -> tuple[Callable[[], Any], Wrong]:
    file = folder / "torsio-pico2.uf2"
    file.write_bytes(image())
    board = _Board(folder)
    board.taking = threading.Thread()  # does nothing

    def wrong(raised: BaseException | None) -> str:
        board.knob.close()
        if raised is None:
            return "" if board.taken == image() else "not whole, and nothing was raised"
        frames = {frame.name for frame in traceback.extract_tb(raised.__traceback__)}
        # The library does not report errors of the stand-in's own files.
        return "" if frames & {"appear", "_take"} else sentence(raised)

    return lambda: torsio.update_firmware(file, host=board, timeout_s=1.0), wrong


SCENARIOS: dict[str, Scenario] = {
    "recording": recording,
    "configuration file": configuration,
    "calibration report": calibration_report,
    "bug report": report,
    "table": table,
    "trade's results": trade,
    "firmware update": firmware_update,
}


def trial(failing: Failing, scenario: Scenario, at: int, error: int) -> tuple[str, int]:
    """Let one operation fail; say what is wrong afterwards, and how many there were."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made).resolve()
        inside = folder / "files"
        inside.mkdir()
        tempfile.tempdir = str(folder)
        act, wrong = scenario(inside)
        raised: BaseException | None = None
        pester = Interrupts(failing.stands if error == ERRORS["blocks"] else lambda: False)
        failing.arm(folder, at, error)
        try:
            pester.during(act)
        except BaseException as caught:
            raised = caught
        finally:
            count = failing.disarm(at)
            tempfile.tempdir = None
        if pester.count > INTERRUPTS or bool(pester.count) != interrupts(raised):
            return f"{pester.count} interrupts, {raised!r} was raised", count
        if error == ERRORS["slow"] and raised:
            return f"slow, and told by {raised!r}", count
        try:
            return wrong(raised), count
        except Exception as caught:
            return f"{type(caught).__name__} afterwards: {caught}", count


def main(every: int, names: list[str]) -> None:
    """Run scenarios, all if none is named, with each of their operations failing in each way."""
    failing = Failing()
    for name in names or SCENARIOS:
        _, count = trial(failing, SCENARIOS[name], -1, 0)
        for kind, error in ERRORS.items():
            for at in range(0, count, every):
                said, done = trial(failing, SCENARIOS[name], at, error)
                if done:  # a call that is no write is not half done
                    print(json.dumps([name, kind, said, f"operation {at}"]), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:])
