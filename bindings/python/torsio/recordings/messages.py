"""Messages of a recording: their topics and columns, and how JSON has their values."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass
from typing import Any, Final, TypeAlias

import numpy as np

from torsio.printed.told import Energies
from torsio.telemetry import TELEMETRY_DTYPE

__all__ = ["COLUMNS", "ENERGIES", "TOPICS", "LoggedReport", "encoded", "plain", "schema_of"]

LoggedReport: TypeAlias = tuple[int, bool, bytes]
"""Ticks of the newest thing that the device had said by then, whether it was sent, its bytes."""

TOPICS: Final = (
    *("telemetry", "energies", "events", "device_events", "drop_outs", "reports", "inputs"),
)
_FIELDS: Final[dict[str, dict[str, str]]] = {
    "drop_outs": {"samples_lost": "integer"},
    "events": {"kind": "string"},
    "device_events": {"kind": "string", "state": "string", "faults": "integer", "tick": "integer"},
    "reports": {"tick": "integer", "sent": "boolean", "name": "string", "bytes": "string"},
    "inputs": {"tick": "integer", "kind": "string", "bytes": "string"},
    "energies": {
        of.name: {"int": "integer", "float": "number", "bool": "boolean"}[str(of.type)]
        for of in fields(Energies)
    },
}
COLUMNS: Final = TELEMETRY_DTYPE.names or ()
ENERGIES: Final = tuple(_FIELDS["energies"])
_JSON_TYPES: Final = {"f": "number", "u": "integer", "i": "integer"}


def schema_of(topic: str) -> dict[str, Any]:
    """Describe a topic's messages to viewers."""
    types = _FIELDS.get(topic) or {
        name: _JSON_TYPES[TELEMETRY_DTYPE[name].kind] for name in COLUMNS
    }
    columns = {name: {"type": type} for name, type in types.items()}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"torsio.{topic}",
        "type": "object",
        "properties": columns,
        "required": list(columns),
    }


def plain(value: Any) -> Any:
    """Turn effects, configurations and arrays into what JSON has, with their class's name.

    NaN and infinities become "NaN", "Infinity" and "-Infinity", which `float` reads.
    """
    if is_dataclass(value) and not isinstance(value, type):
        return {"type": type(value).__name__, **{k: plain(v) for k, v in asdict(value).items()}}
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return _word(value)
    return value


def _word(value: float) -> str:
    return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"


def encoded(message: Mapping[str, Any]) -> bytes:
    """Give a message's bytes."""
    return json.dumps(plain(message), separators=(",", ":"), default=str, allow_nan=False).encode()
