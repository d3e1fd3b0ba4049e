"""Runs programs: with a log, in the background, as root, one ``./dev`` at a time."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn, ParamSpec, TypeVar

TREE = Path(__file__).parent.parent.parent
BUILD = TREE / "build"
LOGS = BUILD / "logs"

_TAIL_LINES = 40
_TAIL_COLUMNS = 300

Word = str | Path
Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


class Failed(Exception):
    """A step failed; says what, in a sentence."""


class UsageError(Exception):
    """The arguments make no sense; says why, in a sentence."""


def say(text: str) -> None:
    """Tell the user what is being done."""
    print(f"torsio: {text}", flush=True)


def shown(path: Path) -> str:
    """Return a path as the user would type it at the top of the tree."""
    return str(path.relative_to(TREE)) if path.is_relative_to(TREE) else str(path)


# --- programs ------------------------------------------------------------------------------------

_children: set[subprocess.Popen[bytes]] = set()
_children_lock = threading.Lock()
_is_stopping = threading.Event()


def _call(
    command: Sequence[Word], output: Path, environment: dict[str, str], *, to_its_end: bool
) -> int:
    with output.open("ab") as log, _children_lock:
        if _is_stopping.is_set():
            raise Failed("interrupted")
        child = subprocess.Popen(
            command, cwd=TREE, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log
        )
        if not to_its_end:
            _children.add(child)
    try:
        return child.wait()
    finally:
        with _children_lock:
            _children.discard(child)


def run_logged(
    name: str,
    *commands: Sequence[Word],
    attempts: int = 1,
    to_its_end: bool = False,
    **variables: str,
) -> None:
    """Run commands one after the other and keep their output in ``build/logs/NAME.log``.

    Parameters
    ----------
    name
        Of the log.
    commands
        Each runs at the top of the tree.
    attempts
        How often to begin again, all of them, after a failure.
    to_its_end
        Never to be ended by `stop_all`: this program waits for it before it ends itself.
    variables
        For their environment, on top of this program's own.

    Raises
    ------
    Failed
        If one of them does not end well. Shows the end of its output before.
    """
    LOGS.mkdir(parents=True, exist_ok=True)
    log = LOGS / f"{name}.log"
    log.write_bytes(b"")
    failed: Sequence[Word] = ()
    for attempt in range(1, attempts + 1):
        for command in commands:
            try:
                status = _call(command, log, {**os.environ, **variables}, to_its_end=to_its_end)
            except OSError as error:
                with log.open("a", encoding="utf-8") as text:
                    text.write(f"{command[0]}: {error.strerror}\n")
                status = 127
            if status != 0:
                failed = command
                break
        else:
            return
        if attempts > 1:
            with log.open("a", encoding="utf-8") as text:
                text.write(f"attempt {attempt} failed\n")
            _is_stopping.wait(5 if attempt < attempts else 0)
    if not _is_stopping.is_set():
        show_end(log)
    words = " ".join(str(word) for word in failed)
    raise Failed(f"'{words}' failed; full log: {shown(log)}")


def show_end(log: Path) -> None:
    """Print the last lines of a log, for a failure to be understood without opening it."""
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()[-_TAIL_LINES:]
    print(*(line[:_TAIL_COLUMNS] for line in lines), sep="\n", file=sys.stderr)


def succeeds(*command: Word, text: str | None = None) -> bool:
    """Tell whether a program is there and ends well, whatever it prints."""
    try:
        result = subprocess.run(
            command,
            input=text.encode() if text is not None else b"",
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            check=False,
        )
    except OSError:
        return False
    return result.returncode == 0


def output_of(*command: Word) -> str:
    """Return what a program prints; nothing if it is not there or fails."""
    try:
        return subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=True
        ).stdout
    except (OSError, subprocess.CalledProcessError):
        return ""


def run(*command: Word) -> int:
    """Run a program that speaks to the user itself, and return its status."""
    sys.stdout.flush()
    return subprocess.run(command, cwd=TREE, check=False).returncode


def become(*command: Word) -> NoReturn:
    """Let a program take the place of this one, its terminal and its status included.

    Raises
    ------
    Failed
        If it cannot be started.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    words = [str(word) for word in command]
    try:
        os.execvp(words[0], words)
    except OSError as error:
        raise Failed(f"{words[0]} cannot be run: {error.strerror}") from None


def without_aslr(*command: Word) -> tuple[Word, ...]:
    """Return the command with the kernel's randomising of addresses turned off, where that works.

    GCC's thread sanitizer up to version 13 gives up on kernels that randomise strongly.
    """
    prefix = ("setarch", os.uname().machine, "-R")
    return (*prefix, *command) if succeeds(*prefix, "true") else command


# --- in the background ---------------------------------------------------------------------------

_pool = ThreadPoolExecutor(8)


def later(
    function: Callable[Parameters, Result], *args: Parameters.args, **kwargs: Parameters.kwargs
) -> Future[Result]:
    """Begin something that mostly waits, for the network for example; ``result()`` awaits it."""
    return _pool.submit(function, *args, **kwargs)


def stop_all() -> None:
    """End every program in the background that may be ended, and begin none any more."""
    _is_stopping.set()
    with _children_lock:
        for child in _children:
            try:
                child.terminate()
            except PermissionError:  # runs as root; the terminal interrupts it itself
                continue
    _pool.shutdown(wait=False, cancel_futures=True)


# --- rights and turns ----------------------------------------------------------------------------


def become_root(need: str, line: str) -> list[str]:
    """Return the words before a command that needs root.

    Raises
    ------
    Failed
        If nobody can become root here. Says ``need``, and the ``line`` to run by hand.
    """
    if os.geteuid() == 0:
        return []
    if succeeds("sudo", "-n", "true"):
        return ["sudo"]
    if sys.stdin.isatty() and shutil.which("sudo") and run("sudo", "-v") == 0:
        return ["sudo"]
    raise Failed(f"{need}; run: sudo {line}")


@contextmanager
def lock() -> Iterator[None]:
    """Let one ``./dev`` of this tree set up and build at a time."""
    BUILD.mkdir(exist_ok=True)
    with (BUILD / ".lock").open("a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            say("waiting for another ./dev in this tree")
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


# --- stamps --------------------------------------------------------------------------------------


def stamp_is(stamp: Path, key: str) -> bool:
    """Tell whether a step has been done with these inputs."""
    try:
        return stamp.read_text(encoding="utf-8") == key
    except OSError:
        return False


@contextmanager
def stamped(stamp: Path, key: str) -> Iterator[None]:
    """Write a stamp once a step has succeeded; an interrupted step leaves none."""
    stamp.unlink(missing_ok=True)
    yield
    stamp.parent.mkdir(parents=True, exist_ok=True)
    stamp.write_text(key, encoding="utf-8")
