"""One number for the lives of some emulated knobs, however the program was made and run.

``./dev determinism`` builds ``life.cpp`` with gcc and clang, without and with full optimisation,
for x86-64 and for aarch64 (which qemu runs), and runs it on 1 to 32 threads, with its time cut in
several ways, many times faster than the clock, and through stops of seconds, by a signal and by a
debugger. Every run must print the same number. It is not written down anywhere: a change of the
plant or of a law changes it, and should.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

TREE = Path(__file__).parent.parent.parent
HERE = Path(__file__).parent
BUILD = TREE / "build/determinism"
STOPPED_S = 2.0


class OverTooSoon(Exception):
    """A program that was to be stopped has ended; says what to do."""


class Missing(Exception):
    """A compiler or an emulator is not installed; says which."""


@dataclass(frozen=True)
class Way:
    """A way to make the program.

    Attributes
    ----------
    name
        Of its folder, and for people.
    compiler, options
        What makes it.
    start
        Words in front of its own command: an emulator.
    """

    name: str
    compiler: str
    options: str
    start: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()


ARM = ("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu")
CROSS = ("-DCMAKE_SYSTEM_NAME=Linux", "-DCMAKE_SYSTEM_PROCESSOR=aarch64")
WAYS = (
    Way("gcc-O0", "g++", "-O0"),
    Way("gcc-O3", "g++", "-O3"),
    Way("gcc-native", "g++", "-O3 -march=native"),
    Way("clang-O0", "clang++", "-O0"),
    Way("clang-O3", "clang++", "-O3"),
    Way("aarch64-O0", "aarch64-linux-gnu-g++", "-O0", ARM, CROSS),
    Way("aarch64-O3", "aarch64-linux-gnu-g++", "-O3", ARM, CROSS),
)


def build(way: Way) -> Path:
    """Build the program in one way and return it.

    Raises
    ------
    Missing
        If what it needs is not installed.
    subprocess.CalledProcessError
        If it does not compile; the log says why.
    """
    for program in (way.compiler, *way.start[:1]):
        if shutil.which(program) is None:
            raise Missing(f"{way.name} needs {program}, which is not installed")
    folder = BUILD / way.name
    log = TREE / f"build/logs/determinism-{way.name}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    configure: list[str | Path] = [
        "cmake",
        "-S",
        HERE,
        "-B",
        folder,
        "-G",
        "Ninja",
        "-DCMAKE_BUILD_TYPE=Debug",
    ]
    configure += [f"-DCMAKE_CXX_COMPILER={way.compiler}", f"-DCMAKE_CXX_FLAGS_DEBUG={way.options}"]
    with log.open("w") as output:
        build: list[str | Path] = ["cmake", "--build", folder, "-t", "torsio_life"]
        for command in ([*configure, *way.settings], build):
            subprocess.run(command, stdout=output, stderr=output, check=True)
    return folder / "torsio_life"


def stop_by_signal(process: int, seconds: float) -> None:
    """Stop a process as Ctrl-Z does, and let it go on."""
    os.kill(process, signal.SIGSTOP)
    if not os.WIFSTOPPED(os.waitpid(process, os.WUNTRACED)[1]):
        raise OverTooSoon("the program was over before it could be stopped: let it live longer")
    time.sleep(seconds)
    os.kill(process, signal.SIGCONT)


def stop_by_debugger(process: int, seconds: float) -> None:
    """Stop each thread of a process as a debugger does that attaches to it, and let it go on."""
    attach, detach, all_children = 16, 17, 0x40000000  # numbers of ptrace(2) and wait(2)
    ptrace = ctypes.CDLL(None, use_errno=True).ptrace
    ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
    threads: list[int] = []
    try:
        for thread in map(int, os.listdir(f"/proc/{process}/task")):
            if ptrace(attach, thread, None, None) != 0:
                why = os.strerror(ctypes.get_errno())
                raise OverTooSoon(f"thread {thread} of the program cannot be attached to: {why}")
            os.waitpid(thread, all_children)
            threads.append(thread)
        time.sleep(seconds)
    finally:
        for thread in threads:
            ptrace(detach, thread, None, None)
        # The signal that stops one may be left over: a program that has just begun stops for that.
        os.kill(process, signal.SIGCONT)


@dataclass(frozen=True)
class Run:
    """One run of the program.

    Attributes
    ----------
    name
        For people.
    command
        What is run.
    stop
        What stops it for a while in the middle; given the process and seconds.
    """

    name: str
    command: tuple[str, ...]
    stop: Callable[[int, float], None] | None = None

    def number(self) -> str:
        """Run it and return the number that it prints.

        Raises
        ------
        subprocess.CalledProcessError
            If it does not end well.
        OverTooSoon
            If it cannot be stopped before its end.
        """
        # A busy machine may come back to this program when the other has long ended.
        for delay_s in (0.02, 0.01, 0.002):
            with suppress(OverTooSoon):
                return self._number(delay_s)
        return self._number(0.0)

    def _number(self, delay_s: float) -> str:
        with subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True) as process:
            if self.stop is not None:
                time.sleep(delay_s)
                self.stop(process.pid, STOPPED_S)
            output = process.communicate()[0]
        if process.returncode != 0:
            raise subprocess.CalledProcessError(process.returncode, self.command)
        return output.strip()


def runs_of(program: Path, seconds: int, knobs: int, threads: Sequence[int]) -> list[Run]:
    """Return the runs of one program that differ in how they are run."""
    base = (str(program), "--seconds", str(seconds), "--knobs", str(knobs))
    paced = (*base, "--pace", "20", "--threads", str(knobs))
    return [
        *(Run(f"{n} threads", (*base, "--threads", str(n))) for n in threads),
        *(Run(f"time cut by seed {n}", (*base, "--cut", str(n))) for n in (1, 2, 3)),
        Run("stopped for 2 s", base, stop_by_signal),
        Run("stopped for 2 s in a debugger", base, stop_by_debugger),
        Run("20 times faster than the clock", paced),
        Run("20 times faster than the clock, stopped for 2 s", paced, stop_by_signal),
    ]


def report(numbers: Sequence[tuple[str, str]]) -> int:
    """Print what each run gave; return 1 if they are not all the same."""
    for name, number in numbers:
        print(f"{number}  {name}", flush=True)
    kinds = len({number for _, number in numbers})
    print(f"{len(numbers)} runs, {'one number' if kinds == 1 else f'{kinds} different numbers'}")
    return 0 if kinds == 1 else 1


def main(arguments: Sequence[str]) -> int:
    """Build and run all ways; return the exit status."""
    parser = argparse.ArgumentParser(prog="./dev determinism", description=__doc__)
    parser.add_argument("--seconds", type=int, default=60, help="length of each knob's life (60)")
    parser.add_argument("--knobs", type=int, default=32, help="number of knobs (32)")
    parser.add_argument("--only", default="", help="part of the names of the ways to build")
    options = parser.parse_args(arguments)
    ways = [way for way in WAYS if options.only in way.name]
    try:
        programs = {way: build(way) for way in ways}
    except Missing as error:
        print(f"determinism: {error}", file=sys.stderr)
        return 2
    except subprocess.CalledProcessError as error:
        print(f"determinism: does not compile: {error}; see build/logs", file=sys.stderr)
        return 2
    size = ("--seconds", str(options.seconds), "--knobs", str(options.knobs))
    runs = [Run(way.name, (*way.start, str(programs[way]), *size)) for way in ways]
    fastest = programs.get(WAYS[1], next(iter(programs.values())))
    runs += runs_of(fastest, options.seconds, options.knobs, (1, 2, 4, 8, 16, 32))
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        numbers = list(pool.map(Run.number, runs))
    return report([(run.name, number) for run, number in zip(runs, numbers, strict=True)])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
