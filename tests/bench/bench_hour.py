"""How soon a new user turns a wall: `./dev demo` as at a terminal, then its page. A JSON line.

`./dev bench hour` plays the user in this tree, `./dev bench hour bookworm` on a bare system of that
Debian release, which `./dev fresh` makes before the time begins.

Keys: `benchmark` "hour"; seconds of the wall clock for a clone of this tree (`clone_s`), from the
command's start until it has written its picture (`picture_s`), then until it tells the page's
address (`address_s`), until the page has the knob (`knob_s`), and until a mouse has turned the
armed knob into the wall (`wall_s`). `picture_s` holds all that is not built yet; a bare system has
the whole of it. `processor_s` is the processor's time of all that, without the browser's.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import pty
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.studio.browser import armed, chromium, drag_to, number, opened, state_is

TREE = Path(__file__).parents[2]
_WALL_RAD = 0.3  # the page's first scene


# What the terminal shows at the end of each part. The first stands where the time begins.
_SIGNS = (r"virtual_wall\.png(?=\s)", r"http://127\S+(?=\s)")
_FRESH = r"\./dev demo, as "
_PARTS = ("picture_s", "address_s", "knob_s", "wall_s")


def _clone_s() -> float:
    with tempfile.TemporaryDirectory() as folder:
        begin_s = time.monotonic()
        subprocess.run(["git", "clone", "--quiet", "--no-hardlinks", TREE, folder], check=True)
        return time.monotonic() - begin_s


def _processor_s(top: int) -> float:
    """Give the processor's time of a program and of all below it, ended ones included."""
    parents, ticks = {}, {}
    for file in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            words = file.read_text(errors="replace").rpartition(")")[2].split()
            parents[int(file.parent.name)] = int(words[1])
            ticks[int(file.parent.name)] = sum(map(int, words[11:15]))

    def is_below(pid: int) -> bool:
        while pid not in (0, top):
            pid = parents.get(pid, 0)
        return pid == top

    return sum(ticks[pid] for pid in ticks if is_below(pid)) / os.sysconf("SC_CLK_TCK")


def _wait_for(sign: str, shown: str, user: int) -> tuple[str, str]:
    """Wait until the terminal shows a sign; give it, and all that was shown."""
    while not (found := re.search(sign, shown)):
        try:
            shown += os.read(user, 4096).decode(errors="replace")
        except OSError:  # its last program has ended
            sys.exit(shown)
    return found[0], shown


def measure(*suite: str) -> dict[str, float]:
    """Play the new user, in a bare system of a release if one is named."""
    command: list[str | Path] = [TREE / "dev", *(("fresh", *suite) if suite else ()), "demo"]
    clone_s = _clone_s()
    user, terminal = pty.openpty()
    with chromium() as browser, subprocess.Popen(
        ["setsid", "--ctty", *command], stdin=terminal, stdout=terminal, stderr=terminal
    ) as dev:  # fmt: skip
        os.close(terminal)
        times, shown, address, before_s = [], "", "", 0.0
        for sign in (_FRESH if suite else "", *_SIGNS):
            address, shown = _wait_for(sign, shown, user)
            times.append(time.monotonic())
            before_s = before_s or _processor_s(dev.pid)
        with opened(browser, address) as page:
            state_is(page, "disarmed")
            times.append(time.monotonic())
            armed(page)
            drag_to(page, 1.5 * _WALL_RAD)
            while number(page, "angle_rad") < _WALL_RAD:
                time.sleep(0.01)
            times.append(time.monotonic())
        processor_s = _processor_s(dev.pid) - before_s
        os.write(user, b"\x03")  # Ctrl-C
    took = {part: b - a for part, (a, b) in zip(_PARTS, itertools.pairwise(times), strict=True)}
    seconds = {"clone_s": clone_s, **took, "processor_s": processor_s}
    return {part: round(of_it, 1) for part, of_it in seconds.items()}


if __name__ == "__main__":
    print(json.dumps({"benchmark": "hour", **measure(*sys.argv[1:]), "load": os.getloadavg()[0]}))
