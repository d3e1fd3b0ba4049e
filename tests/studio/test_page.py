"""The page with the emulated knob in it: one drags the knob into a wall and sees the torques.

Expected values come from the law of the wall, the balance of torques on a knob at rest, and the
reference actuator's numbers.
"""

from __future__ import annotations

import json
import math
import re
import time
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, expect

import torsio
from tests.recordings import check_recording, counts_in_foxglove
from tests.studio.browser import (
    armed,
    drag_to,
    faults_of_access,
    news,
    number,
    numbers,
    opened,
    settled,
    state_is,
)
from torsio import protocol
from torsio.trading.sources import options_of

TREE = Path(__file__).parents[2]
STIFFNESS, WALL_RAD = 1.4, 0.3  # the page's first scene
COULOMB_NM = torsio.PlantParams().knob_coulomb_nm
# A count of the encoder, twice: the wall's torque is computed from counts.
STEP_NM = STIFFNESS * 2 * 2 * math.pi / 8192
FLOAT = 1e-6


def _shared(wanted_nm: float, sensed_nm: float) -> tuple[float, float]:
    """The commands of motor and brake: (3) and (4) of docs/explanation/theory.md with beta 0.5."""
    helps = wanted_nm * sensed_nm >= 0
    return (wanted_nm - sensed_nm, abs(wanted_nm) / 2) if helps else (wanted_nm, 0.0)


def test_wall_pushes_back_as_its_law_says_and_one_key_disarms(browser: Browser, site: str) -> None:
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        assert number(page, "desired_torque_nm") == 0.0
        armed(page)
        # Time waits for a page that is busy.
        page.evaluate("for (const end = Date.now() + 500; Date.now() < end; );")
        drag_to(page, 0.4)
        settled(page, "angle_rad", within=1e-4)
        # Slowly: a bounce off the wall may have wound the spring the other way.
        for _ in range(3):
            page.keyboard.press("ArrowRight")
            settled(page, "angle_rad", within=1e-4)
        names = ("angle_rad", "desired_torque_nm", "motor_command_nm", "brake_capacity_nm")
        angle, wanted, motor, brake, sensed, spring, hand = numbers(
            page, *names, "spring_torque_nm", "true_spring_torque_nm", "true_hand_torque_nm"
        )
        assert angle > WALL_RAD
        assert wanted == pytest.approx(-STIFFNESS * (angle - WALL_RAD), abs=STEP_NM)
        # At rest hand, motor, spring and dry friction are in balance.
        assert abs(hand + motor + spring) <= COULOMB_NM + FLOAT
        # The spring carries the hand's press, as far as the sensor sees it. The sensor does not
        # know the brake's drag, and knows the brake down to its floor only.
        assert sensed < 0
        known = torsio.ActuatorConfig()
        blind = known.brake_torque_min_nm + known.brake_drag_nm
        assert sensed == pytest.approx(spring, abs=blind)
        expected_motor, expected_brake = _shared(wanted, sensed)
        assert motor == pytest.approx(expected_motor, abs=2e-5)
        assert brake == pytest.approx(expected_brake, rel=0.05)

        page.keyboard.press("Escape")
        state_is(page, "disarmed")
        page.wait_for_function("Number(document.getElementById('motor_command_nm').value) === 0")
        page.mouse.up()
        expect(page.locator("#message")).to_be_hidden()
        expect(page.locator("#link")).to_contain_text("0 lost")


def test_hand_takes_the_knob_where_it_is_also_once_its_zero_was_set(
    browser: Browser, site: str
) -> None:
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        drag_to(page, 0.8)
        settled(page, "angle_rad", within=1e-3)
        page.mouse.up()
        page.click("#zero")
        page.wait_for_function("Math.abs(document.getElementById('angle_rad').value) < 1e-3")
        drag_to(page, 0.2)
        assert settled(page, "angle_rad", within=1e-3) == pytest.approx(0.2, abs=0.02)


def test_key_disarms_a_knob_that_is_about_to_bearmed(browser: Browser, site: str) -> None:
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        # Both keys before the page knows of either's answer.
        page.evaluate(
            """() => {
              document.getElementById("arm").click();
              dispatchEvent(new KeyboardEvent("keydown", { key: "Escape" }));
            }"""
        )
        news(page, 2000)
        state_is(page, "disarmed")


def test_scene_in_which_the_knob_may_swing_is_warned_of(browser: Browser, site: str) -> None:
    with opened(browser, site) as page:
        armed(page)
        page.fill("#effects input[name=stiffness_nm_per_rad]", "80")
        expect(page.locator("#message")).to_contain_text("may swing")
        page.fill("#effects input[name=stiffness_nm_per_rad]", "1")
        expect(page.locator("#message")).to_be_hidden()


def test_scene_plays_as_one_edits_and_gives_lines_that_play_the_same(
    browser: Browser, site: str
) -> None:
    with opened(browser, site) as page:
        armed(page)
        page.get_by_role("button", name="remove Wall").click()
        page.select_option("#new-effect", "spring")
        page.click("#add-effect")
        page.fill("#effects input[name=angle_rad]", "0.5")
        page.fill("#effects input[name=stiffness_nm_per_rad]", "0.05")
        # A spring of 0.05 N m/rad to 0.5 rad, at angle 0: friction holds the knob there or short of
        # the rest angle, and the law holds wherever that is.
        page.wait_for_function(
            """() => {
              const value = (name) => Number(document.getElementById(name).value);
              const wanted = 0.05 * (0.5 - value("angle_rad"));
              return Math.abs(value("desired_torque_nm") - wanted) <= 2e-5;
            }"""
        )
        settled(page, "desired_torque_nm", within=1e-6)
        expect(page.locator("#message")).to_be_hidden()
        angle, wanted = numbers(page, "angle_rad", "desired_torque_nm")
        assert wanted == pytest.approx(0.05 * (0.5 - angle), abs=2e-5)

        page.fill("#effects input[name=stiffness_nm_per_rad]", "-1")
        expect(page.locator("#message")).to_have_text(
            "effect 0 (spring): stiffness_nm_per_rad is -1, allowed are 0 to 1000000 N m/rad"
        )
        # A refused scene cannot be copied.
        expect(page.locator("#copy-python")).to_be_disabled()
        page.fill("#effects input[name=stiffness_nm_per_rad]", "0.05")
        expect(page.locator("#copy-python")).to_be_enabled()
        page.select_option("#new-effect", "periodic")
        page.click("#add-effect")
        page.select_option("#effects select[name=waveform]", "triangle")
        lines = page.locator("#python").text_content() or ""
        played: list[object] = []
        exec(lines, {"torsio": torsio, "knob": type("Knob", (), {"play": played.append})})
        assert played == [
            [
                torsio.Spring(angle_rad=0.5, stiffness_nm_per_rad=0.05),
                torsio.Periodic(waveform="triangle", amplitude_nm=0.02, frequency_hz=2),
            ]
        ]
        assert page.locator("#cpp").text_content() == (
            "knob.play({\n"
            "    torsio::Spring{.angle_rad = 0.5, .stiffness_nm_per_rad = 0.05},\n"
            "    torsio::Periodic{.waveform = torsio::Waveform::triangle, .amplitude_nm = 0.02, "
            ".frequency_hz = 2},\n});\n"
        )


def test_curve_is_drawn_as_its_numbers_say_by_keys_too(browser: Browser, site: str) -> None:
    """The picture of a curve and its field of numbers are the same torques."""
    # Whether the drawing's line passes a torque in the middle of its span; 0.1 N m is the top.
    passes = """([canvas, torque]) => {
      const x = canvas.width / 2 - 1, y = Math.round((1 - torque / 0.1) * canvas.height / 2) - 2;
      return canvas.getContext("2d").getImageData(x, y, 2, 4).data.some((value) => value > 0);
    }"""
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        page.get_by_role("button", name="remove Wall").click()
        page.select_option("#new-effect", "curve")
        page.click("#add-effect")
        picture = page.locator("#effects canvas.drawing")
        numbers = page.locator("#effects input[name=torque_nm]")

        def shows(torque_nm: float) -> bool:
            return bool(page.evaluate(passes, [picture.element_handle(), torque_nm]))

        numbers.fill("0, 0.08, 0")
        assert shows(0.08)
        numbers.fill("0, -0.05, 0")
        assert shows(-0.05)
        assert not shows(0.08)

        picture.focus()
        place = page.evaluate("scrollY")
        for key in ("ArrowRight", "PageUp", "ArrowUp", "ArrowUp", "End", "ArrowDown"):
            page.keyboard.press(key)
        # -0.05 + 0.02 + 2 * 0.002, and the last one down by 0.002.
        expect(numbers).to_have_value("0, -0.026, -0.002")
        assert shows(-0.026)
        assert picture.get_attribute("aria-valuetext") == "point 3 of 3: -0.002 N m"
        assert page.evaluate("scrollY") == place
        assert "[0, -0.026, -0.002]" in (page.locator("#python").text_content() or "")


def test_notches_are_on_the_dial_and_a_phone_has_room_for_it(browser: Browser, site: str) -> None:
    with opened(browser, site, viewport={"width": 390, "height": 844}) as page:
        state_is(page, "disarmed")
        expect(page.locator("#who")).to_contain_text("serial number")
        assert page.evaluate("document.querySelector('header').offsetHeight") < 80
        for line in page.locator("#over-time-legend line").all():
            assert line.evaluate("line => line.style.stroke")
        page.select_option("#new-effect", "detents")
        page.click("#add-effect")
        page.fill("#effects input[name=per_turn]", "24")
        expect(page.locator("#places .notch")).to_have_count(24)
        page.fill("#effects input[name=per_turn]", "1000")
        expect(page.locator("#places .notch")).to_have_count(0)
        # In a wider window the curves have all its pixels.
        page.set_viewport_size({"width": 700, "height": 844})
        page.wait_for_function(
            """() => {
              const { width, clientWidth } = document.querySelector(".u-over canvas");
              return clientWidth > 400 && Math.abs(width - devicePixelRatio * clientWidth) < 2;
            }"""
        )


def test_torque_beyond_telemetry_is_named_so(browser: Browser, site: str) -> None:
    """A sample has room for 32,767 steps of 10 uN m."""
    with opened(browser, site) as page:
        armed(page)
        page.get_by_role("button", name="remove Wall").click()
        page.select_option("#new-effect", "constant")
        page.click("#add-effect")
        page.fill("#effects input[name=torque_nm]", "0.3")
        expect(page.locator("#desired_torque_nm")).to_have_text("300.0 mN·m")
        page.fill("#effects input[name=torque_nm]", "-0.4")
        expect(page.locator("#desired_torque_nm")).to_have_text("beyond -327.7 mN·m")


def test_double_click_connects_one_knob(browser: Browser, site: str) -> None:
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        page.dblclick("#connect")
        state_is(page, "disarmed")
        expect(page.locator("#who")).to_contain_text("serial number")
        news(page)
        assert len(page.workers) == 1


def test_connection_that_fails_leaves_nothing_of_the_knob_before(
    browser: Browser, site: str
) -> None:
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        expect(page.locator("#link")).to_contain_text("samples/s")
        page.select_option("#connection", "bridge")
        page.click("#connect")
        expect(page.locator("#message")).to_contain_text("`torsio studio` does not answer")
        expect(page.locator("#who")).to_have_text("no knob")
        expect(page.locator("#state")).to_have_text("not connected")
        assert page.locator("#readouts").inner_text().split("\n")[-1] == "link"
        expect(page.locator("#angle_rad")).to_be_empty()
        expect(page.locator("#link")).to_be_empty()


def test_fault_is_named_with_what_to_do_and_can_be_cleared(browser: Browser, site: str) -> None:
    with opened(browser, site) as page:
        armed(page)
        page.click("#emergency-stop")
        state_is(page, "fault")
        expect(page.locator("#emergency-stop")).to_have_class(re.compile("is-pressed"))
        expect(page.locator("#faults li")).to_contain_text("emergency stop")
        # Its entry of docs/reference/troubleshooting.md.
        expect(page.locator("#faults details")).to_contain_text("broken wire then stops the knob")
        page.click("#clear-fault")
        expect(page.locator("#message")).to_contain_text("fault_persists")
        page.click("#emergency-stop")
        page.click("#clear-fault")
        state_is(page, "disarmed")
        expect(page.locator("#faults li")).to_have_count(0)


def test_configuration_is_checked_applied_compared_and_kept_in_a_file(
    browser: Browser, site: str, tmp_path: Path
) -> None:
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        card = page.locator("#control_config")
        card.locator("summary").click()
        card.locator("select[name=law]").select_option("motor_only")
        expect(card.locator(".differences")).to_have_text("law: paper in the knob, motor_only here")
        card.locator("input[name=beta]").fill("7")
        card.locator("button.apply").click()
        expect(page.locator("#message")).to_have_text("beta is 7, allowed are 0 to 1")
        card.locator("input[name=beta]").fill("0.25")
        card.locator("button.apply").click()
        expect(page.locator("#control_config .differences")).to_be_empty()
        # Settings of a player without a program.
        games = page.locator("#game_config")
        games.locator("summary").click()
        wanted = {"range_deg": 360, "gain": 0.5, "end_stiffness_nm_per_rad": 1}
        for name, value in wanted.items():
            games.locator(f"input[name={name}]").fill(str(value))
        games.locator("button.apply").click()
        expect(page.locator("#game_config .differences")).to_be_empty()
        page.click("#save")
        with page.expect_download() as download:
            page.click("#export-configuration")
        saved = tmp_path / "configuration.json"
        download.value.save_as(saved)
        configs = json.loads(saved.read_text())
        config = configs["control_config"]
        assert torsio.ControlConfig(**config) == torsio.ControlConfig(law="motor_only", beta=0.25)
        assert configs["game_config"].items() >= wanted.items()
        expect(page.locator("#message")).to_be_empty()

        for content, said in (
            ('{"control_config": {"betta": 1}}', "control_config.betta"),
            ("null", "the file is no configuration"),
            ("5", "the file is no configuration"),
            ("[]", "the file is no configuration"),
            ('{"control_config": null}', "the file's control_config is no configuration"),
            ('{"control_config": 5}', "the file's control_config is no configuration"),
        ):
            saved.write_text(content)
            page.set_input_files("#import-configuration", saved)
            expect(page.locator("#message")).to_contain_text(said)

        # Applying one card keeps the edits of another.
        for gain, encoding in ((0.125, "utf-16-be"), (0.375, "utf-16-le"), (0.25, "utf-8")):
            edited = (
                f'\ufeff{{"control_config": {{"beta": 0.75}}, "game_config": {{"gain": {gain}}}}}'
            )
            saved.write_text(edited, encoding)
            page.set_input_files("#import-configuration", saved)
            expect(games.locator(".differences")).to_have_text(
                f"gain: 0.5 in the knob, {gain} here"
            )
        page.locator("#control_config button.apply").click()
        expect(page.locator("#control_config .differences")).to_be_empty()
        expect(games.locator(".differences")).to_have_text("gain: 0.5 in the knob, 0.25 here")


def test_law_that_counts_energy_shows_what_became_of_it(browser: Browser, site: str) -> None:
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        expect(page.locator("#motor_j")).to_be_hidden()
        control = page.locator("#control_config")
        control.locator("summary").click()
        control.locator("select[name=law]").select_option("calibrated")
        control.locator("button.apply").click()
        expect(page.locator("#motor_j")).to_be_visible()
        armed(page)
        page.evaluate("scrollTo(0, 0)")  # back to the dial
        drag_to(page, 0.4)
        deep_rad = settled(page, "angle_rad", within=1e-4) - WALL_RAD
        assert deep_rad > 0.0
        # The energy that wall and friction took from the hand. Energies are asked for now and then,
        # so at rest they may come a moment later.
        taken = 0.5 * STIFFNESS * deep_rad**2 - STEP_NM * deep_rad
        page.wait_for_function(f"-Number(document.getElementById('felt_j').value) >= {taken}")
        motor, felt, stored, brake = numbers(page, "motor_j", "felt_j", "stored_j", "brake_j")
        assert motor == pytest.approx(felt + stored + brake, abs=1e-12)
        assert number(page, "bound_nm_per_rad") >= STIFFNESS


def test_keyboard_alone_turns_the_knob_in_a_narrow_dark_window(browser: Browser, site: str) -> None:
    small = {"viewport": {"width": 380, "height": 800}, "color_scheme": "dark"}
    with opened(browser, site, **small) as page:
        state_is(page, "disarmed")
        # Nothing sticks out at the side.
        assert page.evaluate("document.documentElement.scrollWidth") <= 380
        page.focus("#dial")
        for _ in range(3):
            page.keyboard.press("PageUp")
        # 3 x 20 degrees, less the friction in a soft hand.
        angle = settled(page, "angle_rad", within=1e-4)
        assert angle == pytest.approx(math.radians(60), abs=2 * COULOMB_NM / 0.8)
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(22, 23, 24)"


def test_axe_finds_no_fault_before_anything_is_drawn(browser: Browser, site: str) -> None:
    page = browser.new_page()
    page.route("**/main.js", lambda route: route.fulfill(body="", content_type="text/javascript"))
    page.goto(site)
    assert faults_of_access(page) == []
    page.close()


VALUES_CUT = """() => [...document.querySelectorAll(".fields input, .fields select")]
  .filter((field) => field.scrollWidth > field.clientWidth).map((field) => field.name)"""


def test_axe_finds_no_fault_with_everything_unfolded(browser: Browser, site: str) -> None:
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        page.wait_for_selector("#game_config")
        page.click("#emergency-stop")
        state_is(page, "fault")
        page.evaluate("for (const d of document.querySelectorAll('details')) d.open = true")
        for width in (1280, 400, 320):
            page.set_viewport_size({"width": width, "height": 860})
            # Room for some letters of the ways to a knob.
            assert page.evaluate("document.getElementById('connection').clientWidth") > 100
            for scheme in ("light", "dark"):
                page.emulate_media(color_scheme=scheme)
                assert faults_of_access(page) == [], (scheme, width)
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert page.evaluate(VALUES_CUT) == []
        assert "`" not in page.locator("#configurations").inner_text()


def test_pointer_is_seen_where_the_user_has_forced_the_colours(browser: Browser, site: str) -> None:
    with opened(browser, site, forced_colors="active") as page:
        state_is(page, "disarmed")
        drawn, behind = page.evaluate(
            """["pointer", "knob"].map((id) =>
              getComputedStyle(document.getElementById(id)).backgroundColor)"""
        )
        body = page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert drawn not in (behind, body)


def test_page_without_its_module_says_how_to_build_it(browser: Browser, site: str) -> None:
    page = browser.new_page()
    page.route("**/knob.wasm", lambda route: route.fulfill(status=404))
    page.goto(site)
    expect(page.locator("#message")).to_have_text(
        "knob.wasm is missing beside the page: build it with ./dev studio"
    )
    page.close()


def test_recording_of_the_page_is_one_that_the_library_loads_and_replays(
    browser: Browser, site: str, tmp_path: Path
) -> None:
    file = tmp_path / "page.mcap"
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        # At once: the page arms when the file has all that a replay needs.
        page.evaluate("for (const id of ['record', 'arm']) document.getElementById(id).click()")
        state_is(page, "armed")
        expect(page.locator("#record")).to_have_text("stop recording")
        drag_to(page, 0.4)
        rest = settled(page, "angle_rad", within=1e-4)
        page.keyboard.press("Escape")
        state_is(page, "disarmed")
        page.mouse.up()
        with page.expect_download() as download:
            page.click("#record")
        download.value.save_as(file)
        assert download.value.suggested_filename.endswith(".mcap")
        # A scene that plays already is noted.
        armed(page)
        page.click("#record")
        expect(page.locator("#record")).to_have_text("stop recording")
        news(page)
        page.keyboard.press("Escape")
        state_is(page, "disarmed")
        with page.expect_download() as download:
            page.click("#record")
        download.value.save_as(tmp_path / "later.mcap")
    wall = [torsio.Wall(angle_rad=WALL_RAD, stiffness_nm_per_rad=STIFFNESS)]
    assert options_of(file, {}).scene == wall
    assert options_of(tmp_path / "later.mcap", {}).scene == wall
    counts = check_recording(file)
    assert counts_in_foxglove(file) == counts
    recorded = torsio.load(file)
    assert recorded.whole
    samples = recorded.telemetry
    assert len(samples) > 500
    assert recorded.samples_lost == 0
    assert (np.diff(samples["tick"].astype(np.int64)) == 2).all()
    np.testing.assert_allclose(samples["time_s"], samples["tick"] * 250e-6, rtol=1e-12)
    counts_per_rev = recorded.metadata["info"]["counts_per_rev"]
    turned = samples["position_counts"] * 2 * math.pi / counts_per_rev
    np.testing.assert_allclose(samples["angle_rad"], turned, rtol=1e-12)
    # Where the page showed it at rest, the wall is in the file as its law has it.
    resting = np.abs(samples["angle_rad"] - rest) < 1e-4
    assert rest > WALL_RAD
    assert np.median(samples["desired_torque_nm"][resting]) == pytest.approx(
        -STIFFNESS * (rest - WALL_RAD), abs=STEP_NM
    )
    assert torsio.ControlConfig(**recorded.metadata["configuration"]["ControlConfig"])
    assert [event["kind"] for event in recorded.events] == ["play"]
    # One time line, the device's, with the host's beside it.
    begin_s, end_s = samples["time_s"][[0, -1]]
    offset_s = 1e-9 * recorded.metadata["clock"]["host_minus_device_ns"]
    for event in recorded.events + recorded.device_events:
        assert begin_s - 1.0 < event["device_time_s"] < end_s + 1.0
        assert event["host_time_ns"] * 1e-9 == pytest.approx(time.time(), abs=600.0)
        assert event["device_time_s"] + offset_s == pytest.approx(time.time(), abs=600.0)
    for event in recorded.device_events:
        assert event["device_time_s"] == pytest.approx(event["tick"] * 250e-6, abs=1e-6)
    assert "armed" in {event["state"] for event in recorded.device_events} | {
        protocol.decode(content)[1].get("state") for _, _, content in recorded.reports
    }
    # Every other tick is a sample, and the knob was at rest before: near it, not to the bit.
    replayed = torsio.replay(recorded)
    assert not replayed.from_inputs
    assert len(replayed.replayed) > len(samples) / 2
    assert replayed.largest_differences()["position_counts"] == 0
    assert replayed.largest_differences()["desired_torque_nm"] <= STEP_NM


def test_recording_that_fails_keeps_no_torque_on(browser: Browser, site: str) -> None:
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        page.click("#record")
        expect(page.locator("#record")).to_have_text("stop recording")
        armed(page)
        page.evaluate("TextEncoder.prototype.encode = () => { throw new Error('no memory'); }; 0")
        expect(page.locator("#message")).to_have_text("the recording ends here: no memory")
        page.keyboard.press("Escape")
        state_is(page, "disarmed")
        # What there was of it can be had.
        with page.expect_download():
            page.click("#record")


def test_recording_that_fails_at_its_end_keeps_no_knob(browser: Browser, site: str) -> None:
    with opened(browser, site) as page:
        state_is(page, "disarmed")
        page.click("#record")
        expect(page.locator("#record")).to_have_text("stop recording")
        armed(page)
        page.evaluate("Blob = class { constructor() { throw new Error('no memory'); } }; 0")
        page.click("#connect")
        expect(page.locator("#message")).to_have_text("no memory")
        state_is(page, "disarmed")
        news(page)
        assert len(page.workers) == 1
