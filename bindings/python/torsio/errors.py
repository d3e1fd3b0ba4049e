"""Exceptions of the library. Every message says what was wrong and what to do about it.

Each class also derives from the fitting class of Python's own, so that code which knows nothing of
torsio can handle it.
"""

from __future__ import annotations

__all__ = [
    "Closed",
    "DeviceBusy",
    "DeviceNotFound",
    "Disarmed",
    "DisarmedWarning",
    "Disconnected",
    "Error",
    "HeldLowWarning",
    "InvalidArgument",
    "MalformedReport",
    "NoSpeedLimitWarning",
    "PermissionDenied",
    "ProtocolMismatch",
    "Refused",
    "SceneWarning",
    "StiffnessWarning",
    "Timeout",
]


class Error(Exception):
    """Base of everything that the library raises on purpose.

    An exception that ends `Knob.record` early, KeyboardInterrupt as well, has the samples that came
    until then as its attribute `samples`, a record.
    """

    # Without this OSError's own text ("[Errno ...]") could come first in the classes below.
    def __str__(self) -> str:
        """Give the message."""
        return str(self.args[0]) if self.args else ""


class InvalidArgument(Error, ValueError):
    """A value that the device would refuse. Nothing was sent; what plays goes on."""


class DeviceNotFound(Error, FileNotFoundError):
    """There is no such device, or no device, or more than one to choose from."""


class PermissionDenied(Error, PermissionError):
    """The device is there, but this user may not open it."""


class DeviceBusy(Error, OSError):
    """Somebody, maybe this very program, has opened the device already."""


class ProtocolMismatch(Error, ConnectionError):
    """Firmware and library were built from different report layouts."""


class Refused(Error, RuntimeError):
    """The device said no. The old scene goes on.

    Attributes
    ----------
    status : str
        The reason in one word: "not_armed", "out_of_range" ...
    report : str
        Name of the refused report: "wall", "command" ...
    field : str
        Name of the offending field; empty if no field in particular.
    reason : str
        Why the device had disarmed before: "watchdog", "fault" ...; else empty.
    """

    def __init__(
        self,
        message: str,
        status: str = "",
        report: str = "",
        field: str = "",
        reason: str = "",
    ) -> None:
        super().__init__(message)
        self.status = status
        self.report = report
        self.field = field
        self.reason = reason


class Disarmed(Error, RuntimeError):
    """The torque went off during a `Knob.record` that was to keep it on.

    Attributes
    ----------
    reason : str
        Why: "watchdog", "fault" ...
    """

    def __init__(self, message: str, reason: str = "") -> None:
        super().__init__(message)
        self.reason = reason


class HeldLowWarning(UserWarning):
    """`Knob.arm` has armed a board that gives little: its parts are not confirmed, or not known."""


class NoSpeedLimitWarning(UserWarning):
    """`Knob.arm` has armed a board that nothing stops when its knob runs away."""


class DisarmedWarning(UserWarning):
    """A recording was without torque, at a time or throughout."""


class SceneWarning(UserWarning):
    """A scene asks for what its knob cannot give, or has angles that look like degrees."""


class StiffnessWarning(UserWarning):
    """Let go, the knob may swing or hum for ever: it plays more than its parts can render."""


class MalformedReport(InvalidArgument):
    """Bytes that are no valid report; `status`, `report` and `field` as in `Refused`."""

    def __init__(self, message: str, status: str = "", report: str = "", field: str = "") -> None:
        super().__init__(message)
        self.status = status
        self.report = report
        self.field = field


class Timeout(Error, TimeoutError):
    """The device did not answer in time."""


class Disconnected(Error, ConnectionError):
    """The device was unplugged or lost its power. Open it again once it is back."""


class Closed(Error, RuntimeError):
    """The knob was closed."""
