"""The fields of an interface's report descriptor, as hid-tools reads its items."""

from __future__ import annotations

from dataclasses import dataclass

from hidtools.hid import ReportDescriptor

APPLICATION, LOGICAL = 1, 2  # kinds of collections


@dataclass(frozen=True)
class Field:
    kind: str  # "Input", "Output" or "Feature"
    flags: int
    usages: tuple[int, ...]
    collections: tuple[tuple[int, int, int], ...]  # number, kind and usage, outermost first
    state: dict[str, int]  # of the other items, by hid-tools' names

    @property
    def report(self) -> int:
        return self.state["Report ID"]

    @property
    def logical(self) -> tuple[int, ...]:
        """Usages of the logical collections round it, outermost first."""
        return tuple(usage for _, kind, usage in self.collections if kind == LOGICAL)

    @property
    def minimum(self) -> int:
        return self.state["Logical Minimum"]

    @property
    def maximum(self) -> int:
        return self.state["Logical Maximum"]

    @property
    def physical(self) -> tuple[int, int]:
        return self.state.get("Physical Minimum", 0), self.state.get("Physical Maximum", 0)

    @property
    def count(self) -> int:
        return self.state["Report Count"]

    @property
    def bits(self) -> int:
        """Size of one value."""
        return self.state["Report Size"]


def fields(descriptor: bytes) -> list[Field]:
    """Apply the rules of HID 1.11, 6.2.2 to the items that hid-tools finds."""
    state: dict[str, int] = {}
    usages: list[int] = []
    collections: list[tuple[int, int, int]] = []
    found: list[Field] = []
    for number, item in enumerate(ReportDescriptor.from_bytes(descriptor).rdesc_items):
        if item.item == "Usage":
            usages.append((state["Usage Page"] << 16) | item.value)
        elif item.item == "Collection":
            collections.append((number, item.value, usages[-1]))
            usages = []
        elif item.item == "End Collection":
            collections.pop()
        elif item.item in ("Input", "Output", "Feature"):
            field = Field(item.item, item.value, tuple(usages), tuple(collections), dict(state))
            found.append(field)
            usages = []
        else:
            state[item.item] = item.value
    assert collections == []
    return found


def report_bytes(of: list[Field]) -> dict[tuple[str, int], int]:
    """Return the sizes of all reports with their numbers, by kind and number."""
    return {
        (f.kind, f.report): 1
        + sum(g.bits * g.count for g in of if (g.kind, g.report) == (f.kind, f.report)) // 8
        for f in of
    }
