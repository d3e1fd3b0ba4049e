"""Prints files for the firmware: reports, and the choices of the control mathematics."""

from __future__ import annotations

from firmware.protocol.definition import configurations, constants, effects, reports
from firmware.protocol.definition import enumerations as e
from tools.definition import cpp
from tools.definition.model import Enumeration, Structure
from tools.definition.shared import (
    CONFIG_ENUMERATIONS,
    DEVICE_ENUMERATIONS,
    EFFECT_ENUMERATIONS,
    LISTS,
)

_STD = ("<array>", "<cstdint>", "<string_view>", "<tuple>")


def _wire_header(doc: str, includes: tuple[str, ...], body: str) -> str:
    return cpp.header(doc, LISTS, (*_STD, *includes), "torsio::protocol", body)


def wire_enumerations() -> str:
    """Write firmware/protocol/enumerations.hpp."""
    listed: tuple[Enumeration, ...] = (
        e.TOGGLE, *EFFECT_ENUMERATIONS, *CONFIG_ENUMERATIONS, *DEVICE_ENUMERATIONS, e.OP,
        e.EVENT_KIND, e.STATUS,
    )  # fmt: skip
    body = "".join(map(cpp.wire_enumeration, listed)) + cpp.bits(e.FAULT) + cpp.bits(e.FLAG)
    return _wire_header(
        "Every enumeration and every set of bits that travels.", ("protocol/layout.hpp",), body
    )


def wire_effects() -> str:
    """Write firmware/protocol/effects.hpp."""
    numbers = (
        constants.MAX_EFFECTS,
        constants.CURVE_POOL_POINTS,
        constants.CURVE_POINTS_PER_REPORT,
        constants.MAX_TORQUE_NM,
        constants.MAX_STIFFNESS_NM_PER_RAD,
        constants.MAX_DAMPING_NM_S_PER_RAD,
        constants.MAX_INERTIA_KG_M2,
        constants.MAX_TIME_S,
        constants.MAX_TURNS_Q32,
        constants.MIN_SPAN_TURNS_Q32,
        constants.MAX_SPAN_TURNS_Q32,
        constants.MAX_CYCLES_PER_TURN_Q32,
    )
    listed = (effects.TARGET, effects.TIMING, *effects.EFFECTS, effects.CURVE_POINTS)
    body = "".join(map(cpp.constant, numbers)) + "\n"
    body += "".join(map(cpp.wire_structure, listed))
    body += cpp.report_list(
        "EffectReports", "Reports that put an effect into a slot.", effects.EFFECTS
    )
    body += cpp.report_list("EffectReport", "Any of them.", effects.EFFECTS, "std::variant")
    body += cpp.wire_sizes(listed)
    return _wire_header(
        "The effects of a scene as they travel: one report each. Angles that may lie many turns away "
        "are fixed-point turns, which stay exact after any amount of turning. Every other quantity is a "
        "float in SI units. Torques are torques on the knob, positive along positive "
        "angle.",
        ("<variant>", "protocol/enumerations.hpp", "protocol/layout.hpp"),
        body,
    )


def wire_configuration() -> str:
    """Write firmware/protocol/configuration.hpp."""
    listed = configurations.CONFIGURATIONS
    numbers = (
        constants.UNCONFIRMED_MOTOR_TORQUE_MAX_NM,
        constants.UNCONFIRMED_BRAKE_TORQUE_MAX_NM,
        constants.UNCONFIRMED_SPEED_LIMIT_RAD_S,
    )
    body = "// Limits of a real board until its parts are confirmed and known.\n"
    body += "".join(map(cpp.constant, numbers)) + "\n"
    body += cpp.constant(constants.LET_GO_S) + "\n"
    body += cpp.constant(constants.EXCITATION_STILL_S) + "\n"
    body += "".join(map(cpp.wire_structure, listed)) + cpp.wire_sizes(listed)
    return _wire_header(
        "The device's parts and its control: the reports that are kept in flash.",
        ("protocol/effects.hpp", "protocol/enumerations.hpp", "protocol/layout.hpp"),
        body,
    )


def wire_configurations() -> str:
    """Write firmware/protocol/configurations.hpp."""
    listed = configurations.CONFIGURATIONS
    names = {of.name: of.name.removesuffix("Config").lower() for of in listed}
    members = "".join(f"{of} {name};\n" for of, name in names.items())
    given = "".join(f"std::optional<{of}> {name}{{}};\n" for of, name in names.items())
    visits = "".join(f"visit(all.{name});\n" for name in names.values())
    places = "".join(
        f"template <>\nstruct PlaceOf<{of}> {{\n"
        f"static constexpr auto value = &Configurations::{name};\n}};\n"
        for of, name in names.items()
    )
    body = cpp.report_list("AllConfigurations", "Their reports.", listed)
    body += f"/// One of each.\nstruct Configurations {{\n{members}}};\n\n"
    body += f"/// Some of them.\nstruct GivenConfigurations {{\n{given}}};\n\n"
    body += "/// Where a report has its place among them.\n"
    body += f"template <class Report>\nstruct PlaceOf;\n{places}\n"
    body += (
        "template <class Report>\nconcept Configuration = requires { PlaceOf<Report>::value; };\n\n"
    )
    body += "/// Calls `visit(part)` for each.\ntemplate <class All, class Visit>\n"
    body += f"constexpr void for_each_configuration(All& all, Visit&& visit) {{\n{visits}}}\n"
    return _wire_header(
        "All configurations, to go through.",
        ("<optional>", "<tuple>", "protocol/configuration.hpp"),
        body,
    )


def device_config_rules() -> str:
    """Write firmware/device/config_rules.hpp."""
    return cpp.header(
        "Rules across the fields of a configuration: what no single field's range can say.",
        LISTS,
        ("protocol/configuration.hpp", "protocol/status.hpp"),
        "torsio::device",
        "".join(
            f"protocol::Verdict check_consistent(const protocol::{of.name}& config);\n"
            for of in configurations.WITH_RULES
        ),
    )


def wire_reports() -> str:
    """Write firmware/protocol/reports.hpp."""
    listed: list[Structure] = [
        of
        for of in reports.ALL_REPORTS
        if of not in effects.EFFECTS
        and of not in configurations.CONFIGURATIONS
        and of is not effects.CURVE_POINTS
    ]
    listed.insert(listed.index(reports.TELEMETRY), reports.SAMPLE)
    listed.insert(listed.index(reports.GAME_MONITOR), reports.GAME_EFFECT)
    numbers = (
        constants.MIN_CONTROL_PERIOD_NS,
        constants.MAX_CONTROL_PERIOD_NS,
        constants.EMULATED_CONTROL_PERIOD_NS,
        constants.MIN_CONTROL_RATE_HZ,
        constants.MAX_CONTROL_RATE_HZ,
    )
    body = "".join(map(cpp.constant, numbers)) + "\n"
    body += cpp.constant(constants.PROTOCOL_VERSION) + cpp.constant(constants.SAMPLES_PER_REPORT)
    released = ", ".join(f"0x{one:08X}" for one in constants.RELEASED_FINGERPRINTS)
    body += f"inline constexpr std::array<std::uint32_t, {len(constants.RELEASED_FINGERPRINTS)}>\n"
    body += f"released_fingerprints{{{released}}};  // of older firmware that this library drives\n"
    body += cpp.constant(constants.GAME_EFFECTS_PER_REPORT) + "\n"
    body += "".join(map(cpp.wire_structure, listed))
    body += cpp.report_list(
        "AllReports", "Every report, in the order of the documentation.", reports.ALL_REPORTS
    )
    body += cpp.wire_sizes(listed)
    return _wire_header(
        "Everything that is neither an effect nor configuration: identity, clock, health, commands, "
        "telemetry; and the list of all reports.",
        (
            "protocol/configuration.hpp", "protocol/effects.hpp", "protocol/enumerations.hpp",
            "protocol/layout.hpp", "protocol/status.hpp",
        ),
        body,
    )  # fmt: skip


def core_enumerations() -> str:
    """Write firmware/core/enumerations.hpp."""
    listed = (e.WAVEFORM, e.DETENT_PROFILE, e.GRAIN, e.LAW)
    return cpp.header(
        "The choices that the control mathematics has. They keep their number from the wire.",
        LISTS,
        ("<cstdint>",),
        "torsio::core",
        "".join(map(cpp.host_enumeration, listed)),
    )


FILES = {
    "firmware/core/enumerations.hpp": core_enumerations,
    "firmware/protocol/enumerations.hpp": wire_enumerations,
    "firmware/protocol/effects.hpp": wire_effects,
    "firmware/protocol/configuration.hpp": wire_configuration,
    "firmware/protocol/configurations.hpp": wire_configurations,
    "firmware/protocol/reports.hpp": wire_reports,
    "firmware/device/config_rules.hpp": device_config_rules,
}
