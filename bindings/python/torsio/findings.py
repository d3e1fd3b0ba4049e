"""One finding of `torsio doctor`: what was looked at, and what is to be done."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

__all__ = ["Finding"]


@dataclass(frozen=True)
class Finding:
    """One matter that was looked at."""

    check: str
    """Its name, for machines."""
    ok: bool
    text: str
    """What was found, in plain words."""
    advice: str = ""
    """What to do; empty if `ok`."""
    values: dict[str, Any] = field(default_factory=dict)
    """The figures behind it, SI units."""

    @property
    def more(self) -> str:
        """Where there is more to read, in the project; empty if `ok`."""
        return "" if self.ok else f"docs/troubleshooting.md#{self.check}"
