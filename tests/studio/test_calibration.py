"""Calibration as the page's guided steps, by the server that has the knob."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, WebSocketRoute, expect

import torsio
from tests.studio.browser import bridge, faults_of_access, opened, state_is
from torsio.studio.calibrating import calibrate_for

STIFFNESS = torsio.PlantParams().shaft_stiffness_nm_per_rad
DRIFT = {"do": "calibrate", "drift": True}
SUPPLY_V = 13.2
DEEP = "[" * 100_000


def test_page_measures_shows_and_keeps_what_it_found_when_told(
    browser: Browser, tmp_path: Path
) -> None:
    window = {"viewport": {"width": 400, "height": 860}, "color_scheme": "dark"}
    with (
        bridge(XDG_DATA_HOME=str(tmp_path)) as address,
        opened(browser, address, **window) as page,
    ):
        state_is(page, "disarmed")
        page.locator("#calibration summary").click()
        expect(page.locator("#calibrate")).to_be_disabled()
        assert faults_of_access(page) == []
        page.check("#calibrate-clear")
        page.check("#calibrate-drift")
        page.click("#calibrate")
        expect(page.locator("#calibration-keep")).to_be_visible()
        expect(page.locator("#calibration-steps .done")).to_have_count(3)
        expect(page.locator("#calibration-result canvas")).to_have_count(3)
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            assert faults_of_access(page) == []
        row = page.locator("#calibration-result tr", has_text="stiffness_nm_per_rad").first
        value, _, sigma = (row.locator("td").nth(1).text_content() or "").partition(" ± ")
        # Four standard uncertainties: one of 16,000 honest ones is further off.
        assert float(value) == pytest.approx(STIFFNESS, abs=4 * float(sigma))
        assert list(tmp_path.rglob("*.json")) == []
        page.click("#calibration-keep")
        expect(page.locator("#calibration-result")).to_contain_text("emulated knob forgets it")
        (kept,) = tmp_path.rglob("*.json")
        found = json.loads(kept.read_text())["quantities"]["stiffness_nm_per_rad"]
        assert float(value) == pytest.approx(found["value"], abs=0.1 * float(sigma))
        # The page has its knob again.
        state_is(page, "disarmed")
        expect(page.locator("#who")).to_contain_text("held by torsio studio")
        expect(page.locator("#message")).to_be_hidden()


class _Page:
    """A page for the server: it says `sayings`, and goes `away` after a step."""

    def __init__(self, *sayings: Any, away: str = "") -> None:
        self.told: list[dict[str, Any]] = []
        self._sayings, self._away = list(sayings), away
        self._left = asyncio.Event()

    async def receive_text(self) -> str:
        saying = self._sayings.pop(0)
        return DEEP if saying is DEEP else json.dumps(saying)

    async def receive(self) -> dict[str, Any]:
        await self._left.wait()
        return {"type": "websocket.disconnect"}

    async def send_json(self, said: dict[str, Any]) -> None:
        self.told.append(said)
        if said.get("name") == self._away:
            self._left.set()


@pytest.fixture
def knob(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[torsio.Knob]:
    """Give a knob that can be looked at when the server has closed it."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    with torsio.open("emulated") as knob, monkeypatch.context() as patch:
        patch.setattr(knob, "close", lambda: None)
        yield knob


def _calibrated(knob: torsio.Knob, *sayings: Any, away: str = "") -> list[dict[str, Any]]:
    page = _Page(*sayings, away=away)

    async def run() -> None:
        try:
            await calibrate_for(page, lambda: knob)  # type: ignore[arg-type]
        except Exception as error:
            page.told.append({"kind": type(error).__name__})

    # The browser's driver has a loop of its own in this thread.
    with ThreadPoolExecutor() as pool:
        pool.submit(lambda: asyncio.run(run())).result()
    return page.told


def test_page_that_goes_stops_the_knob_and_leaves_it_as_it_was(knob: torsio.Knob) -> None:
    before = (knob.actuator_config(), knob.control_config())
    told = _calibrated(knob, {"do": "calibrate"}, away="signs")
    assert [said["kind"] for said in told] == ["step", "WebSocketDisconnect"]
    assert knob.state == "disarmed"
    assert (knob.actuator_config(), knob.control_config()) == before


def test_server_that_ends_stops_the_knob_and_closes_it_as_it_was(
    knob: torsio.Knob, monkeypatch: pytest.MonkeyPatch
) -> None:
    def look() -> tuple[Any, ...]:
        return knob.state, knob.actuator_config(), knob.control_config()

    before, closed = look(), []
    monkeypatch.setattr(knob, "close", lambda: closed.append(look()))
    page = _Page({"do": "calibrate"}, away="never")

    async def run() -> None:
        calibrating = asyncio.create_task(calibrate_for(page, lambda: knob))  # type: ignore[arg-type]
        while {"kind": "step", "name": "friction and inertia"} not in page.told:
            await asyncio.sleep(1e-3)
        calibrating.cancel()
        await asyncio.wait({calibrating})
        assert calibrating.cancelled()

    with ThreadPoolExecutor() as pool:
        pool.submit(lambda: asyncio.run(run())).result()
    assert closed == [before]


@pytest.mark.parametrize("answer", [{"do": "leave"}, [], DEEP], ids=["leave", "list", "deep"])
def test_nothing_is_kept_without_a_yes(knob: torsio.Knob, tmp_path: Path, answer: Any) -> None:
    knob.update(knob_coulomb_nm=3e-3)
    before = knob.actuator_config()
    told = _calibrated(knob, DRIFT, answer)
    assert [said["kind"] for said in told] == ["step", "step", "step", "found"]
    assert told[-1]["changes"]
    assert knob.actuator_config() == before
    assert list(tmp_path.rglob("*.json")) == []


@pytest.fixture
def driven(monkeypatch: pytest.MonkeyPatch) -> Iterator[torsio.Knob]:
    """Give a knob that measures its motor's current, on a supply that is not the configured one."""
    plant = torsio.PlantParams(electrics=torsio.Electrics(supply_v=SUPPLY_V))
    options = torsio.EmulatorOptions(plant=plant, control_rate_hz=20_000.0)
    with torsio.open("emulated", emulator=options) as knob, monkeypatch.context() as patch:
        patch.setattr(knob, "close", lambda: None)
        knob.sleep(0.2)
        yield knob


def test_supply_that_a_meter_shows_is_reckoned_with_and_proposed(driven: torsio.Knob) -> None:
    told = _calibrated(driven, {"do": "calibrate", "supply_v": SUPPLY_V}, {"do": "leave"})
    assert told[-1]["kind"] == "found", told[-1]
    changes = {name: after for name, _, after in told[-1]["changes"]}
    assert changes["supply_v"] == SUPPLY_V
    constant = {name: value for name, value, _ in told[-1]["quantities"]}[
        "motor_torque_constant_nm_per_a"
    ]
    value, _, sigma = constant.partition(" +- ")
    assert float(value) == pytest.approx(0.05, abs=2.0 * float(sigma))
    assert float(sigma) < 0.02 * 0.05


@pytest.mark.parametrize("supply_v", ["12", [12.0], 1e9], ids=["text", "list", "far"])
def test_supply_that_is_none_is_refused(knob: torsio.Knob, supply_v: Any) -> None:
    told = _calibrated(knob, {"do": "calibrate", "supply_v": supply_v})
    assert [said["kind"] for said in told] == ["refused"]
    assert "supply_v" in told[0]["why"]


def test_page_says_that_a_measurement_died_without_a_last_word(browser: Browser) -> None:
    with bridge() as address, browser.new_context() as context:
        # In place of the server's measurement: one that goes after its first step.
        def die(socket: WebSocketRoute) -> None:
            def answer(_: str | bytes) -> None:
                socket.send(json.dumps({"kind": "step", "name": "signs"}))
                socket.close()

            socket.on_message(answer)

        page = context.new_page()
        page.route_web_socket("**/calibration*", die)
        page.goto(address)
        state_is(page, "disarmed")
        page.locator("#calibration summary").click()
        page.check("#calibrate-clear")
        page.click("#calibrate")
        expect(page.locator("#calibration-result")).to_contain_text("nothing was measured")
        state_is(page, "disarmed")  # it has its knob again


@pytest.mark.parametrize("forgets", [False, True])
def test_page_says_what_keeps_it(browser: Browser, *, forgets: bool) -> None:
    found: dict[str, object] = {name: [] for name in ("quantities", "changes", "drifted", "fits")}
    with bridge() as address, browser.new_context() as context:
        # In place of the server's measurement: one of a knob that keeps, or does not.
        def find(socket: WebSocketRoute) -> None:
            def answer(_: str | bytes) -> None:
                socket.send(
                    json.dumps(found | {"kind": "found", "seconds": 1.0, "compared_with": None})
                )
                socket.send(json.dumps({"kind": "kept", "path": "x.json", "forgets": forgets}))
                socket.close()

            socket.on_message(answer)

        page = context.new_page()
        page.route_web_socket("**/calibration*", find)
        page.goto(address)
        state_is(page, "disarmed")
        page.locator("#calibration summary").click()
        page.check("#calibrate-clear")
        page.click("#calibrate")
        expect(page.locator("#calibration-result")).to_contain_text("x.json.")
        words = page.locator("#calibration-result").text_content() or ""
        assert ("Kept in the knob" in words, "forgets it" in words) == (not forgets, forgets)


def test_page_tells_the_supply_that_was_typed(browser: Browser, tmp_path: Path) -> None:
    with bridge(XDG_DATA_HOME=str(tmp_path)) as address, opened(browser, address) as page:
        state_is(page, "disarmed")
        page.locator("#calibration summary").click()
        page.check("#calibrate-clear")
        page.fill("#calibrate-supply", "12.3")
        page.click("#calibrate")
        # This knob measures no current, so nothing would use it.
        expect(page.locator("#calibration-result")).to_contain_text(
            "supply_v is for the electrical"
        )


def test_knob_that_is_held_is_refused_with_the_reason(knob: torsio.Knob) -> None:
    knob.emulator.set_hand(torsio.PrescribedMotion(angle_rad=[(0.0, 0.0)]))
    told = _calibrated(knob, DRIFT)
    assert told[-1]["kind"] == "refused"
    assert "signs: " in told[-1]["why"]


@pytest.mark.parametrize("saying", [{"do": "keep"}, [], "calibrate", None, DEEP], ids=lambda _: "")
def test_nonsense_measures_nothing(knob: torsio.Knob, saying: Any) -> None:
    assert [said["kind"] for said in _calibrated(knob, saying)] == ["refused"]
