"""What the studio's page costs: one JSON line each.

The page runs in the distribution's Chromium, headless, whose picture the processor draws; with a
graphics card it is less. CPU times are of all of the browser's processes together, time and
latency are the wall clock's, so run it on a computer that has nothing else to do.

Keys: `benchmark` "studio"; `what` "load" (the page with the emulated knob in it: `bytes` to fetch,
compressed, and `first_torque_s` from the first request until the scene has made a torque), or
"live" (the page over `torsio studio`: `samples_per_s`, `samples_lost`, `cpu_share` of one core for
the browser and `bridge_cpu_share` for the bridge, `latency_ms` from the arrival of the newest
sample in the page to the end of drawing it, median). `goal_...` are what they should be.
"""

from __future__ import annotations

import gzip
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

TREE = Path(__file__).parents[2]
sys.path.insert(0, str(TREE))  # this file is also run as a program
from playwright.sync_api import Browser, Page  # noqa: E402

from tests.studio.browser import PAGE, chromium, opened, served, state_is  # noqa: E402

MEASURED_S = 10.0
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
_GOALS = {"bytes": 1_000_000, "first_torque_s": 2.0, "cpu_share": 0.15, "latency_ms": 50.0}


def _cpu_s(root: int) -> float:
    """CPU seconds of a process and of all below it."""
    parents, spent = {}, {}
    for folder in Path("/proc").iterdir():
        if not folder.name.isdigit():
            continue
        try:
            words = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        parents[int(folder.name)] = int(words[1])
        spent[int(folder.name)] = (int(words[11]) + int(words[12])) / _TICKS_PER_S
    below = {root}
    while more := {child for child, parent in parents.items() if parent in below} - below:
        below |= more
    return sum(spent.get(process, 0.0) for process in below)


def load(browser: Browser) -> dict[str, Any]:
    """Measure how soon one feels something."""
    size = sum(len(gzip.compress(file.read_bytes())) for file in PAGE.iterdir())
    with served() as address:
        begin = time.perf_counter()
        with opened(browser, address) as page:
            state_is(page, "disarmed")
            page.click("#arm")
            page.focus("#dial")
            for _ in range(3):
                page.keyboard.press("PageUp")
            page.wait_for_function("Number(document.getElementById('desired_torque_nm').value) < 0")
            return {"what": "load", "bytes": size, "first_torque_s": time.perf_counter() - begin}


def _shown(page: Page) -> tuple[float, int]:
    """Samples that have come, and samples that were lost."""
    samples, lost = page.evaluate("[window.studio.samples(), window.studio.lost()]")
    return float(samples), int(lost)


def live(browser: Browser, process: int) -> dict[str, Any]:
    """Measure the page over the bridge, at all telemetry that it asks for."""
    command = [sys.executable, "-c", "from torsio.__main__ import main; main()", "studio"]
    with subprocess.Popen(
        [*command, "--device", "emulated", "--page", str(PAGE)], stdout=subprocess.PIPE, text=True
    ) as bridge:
        assert bridge.stdout is not None
        address = bridge.stdout.readline().split()[1]
        try:
            with opened(browser, address) as page:
                state_is(page, "disarmed")
                time.sleep(2.0)
                begin, spent, passed = time.perf_counter(), _cpu_s(process), _cpu_s(bridge.pid)
                count, lost = _shown(page)
                time.sleep(MEASURED_S)
                duration_s = time.perf_counter() - begin
                count_then, lost_then = _shown(page)
                count, lost = count_then - count, lost_then - lost
                return {
                    "what": "live",
                    "samples_per_s": count / duration_s,
                    "samples_lost": lost,
                    "cpu_share": (_cpu_s(process) - spent) / duration_s,
                    "bridge_cpu_share": (_cpu_s(bridge.pid) - passed) / duration_s,
                    "latency_ms": page.evaluate("window.studio.latencyMs()"),
                }
        finally:
            bridge.terminate()


def main() -> None:
    """Print the lines."""
    with chromium() as browser:
        # The driver of the browser is a child of this process, and the browser its child.
        for line in (load(browser), live(browser, _driver())):
            goals = {f"goal_{name}": goal for name, goal in _GOALS.items() if name in line}
            print(json.dumps({"benchmark": "studio", **line, **goals}), flush=True)


def _driver() -> int:
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            words = (folder / "stat").read_text().rpartition(")")[2].split()
            if int(words[1]) == os.getpid():
                return int(folder.name)
    raise RuntimeError("the browser does not run")


if __name__ == "__main__":
    main()
