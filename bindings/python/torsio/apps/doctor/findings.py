"""One finding of `torsio doctor`: what was looked at, and what is to be done."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from torsio.common.documents import entry

__all__ = ["Finding"]


@dataclass(frozen=True)
class Finding:
    """One matter that was looked at."""

    check: str
    """Its name, for machines."""
    ok: bool
    text: str
    """The finding, in plain words."""
    advice: str = ""
    """Advice; empty if there is nothing to be done."""
    values: dict[str, Any] = field(default_factory=dict)
    """The figures behind it, SI units."""
    faults: tuple[str, ...] = ()
    """Faults that have entries of their own."""

    @property
    def more(self) -> str:
        """Where there is more to read, on the site or in a clone; empty without advice."""
        return entry(self.check) if self.advice else ""

    @property
    def links(self) -> list[str]:
        """All entries: the faults' and the finding's own."""
        return [*map(entry, self.faults), self.more] if self.advice else []
