"""A knob's events, taken or told to a function."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any

from torsio import _torsio
from torsio.common import checks
from torsio.printed.told import Event

__all__ = ["KnobEvents", "tell"]


def tell(callback: Callable[[Event], object] | None) -> Callable[[dict[str, Any]], object] | None:
    """Make of a function of an `Event` what the extension calls."""
    if callback is None:
        return None
    checks.function("callback", callback)
    return lambda event: callback(Event(**event))


class KnobEvents:
    """The part that a `torsio.Knob` has for its events."""

    def __init__(self, knob: _torsio.Knob) -> None:
        self._knob = knob
        self._told: Callable[[dict[str, Any]], object] | None = None

    def events(self, timeout_s: float = 0.0) -> list[Event]:
        """Take the events that nobody has taken yet, oldest first.

        Changes of state and owner, faults, silence, missed deadlines, the end of the connection.
        1,024 are kept; `statistics` counts older ones as lost.

        Parameters
        ----------
        timeout_s
            How long to wait for one if there is none.
        """
        taken = self._knob.events(checks.number("timeout_s", timeout_s))
        return [Event(**event) for event in taken]

    def on_event(self, callback: Callable[[Event], object] | None) -> None:
        """Call back with every event from now on; None ends it.

        One after the other: from a thread of the knob, or, in virtual time, from the thread that
        lets time pass. The callback may use the knob. Its exceptions go to `sys.unraisablehook`,
        and the next event is told all the same. What is no `Exception`, such as `SystemExit`, goes
        on in the main thread.
        """
        told = tell(callback)
        self._told = told
        if told is None:
            self._knob.on_event(None)
            return
        # Mostly the callback has the knob. The extension must not have it then, because the garbage
        # collector does not see what the extension has.
        this = weakref.ref(self)

        def hear(event: dict[str, Any]) -> None:
            events = this()
            if events is not None and events._told is not None:
                events._told(event)

        self._knob.on_event(hear)

    def forget(self) -> None:
        """Let go of the callback of a closed knob."""
        self._told = None
