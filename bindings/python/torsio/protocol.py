"""Reports as dictionaries and as bytes, through the same codec that device and SDK use.

For tests, tools and other transports; `torsio.open` needs none of this.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from torsio._torsio import protocol as _protocol
from torsio.common import checks
from torsio.errors import MalformedReport
from torsio.printed.statuses import STATUS_NAMES

__all__ = [
    "DRIVEN_FINGERPRINTS",
    "REPORT_SIZE",
    "STATUS_NAMES",
    "VERSION",
    "decode",
    "encode",
    "fingerprint",
    "reports",
]

REPORT_SIZE: Final[int] = _protocol.REPORT_SIZE
"""Bytes of every report."""
VERSION: Final[int] = _protocol.VERSION
"""Version of the protocol."""
DRIVEN_FINGERPRINTS: Final = (_protocol.fingerprint(), *_protocol.RELEASED_FINGERPRINTS)
"""Fingerprints of the firmware that this library drives: its own first, then released ones."""


def fingerprint() -> int:
    """Hash of every report's layout."""
    return _protocol.fingerprint()


def reports() -> list[dict[str, Any]]:
    """Describe every report: name, id, direction, documentation and fields with their ranges."""
    return _protocol.reports()


def encode(report: str, values: Mapping[str, Any]) -> bytes:
    """Make the bytes of a report.

    Parameters
    ----------
    report
        Its name.
    values
        Nested as the report is; enumerations by name. Fields not given keep their defaults. Ranges
        are not checked, so that tests can make what a device must refuse.

    Raises
    ------
    ValueError
        Unknown report or field, or a number that does not fit into the field's type.
    """
    return _protocol.encode(checks.text("report", report), checks.table("values", values))


def decode(data: bytes) -> tuple[str, dict[str, Any]]:
    """Read the bytes of a report into its name and values, by the rules of the device.

    Raises
    ------
    MalformedReport
        With the status and, where there is one, the index of the field.
    """
    checks.kind("data", data, bytes, "bytes")
    name, values, status, field = _protocol.decode(data)
    if status:
        where = f", field {field}" if field is not None else ""
        raise MalformedReport(
            f"{name or 'report'}: {STATUS_NAMES[status]}{where}",
            STATUS_NAMES[status],
            name or "",
            "" if field is None else str(field),
        )
    assert name is not None
    return name, values
