"""Many unplugs, each while something else is going on, at a moment of chance.

``./dev unplugs [N]`` opens an emulated knob N times (1,000), lets it do something, and pulls its
plug. The user must get `Disconnected` within a second. Afterwards there must be as many threads and
descriptors and as much memory as before.

``./dev unplugs N --kernel 6.12`` does it with a virtual USB knob on a real kernel, in a virtual
machine; ``tests/vm/guest/test_many_unplugs.py`` is what runs there.
"""

from __future__ import annotations

import argparse
import ctypes
import gc
import itertools
import os
import random
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import torsio

LATEST_S = 1.0
# For who waits for a feature report at that moment, where the cable is USB/IP's: Linux gives it up
# after 5 s, a controller of silicon at once.
LATEST_IN_REQUEST_S = 5.0 + LATEST_S
# Memory for each unplug, and for the rest of the process meanwhile.
MOST_BYTES = 1024
SLACK_BYTES = 12 << 20
TELL_EVERY = 20
# Tell the guest how many.
COUNT_VARIABLE, SEED_VARIABLE = "TORSIO_UNPLUGS", "TORSIO_UNPLUGS_SEED"


def sleep(knob: torsio.Knob) -> None:
    while True:
        knob.sleep(60.0)


def play(knob: torsio.Knob) -> None:
    for scale in itertools.count(1):
        wall = torsio.Wall(stiffness_nm_per_rad=0.001 * (1 + scale % 1000))
        knob.play([wall, torsio.Damper(damping_nm_s_per_rad=1e-4)])


def upload(knob: torsio.Knob) -> None:
    for scale in itertools.count(1):
        knob.play(torsio.Curve(torque_nm=[1e-6 * (scale % 100) * n for n in range(200)]))


def record(knob: torsio.Knob) -> None:
    try:
        while True:
            knob.record(duration_s=1.0)
    except torsio.Disconnected as error:
        if not hasattr(error, "samples"):
            raise RuntimeError("what came until then was thrown away") from error
        raise


def read(knob: torsio.Knob) -> None:
    knob.start_telemetry()
    while True:
        knob.read(timeout_s=60.0)


def toggle(knob: torsio.Knob) -> None:
    while True:
        knob.arm()
        knob.disarm()


def save(knob: torsio.Knob) -> None:
    knob.disarm()
    while True:
        knob.save()


def configure(knob: torsio.Knob) -> None:
    knob.disarm()
    for count in itertools.count():
        knob.update(speed_limit_rad_s=50.0 + count % 10)


def ask(knob: torsio.Knob) -> None:
    while True:
        knob.clock()
        knob.health()


def stream(knob: torsio.Knob) -> None:
    while True:
        knob.stream_local_model(torque_nm=0.001, deadline_s=1.0)


def follow(knob: torsio.Knob) -> None:
    knob.start_telemetry(prompt=True)
    for _ in knob.every(0.001):
        knob.latest()


def play_game(knob: torsio.Knob) -> None:
    while True:
        knob.game_effects()


def hear_and_toggle(knob: torsio.Knob) -> None:
    """Toggles, while the callback of each event asks on its own."""

    def hear(event: torsio.Event) -> None:
        with suppress(torsio.Error):
            knob.health()
            knob.events()

    knob.on_event(hear)
    toggle(knob)


def pull_in_callback(knob: torsio.Knob) -> None:
    """The plug goes in the callback itself."""

    def hear(_: torsio.Event) -> None:
        with suppress(torsio.Closed):  # an event of before, heard after
            knob.emulator.unplug()

    knob.on_event(hear)
    toggle(knob)


def close_in_callback(knob: torsio.Knob) -> None:
    """The callback closes the knob, with the plug in or out."""
    knob.on_event(lambda _: knob.close())
    toggle(knob)


STATES: dict[str, Callable[[torsio.Knob], object]] = {
    "asleep": sleep,
    "asking": ask,
    "playing": play,
    "uploading": upload,
    "recording": record,
    "reading": read,
    "arming": toggle,
    "saving": save,
    "configuring": configure,
    "streaming": stream,
    "in a loop of its own": follow,
    "a game's effects": play_game,
    "in a callback": hear_and_toggle,
    "pulled by a callback": pull_in_callback,
    "closed by a callback": close_in_callback,
    "waiting for a state": lambda knob: [
        knob.wait_for("fault", timeout_s=60.0) for _ in itertools.count()
    ],
    "waiting for events": lambda knob: [knob.events(timeout_s=60.0) for _ in itertools.count()],
}


# Those that ask for feature reports, and those that only an emulated knob can be in.
ASKING = {"asking", "recording", "configuring", "a game's effects", "in a callback"}
EMULATED = {"pulled by a callback"}

# Gives an open knob, and a function that pulls its plug; the next call plugs it in.
Source = Callable[[bool], AbstractContextManager[tuple[torsio.Knob, Callable[[], object]]]]


@contextmanager
def emulated(paced: bool) -> Iterator[tuple[torsio.Knob, Callable[[], object]]]:
    """Open an emulated knob."""
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(paced=paced)) as knob:
        yield knob, lambda: knob.emulator.unplug()


@dataclass(frozen=True)
class Means:
    """A process's memory, files and threads."""

    threads: int
    files: int
    memory: int

    @staticmethod
    def now() -> Means:
        """Count this process's, without what the allocator keeps for the next time."""
        gc.collect()
        with suppress(OSError, AttributeError):  # another C library than GNU's
            ctypes.CDLL(None).malloc_trim(0)
        return Means.of("self")

    @staticmethod
    def of(process: int | str) -> Means:
        """Count a process's."""
        folder = Path(f"/proc/{process}")
        pages = int((folder / "statm").read_text().split()[1])
        return Means(
            len(os.listdir(folder / "task")),
            len(os.listdir(folder / "fd")),
            pages * os.sysconf("SC_PAGE_SIZE"),
        )

    def faults(self, before: Means, unplugs: int) -> list[str]:
        """Return what is left behind after so many unplugs."""
        found = []
        if self.threads > before.threads:
            found.append(f"{self.threads - before.threads} threads are left")
        if self.files > before.files:
            found.append(f"{self.files - before.files} descriptors are left")
        if self.memory - before.memory > SLACK_BYTES + MOST_BYTES * unplugs:
            found.append(f"the process has grown by {self.memory - before.memory} bytes")
        return found

    def __str__(self) -> str:
        return f"{self.threads} threads, {self.files} descriptors, {self.memory / 1e6:.1f} MB"


@dataclass
class Trial:
    """One unplug: what its user heard, and how long after it."""

    state: str
    paced: bool
    wait_s: float
    latest_s: float = LATEST_S
    pulled_s: float = 0.0
    late_s: float = float("inf")
    heard: BaseException | None = None

    def run(self, source: Source = emulated) -> None:
        """Do it."""
        with source(self.paced) as (knob, pull_plug):
            knob.arm()
            user = threading.Thread(target=self._use, args=(knob,), daemon=True)
            user.start()
            time.sleep(self.wait_s)
            self.pulled_s = time.monotonic()
            with suppress(torsio.Closed):  # by a callback
                pull_plug()
            user.join(10.0)

    def _use(self, knob: torsio.Knob) -> None:
        try:
            STATES[self.state](knob)
        except BaseException as error:
            self.heard = error
        # A callback may have pulled it before its time.
        self.late_s = max(0.0, time.monotonic() - self.pulled_s) if self.pulled_s else 0.0

    def fault(self) -> str:
        """Return what is wrong with it; empty if nothing is."""
        if self.heard is None:
            return "nobody was told"
        told: tuple[type[Exception], ...] = (torsio.Disconnected,)
        if STATES[self.state] is close_in_callback:
            told += (torsio.Closed,)
        if self.latest_s > LATEST_S:
            # Another thread's request holds the kernel, so the unplug is told late.
            told += (torsio.Timeout,)
        if not isinstance(self.heard, told):
            return f"told by {self.heard!r}"
        return f"told after {self.late_s:.2f} s" if self.late_s > self.latest_s else ""


@dataclass
class Outcome:
    """The results of many trials.

    Attributes
    ----------
    latest_s, latest_in_request_s
        From the plug to the exception, at most; the second where a feature report may be waited
        for on a cable.
    before, after
        What the process has: once a fifth is done, and now.
    """

    faults: list[str] = field(default_factory=list)
    states: Counter[str] = field(default_factory=Counter)
    latest_s: float = 0.0
    latest_in_request_s: float = 0.0
    before: Means | None = None
    after: Means | None = None

    def count(self, trial: Trial) -> None:
        """Take a trial in."""
        number = self.states.total()
        self.states[trial.state] += 1
        if trial.latest_s > LATEST_S:
            self.latest_in_request_s = max(self.latest_in_request_s, trial.late_s)
        else:
            self.latest_s = max(self.latest_s, trial.late_s)
        if fault := trial.fault():
            self.faults.append(f"unplug {number}, {trial.state}, paced {trial.paced}: {fault}")

    def __str__(self) -> str:
        in_request = f" ({1000 * self.latest_in_request_s:.0f} ms in a request)"
        return (
            f"{self.states.total()} unplugs in {len(self.states)} states, told within "
            f"{1000 * self.latest_s:.0f} ms{in_request if self.latest_in_request_s else ''}, "
            f"before: {self.before}, after: {self.after}, {len(self.faults)} faults"
        )


def pull(
    count: int,
    seed: int,
    source: Source = emulated,
    tell: Callable[[Outcome], object] = lambda _: None,
) -> Outcome:
    """Unplug so many times, each state as often as the others; tell of it now and then."""
    chance = random.Random(seed)
    outcome = Outcome()
    on_cable = source is not emulated
    states = [state for state in STATES if not (on_cable and state in EMULATED)]
    settled = count // 5
    for number, state in zip(range(count), itertools.cycle(states), strict=False):
        if number == settled:
            outcome.before = Means.now()
        latest_s = LATEST_IN_REQUEST_S if on_cable and state in ASKING else LATEST_S
        trial = Trial(state, chance.random() < 0.7, chance.random() * 0.04, latest_s)
        trial.run(source)
        outcome.count(trial)
        if number % TELL_EVERY == 0 and number > settled:
            outcome.after = Means.now()
            tell(outcome)
    if outcome.before is not None:
        outcome.after = Means.now()
        outcome.faults += outcome.after.faults(outcome.before, count - settled)
    return outcome


def main(arguments: Sequence[str]) -> int:
    """Run trials and tell of them; return the exit status."""
    parser = argparse.ArgumentParser(prog="./dev unplugs", description=__doc__)
    parser.add_argument("count", nargs="?", type=int, default=1000, help="number of unplugs (1000)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the moments (1)")
    parser.add_argument("--kernel", default="", help="kernel of the guest: 6.1, 6.12")
    options = parser.parse_args(arguments)
    if options.kernel:
        return in_guest(options.kernel, options.count, options.seed)
    begin_s = time.monotonic()
    outcome = pull(options.count, options.seed)
    print(*outcome.faults, sep="\n")
    print(outcome, f"{time.monotonic() - begin_s:.0f} s")
    return 1 if outcome.faults else 0


def in_guest(kernel: str, count: int, seed: int) -> int:
    """Do it in a virtual machine; return the exit status."""
    from tests.vm import guests, results  # the guest's part needs no import of it

    test = "tests/vm/guest/test_many_unplugs.py::test_many_unplugs_in_every_state"
    variables = {COUNT_VARIABLE: str(count), SEED_VARIABLE: str(seed)}
    # A plug cycle takes a second or two of an emulated processor, and more of a busy one.
    problem = guests.run_guest(kernel, [test], variables, limit_s=600.0 + 20.0 * count)
    if not problem:
        problem = results.read_junit(guests.junit(kernel))[results.test_key(test)].problem
    if problem:
        print(problem)
    with suppress(FileNotFoundError):  # a guest that died early has not told anything
        told = (guests.share(kernel) / "unplugs").read_text(encoding="utf-8")
        print(f"kernel {kernel}: {told.strip()}")
    return 1 if problem else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
