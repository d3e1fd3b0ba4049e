"""How soon a new user turns a wall: `./dev demo` as at a terminal, then its page. A JSON line.

Keys: `benchmark` "hour"; seconds of the wall clock from the command's start until it has written
its picture (`picture_s`), then until it tells the page's address (`address_s`), until the page has
the knob (`knob_s`), and until a mouse has turned the armed knob into the wall (`wall_s`). The first
holds all that is not built yet; a fresh clone has the whole of it.
"""

from __future__ import annotations

import json
import os
import pty
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

TREE = Path(__file__).parents[2]
sys.path.insert(0, str(TREE))  # this file is also run as a program
from tests.studio.browser import armed, chromium, drag_to, number, opened, state_is  # noqa: E402

_WALL_RAD = 0.3  # the page's first scene


def measure() -> dict[str, float]:
    """Play the new user."""
    times, shown, (user, terminal) = [time.monotonic()], "", pty.openpty()
    with chromium() as browser, subprocess.Popen(
        [TREE / "dev", "demo"], stdin=terminal, stdout=terminal, stderr=terminal, close_fds=True
    ) as demo:  # fmt: skip
        address = ""
        for sign in (r"virtual_wall\.png", r"http://127\S+"):
            while not (found := re.search(sign + r"(?=\s)", shown)):
                shown += os.read(user, 4096).decode(errors="replace")
            times.append(time.monotonic())
            address = found[0]
        with opened(browser, address) as page:
            state_is(page, "disarmed")
            times.append(time.monotonic())
            armed(page)
            drag_to(page, 1.5 * _WALL_RAD)
            while number(page, "angle_rad") < _WALL_RAD:
                time.sleep(0.01)
            times.append(time.monotonic())
        demo.send_signal(signal.SIGINT)
    names = ("picture_s", "address_s", "knob_s", "wall_s")
    return {name: round(b - a, 1) for name, a, b in zip(names, times, times[1:], strict=False)}


if __name__ == "__main__":
    print(json.dumps({"benchmark": "hour", **measure(), "load": os.getloadavg()[0]}))
