"""How soon a new user turns a wall: `./dev demo` as at a terminal, then its page. A JSON line.

`./dev bench hour` plays the user in this tree, `./dev bench hour bookworm` on a bare system of that
Debian release, which `./dev fresh` makes before the time begins.

Keys: `benchmark` "hour"; seconds of the wall clock for a clone of this tree (`clone_s`), from the
command's start until it has written its picture (`picture_s`), then until it tells the page's
address (`address_s`), until the page has the knob (`knob_s`), and until a mouse has turned the
armed knob into the wall (`wall_s`). `picture_s` holds all that is not built yet; a bare system has
the whole of it.
"""

from __future__ import annotations

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

TREE = Path(__file__).parents[2]
sys.path.insert(0, str(TREE))  # this file is also run as a program
from tests.studio.browser import armed, chromium, drag_to, number, opened, state_is  # noqa: E402

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
    ):  # fmt: skip
        os.close(terminal)
        times, shown, address = [], "", ""
        for sign in (_FRESH if suite else "", *_SIGNS):
            address, shown = _wait_for(sign, shown, user)
            times.append(time.monotonic())
        with opened(browser, address) as page:
            state_is(page, "disarmed")
            times.append(time.monotonic())
            armed(page)
            drag_to(page, 1.5 * _WALL_RAD)
            while number(page, "angle_rad") < _WALL_RAD:
                time.sleep(0.01)
            times.append(time.monotonic())
        os.write(user, b"\x03")  # Ctrl-C
    took = {part: b - a for part, (a, b) in zip(_PARTS, itertools.pairwise(times), strict=True)}
    return {part: round(seconds, 1) for part, seconds in {"clone_s": clone_s, **took}.items()}


if __name__ == "__main__":
    print(json.dumps({"benchmark": "hour", **measure(*sys.argv[1:]), "load": os.getloadavg()[0]}))
