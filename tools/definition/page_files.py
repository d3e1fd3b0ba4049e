"""Prints files for readers and for the studio, and the places that state the USB ids."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from firmware.protocol.definition import configurations, constants, effects, reports
from firmware.protocol.definition import enumerations as e
from tools import check_layers, usb_ids
from tools.definition import javascript, markdown
from tools.definition.shared import LISTS, TREE, with_printed
from tools.dev import groups


def protocol_page() -> str:
    """Write docs/reference/protocol.md."""
    return markdown.protocol(
        reports.ALL_REPORTS,
        (reports.SAMPLE, reports.GAME_EFFECT),
        e.STATUS,
        e.FAULT,
        e.FLAG,
        int(constants.PROTOCOL_VERSION.value),
    )


def studio_reports() -> str:
    """Write studio/src/reports.ts."""
    vendor, product = (int(number, 16) for number in usb_ids.ids())
    names = "readonly string[]"
    return javascript.module(
        "Every report, configuration and effect, with ranges, units and words.",
        LISTS,
        {
            "FINGERPRINT": ("number", markdown.fingerprint(reports.ALL_REPORTS)),
            "RELEASED_FINGERPRINTS": ("readonly number[]", list(constants.RELEASED_FINGERPRINTS)),
            "PROTOCOL_VERSION": ("number", constants.PROTOCOL_VERSION.value),
            "USB": ("{ vendorId: number; productId: number }",
                    {"vendorId": vendor, "productId": product}),
            "CURVE_POINTS_PER_REPORT": ("number", constants.CURVE_POINTS_PER_REPORT.value),
            "MAX_TORQUE_NM": ("number", constants.MAX_TORQUE_NM.value),
            "MAX_TURNS_Q32": ("number", float(constants.MAX_TURNS_Q32.value)),
            "MIN_SPAN_TURNS_Q32": ("number", float(constants.MIN_SPAN_TURNS_Q32.value)),
            "MAX_CYCLES_PER_TURN_Q32": ("number", float(constants.MAX_CYCLES_PER_TURN_Q32.value)),
            "MAX_SPAN_TURNS_Q32": ("number", float(constants.MAX_SPAN_TURNS_Q32.value)),
            "LEDGER_TORQUE_NM": ("number", constants.LEDGER_TORQUE_NM),
            "STATES": (names, javascript.values(e.STATE)),
            "OWNERS": (names, javascript.values(e.OWNER)),
            "STATUSES": (
                "readonly { name: string; doc: string; advice: string }[]",
                [{"name": v.name, "doc": v.doc, "advice": v.advice} for v in e.STATUS.values],
            ),
            "DISARM_REASONS": (
                "readonly { name: string; doc: string }[]",
                [{"name": v.name, "doc": v.doc} for v in e.DISARM_REASON.values],
            ),
            "FAULTS": ("readonly Bit[]", javascript.bits(e.FAULT)),
            "FLAGS": ("readonly Bit[]", javascript.bits(e.FLAG)),
            "EFFECTS": (names, [of.snake for of in effects.EFFECTS]),
            "CONFIGURATIONS": (names, [of.snake for of in configurations.CONFIGURATIONS]),
            "REPORTS": ("Readonly<Record<string, Report>>", javascript.reports(reports.ALL_REPORTS)),
        },
    )  # fmt: skip


def hardware_page() -> str:
    """Write the table of wiring in docs/reference/hardware.md."""
    page = "docs/reference/hardware.md"
    text = usb_ids.with_ids((TREE / page).read_text(encoding="utf-8"))
    return with_printed(page, text, markdown.wiring(configurations.BOARD_CONFIG))


def configuration_page() -> str:
    """Write the tables of docs/reference/configuration.md."""
    page = "docs/reference/configuration.md"
    text = (TREE / page).read_text(encoding="utf-8")
    return with_printed(page, text, markdown.configuration(configurations.CONFIGURATIONS))


def architecture_page() -> str:
    """Write the table of allowed includes in docs/explanation/architecture.md."""
    page = "docs/explanation/architecture.md"
    return with_printed(page, (TREE / page).read_text(encoding="utf-8"), check_layers.table())


def _with_usb_ids(place: Path) -> Callable[[], str]:
    """Give a file that states the knob's USB ids as it must be."""
    return lambda: usb_ids.with_ids(place.read_text(encoding="utf-8"))


def contributing_page() -> str:
    """Write the table of tests in CONTRIBUTING.md."""
    page = "CONTRIBUTING.md"
    return with_printed(page, (TREE / page).read_text(encoding="utf-8"), groups.table())


FILES = {
    **{str(place.relative_to(TREE)): _with_usb_ids(place) for place in usb_ids.places()},
    "studio/src/reports.ts": studio_reports,
    "CONTRIBUTING.md": contributing_page,
    "docs/reference/configuration.md": configuration_page,
    "docs/reference/protocol.md": protocol_page,
    "docs/reference/hardware.md": hardware_page,
    "docs/explanation/architecture.md": architecture_page,
}
