"""C++ and Python offer the same things under the same names.

Where they differ on purpose, a table below says why.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable
from typing import Any, Literal, get_args, get_origin, get_type_hints

import pytest

import torsio
from tests.python.cpp_headers import Scope, read_sdk
from torsio import telemetry

SDK = read_sdk()

CPP_ONLY = {
    "OpenOptions": "keyword arguments of torsio.open",
    "WatchOptions": "keyword arguments of torsio.watch",
    "LocalModel": "keyword arguments of Knob.stream_local_model",
    "TelemetrySample": "columns of an array, TELEMETRY_DTYPE",
    "TruthSample": "columns of an array, TRUTH_DTYPE",
    "ReportBytes": "bytes",
    "ReportTap": "what Knob.record_to and torsio.studio.watch use",
    "LoggedReport": "a row of Recorded.reports",
    "open_transport": "for whoever wraps one",
    "UpdateOptions": "keyword arguments of torsio.update_firmware",
    "Knot": "a pair (time_s, value)",
    "Interrupted": "KeyboardInterrupt",
    "TelemetryRecord": "a record, and DisarmedWarning",
    "flag": "torsio.telemetry.FLAG_...",
    "matching_config": "PlantParams.matching_config",
    "matching_shaft": "PlantParams.matching_shaft",
    "kMaxTorqueNm": "a range, which the messages name",
    "kEmulatedSerial": "torsio.emulator_options.EMULATED_SERIAL",
    "HandFunction": "torsio.hands.HandFunction, which nobody needs to name",
    "Profile": "torsio.hands.Profile, which nobody needs to name",
}
PYTHON_ONLY = {
    "DisarmedWarning": "TelemetryRecord::disarmed",
    "SceneWarning": "C++ compares with Knob::limits by itself",
    "StiffnessWarning": "what Knob::play and Knob::stream_local_model return",
    "HeldLowWarning": "Knob::limits",
    "NoSpeedLimitWarning": "Knob::limits",
    "MalformedReport": "of torsio.protocol, which C++ has not",
    "deg": "a number of degrees in radians, which is one multiplication",
    "open": "Knob::open",
    "watch": "the constructor of DeviceWatch",
    "TELEMETRY_DTYPE": "TelemetrySample",
    "TRUTH_DTYPE": "TruthSample",
    "__version__": "the package's, in CMake",
    "core": "for study",
    "emulator": "for study",
    "protocol": "for study",
    "telemetry": "the module of TELEMETRY_DTYPE",
    "load": "recordings are Python's",
    "Recorded": "what load gives",
    "RecordingFile": "what Knob.record_to gives",
    "Replayed": "what replay gives",
    "replay": "recordings are Python's",
}
METHODS_ONLY = {
    "Knob.open": "torsio.open",
    "Knob.telemetry": "a generator; C++ calls read() in a loop",
    "Knob.disarm_to_close": "the first step of Python's close, which runs from C++",
    "Knob.record_to": "recordings are Python's",
    "Knob.tap": "Knob.record_to and torsio.studio.watch have one",
    "Knob.feature": "for those two; Python has clock(), health() and the rest",
}
FIELDS_ONLY = {
    "FirmwarePlan": {"options"},  # keyword arguments of torsio.prepare_update
}
OTHER_PARAMETERS = {
    "Knob.stream_local_model": "keyword arguments in place of a LocalModel",
    "Knob.update": "keyword arguments in place of a function",
}


def public(names: Any) -> set[str]:
    return {name for name in names if not name.startswith("_")}


def members(python: type) -> dict[str, Any]:
    """Give what a class has, its bases' parts included."""
    parts = reversed(python.__mro__[:-1])
    return {name: value for part in parts for name, value in vars(part).items()}


def test_both_have_the_same_types_and_functions() -> None:
    enumerations = {name for name, scope in SDK.scopes.items() if scope.kind == "enum"}
    cpp = (SDK.members | set(SDK.functions) | set(SDK.scopes)) - enumerations
    python = set(torsio.__all__)
    assert cpp - python == set(CPP_ONLY)
    assert python - cpp == set(PYTHON_ONLY)


@pytest.mark.parametrize("name", ["DeviceWatch", "Emulator", "GamePort", "Knob"])
def test_class_has_the_same_methods_and_parameters(name: str) -> None:
    cpp, python = SDK.scopes[name].functions, members(getattr(torsio, name))
    different = {f"{name}.{method}" for method in set(cpp) ^ public(python)}
    assert different == {method for method in METHODS_ONLY if method.startswith(name + ".")}
    for method in set(cpp) & public(python):
        value = python[method]
        parameters: tuple[str, ...] = ()
        # close runs from C++, where it has no signature.
        if not isinstance(value, property) and method != "close":
            _, *parameters = inspect.signature(value).parameters  # type: ignore[assignment]
        is_same = tuple(parameters) in cpp[method]
        assert is_same != (f"{name}.{method}" in OTHER_PARAMETERS), method


STRUCTS = sorted(
    name
    for name, scope in SDK.scopes.items()
    if scope.kind == "struct" and dataclasses.is_dataclass(getattr(torsio, name, None))
)


def test_nearly_all_structs_are_compared() -> None:
    structs = {name for name, scope in SDK.scopes.items() if scope.kind == "struct"}
    of_another_kind = {name for name in CPP_ONLY if name in structs} | {"FirmwareHost"}
    assert structs - set(STRUCTS) == of_another_kind


@pytest.mark.parametrize("name", STRUCTS)
def test_struct_has_the_same_fields(name: str) -> None:
    fields = public(field.name for field in dataclasses.fields(getattr(torsio, name)))
    assert SDK.scopes[name].members ^ fields == FIELDS_ONLY.get(name, set())


def test_what_stands_in_for_the_computer_has_the_same_parts() -> None:
    host = torsio.FirmwareHost
    assert public(vars(host)) | set(host.__annotations__) == SDK.scopes["FirmwareHost"].members


@pytest.mark.parametrize(
    ("struct", "names"),
    [
        ("TelemetrySample", telemetry.TELEMETRY_DTYPE.names),
        ("TruthSample", telemetry.TRUTH_DTYPE.names),
    ],
)
def test_record_has_the_columns_of_the_struct(struct: str, names: tuple[str, ...]) -> None:
    assert set(names) == SDK.scopes[struct].members


def test_flags_are_the_same() -> None:
    flags = {name.removeprefix("FLAG_").lower() for name in vars(telemetry) if "FLAG_" in name}
    assert flags == SDK.scopes["flag"].members


@pytest.mark.parametrize(
    ("struct", "function", "only_one"),
    [
        # Ctrl-C is Python's; the selector is an argument of its own in C++.
        ("OpenOptions", torsio.open, {"interrupted", "selector"}),
        # A time-out is one of the iteration, and the callback another constructor's.
        ("WatchOptions", torsio.watch, {"callback", "timeout_s"}),
        ("UpdateOptions", torsio.update_firmware, {"interrupted", "path", "selector"}),
        ("LocalModel", torsio.Knob.stream_local_model, {"self"}),
    ],
)
def test_keyword_arguments_are_the_fields_of_the_struct(
    struct: str, function: Callable[..., object], only_one: set[str]
) -> None:
    assert SDK.scopes[struct].members ^ set(inspect.signature(function).parameters) == only_one


def literals() -> set[frozenset[str]]:
    """Give what every Literal among the fields of the data classes allows."""
    found = set()
    for name in torsio.__all__:
        if dataclasses.is_dataclass(kind := getattr(torsio, name)):
            for hint in get_type_hints(kind).values():
                for part in (hint, *get_args(hint)):
                    if get_origin(part) is Literal:
                        found.add(frozenset(get_args(part)))
    return found


def enumerations(scope: Scope) -> dict[str, frozenset[str]]:
    found = {}
    for name, inner in scope.scopes.items():
        if inner.kind == "enum":
            found[name] = frozenset(inner.members)
        found |= enumerations(inner)
    return found


def test_every_enumeration_is_a_literal_with_the_same_names() -> None:
    found = enumerations(SDK)
    assert {"Kind", "Law", "State", "Waveform"} <= set(found)
    missing = {name for name, values in found.items() if values not in literals()}
    assert missing == set()
