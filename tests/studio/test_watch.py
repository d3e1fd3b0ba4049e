"""`torsio.live`: pages look on at a knob that a program drives, and can change nothing."""

from __future__ import annotations

import contextlib
import itertools
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, expect
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

import torsio
import torsio.studio
from tests.faults.lines import Injection
from tests.python import wire
from tests.python.game import CONSTANT, Game
from tests.studio.browser import PAGE, opened, served, settled, state_is
from torsio.studio.live_page import LivePage
from torsio.studio.server import Server

WRITE, INPUT, GET, SET, GOT, STALLED, HAVE = 0, 1, 2, 3, 4, 5, 7
IDENTITY, NO_REPORT = 0x01, 0x7F
WALL = torsio.Wall(angle_rad=-0.1, stiffness_nm_per_rad=0.3)  # the knob, at 0, is inside


@pytest.fixture
def knob() -> Iterator[torsio.Knob]:
    with torsio.open("emulated", emulator=torsio.EmulatorOptions(paced=True)) as knob:
        yield knob


@pytest.fixture
def watch(knob: torsio.Knob) -> Iterator[LivePage]:
    with torsio.studio.live(knob, page=PAGE) as watch:
        yield watch


def _socket(watch: LivePage) -> ClientConnection:
    url = urlsplit(watch.address)
    assert url.hostname == "127.0.0.1"
    return connect(f"ws://{url.netloc}/knob?{url.query}", origin=Origin(f"http://{url.netloc}"))


def _received(socket: ClientConnection) -> bytes:
    message = socket.recv(timeout=30)
    assert isinstance(message, bytes)
    return message


def _answer(socket: ClientConnection) -> bytes:
    """Give the next message that is no telemetry."""
    while (message := _received(socket))[0] == INPUT:
        socket.send(bytes([HAVE]))
    return message


def _reason_of_end(socket: ClientConnection) -> str:
    """Take all that comes until the server closes, and give its reason."""
    try:
        while True:
            socket.recv(timeout=30)
    except ConnectionClosed as closed:
        return closed.rcvd.reason if closed.rcvd else ""


def test_onlookers_get_what_the_program_gets_and_each_the_same(
    knob: torsio.Knob, watch: LivePage
) -> None:
    with _socket(watch) as first, _socket(watch) as second:
        for socket in (first, second):
            hello = socket.recv(timeout=30)
            assert isinstance(hello, str)
            assert '"read_only": true' in hello
            assert "driven by a program" in hello
            socket.send(bytes([GET, IDENTITY]))
            answer = _answer(socket)
            assert answer[0] == GOT
            assert wire.decode(answer[1:])[1]["serial"][:8] == list(b"EMULATED")
            socket.send(bytes([GET, NO_REPORT]))
            assert _answer(socket) == bytes([STALLED])
        # Nobody asked for telemetry, so the page gets the program's answers only.
        knob.play(WALL)
        knob.arm()
        for socket in (first, second):
            told = b""
            while b"\x41" not in {told[at : at + 1] for at in range(0, len(told), 64)}:
                message = _received(socket)
                assert message[0] == INPUT
                socket.send(bytes([HAVE]))
                told += message[1:]
            name, values = wire.decode(told[:64])
            assert name in ("acknowledgement", "event")
            assert values["state"] in ("disarmed", "armed")
    # Pages that go take nothing with them.
    assert knob.state == "armed"


def test_close_waits_for_the_server_also_after_an_interrupted_close(
    knob: torsio.Knob, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(server: Server) -> None:
        real(server)
        time.sleep(0.1)
        done.set()

    (tmp_path / "index.html").touch()
    real, done = Server.run, threading.Event()
    monkeypatch.setattr(Server, "run", run)
    for at in itertools.count():
        done.clear()
        watch, injection = (
            torsio.studio.live(knob, page=tmp_path),
            Injection(at, KeyboardInterrupt),
        )
        with contextlib.suppress(KeyboardInterrupt), injection.active():
            watch.close()
        watch.close()
        assert done.is_set(), injection.where
        if injection.where is None:
            break


@pytest.mark.parametrize("kind", [WRITE, SET])
def test_page_that_writes_is_shown_the_door_and_the_knob_stays_as_it_was(
    knob: torsio.Knob, watch: LivePage, kind: int
) -> None:
    disarm = wire.encode("command", {"sequence": 1, "axis": 0, "op": "disarm"})
    knob.arm()
    with _socket(watch) as socket:
        socket.recv(timeout=30)
        socket.send(bytes([kind]) + disarm)
        assert "may only watch" in _reason_of_end(socket)
    knob.sleep(0.05)
    assert knob.state == "armed"


def test_page_shows_and_cannot_drive_and_sees_what_a_game_plays(
    browser: Browser, knob: torsio.Knob, watch: LivePage
) -> None:
    with opened(browser, watch.address) as page:
        state_is(page, "disarmed")
        expect(page.locator("#who")).to_contain_text("only watching")
        knob.play(WALL)
        knob.start_telemetry(500.0)
        knob.arm()
        state_is(page, "armed")
        # The wall pushes the knob, which nobody holds, to its surface.
        page.wait_for_function("Number(document.getElementById('angle_rad').value) < -0.05")
        angle = settled(page, "angle_rad", within=1e-4)
        assert angle == pytest.approx(knob.position_rad(), abs=1e-3)
        for name in ("arm", "disarm", "zero", "save"):
            assert page.locator(f"#{name}").is_disabled()
        # The key that disarms is for those who drive.
        page.keyboard.press("Escape")
        knob.sleep(0.05)
        assert knob.state == "armed"
        knob.disarm()
        state_is(page, "disarmed")
        page.click("#games summary")
        expect(page.locator("#games-state")).to_contain_text("no game has said anything")
        game = Game(knob)
        block = game.create(CONSTANT)
        game.constant(block, 5000)
        game.play(block)
        expect(page.locator("#games-state")).to_contain_text(
            "a game or your own feel has the actuator"
        )
        row = page.locator("#game-effects tr")
        expect(row).to_contain_text("playing")
        (effect,) = knob.game_effects()
        cells = row.locator("td").all_text_contents()
        assert cells[:3] == [str(effect.block), "constant", "playing"]
        assert float(cells[3]) == pytest.approx(1e3 * effect.torque_nm, abs=0.06)
        assert effect.torque_nm != 0
        # Three effects of the whole limit each.
        game.constant(block, 32767)
        for _ in range(2):
            more = game.create(CONSTANT)
            game.constant(more, 32767)
            game.play(more)
        asked = "ask for 300 % of their limit, clipped 100 % of the time"
        expect(page.locator("#games-state")).to_contain_text(asked)
        knob.close()
        expect(page.locator("#message")).to_contain_text("closed its knob")


def test_page_sees_what_the_program_configures(
    browser: Browser, knob: torsio.Knob, watch: LivePage
) -> None:
    with opened(browser, watch.address) as page:
        expect(page.locator("#message")).to_contain_text("streams no telemetry")
        knob.start_telemetry(500.0)
        expect(page.locator("#message")).to_be_hidden()
        assert knob.emulator is not None
        turned = torsio.PrescribedMotion(angle_rad=[(0.0, 0.0), (0.1, 0.5)])
        knob.update(counts_per_rev=4096)
        counts = page.locator("#actuator_config input[name=counts_per_rev]")
        expect(counts).to_have_value("4096")
        knob.emulator.set_hand(turned)
        page.wait_for_function("Number(document.getElementById('angle_rad').value) > 0.3")
        angle = settled(page, "angle_rad", within=1e-4)
        assert angle == pytest.approx(knob.position_rad(), abs=2e-3)


def test_notebook_shows_the_page_in_a_frame(
    browser: Browser, knob: torsio.Knob, tmp_path: Path
) -> None:
    with torsio.live(knob, page=PAGE) as live:
        # A notebook's own page comes from another port of this machine.
        (tmp_path / "index.html").write_text(f"<p>Out[1]:</p>{live._repr_html_()}")
        with served(tmp_path) as notebook, opened(browser, notebook) as page:
            frame = page.frame_locator("iframe")
            expect(frame.locator("#state[value=disarmed]")).to_be_attached()
            expect(frame.get_by_text("driven by a program")).to_be_visible()
            knob.arm()
            expect(frame.locator("#state[value=armed]")).to_be_attached()


def test_watch_that_is_closed_ends_its_pages_and_leaves_the_knob(knob: torsio.Knob) -> None:
    knob.arm()
    watch = torsio.studio.live(knob, page=PAGE)
    with _socket(watch) as socket:
        socket.recv(timeout=30)
        with ThreadPoolExecutor() as pool:
            closing = pool.submit(watch.close)
            _reason_of_end(socket)
            closing.result(timeout=30)
    assert knob.state == "armed"


def test_port_in_use_and_missing_page_are_named(knob: torsio.Knob, watch: LivePage) -> None:
    port = urlsplit(watch.address).port
    assert port is not None
    with pytest.raises(torsio.Error, match=f"port {port} of this machine is in use"):
        torsio.studio.live(knob, page=PAGE, port=port)
    with pytest.raises(torsio.Error, match="the page is not in '/nowhere'"):
        torsio.studio.live(knob, page="/nowhere")
