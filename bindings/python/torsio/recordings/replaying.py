"""Replay: a recording's inputs run again through the firmware's sources.

On the sources of the recording the outputs are the same to the bit; on others, or with another
configuration, the first difference is told. See docs/reference/studio.md.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from torsio import protocol
from torsio._torsio.emulator import ReplayedDevice
from torsio.common import checks
from torsio.common.emulated import moves_parts
from torsio.errors import Error, InvalidArgument, MalformedReport
from torsio.printed.config import CONFIGS
from torsio.printed.emulator_options import DeviceInput
from torsio.recordings.inputs import from_telemetry
from torsio.recordings.loading import Recorded, load
from torsio.telemetry import TELEMETRY_DTYPE, Record

__all__ = ["Replayed", "replay"]

_TICKS_TO_SAVE: Final = 16
_FIELDS: Final = {
    report["name"]: {field["name"]: field for field in report["fields"]}
    for report in protocol.reports()
}
# Fields of effects that can be changed: those that travel as they are.
_EFFECT_FIELDS: Final = {
    report: [name for name, of in fields.items() if of["type"] == "f32" and of["count"] == 1]
    for report, fields in _FIELDS.items()
    if "target" in fields
}
_IDS: Final = {report["name"]: report["id"] for report in protocol.reports()}
# Compared columns of a sample: all that the device computes, in this order.
_OUTPUTS: Final = (
    *("position_counts", "speed_rad_s", "desired_torque_nm", "motor_command_nm"),
    *("brake_capacity_nm", "spring_torque_nm"),
)


@dataclass(frozen=True, repr=False)
class Replayed(checks.ShortRepr):
    """A device's behaviour on a recording's inputs, beside the recorded one.

    Attributes
    ----------
    recorded, replayed
        Telemetry of the same ticks, of `torsio.telemetry.TELEMETRY_DTYPE`, shape (n,).
    from_inputs
        True: run on the very inputs of an emulated device. False: on the counts in the telemetry
        and the reports sent, as from hardware, or where the inputs do not begin at power-up;
        between samples the knob is taken to turn evenly.
    answers
        Acknowledgements and events that were compared.
    first_difference
        In words; empty if there is none.
    """

    recorded: Record
    replayed: Record
    from_inputs: bool
    answers: int
    first_difference: str

    @property
    def identical(self) -> bool:
        """Every sample and answer is the same to the bit."""
        return not self.first_difference

    def largest_differences(self) -> dict[str, float]:
        """Give the largest difference in each column that the device computes."""
        if len(self.recorded) == 0:
            return dict.fromkeys(_OUTPUTS, 0.0)
        return {
            name: float(
                np.max(
                    np.abs(self.recorded[name].astype(float) - self.replayed[name].astype(float))
                )
            )
            for name in _OUTPUTS
        }


def replay(recording: str | Path | Recorded, **changes: Any) -> Replayed:
    """Run a recording's inputs through the device again.

    Parameters
    ----------
    recording
        A file of `Knob.record_to`, or what `load` gave.
    **changes
        Fields of the configuration by name, as for `Knob.update`, to see what the device would have
        done: ``replay("wall.mcap", law="motor_only")``; and fields of the scene's effects:
        ``replay("wall.mcap", **{"wall.stiffness_nm_per_rad": 0.7})`` for every wall. The
        knob turns as it was recorded all the same; nobody knows what the hand would have done.

    Raises
    ------
    torsio.Error
        If there is too little in the file.
    torsio.InvalidArgument
        If a change is no field, or out of its range.
    """
    recorded = recording if isinstance(recording, Recorded) else load(recording)
    if not recorded.has_all_inputs:
        recorded = replace(recorded, inputs=[])
    versions = recorded.metadata["versions"]
    if versions.get("fingerprint") not in protocol.DRIVEN_FINGERPRINTS:
        raise Error(
            f"the recording is of another protocol (version {versions.get('protocol')}) than this "
            f"library's: replay it with Torsio {versions.get('torsio', versions.get('firmware'))}"
        )
    if len(recorded.telemetry) == 0:
        raise Error("the recording has no telemetry, so there is nothing to compare a replay with")
    wanted = _Changes(_by_report(changes))
    try:
        behind = 0
        inputs: Iterable[DeviceInput] = recorded.inputs
        if not recorded.inputs:
            made = from_telemetry(recorded)
            inputs, behind = made.inputs, made.ticks_behind
        answers, samples = _run(inputs, wanted, recorded, behind)
        wanted.check_met()
        return _compare(recorded, samples, answers)
    except Error:
        raise
    except Exception as error:  # as in load(), damage may raise any error
        raise Error(f"the recording is damaged ({type(error).__name__}: {error})") from error


def _by_report(changes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Sort changes by the report that has them, as they travel."""
    wanted: dict[str, dict[str, Any]] = {}
    for path, value in changes.items():
        owner, name = _place(path)
        on_wire = {True: "on", False: "off"}[value] if isinstance(value, bool) else value
        wanted.setdefault(owner, {})[name] = on_wire
        try:
            protocol.decode(protocol.encode(owner, {name: on_wire}))
        except (ValueError, TypeError):
            field = _FIELDS[owner][name]
            allowed = field.get("choices") or [f"{field['min']:.10g} to {field['max']:.10g}"]
            raise InvalidArgument(
                f"{path} is {checks.show(value)}, allowed are {', '.join(allowed)}"
            ) from None
    return wanted


def _place(path: str) -> tuple[str, str]:
    """Find the report and the field that a change is about."""
    effect, dot, name = path.rpartition(".")
    if not dot:
        for part, config in CONFIGS.items():
            if name in {field.name for field in fields(config)}:
                return f"{part}_config", name
        raise InvalidArgument(checks.no_field(name, CONFIGS.values()))
    known = _EFFECT_FIELDS.get(effect)
    if known is None:
        raise InvalidArgument(
            f"{path}: there is no effect {effect}, but {', '.join(_EFFECT_FIELDS)}"
        )
    if name not in known:
        raise InvalidArgument(f"{path}: you can change {', '.join(known)} of {effect}")
    return effect, name


class _Changes:
    """Changes in the reports that a device takes, and what there was to change."""

    def __init__(self, by_report: Mapping[str, Mapping[str, Any]]) -> None:
        self.by_report = by_report
        self._met: set[str] = set()

    def put(self, content: bytes) -> bytes:
        """Put changes into a report, if it is one that has some."""
        try:
            name, values = protocol.decode(content)
        except MalformedReport:
            return content
        if name not in self.by_report:
            return content
        self._met.add(name)
        return protocol.encode(name, {**values, **self.by_report[name]})

    def check_met(self) -> None:
        """Raise `InvalidArgument` if there was nothing that a change could be made of."""
        if absent := self.by_report.keys() - self._met:
            raise InvalidArgument(
                f"the recording has no {' and no '.join(sorted(absent))}, so there is nothing to "
                "change"
            )


def _run(
    inputs: Iterable[DeviceInput],
    wanted: _Changes,
    recorded: Recorded,
    behind: int,
) -> tuple[list[bytes], dict[int, dict[str, Any]]]:
    """Give the answers in order, and the samples by their tick."""
    info = recorded.metadata["info"]
    period_ns = round(1e9 / info["control_rate_hz"])
    # A board holds torques low until its parts are confirmed and their values known.
    device = ReplayedDevice(control_period_ns=period_ns, moves_parts=moves_parts(info["board"]))
    answers: list[bytes] = []
    samples: dict[int, dict[str, Any]] = {}
    steps: tuple[float, float] | None = None
    # In a gap of a recording the device may send any number that nobody compares.
    ticks = set(recorded.telemetry["tick"].tolist())
    is_exact = bool(recorded.inputs)
    for given in inputs:
        _take(device, given, wanted)
        if given.kind == "power" and given.bytes == b"\1":
            steps = _steps_of(device)
        for name, values in _outputs(device, behind):
            if name == "telemetry":
                assert steps is not None
                sent = _samples(values, steps)
                samples.update(one for one in sent if one[0] in ticks or is_exact or not samples)
            else:
                answers.append(protocol.encode(name, values))
    return answers, samples


def _take(device: ReplayedDevice, given: DeviceInput, wanted: _Changes) -> None:
    may_change = given.kind in ("feature", "output") and bool(wanted.by_report)
    try:
        device.take(given.kind, wanted.put(given.bytes) if may_change else given.bytes)
    except ValueError as error:
        raise Error(f"at tick {given.tick} the recording is damaged: {error}") from None
    if given.kind == "stored" and wanted.by_report:
        _store(device, wanted)


def _outputs(device: ReplayedDevice, behind: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Give the reports with the recording's ticks, without those before it begins."""
    for _, report in device.take_outputs():
        name, values = protocol.decode(report)
        values["tick"] += behind
        if values["tick"] >= 0:
            yield name, values


def _steps_of(device: ReplayedDevice) -> tuple[float, float]:
    """Give the device's steps of torque, N m, and of speed, rad/s."""
    identity = device.get_feature(_IDS["identity"])
    assert identity is not None
    values = protocol.decode(identity)[1]
    return values["torque_step_nm"], values["speed_step_rad_s"]


def _store(device: ReplayedDevice, wanted: _Changes) -> None:
    """Save changes in a life before the recorded one, so that they are there from its start."""
    device.take("power", b"\1")
    for name in wanted.by_report.keys() & {f"{part}_config" for part in CONFIGS}:
        content = device.get_feature(_IDS[name])
        assert content is not None
        device.take("feature", wanted.put(content))
    ticks = bytes(4 * _TICKS_TO_SAVE)
    device.take("counts", ticks)
    device.take("output", protocol.encode("command", {"op": "save"}))
    device.take("counts", ticks)
    for _, report in device.take_outputs():
        name, values = protocol.decode(report)
        if name == "acknowledgement" and values["status"] != 0:
            reason = protocol.STATUS_NAMES[values["status"]]
            raise InvalidArgument(f"the device refuses these changes ({reason})")
    device.take("power", b"\0")


def _samples(
    report: Mapping[str, Any], steps: tuple[float, float]
) -> Iterator[tuple[int, dict[str, Any]]]:
    """Take a telemetry report apart; positions are the low 32 bits."""
    torque, speed = (np.float32(step) for step in steps)
    for i in range(report["axis_samples"] >> 4):
        sample = report["sample"][i]
        yield (
            report["tick"] + i * report["decimation"],
            {
                "position_counts": report["base_counts"] + sample["offset_counts"],
                "speed_rad_s": np.float32(sample["speed"]) * speed,
                "desired_torque_nm": np.float32(sample["desired_torque"]) * torque,
                "motor_command_nm": np.float32(sample["motor_command"]) * torque,
                "brake_capacity_nm": np.float32(sample["brake_capacity"]) * torque,
                "spring_torque_nm": np.float32(sample["spring_torque"]) * torque,
                "flags": report["flags"],
            },
        )


def _compare(
    recorded: Recorded, samples: Mapping[int, Mapping[str, Any]], answers: list[bytes]
) -> Replayed:
    there = np.array([int(tick) in samples for tick in recorded.telemetry["tick"]], bool)
    before = recorded.telemetry[there]
    after = _as_now(before, samples)
    missing, told = _wanted(recorded, there, samples)
    found: list[tuple[int, str]] = []
    if len(missing):
        found.append((int(missing[0]), "telemetry: recorded, and not sent now"))
    found += _differences(before, after)
    compared, difference = _compare_answers(told, answers)
    if difference:
        found.append(difference)
    # Within one tick, the device computes this first.
    first = min(found, key=lambda one: one[0], default=None)
    rate = recorded.metadata["info"]["control_rate_hz"]
    text = "" if first is None else f"tick {first[0]} ({first[0] / rate:.4f} s): {first[1]}"
    if text and not recorded.inputs and not _has_scene(recorded):
        text += "; a scene that an earlier program has left in the knob is not in the recording"
    return Replayed(before, after, bool(recorded.inputs), compared, text)


def _as_now(before: Record, samples: Mapping[int, Mapping[str, Any]]) -> Record:
    """Give the recorded samples with what the device puts out now."""
    after: Record = np.zeros(len(before), TELEMETRY_DTYPE)
    for name in ("tick", "time_s", "position_counts", "angle_rad", "flags"):
        after[name] = before[name]
    for i, tick in enumerate(before["tick"].tolist()):
        for name in _OUTPUTS[1:]:
            after[name][i] = samples[tick][name]
        # Only 32 bits of the position travel.
        error = (samples[tick]["position_counts"] - int(before["position_counts"][i])) % 2**32
        after["position_counts"][i] += error - 2**32 * (error >= 2**31)
    return after


def _wanted(
    recorded: Recorded, there: npt.NDArray[np.bool_], samples: Mapping[int, Mapping[str, Any]]
) -> tuple[npt.NDArray[Any], list[bytes]]:
    """Give the ticks of recorded samples that are not sent now, and the recorded answers."""
    missing = recorded.telemetry["tick"][~there]
    told = [content for _, sent, content in recorded.reports if not sent]
    if not recorded.inputs:
        # Ignore samples before the recording's first request.
        missing = missing[missing >= min(samples, default=0)]
    elif not recorded.whole:
        # A torn file has more of the device's outputs than of its inputs.
        end = max(samples, default=0)
        missing = missing[missing <= end]
        told = [content for content in told if protocol.decode(content)[1]["tick"] <= end]
    return missing, told


def _differences(before: Record, after: Record) -> Iterator[tuple[int, str]]:
    """Give the first tick at which each output differs, with both values."""
    for name in _OUTPUTS:
        unequal = np.flatnonzero(before[name] != after[name])
        if len(unequal):
            i = unequal[0]
            text = f"telemetry: {name} {before[name][i]} recorded, {after[name][i]} now"
            yield int(before["tick"][i]), text


def _has_scene(recorded: Recorded) -> bool:
    return any(sent and content[0] == _IDS["commit"] for _, sent, content in recorded.reports)


def _compare_answers(told: list[bytes], answers: list[bytes]) -> tuple[int, tuple[int, str] | None]:
    """Compare acknowledgements and events, from the first that both have on."""
    if not told:
        return 0, None
    if told[0] not in answers:
        name, values = protocol.decode(told[0])
        return 0, (values["tick"], f"{name}: {values} recorded, and not sent now")
    later = answers[answers.index(told[0]) :]
    for before, after in zip(told, later, strict=False):
        if before != after:
            name, values = protocol.decode(before)
            return len(told), (
                values["tick"],
                f"{name}: {values} recorded, {protocol.decode(after)} now",
            )
    return len(told), None
