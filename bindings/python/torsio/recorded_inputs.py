"""A device's inputs, made from what its host has seen: for the replay of hardware.

Exact where every tick was a sample and the device's filters had come to rest before the recording
began; near it otherwise.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from torsio import _torsio, protocol
from torsio.config import LET_GO_S, ActuatorConfig
from torsio.emulated_knob import DeviceInput
from torsio.errors import Error, MalformedReport
from torsio.knob_configuration import CONFIGS
from torsio.recording import Recorded
from torsio.telemetry import FLAG_STATE_MASK

__all__ = ["RecordedInputs", "from_telemetry"]

# On the way to where the recording begins: slower than any limit of speed, and then at rest.
_COUNTS_PER_S: Final = 8192
_REST_S: Final = 1.0
_FURTHEST_COUNTS: Final = 10_000_000
# Where every report that is answered has its sequence number.
_SEQUENCE: Final = slice(1, 3)
_FEATURES: Final = {r["name"] for r in protocol.reports() if r["direction"] == "feature"}


@dataclass(frozen=True)
class RecordedInputs:
    """Inputs, and by how much the replaying device's ticks are behind the recorded ones."""

    inputs: Iterator[DeviceInput]
    ticks_behind: int


def from_telemetry(recorded: Recorded) -> RecordedInputs:
    """Make inputs from the counts in the telemetry and the reports that were sent.

    Raises
    ------
    torsio.Error
        If the recording begins in the middle of something.
    """
    first = recorded.telemetry[0]
    if first["flags"] & FLAG_STATE_MASK == 1:
        raise Error(
            "the recording begins while the knob is armed, so the scene is not in it: call "
            "record_to before play and arm"
        )
    if abs(int(first["position_counts"])) > _FURTHEST_COUNTS:
        raise Error("the recording begins too many turns from the zero: call zero() before it")
    before = _way_there(recorded)
    behind = int(first["tick"]) - len(before)
    return RecordedInputs(_inputs(recorded, before, behind), behind)


def _way_there(recorded: Recorded) -> npt.NDArray[np.int64]:
    """Turn from angle 0 to the first sample's, and rest there."""
    rate = recorded.metadata["info"]["control_rate_hz"]
    begin = int(recorded.telemetry["position_counts"][0])
    steps = round(abs(begin) * rate / _COUNTS_PER_S)
    way = np.rint(np.linspace(0, begin, steps + 2)).astype(np.int64)
    return np.append(way, np.full(round(_REST_S * rate), begin))


def _inputs(
    recorded: Recorded, before: npt.NDArray[np.int64], behind: int
) -> Iterator[DeviceInput]:
    kept = recorded.metadata["configuration"]
    yield DeviceInput(0, "power", b"\1")
    for name, config in CONFIGS.items():
        encode = getattr(_torsio.Knob, f"encode_{name}")
        yield DeviceInput(0, "feature", encode(config(**kept[config.__name__])))
    ticks = recorded.telemetry["tick"].astype(np.int64) - behind
    every = np.arange(ticks[0], ticks[-1] + 1)
    between = np.interp(every, ticks, recorded.telemetry["position_counts"])
    counts = np.append(before, np.rint(between).astype(np.int64))
    actuator = ActuatorConfig(**kept["ActuatorConfig"])
    counts *= -1 if actuator.encoder_reversed else 1
    wire = (counts % (1 << actuator.counter_bits)).astype("<u4")
    done = 0
    for tick, kind, content in _sent(recorded):
        until = min(max(tick - behind, done), len(wire))
        yield DeviceInput(done, "counts", wire[done:until].tobytes())
        yield DeviceInput(until, kind, content)
        done = until
    yield DeviceInput(done, "counts", wire[done:].tobytes())


def _sent(recorded: Recorded) -> Iterator[tuple[int, str, bytes]]:
    """Give the reports that were sent, each with the tick before which it came."""
    control = recorded.metadata["configuration"]["ControlConfig"]
    rate = recorded.metadata["info"]["control_rate_hz"]
    # Who disarms is answered once the torque has gone; docs/architecture.md, "States".
    letting_go = round(min(LET_GO_S, control["passive_ramp_s"]) * rate)
    taken_at: dict[tuple[int, int], list[int]] = {}
    for _, sent, content in recorded.reports:
        name, values = protocol.decode(content)
        if not sent and name == "acknowledgement":
            taken_at.setdefault((values["report"], values["sequence"]), []).append(values["tick"])
    for newest, sent, content in recorded.reports:
        if not sent:
            continue
        try:
            name, values = protocol.decode(content)
        except MalformedReport:
            continue
        answers = taken_at.get((content[0], int.from_bytes(content[_SEQUENCE], "little")))
        # What is not answered came soon after it was sent.
        tick = answers.pop(0) if answers else newest + 1
        if values.get("op") in ("disarm", "stop") and _was_armed(recorded, tick - letting_go):
            tick -= letting_go + 1
        yield tick, "feature" if name in _FEATURES else "output", content


def _was_armed(recorded: Recorded, tick: int) -> bool:
    """Tell whether the knob was armed just before an order came at a tick."""
    before = int(np.searchsorted(recorded.telemetry["tick"], tick - 1)) - 1
    return before >= 0 and bool(recorded.telemetry["flags"][before] & FLAG_STATE_MASK == 1)
