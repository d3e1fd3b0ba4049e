"""A page that drives a knob through `torsio studio`, and all whom the bridge does not let in."""

from __future__ import annotations

import asyncio
import math
import subprocess
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, WebSocketRoute, expect
from starlette.websockets import WebSocketDisconnect
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

from tests.python import wire
from tests.studio.browser import (
    BRIDGE,
    PROGRAM,
    be_patient,
    bridge,
    drag_to,
    news,
    number,
    opened,
    settled,
    state_is,
)
from torsio import protocol
from torsio.studio.bridge import KEPT_REPORTS, Bridge, Waiting
from torsio.studio.server import pass_on

WRITE, INPUT, GET, SET, GOT, TAKEN, HAVE = 0, 1, 2, 3, 4, 6, 7
COMMIT = 0x11


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Run the command, and give the address that it prints."""
    with bridge() as address:
        yield address


def _socket(address: str, *, origin: str = "", token: str | None = None) -> ClientConnection:
    url = urlsplit(address)
    query = url.query if token is None else f"token={token}"
    return connect(
        f"ws://{url.netloc}/knob?{query}",
        origin=Origin(origin or f"http://{url.netloc}"),
    )


def _said_at_the_door(socket: ClientConnection) -> str:
    with pytest.raises(ConnectionClosed) as closed:
        socket.recv(timeout=30)
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 4403
    return closed.value.rcvd.reason


def _said(socket: ClientConnection) -> Iterator[tuple[str, dict[str, Any]]]:
    """Give the reports that the device sends, as a quick page takes them."""
    while True:
        message = socket.recv(timeout=30)
        assert isinstance(message, bytes)
        if message[0] == INPUT:
            socket.send(bytes([HAVE]))
            for at in range(1, len(message), 64):
                yield wire.decode(message[at : at + 64])


def test_address_is_of_this_machine_alone(address: str) -> None:
    assert urlsplit(address).hostname == "127.0.0.1"


def test_page_plays_a_wall_on_the_knob_of_the_bridge(browser: Browser, address: str) -> None:
    with opened(browser, address) as page:
        state_is(page, "disarmed")
        expect(page.locator("#who")).to_contain_text("held by torsio studio")
        # Nobody turns this knob, so the scene does: a spring to 0.2 rad.
        page.get_by_role("button", name="remove Wall").click()
        page.select_option("#new-effect", "spring")
        page.click("#add-effect")
        page.fill("#effects input[name=angle_rad]", "0.2")
        page.fill("#effects input[name=stiffness_nm_per_rad]", "0.3")
        be_patient(page)
        page.click("#arm")
        state_is(page, "armed")
        page.wait_for_function("Number(document.getElementById('angle_rad').value) > 0.05")
        angle = settled(page, "angle_rad", within=1e-4)
        wanted = 0.3 * (0.2 - angle)
        step_nm = 0.3 * 2 * 2 * math.pi / 8192
        assert number(page, "desired_torque_nm") == pytest.approx(wanted, abs=step_nm)
        page.keyboard.press("Escape")
        state_is(page, "disarmed")


def test_mouse_turns_the_knob_that_the_command_holds(browser: Browser, address: str) -> None:
    with opened(browser, address) as page:
        state_is(page, "disarmed")
        expect(page.locator("#hint")).to_contain_text("drag the knob into the wall")
        be_patient(page)
        page.evaluate("scrollTo(0, 0)")
        page.click("#hint-arm")
        state_is(page, "armed")
        drag_to(page, 0.4)
        # The page's first wall stands at 0.3 rad.
        assert settled(page, "angle_rad", within=1e-4) > 0.3
        assert number(page, "true_hand_torque_nm") > 0.01
        expect(page.locator("#hint")).to_be_hidden()
        page.mouse.up()
        page.click("#emergency-stop")
        state_is(page, "fault")
        expect(page.locator("#emergency-stop")).to_have_text("release emergency stop")
        page.click("#emergency-stop")
        page.click("#clear-fault")
        state_is(page, "disarmed")


def test_page_without_the_emulated_device_says_no_word_about_it(
    browser: Browser, address: str
) -> None:
    with opened(browser, "about:blank") as page:
        page.route("**/knob.wasm", lambda route: route.fulfill(status=404))
        with page.expect_response("**/knob.wasm"):
            page.goto(address)
        state_is(page, "disarmed")
        page.fill("#effects input[name=stiffness_nm_per_rad]", "0.3")
        news(page, 2000)
        expect(page.locator("#message")).to_be_hidden()


def test_page_says_why_the_torque_went(browser: Browser, address: str) -> None:
    """The device's words are put in between: no test can starve a page in good order."""
    page_of: list[WebSocketRoute] = []

    def connect_through(route: WebSocketRoute) -> None:
        route.connect_to_server()
        page_of.append(route)

    with opened(browser, "about:blank") as page:
        page.route_web_socket("**/knob?*", connect_through)
        page.goto(address)
        state_is(page, "disarmed")
        events = [
            {"kind": "state_changed", "state": "armed", "owner": "sdk"},
            {"kind": "watchdog", "state": "armed", "owner": "sdk"},
            {"kind": "state_changed", "state": "disarmed", "owner": "none"},
        ]
        told = b"".join(protocol.encode("event", event) for event in events)
        page_of[0].send(bytes([INPUT]) + told)
        expect(page.locator("#message")).to_have_text(
            "the knob has disarmed itself: the host was silent for too long, or the bus was lost"
        )


def test_command_keeps_the_knob_armed_while_its_page_is_late(address: str) -> None:
    """A busy page gives no sign of life; the knob's watchdog counts in its own time."""
    watchdog_s, control_hz = 1.0, 4000.0
    with _socket(address) as socket:
        socket.recv(timeout=30)
        patience = {"sequence": 6, "watchdog_s": watchdog_s}
        socket.send(bytes([SET]) + protocol.encode("control_config", patience))
        socket.send(bytes([WRITE]) + protocol.encode("stream", {"sequence": 7, "decimation": 40}))
        socket.send(bytes([WRITE]) + protocol.encode("command", {"sequence": 8, "op": "arm"}))
        said = _said(socket)
        armed_at = next(v["tick"] for _, v in said if v.get("state") == "armed")
        for name, values in said:
            assert values.get("state") in (None, "armed"), values
            if name == "telemetry" and values["tick"] > armed_at + 3 * watchdog_s * control_hz:
                break
        disarm = protocol.encode("command", {"sequence": 9, "op": "disarm"})
        socket.send(bytes([WRITE]) + disarm)
        assert next(v["state"] for _, v in said if v.get("state") == "disarmed")


def test_command_keeps_no_knob_armed_whose_page_has_gone_silent_or_said_disarm(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It repeats a sign of life for a while, and none once the page wants no torque."""
    written: list[str] = []

    class Silent:
        def read(self, timeout_s: float) -> None:
            time.sleep(1e-3)

        def write(self, report: bytes) -> bool:
            written.append(protocol.decode(report)[1]["op"])
            return True

        def close(self) -> None:
            pass

    def told(*ops: str) -> list[str]:
        async def tell() -> None:
            bridge = Bridge(Silent())  # type: ignore[arg-type]
            for op in ops:
                await bridge.answer(bytes([WRITE]) + protocol.encode("command", {"op": op}))
            while len(written) < len(ops) + 2 and time.monotonic() < bridge._alive_until_s + 0.1:
                await asyncio.sleep(1e-3)
            await asyncio.to_thread(bridge.close)

        written.clear()
        with ThreadPoolExecutor() as pool:
            pool.submit(lambda: asyncio.run(tell())).result()
        return list(written)

    assert told("arm")[:3] == ["arm", "keep_alive", "keep_alive"]
    assert told("arm", "keep_alive", "disarm")[-2:] == ["disarm", "disarm"]
    monkeypatch.setattr("torsio.studio.bridge.PAGE_SILENCE_S", 0.0)
    assert told("arm") == ["arm", "disarm"]


class _Page:
    """A page that says commands, waits for conditions between them, and goes."""

    def __init__(self, *says: str | Callable[[], bool]) -> None:
        self._says = iter(says)
        self.told = ""

    async def send_text(self, text: str) -> None:
        pass

    async def send_bytes(self, message: bytes) -> None:
        pass

    async def receive_bytes(self) -> bytes:
        for says in self._says:
            if isinstance(says, str):
                return bytes([WRITE]) + protocol.encode("command", {"op": says})
            while not says():
                await asyncio.sleep(1e-3)
        raise WebSocketDisconnect

    async def close(self, code: int, reason: str) -> None:
        self.told = reason


class _Device:
    """Takes some commands and has no room for others."""

    def __init__(self, takes: Callable[[str], bool]) -> None:
        self.asked: list[str] = []
        self.taken: list[str] = []
        self._takes = takes

    def read(self, timeout_s: float) -> None:
        time.sleep(1e-3)

    def write(self, report: bytes) -> bool:
        op = protocol.decode(report)[1]["op"]
        self.asked.append(op)
        if takes := self._takes(op):
            self.taken.append(op)
        return takes

    def close(self) -> None:
        self.taken.append("close")

    def serve(self, page: _Page) -> list[str]:
        """Give what it took while the page was there."""

        async def run() -> list[str]:
            bridge = Bridge(self)  # type: ignore[arg-type]
            served = pass_on(bridge, page, title="", read_only=False)  # type: ignore[arg-type]
            await asyncio.wait_for(served, 30.0)
            taken = list(self.taken)
            await asyncio.to_thread(bridge.close)
            return taken

        with ThreadPoolExecutor() as pool:
            return pool.submit(lambda: asyncio.run(run())).result()


@pytest.mark.parametrize("stuck", ["zero", "arm"])
def test_disarm_passes_what_waits_and_no_arm_that_was_older_follows_it(stuck: str) -> None:
    device = _Device(lambda op: op == "disarm" or "disarm" in device.taken)
    waits, passed = (lambda: stuck in device.asked), (lambda: "save" in device.taken)
    page = _Page(stuck, waits, "arm", "save", "disarm", passed)
    assert [op for op in device.serve(page) if op != "zero"] == ["disarm", "save"]


def test_arm_that_is_under_way_while_a_disarm_passes_is_followed_by_one() -> None:
    def takes(op: str) -> bool:
        while op == "arm" and "disarm" not in device.taken:
            time.sleep(1e-3)
        return True

    device = _Device(takes)
    page = _Page("arm", lambda: "arm" in device.asked, "disarm", lambda: len(device.taken) == 3)
    assert device.serve(page) == ["disarm", "arm", "disarm"]


def test_device_that_has_no_room_is_given_up_and_disarmed_when_it_has(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("torsio.studio.bridge._ROOM_S", 0.1)
    device = _Device(lambda op: device.asked.count("disarm") == 5)
    page = _Page("zero", lambda: False)
    assert device.serve(page) == []
    assert "takes no more reports" in page.told
    assert device.taken == ["disarm", "close"]


def test_knob_that_is_armed_keeps_the_scene_that_plays(browser: Browser, address: str) -> None:
    sent: list[bytes] = []

    def connect_armed(route: WebSocketRoute) -> None:
        server = route.connect_to_server()

        def to_server(message: str | bytes) -> None:
            assert isinstance(message, bytes)
            sent.append(message)
            server.send(message)

        def to_page(message: str | bytes) -> None:
            if message != bytes([TAKEN]):  # answers to others' questions
                route.send(message)

        # Before the page's first word; the knob waits a minute for the next one.
        patient = protocol.encode("control_config", {"sequence": 6, "watchdog_s": 60.0})
        server.send(bytes([SET]) + patient)
        arm = wire.encode("command", {"sequence": 7, "axis": 0, "op": "arm"})
        server.send(bytes([WRITE]) + arm)
        route.on_message(to_server)
        server.on_message(to_page)

    with opened(browser, "about:blank") as page:
        page.route_web_socket("**/knob?*", connect_armed)
        page.goto(address)
        state_is(page, "armed")
        expect(page.locator("#message")).to_contain_text("keeps its scene until you edit")
        assert not [message for message in sent if message[:2] == bytes([WRITE, COMMIT])]
        page.keyboard.press("Escape")
        state_is(page, "disarmed")
        # Armed anew, it plays the page's scene.
        page.click("#arm")
        state_is(page, "armed")
        assert [message for message in sent if message[:2] == bytes([WRITE, COMMIT])]
        page.keyboard.press("Escape")
        state_is(page, "disarmed")


def test_page_that_was_cut_off_says_so(browser: Browser, address: str) -> None:
    with opened(browser, "about:blank") as page:
        page.route_web_socket("**/knob?*", lambda socket: socket.close(reason="cut for the test"))
        page.goto(address)
        expect(page.locator("#message")).to_have_text("cut for the test")


def test_foreign_origin_and_wrong_token_are_told_why_they_may_not_in(address: str) -> None:
    with _socket(address, origin="http://example.org") as socket:
        assert "comes from another place" in _said_at_the_door(socket)
    with _socket(address, token="x") as socket:
        assert "token is not the right one" in _said_at_the_door(socket)


def test_foreign_host_name_gets_nothing(address: str) -> None:
    url = urlsplit(address)
    with pytest.raises(InvalidStatus, match="400"):
        connect(
            f"ws://{url.netloc}/knob?{url.query}",
            additional_headers={"Host": "evil.example"},
            origin=Origin("http://evil.example"),
        )


def test_second_page_is_told_to_wait_and_reports_pass_as_they_are(address: str) -> None:
    with _socket(address) as socket:
        assert "held by torsio studio" in str(socket.recv(timeout=30))
        with _socket(address) as second:
            assert "another page has the knob" in _said_at_the_door(second)
        socket.send(bytes([GET, 0x01]))
        answer = socket.recv(timeout=30)
        assert isinstance(answer, bytes)
        assert answer[0] == GOT
        assert wire.decode(answer[1:])[1]["serial"][:8] == list(b"EMULATED")
        socket.send(
            bytes([WRITE]) + wire.encode("command", {"sequence": 7, "axis": 0, "op": "arm"})
        )
        values = next(v for name, v in _said(socket) if name == "acknowledgement")
        assert (values["sequence"], values["status"], values["state"]) == (7, 0, "armed")


def test_slow_page_gets_answers_and_no_more_telemetry_than_it_takes(address: str) -> None:
    with _socket(address) as socket:
        socket.recv(timeout=30)
        stream = {"sequence": 1, "axis": 0, "decimation": 1, "prompt": "off"}
        socket.send(bytes([WRITE]) + wire.encode("stream", stream))
        kinds = []
        # This page never says that it has something, and asks and asks.
        for _ in range(50):
            socket.send(bytes([GET, 0x03]))
            while True:
                message = socket.recv(timeout=30)
                assert isinstance(message, bytes)
                kinds.append(message[0])
                if message[0] == GOT:
                    break
        assert kinds.count(GOT) == 50
        assert kinds.count(INPUT) <= 2
        for _ in range(2):
            socket.send(bytes([HAVE]))
        said = _said(socket)
        ticks = [v["tick"] for name, v in (next(said) for _ in range(200)) if name == "telemetry"]
        assert ticks == sorted(ticks)


def test_what_waits_too_long_is_the_oldest_telemetry_and_nothing_else() -> None:
    telemetry = [bytes([0x40]) + i.to_bytes(4, "big") for i in range(KEPT_REPORTS + 10)]
    answers = [bytes([0x41, i]) for i in range(5)]

    async def fill() -> list[bytes]:
        waiting = Waiting()
        for answer in answers:
            waiting.put(answer)
        for report in telemetry:
            waiting.put(report)
        return await waiting.take()

    # The browser's driver has a loop of its own in this thread.
    with ThreadPoolExecutor() as pool:
        taken = pool.submit(lambda: asyncio.run(fill())).result()
    assert taken == [*answers, *telemetry[len(telemetry) - KEPT_REPORTS + len(answers) :]]


@pytest.mark.parametrize(
    "message", [b"", b"\x00short", b"\x09" + bytes(64), bytes([GET, 1, 2]), bytes(1025), "text"]
)
def test_nonsense_ends_the_connection_and_harms_nobody(address: str, message: str | bytes) -> None:
    with _socket(address) as socket:
        socket.recv(timeout=30)
        socket.send(message)
        with pytest.raises(ConnectionClosed):
            socket.recv(timeout=30)
    with _socket(address) as socket:
        assert "held by torsio studio" in str(socket.recv(timeout=30))


def test_port_in_use_is_named(address: str) -> None:
    port = str(urlsplit(address).port)
    done = subprocess.run(
        [*PROGRAM, *BRIDGE, "--port", port],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 1
    assert f"port {port} of this machine is in use" in done.stderr


def test_page_that_is_not_there_is_named() -> None:
    done = subprocess.run(
        [*PROGRAM, "studio", "--device", "emulated", "--page", "/nowhere"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 1
    assert "the page is not in '/nowhere'" in done.stderr
    assert "Traceback" not in done.stderr
