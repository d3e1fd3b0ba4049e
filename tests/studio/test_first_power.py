"""First power, step by step on the page, as docs/how-to/first-power.md has it."""

from __future__ import annotations

import re
from pathlib import Path

from playwright.sync_api import Browser, Locator, Page, expect

from tests.studio.browser import armed, news, opened, state_is

GUIDE = Path(__file__).parents[2] / "docs/how-to/first-power.md"


def _step(page: Page, title: str) -> Locator:
    """A step of first power."""
    label = page.get_by_text(title, exact=True)
    return page.locator("#first-power-steps li").filter(has=label)


# The emergency stop pressed, released and its fault cleared while nothing is drawn.
PRESSED_BETWEEN_TWO_PICTURES = """async () => {
  const draw = requestAnimationFrame, waiting = [];
  window.requestAnimationFrame = (picture) => waiting.push(picture);
  const there = (id) => document.getElementById(id);
  const becomes = (when) => new Promise((resolve) => {
    const look = () => (when() ? resolve() : setTimeout(look, 1));
    look();
  });
  there("emergency-stop").click();
  await becomes(() => there("faults").children.length);
  const told = there("faults").textContent;
  there("emergency-stop").click();
  there("clear-fault").click();
  await becomes(() => there("state").value === "disarmed");
  window.requestAnimationFrame = draw;
  waiting.forEach((picture) => draw(picture));
  return told;
}"""


def test_first_power_stops_the_motor_in_a_tab_that_is_hidden(browser: Browser, site: str) -> None:
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        page.click("#first-power summary")
        _step(page, "Motor").locator("button").click()
        expect(page.locator("#python")).to_contain_text("torsio.Constant(torque_nm=")
        # The browser draws no picture of it any more.
        page.evaluate("window.requestAnimationFrame = () => 0")
        page.click("#arm")
        expect(_step(page, "Motor").locator("input")).to_be_checked()
        state_is(page, "disarmed")


def test_first_power_goes_on_as_the_knob_does_what_it_should(browser: Browser, site: str) -> None:
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        page.focus("#dial")
        for _ in range(4):
            page.keyboard.press("PageUp")
        page.click("#first-power summary")
        titles = page.locator("#first-power-steps label").all_text_contents()
        guide = GUIDE.read_text(encoding="utf-8")
        assert "(studio.md#on-the-page)" in guide
        assert titles == re.findall(r"^\d+\. \*\*(.+?)\*\*", guide, re.M)
        present = page.locator("#first-power-steps [aria-current=step] label")
        done = {title: _step(page, title).locator("input") for title in titles}
        expect(done["Link"]).to_be_checked()
        expect(present).to_have_text("Encoder")
        # Turned by hand, backwards first.
        expect(_step(page, "Encoder")).to_contain_text("of 360")
        page.focus("#dial")
        for _ in range(4):
            page.keyboard.press("PageDown")
        expect(_step(page, "Encoder")).to_contain_text("counts backwards")
        for _ in range(24):
            page.keyboard.press("PageUp")
        expect(done["Encoder"]).to_be_checked()
        # It cannot see steps with a meter; the others go on by themselves.
        expect(present).to_have_text("Supply")
        page.keyboard.press("Backspace")
        assert "close its contact to ground" in page.evaluate(PRESSED_BETWEEN_TWO_PICTURES)
        expect(done["Emergency stop"]).to_be_checked()
        # Nobody holds the knob: the push turns it, and then the page disarms.
        expect(done["Motor"]).not_to_be_checked()
        _step(page, "Motor").locator("button").click()
        expect(page.locator("#python")).to_contain_text("torsio.Constant(torque_nm=")
        caps = {"motor_torque_cap_nm": 0.015, "brake_torque_cap_nm": 0.015, "speed_limit_rad_s": 10}
        for name, value in caps.items():
            expect(page.locator(f"#control_config input[name={name}]")).to_have_value(str(value))
        assert page.locator("#state").get_attribute("value") == "disarmed"
        # The hand turned the knob faster than the limit that holds now.
        expect(page.locator("#speed_rad_s")).to_have_text("0.00 rad/s")
        # It may be over before anybody sees the knob armed.
        page.click("#arm")
        expect(done["Motor"]).to_be_checked()
        state_is(page, "disarmed")
        # Once more: it ends as well.
        page.click("#arm")
        news(page, 2000)
        state_is(page, "disarmed")
        expect(page.locator("#faults li")).to_have_count(0)
        expect(present).to_have_text("Supply")
        done["Supply"].check()
        expect(present).not_to_have_text("Supply")
        _step(page, "Brake").locator("button").click()
        expect(page.locator("#python")).to_contain_text("torsio.Friction(torque_nm=0.01)")
        page.wait_for_selector("#control_config")
        armed(page)
        page.focus("#dial")
        for _ in range(100):
            if done["Brake"].is_checked():
                break
            # In small steps: more than 10 rad/s are a fault now.
            page.keyboard.press("ArrowRight")
            news(page)
        expect(done["Brake"]).to_be_checked()
        expect(page.locator("#message")).to_be_hidden()
