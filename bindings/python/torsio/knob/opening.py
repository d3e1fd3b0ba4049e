"""Ways to a knob: list those that are there, open one."""

from __future__ import annotations

from torsio import _torsio
from torsio.common import checks
from torsio.common.emulated import selects_emulated
from torsio.knob import Knob
from torsio.knob.transport import Transport
from torsio.printed.emulator_options import EmulatorOptions
from torsio.printed.told import ListedDevice

__all__ = ["list_devices", "open"]

_MAX_RING_SAMPLES = 2**24


def open(
    selector: str | Transport | None = None,
    *,
    emulator: EmulatorOptions | None = None,
    command_timeout_s: float = 1.0,
    ring_samples: int = 65536,
) -> Knob:
    """Open a knob. It is as it was left: look at its `state` to see whether it is armed.

    Parameters
    ----------
    selector
        Path, serial number, "emulated", "emulated:NAME", or None for the only real device.
        "emulated" gives a new knob each time. "emulated:NAME" is one device: it keeps its saved
        configuration while the process lives, and a second open of it raises `DeviceBusy`. Or a
        `Transport` of one's own, which is closed with the knob.
    emulator
        Options of an emulated knob; an error with a selector of a real one.
    command_timeout_s
        Longest wait for an answer of the device.
    ring_samples
        Telemetry kept until it is read; the oldest goes first.

    Raises
    ------
    DeviceNotFound, PermissionDenied, DeviceBusy, ProtocolMismatch, InvalidArgument
    """
    checks.kind(
        "emulator", emulator, (EmulatorOptions, type(None)), "a torsio.EmulatorOptions or None"
    )
    if isinstance(selector, Transport):
        time_waits = selector.time_is_virtual
    else:
        selector = checks.selector(selector)
        time_waits = selects_emulated(selector) and not (emulator and emulator.paced)
    return Knob(
        _torsio.open_knob(
            selector,
            emulator=emulator,
            command_timeout_s=checks.number("command_timeout_s", command_timeout_s),
            ring_samples=checks.whole("ring_samples", ring_samples, 1, _MAX_RING_SAMPLES),
        ),
        logs_inputs=emulator is not None and emulator.log_inputs,
        time_waits=time_waits,
    )


def list_devices() -> list[ListedDevice]:
    """List all knobs that are plugged in, and the emulated one, which is always last."""
    return [ListedDevice(**device) for device in _torsio.list_devices()]
