"""The distribution's Firefox, driven over WebDriver BiDi, which it speaks itself.

Playwright drives no Firefox but its own, and nobody packages geckodriver.
"""

from __future__ import annotations

import json
import re
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

# Longer than any loaded machine takes: nothing here is about time.
_PATIENCE_S = 240.0
_LOOK_S = 0.1
# Firefox asks its maker's servers for many things. Each would wait in vain here.
_PREFERENCES = {
    "services.settings.server": "data:,#remote-settings-dummy/v1",
    "app.normandy.enabled": False,
    "browser.safebrowsing.update.enabled": False,
    "browser.startup.homepage": "about:blank",
    "network.captive-portal-service.enabled": False,
    "toolkit.telemetry.server": "",
}


class Page:
    """The browser's only page."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self._asked = 0
        self._ask("session.new", capabilities={})
        (context,) = self._ask("browsingContext.getTree")["contexts"]
        self._context = context["context"]

    def _ask(self, method: str, **parameters: Any) -> dict[str, Any]:
        self._asked += 1
        question = {"id": self._asked, "method": method, "params": parameters}
        self._socket.send(json.dumps(question))
        while True:
            answer = json.loads(self._socket.recv(timeout=_PATIENCE_S))
            if answer.get("id") == self._asked:
                assert answer["type"] == "success", answer
                return dict(answer["result"])

    def goto(self, address: str) -> None:
        """Open an address, and wait until it is loaded."""
        self._ask("browsingContext.navigate", context=self._context, url=address, wait="complete")

    def evaluate(self, expression: str) -> Any:
        """Give the value of an expression: text, number or truth."""
        answer = self._ask(
            "script.evaluate",
            expression=expression,
            target={"context": self._context},
            awaitPromise=True,
        )
        assert answer["type"] == "success", answer
        return answer["result"].get("value")

    def wait_for(self, expression: str) -> None:
        """Wait until an expression is true."""
        end = time.monotonic() + _PATIENCE_S
        while not self.evaluate(expression):
            assert time.monotonic() < end, f"{expression} is not true: {self.text('body')}"
            time.sleep(_LOOK_S)

    def text(self, selector: str) -> str:
        """Give what stands in an element."""
        return str(self.evaluate(f"document.querySelector({selector!r}).innerText"))

    def value(self, name: str) -> float:
        """Give a readout, in SI units."""
        return float(self.evaluate(f"document.getElementById({name!r}).value"))

    def click(self, selector: str) -> None:
        """Click, as a user who has found it does."""
        self.evaluate(f"document.querySelector({selector!r}).click()")

    def fill(self, selector: str, value: str) -> None:
        """Write into a field."""
        self.evaluate(
            f"{{ const field = document.querySelector({selector!r}); field.value = {value!r};"
            " field.dispatchEvent(new Event('input', { bubbles: true })) }"
        )

    def press(self, key: str) -> None:
        """Press a key and release it, as a keyboard does."""
        strokes = [{"type": kind, "value": key} for kind in ("keyDown", "keyUp")]
        keyboard = {"type": "key", "id": "keyboard", "actions": strokes}
        self._ask("input.performActions", context=self._context, actions=[keyboard])

    def close(self) -> None:
        """End the browser."""
        self._ask("browser.close")


@contextmanager
def firefox() -> Iterator[Page]:
    """Start the browser, with a profile of its own."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        lines = [f"user_pref({json.dumps(k)}, {json.dumps(v)});" for k, v in _PREFERENCES.items()]
        Path(profile, "user.js").write_text("\n".join(lines), encoding="utf-8")
        options = ("--headless", "--no-remote", "--profile", profile, "--remote-debugging-port=0")
        said = Path(profile, "said.txt")
        with (
            said.open("w") as file,
            subprocess.Popen(["/usr/bin/firefox-esr", *options], stderr=file) as process,
        ):
            try:
                end = time.monotonic() + _PATIENCE_S
                while not (found := re.search(r"BiDi listening on (ws://\S+)", said.read_text())):
                    assert process.poll() is None, said.read_text()
                    assert time.monotonic() < end, said.read_text()
                    time.sleep(_LOOK_S)
                with connect(f"{found[1]}/session", max_size=None) as socket:
                    page = Page(socket)
                    yield page
                    page.close()
                process.wait(_PATIENCE_S)
            finally:
                process.kill()
