"""The distribution's Chromium, and pages of the studio served to it on loopback."""

from __future__ import annotations

import functools
import math
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, expect, sync_playwright

PAGE = Path(__file__).parents[2] / "build/studio/page"
AXE = Path(__file__).parents[2] / "studio/node_modules/axe-core/axe.min.js"
# More than the delay of a moving hand, and a few of the slowest readout.
STILL_SAMPLES = 800
# Chromium asks its maker's servers for many things. Each would wait in vain here.
_OPTIONS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"),
    *("--disable-background-networking", "--disable-component-update"),
)


class _Quiet(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: Any) -> None:
        pass


@contextmanager
def served(folder: Path = PAGE) -> Iterator[str]:
    """Serve a folder as any host would; gives its address."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(_Quiet, directory=str(folder)))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


PROGRAM = (sys.executable, "-c", "from torsio.__main__ import main; main()")
BRIDGE = ("studio", "--device", "emulated", "--page", str(PAGE))


@contextmanager
def bridge(*words: str, **environment: str) -> Iterator[str]:
    """Run `torsio studio`, or other words, with an emulated knob; gives the address it prints."""
    command, env = [*PROGRAM, *(words or BRIDGE)], {**os.environ, **environment}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=env) as process:
        assert process.stdout is not None
        name, address = "", ""
        while name != "studio":
            line = process.stdout.readline()
            assert line
            name, _, address = line.strip().partition("  ")
        try:
            yield address
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(30)


@contextmanager
def chromium() -> Iterator[Browser]:
    """Start the distribution's browser."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path="/usr/bin/chromium", args=list(_OPTIONS)
        )
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def opened(browser: Browser, address: str, **options: Any) -> Iterator[Page]:
    """Open a page as a new visitor; what it complains of is an error in the end."""
    complaints: list[str] = []
    page = browser.new_page(**{"viewport": {"width": 1280, "height": 860}, **options})
    page.set_default_timeout(60_000)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    try:
        page.goto(address)
        yield page
    finally:
        page.close()
    assert not complaints, complaints


def state_is(page: Page, state: str) -> None:
    """Wait until the page shows a state of the knob."""
    page.wait_for_selector(f"#state[value='{state}']", state="attached")


def armed(page: Page) -> None:
    """Arm the knob as a person does, once it is there."""
    state_is(page, "disarmed")
    page.click("#arm")
    state_is(page, "armed")


def drag_to(page: Page, angle_rad: float, steps: int = 12) -> None:
    """Take the knob at its right and drag it round by an angle; it stays held."""
    box = page.locator("#dial").bounding_box()
    assert box is not None
    x, y, radius = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, 0.4 * box["width"]
    page.mouse.move(x + radius, y)
    page.mouse.down()
    for step in range(1, steps + 1):
        angle = angle_rad * step / steps
        page.mouse.move(x + radius * math.cos(angle), y + radius * math.sin(angle))


def number(page: Page, name: str) -> float:
    """Return a readout, in SI units."""
    return numbers(page, name)[0]


def be_patient(page: Page) -> None:
    """Have the knob wait a minute for its page: a busy or emulated machine is slow."""
    control = page.locator("#control_config")
    control.locator("summary").click()
    control.locator("input[name=watchdog_s]").fill("60")
    control.locator("button.apply").click()
    expect(page.locator("#control_config .differences")).to_be_empty()


def numbers(page: Page, *names: str) -> list[float]:
    """Return readouts of one moment, in SI units, once there are samples to read them from."""
    # The knob's state is shown as soon as the page has it; its samples come later.
    read = """(names) => {
      const shown = names.map((name) => parseFloat(document.getElementById(name).value));
      return shown.some(Number.isNaN) ? false : shown;
    }"""
    return list(page.wait_for_function(read, arg=list(names)).json_value())


def news(page: Page, samples: int = 100) -> None:
    """Wait until the numbers shown are of a later moment."""
    written = page.evaluate("window.studio.written()")
    page.wait_for_function(f"window.studio.written() > {written + samples}")


def settled(page: Page, name: str, *, within: float, timeout_ms: float = 60_000) -> float:
    """Wait until a readout of the samples stands still, and return it."""
    # Counts news instead of time: late news is no standstill.
    page.wait_for_function(
        f"""([name, within]) => {{
          const value = Number(document.getElementById(name).value);
          const written = window.studio.written();
          const state = (window.settling ??= {{}});
          const kept = state[name];
          if (!kept || Math.abs(value - kept.value) > within || written < kept.since) {{
            state[name] = {{ value, since: written }};
            return false;
          }}
          return written - kept.since > {STILL_SAMPLES};
        }}""",
        arg=[name, within],
        timeout=timeout_ms,
    )
    # The next time counts anew.
    page.evaluate("window.settling = {}")
    return number(page, name)


def faults_of_access(page: Page) -> list[tuple[str, str]]:
    """Have axe look at the page as it stands; gives rules that are broken, and where."""
    page.add_script_tag(path=AXE)
    found = page.evaluate("axe.run().then((found) => found.violations)")
    return [(of["id"], node["html"]) for of in found for node in of["nodes"]]
