"""Names of the protocol's numbers."""

# Printed from the field lists in firmware/protocol/definition/ by `./dev generate`;
# change those instead.

from __future__ import annotations

from typing import Final

__all__ = [
    "STATUS_NAMES",
]

STATUS_NAMES: Final = (
    "ok",
    "bad_length",
    "bad_padding",
    "unknown_report",
    "not_finite",
    "out_of_range",
    "inconsistent",
    "bad_axis",
    "empty_slot",
    "not_armed",
    "not_disarmed",
    "fault_latched",
    "fault_persists",
    "stale",
    "busy",
    "not_owner",
    "unsupported",
)
"""Names of the status codes, by code."""
