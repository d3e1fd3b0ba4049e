"""A rehearsal on the studio's page: as on the bench, with a fault built in."""

from __future__ import annotations

from playwright.sync_api import expect

from tests.studio.browser import bridge, chromium, opened, state_is


def test_page_shows_that_the_motor_turns_backwards() -> None:
    words = ("rehearse", "--page", "--fault", "motor_swapped")
    with bridge(*words) as address, chromium() as browser, opened(browser, address) as page:
        state_is(page, "disarmed")
        page.click("#first-power summary")
        step = page.locator("#first-power-steps li").filter(has_text="Motor").first
        step.locator("button").click()
        expect(page.locator("#python")).to_contain_text("torsio.Constant(torque_nm=")
        page.click("#arm")  # it may be over before anybody sees the knob armed
        expect(step).to_contain_text("turned backwards", timeout=60_000)
