"""The cost of the studio's page: one JSON line each.

The page runs in the distribution's Chromium, headless, whose picture the processor draws; with a
graphics card it is less. CPU shares are counted, seconds of CPU in a second; the others are the
wall clock's. Beside them stands how busy the machine was: `load`, processes that want to run, of
`cpus`, and `loop_s`, the CPU time that a fixed loop took, which grows too where hyperthreads share
a core: a machine at rest has its smallest.

Keys: `benchmark` "studio"; `what`
"load" (the page with the emulated knob in it: `bytes` to fetch, compressed, and `first_torque_s`
from the first request until the scene has made a torque, with `phases_s`, what took how long of it,
and `cpu_s`, the CPU time of all of the browser until then), or
"rest" and "turned" (a page that watches a knob, armed, at 4,000 samples a second, untouched, or
turned far into a wall and out of it all the time: `samples_per_s`, `samples_lost`,
`pictures_per_s`; `page_cpu_share` of one core for the page's process, `cpu_share` for all of the
browser, and `program_cpu_share` for the program that drives the emulated knob and passes it on;
`latency_ms` and `latency_95_ms` from when the knob made a sample until the browser has painted it,
half of them and 95 %, without the milliseconds that the quickest was on its way), or
"emulated" (the same of the page with the emulated knob in it, which runs there, too).
`goal_...` are what they should be.
"""

from __future__ import annotations

import functools
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

import torsio  # noqa: E402
import torsio.studio  # noqa: E402
from tests.studio.browser import PAGE, chromium, opened, served, state_is  # noqa: E402

MEASURED_S, SETTLED_S = 10.0, 5.0
RATE_HZ = 4000.0
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
_GOALS = {
    "bytes": 1_000_000,
    "first_torque_s": 2.0,
    "samples_lost": 0,
    "page_cpu_share": 0.15,
    "latency_ms": 50.0,
}
# Arms as soon as it can and turns the knob into the wall.
_HASTE = """
  addEventListener("DOMContentLoaded", () => {
    const at = (name) => performance.mark(name);
    const look = () => {
      const arm = document.getElementById("arm"), state = document.getElementById("state").value;
      if (!arm.disabled) { at("open"); arm.click(); }
      else if (state === "armed" && !performance.getEntriesByName("armed").length) {
        at("armed");
        const key = new KeyboardEvent("keydown", { key: "PageUp" });
        for (let i = 0; i < 3; ++i) document.getElementById("dial").dispatchEvent(key);
      }
      if (Number(document.getElementById("desired_torque_nm").value) < 0) { at("torque"); return; }
      setTimeout(look, 5);
    };
    look();
  });
"""
_PHASES = """() => {
  const mark = (name) => performance.getEntriesByName(name)[0].startTime;
  return {
    page: performance.getEntriesByType("navigation")[0].responseEnd,
    script: mark("script"), module: mark("module"), open: mark("open"), armed: mark("armed"),
    torque: mark("torque"),
  };
}"""


def _busy() -> dict[str, float]:
    """Say how busy the machine is."""
    begin = time.process_time()
    total = 0
    for i in range(2_000_000):
        total += i
    spent = time.process_time() - begin
    return {"load": os.getloadavg()[0], "cpus": os.cpu_count() or 1, "loop_s": spent}


def _cpu_s(root: int, what: bytes = b"") -> float:
    """CPU seconds of a process and of all below it that have this among their arguments."""
    parents, spent = {}, {}
    for folder in Path("/proc").iterdir():
        if not folder.name.isdigit():
            continue
        try:
            words = (folder / "stat").read_text().rpartition(")")[2].split()
            arguments = (folder / "cmdline").read_bytes()
        except OSError:
            continue
        parents[int(folder.name)] = int(words[1])
        if what in arguments:
            spent[int(folder.name)] = (int(words[11]) + int(words[12])) / _TICKS_PER_S
    below = {root}
    while more := {child for child, parent in parents.items() if parent in below} - below:
        below |= more
    return sum(spent.get(process, 0.0) for process in below)


def load(browser: Browser, process: int) -> dict[str, Any]:
    """Measure how soon one feels something."""
    size = sum(len(gzip.compress(file.read_bytes())) for file in PAGE.iterdir())
    spent = _cpu_s(process)
    with served() as address, opened(browser, "about:blank") as page:
        page.add_init_script(_HASTE)
        page.goto(address)
        page.wait_for_function("performance.getEntriesByName('torque').length")
        spent = _cpu_s(process) - spent
        ends = page.evaluate(_PHASES)
    begins = [0.0, *list(ends.values())[:-1]]
    phases = {
        name: round(1e-3 * (end - begin), 3)
        for (name, end), begin in zip(ends.items(), begins, strict=True)
    }
    return {
        "what": "load",
        "bytes": size,
        "first_torque_s": 1e-3 * ends["torque"],
        "phases_s": phases,
        "cpu_s": spent,
    }


def _shown(page: Page) -> list[int]:
    """Samples that have come, samples that were lost, and pictures that were drawn."""
    names = ("samples", "lost", "pictures")
    return [int(page.evaluate(f"window.studio.{name}()")) for name in names]


def _measured(page: Page, process: int) -> dict[str, Any]:
    """Measure a page that shows a knob."""
    page.wait_for_function("window.studio.samples() > 4000")
    time.sleep(SETTLED_S)  # the browser has compiled its busy code by now
    begin, spent, drawn = time.perf_counter(), _cpu_s(process), _cpu_s(process, b"--type=renderer")
    before = _shown(page)
    time.sleep(MEASURED_S)
    duration_s = time.perf_counter() - begin
    count, lost, pictures = (b - a for a, b in zip(before, _shown(page), strict=True))
    return {
        "samples_per_s": count / duration_s,
        "samples_lost": lost,
        "pictures_per_s": pictures / duration_s,
        "page_cpu_share": (_cpu_s(process, b"--type=renderer") - drawn) / duration_s,
        "cpu_share": (_cpu_s(process) - spent) / duration_s,
        "latency_ms": page.evaluate("window.studio.latencyMs(0.5)"),
        "latency_95_ms": page.evaluate("window.studio.latencyMs(0.95)"),
    }


def drive(what: str) -> None:
    """Drive an emulated knob, and have pages watch, until killed."""
    to_and_fro = [(0.5 * i, 1.5 * (i % 2)) for i in range(1200)]
    turn = torsio.PrescribedMotion(angle_rad=to_and_fro)
    hand = turn if what == "turned" else torsio.NoHand()
    options = torsio.EmulatorOptions(control_rate_hz=RATE_HZ, hand=hand, paced=True)
    with torsio.open("emulated", emulator=options) as knob:
        knob.play(torsio.Wall(angle_rad=0.1, stiffness_nm_per_rad=1.4))
        knob.arm()
        knob.start_telemetry(RATE_HZ)
        with torsio.studio.watch(knob, page=PAGE) as watch:
            print(watch.address, flush=True)
            while True:
                knob.sleep(0.05)
                knob.read(max_samples=65536, timeout_s=0.0)


def live(browser: Browser, process: int, what: str) -> dict[str, Any]:
    """Measure a page that watches a knob which another program drives."""
    with subprocess.Popen(
        [sys.executable, __file__, "drive", what], stdout=subprocess.PIPE, text=True
    ) as program:
        assert program.stdout is not None
        address = program.stdout.readline().strip()
        try:
            with opened(browser, address) as page:
                state_is(page, "armed")
                begin, spent = time.perf_counter(), _cpu_s(program.pid)
                found = _measured(page, process)
                share = (_cpu_s(program.pid) - spent) / (time.perf_counter() - begin)
                return {"what": what, **found, "program_cpu_share": share}
        finally:
            program.terminate()


def emulated(browser: Browser, process: int) -> dict[str, Any]:
    """Measure a page with the emulated knob in it, pressed into a wall."""
    with served() as address, opened(browser, address) as page:
        state_is(page, "disarmed")
        page.click("#arm")
        page.focus("#dial")
        for _ in range(2):
            page.keyboard.press("PageUp")
        return {"what": "emulated", **_measured(page, process)}


def main() -> None:
    """Print the lines."""
    if sys.argv[1:2] == ["drive"]:
        drive(sys.argv[2])
        return
    if sys.argv[1:]:
        sys.exit("bench studio measures all that it can, and takes no arguments")
    rest, turned = (functools.partial(live, what=what) for what in ("rest", "turned"))
    with chromium() as browser:
        # The driver of the browser is a child of this process, and the browser its child.
        process = _driver()
        for measure in load, rest, turned, emulated:
            before = _busy()
            line = measure(browser, process)
            goals = {name: goal for name, goal in _GOALS.items() if name in line}
            if measure is emulated:
                goals.pop("page_cpu_share")  # the goal is for a page that shows, not computes
            named = {f"goal_{name}": goal for name, goal in goals.items()}
            print(json.dumps({"benchmark": "studio", **line, **named, **before}), flush=True)


def _driver() -> int:
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            words = (folder / "stat").read_text().rpartition(")")[2].split()
            if int(words[1]) == os.getpid():
                return int(folder.name)
    raise RuntimeError("the browser does not run")


if __name__ == "__main__":
    main()
