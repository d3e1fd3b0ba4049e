"""A way to a device of one's own: across a network, through a recorder, from a simulation."""

from __future__ import annotations

from abc import ABC, abstractmethod

__all__ = ["Transport"]


class Transport(ABC):
    """An open connection to one device, for `torsio.open`.

    It moves whole reports of 64 bytes, as USB HID does. Everything above works the same over a
    cable, over the emulated device and over your own transport. `read` and `advance_to` are called
    by one thread at a time. Any thread may call the others at any time, also while another thread
    is in `read`. Every method but `read` must come back: to close a knob waits for them.

    A method that finds the device gone raises `Disconnected`. Any other exception of `read` counts
    as `Disconnected` too, with its text.
    """

    time_is_virtual: bool = False
    """Whether time passes only in `advance_to` and in calls that send and ask; read once."""

    @abstractmethod
    def close(self) -> None:
        """Let go of the device. Called when nobody is in `read` any more; again if interrupted.

        A knob closes after 5 s if `read` does not come back; this is called when it does.
        """

    @abstractmethod
    def write(self, report: bytes) -> bool:
        """Send an output report; False if there is no room now."""

    @abstractmethod
    def read(self, timeout_s: float) -> bytes | None:
        """Take the next input report; None if none came in time. Virtual time is not waited for."""

    @abstractmethod
    def get_feature(self, report_id: int) -> bytes | None:
        """Ask for a feature report, and wait for it; None if the device stalled the request."""

    @abstractmethod
    def set_feature(self, report: bytes) -> bool:
        """Send a feature report; False if the device stalled the request."""

    def now_ns(self) -> int:
        """Give the time in which time-outs count, since whenever; virtual time only."""
        raise NotImplementedError

    def advance_to(self, time_ns: int) -> None:
        """Let virtual time pass up to that; nothing if it is past."""
        raise NotImplementedError
