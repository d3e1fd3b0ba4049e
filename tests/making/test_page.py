"""A rehearsal on the studio's page: as on the bench, with a fault built in."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

from playwright.sync_api import expect

from tests.studio.browser import PROGRAM, chromium, opened, state_is


@contextmanager
def rehearsed(*words: str) -> Iterator[tuple[list[str], str]]:
    """Run `torsio rehearse --page`; gives what a meter shows, and the page's address."""
    with subprocess.Popen(
        [*PROGRAM, "rehearse", "--page", *words], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        told: list[str] = []
        while not (line := process.stdout.readline()).startswith("studio"):
            assert line
            told.append(line)
        try:
            yield told, line.split()[1]
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(30)


def test_page_shows_that_the_motor_turns_backwards() -> None:
    with (
        rehearsed("--fault", "motor_swapped") as (meter, address),
        chromium() as browser,
        opened(browser, address) as page,
    ):
        assert meter[0] == "meter   12.0 V at bridges\n"
        state_is(page, "disarmed")
        page.click("#first-power summary")
        step = page.locator("#first-power-steps li").filter(has_text="Motor").first
        step.locator("button").click()
        expect(page.locator("#python")).to_contain_text("torsio.Constant(torque_nm=")
        page.click("#arm")
        expect(step).to_contain_text("turned backwards", timeout=60_000)
