"""The page in Firefox, which has no WebHID: it reaches a knob through `torsio studio`."""

from __future__ import annotations

import pytest

from tests.studio.browser import bridge
from tests.studio.firefox import firefox

ESCAPE = "\ue00c"  # as WebDriver names it
STIFFNESS, REST_RAD = 0.3, 0.2


def test_firefox_plays_a_spring_through_the_bridge_and_one_key_disarms() -> None:
    with bridge() as address, firefox() as page:
        page.goto(address)
        page.wait_for("document.getElementById('state').value === 'disarmed'")
        assert "held by torsio studio" in page.text("#who")
        page.click("[aria-label='remove Wall']")
        page.evaluate("document.getElementById('new-effect').value = 'spring'")
        page.click("#add-effect")
        page.fill("#effects input[name=angle_rad]", str(REST_RAD))
        page.fill("#effects input[name=stiffness_nm_per_rad]", str(STIFFNESS))
        # As slow as a loaded machine may be, this page is there.
        page.wait_for("document.querySelector('#control_config button.apply')")
        page.fill("#control_config input[name=watchdog_s]", "60")
        page.click("#control_config button.apply")
        page.wait_for("document.querySelector('#control_config .differences').innerText === ''")
        page.click("#arm")
        page.wait_for("document.getElementById('state').value === 'armed'")
        # Friction holds the knob short of the rest angle; at rest the law can be read off.
        page.wait_for("Number(document.getElementById('angle_rad').value) > 0.05")
        page.wait_for("document.getElementById('speed_rad_s').innerText.startsWith('0.00')")
        wanted = STIFFNESS * (REST_RAD - page.value("angle_rad"))
        assert page.value("desired_torque_nm") == pytest.approx(wanted, abs=0.01)
        page.press(ESCAPE)
        page.wait_for("document.getElementById('state').value === 'disarmed'")
        # The other way says what to use.
        page.evaluate("document.getElementById('connection').value = 'webhid'")
        page.click("#connect")
        page.wait_for("!document.getElementById('message').hidden")
        assert "this browser has no WebHID" in page.text("#message")
