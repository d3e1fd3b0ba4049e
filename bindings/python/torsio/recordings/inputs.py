"""A device's inputs, made from what its host has seen: for the replay of hardware.

Exact where every tick was a sample and the device's filters had come to rest before the recording
began; near it otherwise.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, count, groupby
from typing import Any, Final, Literal

import numpy as np
import numpy.typing as npt

from torsio import _torsio, protocol
from torsio.errors import Error, MalformedReport
from torsio.printed.config import CONFIGS, LET_GO_S, ActuatorConfig
from torsio.printed.emulator_options import DeviceInput
from torsio.recordings.loading import Recorded
from torsio.telemetry import FLAG_STATE_MASK

__all__ = ["RecordedInputs", "from_telemetry"]

# To where the recording begins: slower than any limit of speed, with rests before and after.
_COUNTS_PER_S: Final = 8192
_REST_S: Final = 1.0
# As long a scene may have played before the recording for its timed effects to be where they were.
_LONGEST_REST_S: Final = 600.0
_FURTHEST_COUNTS: Final = 10_000_000
# A small file can claim any gap: an hour at the fastest rate, and more if there are samples.
_MOST_TICKS: Final = 80_000_000
_MOST_TICKS_PER_SAMPLE: Final = 1000
_TICKS_AT_ONCE: Final = 65536
# Where every report that is answered has its sequence number.
_SEQUENCE: Final = slice(1, 3)
_REPORTS: Final = {report["name"]: report for report in protocol.reports()}
_FEATURES: Final = {name for name, r in _REPORTS.items() if r["direction"] == "feature"}
_SAMPLES_PER_REPORT: Final = {f["name"]: f["count"] for f in _REPORTS["telemetry"]["fields"]}[
    "sample"
]


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
            "the recording begins while the knob is armed, and how that came about is not in it: "
            "call record_to before arm"
        )
    if abs(int(first["position_counts"])) > _FURTHEST_COUNTS:
        raise Error("the recording begins too many turns from the zero: call zero() before it")
    orders = _orders(recorded)
    zeroed = np.array([order.tick for order in orders if order.is_zero], np.int64)
    # A zero that moves before the first sample moves at the end of the way.
    begin = 0 if np.any(zeroed <= first["tick"]) else int(first["position_counts"])
    told = min([int(first["tick"]), *(order.tick for order in orders)])
    rate = recorded.metadata["info"]["control_rate_hz"]
    before = _way_there(begin, int(first["tick"]) - told, rate)
    behind = int(first["tick"]) - before.length
    after = _turned(recorded, zeroed)
    turned = _Turned(
        np.append(before.ticks, after.ticks - behind),
        np.append(before.counts, after.counts),
        after.length - behind,
    )
    samples = len(recorded.telemetry)
    if turned.length > _MOST_TICKS + _MOST_TICKS_PER_SAMPLE * samples:
        raise Error(f"a replay of {turned.length:,} ticks from {samples:,} samples makes no sense")
    return RecordedInputs(_inputs(recorded, turned, orders, behind), behind)


@dataclass(frozen=True)
class _Turned:
    """Where the encoder is at some ticks; evenly between them, and at rest behind the last."""

    ticks: npt.NDArray[np.int64]
    counts: npt.NDArray[np.int64]
    length: int

    def wire(self, begin: int, end: int, config: ActuatorConfig) -> Iterator[DeviceInput]:
        """Give the counts of ticks, in pieces, so that neither they nor the answers are many."""
        for at in range(begin, end, _TICKS_AT_ONCE):
            every = np.arange(at, min(at + _TICKS_AT_ONCE, end))
            counts = np.rint(np.interp(every, self.ticks, self.counts)).astype(np.int64)
            counts = -counts if config.encoder_reversed else counts
            wire = (counts % (1 << config.counter_bits)).astype("<u4")
            yield DeviceInput(at, "counts", wire.tobytes())


def _way_there(begin: int, told_ticks: int, rate_hz: float) -> _Turned:
    """Rest at angle 0 until the device is configured, turn to where it begins, and rest there.

    In that last rest comes what the device was told before the first sample.
    """
    rest = round(_REST_S * rate_hz)
    there = rest + round(abs(begin) * rate_hz / _COUNTS_PER_S) + 1
    last = there + min(max(told_ticks, rest), round(_LONGEST_REST_S * rate_hz))
    return _Turned(np.array([rest, there, last]), np.array([0, begin, begin]), last + 1)


def _turned(recorded: Recorded, zeroed: npt.NDArray[np.int64]) -> _Turned:
    """Give where the encoder is from the first sample on, wherever the zero is."""
    ticks = recorded.telemetry["tick"].astype(np.int64)
    positions = recorded.telemetry["position_counts"]
    # The last samples wait until their report is full.
    last = _SAMPLES_PER_REPORT * (ticks[-1] - ticks[-2:][0])
    length = int(ticks[-1]) + 1 + int(last)
    zeroed = zeroed[zeroed > ticks[0]]
    firsts = np.searchsorted(ticks, zeroed)
    counts = positions.copy()
    for i in firsts:
        counts[i:] = positions[i:] + counts[i - 1]
    # Up to there it is taken to rest.
    ticks = np.insert(ticks, firsts, zeroed - 1)
    counts = np.insert(counts, firsts, counts[firsts - 1])
    return _Turned(ticks, counts, length)


def _inputs(
    recorded: Recorded, turned: _Turned, orders: list[_Order], behind: int
) -> Iterator[DeviceInput]:
    kept = recorded.metadata["configuration"]
    yield DeviceInput(0, "power", b"\1")
    for name, config in CONFIGS.items():
        values = config(**kept[config.__name__])
        report = _torsio.Knob.encode_config(f"{name}_config", values)
        yield DeviceInput(0, "feature", report)
    actuator = ActuatorConfig(**kept["ActuatorConfig"])
    done = 0
    for i, order in enumerate(orders):
        # The device takes one in a tick, also of those before its first.
        until = max(order.tick - behind, i, done)
        if until >= turned.length:
            break
        yield from turned.wire(done, until, actuator)
        yield DeviceInput(until, order.kind, order.content)
        done = until
    yield from turned.wire(done, turned.length, actuator)


@dataclass(frozen=True)
class _Order:
    """A report that was sent, and the tick before which it came."""

    tick: int
    kind: Literal["feature", "output"]
    content: bytes
    is_zero: bool
    """It made a position angle 0."""


def _orders(recorded: Recorded) -> list[_Order]:
    """Give the reports that were sent, in the order in which the device took them."""
    control = recorded.metadata["configuration"]["ControlConfig"]
    rate = recorded.metadata["info"]["control_rate_hz"]
    # The answer to disarming comes once the torque has gone: docs/explanation/architecture.md.
    letting_go = round(min(LET_GO_S, control["passive_ramp_s"]) * rate)
    answers = _answers(recorded)
    busy = {values["tick"] for values in chain.from_iterable(answers.values())}
    orders: list[_Order] = []
    for guess, content in _sent(recorded):
        try:
            name, values = protocol.decode(content)
        except MalformedReport:
            continue
        op = values.get("op")
        found = answers.get((content[0], int.from_bytes(content[_SEQUENCE], "little")))
        answer = found.pop(0) if found else None
        if answer is not None:
            tick = answer["tick"]
            if op in ("disarm", "stop"):
                tick = _came(recorded, tick, letting_go)
        elif op == "keep_alive" and guess in busy:
            continue  # any report in that tick keeps it alive
        else:
            tick = _next_free(guess, busy)
        kind: Literal["feature", "output"] = "feature" if name in _FEATURES else "output"
        is_zero = op == "zero" and answer is not None and answer["status"] == 0
        orders.append(_Order(tick, kind, content, is_zero))
    return sorted(orders, key=lambda order: order.tick)


def _answers(recorded: Recorded) -> dict[tuple[int, int], list[dict[str, Any]]]:
    """Give the acknowledgements by report and sequence number, in their order."""
    answers: dict[tuple[int, int], list[dict[str, Any]]] = {}
    for _, sent, content in recorded.reports:
        name, values = protocol.decode(content)
        if not sent and name == "acknowledgement":
            answers.setdefault((values["report"], values["sequence"]), []).append(values)
    return answers


def _sent(recorded: Recorded) -> Iterator[tuple[int, bytes]]:
    """Give the reports that were sent, each with the tick before which it came if nobody says.

    Soon after it was sent: those between two things that the device said, evenly.
    """
    if not recorded.reports:
        return
    newest = [tick for tick, _ in groupby(tick for tick, _, _ in recorded.reports)]
    ends = [*newest[1:], int(recorded.telemetry["tick"][-1])]
    together = groupby(recorded.reports, key=lambda row: row[0])
    for (tick, rows), end in zip(together, ends, strict=True):
        sent = [content for _, sent, content in rows if sent]
        between = max(0, end - tick - 1)
        for i, content in enumerate(sent):
            yield tick + 1 + between * i // len(sent), content


def _next_free(tick: int, busy: set[int]) -> int:
    """Take the first tick from this one on in which the device took nothing."""
    free = next(at for at in count(tick) if at not in busy)
    busy.add(free)
    return free


def _came(recorded: Recorded, answered: int, letting_go: int) -> int:
    """Give the tick of an order to disarm, from its answer's, which waits for an armed torque."""
    came = answered - letting_go - 1
    before = int(np.searchsorted(recorded.telemetry["tick"], came)) - 1
    armed = before >= 0 and recorded.telemetry["flags"][before] & FLAG_STATE_MASK == 1
    return came if armed else answered
