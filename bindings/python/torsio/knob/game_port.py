"""The game interface of an emulated knob, as a driver uses it."""

from __future__ import annotations

from torsio import _torsio
from torsio.common import checks

__all__ = ["GamePort"]

_LONGEST_REPORT = 64


def _report(report: bytes) -> bytes:
    checks.kind("report", report, bytes, "bytes")
    if not 1 <= len(report) <= _LONGEST_REPORT:
        raise ValueError(f"report must have 1 to {_LONGEST_REPORT} bytes, has {len(report)}")
    return report


class GamePort:
    """Reports of the game interface as bytes, each with its id first; see docs/reference/games.md.

    They take effect at the next control tick.
    """

    def __init__(self, knob: _torsio.Knob) -> None:
        self._knob = knob

    def write(self, report: bytes) -> None:
        """Send an output report. A report that does not fit is ignored, as on the bus."""
        self._knob.game_write(_report(report))

    def read(self) -> bytes | None:
        """Take the next input report: axis and buttons, or what an effect does."""
        return self._knob.game_read() or None

    def set_feature(self, report: bytes) -> bool:
        """Send a feature report; False if the device stalls the request."""
        return self._knob.game_set_feature(_report(report))

    def get_feature(self, report_id: int) -> bytes | None:
        """Ask for a feature report; None if the device stalls the request."""
        return self._knob.game_get_feature(checks.whole("report_id", report_id, 0, 255)) or None

    def set_buttons(self, pressed: int) -> None:
        """Press exactly these buttons, bit 0 the first."""
        self._knob.game_set_buttons(checks.whole("pressed", pressed, 0, 3))
