"""Prints files for C++ users, and for the emulator."""

from __future__ import annotations

from emulator.definition import plant
from firmware.protocol.definition import configurations, constants, effects, reports, told
from firmware.protocol.definition import enumerations as e
from tools.definition import cpp
from tools.definition.model import REPORT_UNITS
from tools.definition.shared import (
    CONFIG_ENUMERATIONS,
    DEVICE_ENUMERATIONS,
    EFFECT_ENUMERATIONS,
    KNOT,
    LISTS,
    PLANT_LISTS,
)

_EMULATED = (*plant.PARTS, plant.PLANT_PARAMS, plant.LINK_FAULTS, *plant.TOLD)


def _sdk_header(doc: str, includes: tuple[str, ...], body: str, lists: str = LISTS) -> str:
    return cpp.header(doc, lists, includes, "torsio", body)


def sdk_scene() -> str:
    """Write sdk/include/torsio/scene.hpp."""
    variant = ", ".join(of.name for of in effects.EFFECTS)
    body = (
        f"inline constexpr double kMaxTorqueNm = {float(constants.MAX_TORQUE_NM.value)};  "
        "///< of any effect; the actuator's limits are lower\n\n"
    )
    body += "".join(map(cpp.host_enumeration, EFFECT_ENUMERATIONS))
    body += "".join(map(cpp.host_structure, (effects.TIMING, *effects.EFFECTS)))
    body += "/// Any effect.\n"
    body += f"using Effect = std::variant<{variant}>;\n\n"
    body += cpp.comment(
        f"Up to {constants.MAX_EFFECTS.value} effects; their torques add up. An effect with the "
        "same place and the same values in the next scene goes on playing. Any other starts anew."
    )
    body += "using Scene = std::vector<Effect>;\n\n"
    body += "".join(map(cpp.host_structure, (reports.LOCAL_MODEL, reports.EXCITATION)))
    return _sdk_header(
        "Scenes: what the knob shall feel like. Torques are torques on the knob, positive along "
        "positive angle. Angles are measured from the device's zero. docs/reference/protocol.md has the equation "
        "of each effect.",
        ("<cstdint>", "<limits>", "<optional>", "<variant>", "<vector>"),
        body,
    )


def sdk_config() -> str:
    """Write sdk/include/torsio/config.hpp."""
    body = "".join(map(cpp.host_enumeration, CONFIG_ENUMERATIONS))
    body += "".join(map(cpp.host_structure, configurations.CONFIGURATIONS))
    return _sdk_header(
        "The device's configuration. It can be set only while disarmed and is lost at power-off unless "
        "`Knob::save()` keeps it.",
        ("<cstdint>",),
        body,
    )


def sdk_emulator_options() -> str:
    """Write sdk/include/torsio/emulator_options.hpp."""
    return _sdk_header(
        "How to make an emulated knob.",
        (
            "<cstdint>", "<optional>", "<string>", "torsio/config.hpp", "torsio/plant.hpp",
        ),
        cpp.host_structure(plant.EMULATOR_OPTIONS),
        f"{LISTS} and {PLANT_LISTS}",
    )  # fmt: skip


def sdk_telemetry() -> str:
    """Write sdk/include/torsio/telemetry.hpp."""
    body = "".join(map(cpp.host_enumeration, (*DEVICE_ENUMERATIONS, e.DISARM_REASON)))
    body += cpp.bits(e.FLAG, with_names=False)
    body += "".join(map(cpp.host_structure, (told.TELEMETRY_SAMPLE, *told.TOLD)))
    return _sdk_header(
        "The device's reports about itself.",
        ("<cstdint>", "<string>", "<vector>"),
        body,
    )


def sdk_fields() -> str:
    """Write sdk/include/torsio/fields.hpp."""
    structures = (
        effects.TIMING, *effects.EFFECTS, reports.LOCAL_MODEL, reports.EXCITATION,
        *configurations.CONFIGURATIONS, told.TELEMETRY_SAMPLE, *told.TOLD,
        plant.EMULATOR_OPTIONS,
    )  # fmt: skip
    named = (
        *EFFECT_ENUMERATIONS, *CONFIG_ENUMERATIONS, *DEVICE_ENUMERATIONS, e.DISARM_REASON,
    )  # fmt: skip
    body = "".join(map(cpp.names, named))
    body += "\n" + "".join(map(cpp.field_list, structures))
    return _sdk_header(
        "The fields of every public structure by name, with unit, range and sentence, and the names of "
        "every enumeration's values: for tools that show, keep or edit them.",
        (
            "<array>", "<string_view>", "torsio/config.hpp", "torsio/emulator_options.hpp",
            "torsio/field.hpp", "torsio/scene.hpp", "torsio/telemetry.hpp",
        ),
        body,
        f"{LISTS} and {PLANT_LISTS}",
    )  # fmt: skip


def sdk_wire_types() -> str:
    """Write sdk/conversion/wire_types.hpp."""
    travelling = (
        effects.TIMING, *effects.EFFECTS, reports.LOCAL_MODEL, reports.EXCITATION,
        *configurations.CONFIGURATIONS,
    )  # fmt: skip
    body = "".join(
        f"template <>\nstruct WireType<{of.name}> {{\nusing type = protocol::{of.name};\n}};\n"
        for of in travelling
    )
    return _sdk_header(
        "The protocol's structure for each of the user's, and the units of each report.",
        (
            "<array>", "<cstddef>", "<string_view>",
            "protocol/configuration.hpp", "protocol/effects.hpp", "protocol/reports.hpp",
            "torsio/config.hpp", "torsio/scene.hpp",
        ),
        "/// `type` is the report's structure for a user's structure.\ntemplate <class Host>\nstruct WireType;\n\n"
        + body
        + "\n"
        + cpp.report_units(REPORT_UNITS),
    )  # fmt: skip


def emulator_plant() -> str:
    """Write emulator/include/torsio/plant.hpp."""
    body = cpp.comment(KNOT)
    body += (
        "struct Knot {\ndouble time_s;  ///< since the hand took over\n"
        "double value;  ///< of the function then\n};\n\n"
        "/// A piecewise-linear function of time: its corners in the order of their times.\n"
        "using Profile = std::vector<Knot>;\n\n"
    )
    body += cpp.comment(plant.HAND_FUNCTION)
    body += "using HandFunction =\n    std::function<double(double time_s, double angle_rad, double speed_rad_s)>;\n\n"
    body += "".join(map(cpp.host_structure, plant.HANDS))
    body += "/// The hand on an emulated knob.\n"
    body += f"using Hand = std::variant<{', '.join(of.name for of in plant.HANDS)}>;\n\n"
    body += "".join(map(cpp.host_enumeration, plant.ENUMERATIONS))
    body += "".join(map(cpp.host_structure, _EMULATED))
    body += "/// Serial number of an emulated or virtual knob that is told no other.\n"
    body += f'inline constexpr std::string_view kEmulatedSerial = "{plant.EMULATED_SERIAL}";\n'
    return _sdk_header(
        "An emulated knob: its parts, its hand, its inputs, and values that only the simulation "
        "knows.",
        (
            "<cstdint>",
            "<functional>",
            "<limits>",
            "<optional>",
            "<string_view>",
            "<variant>",
            "<vector>",
        ),
        body,
        PLANT_LISTS,
    )


def emulator_plant_fields() -> str:
    """Write emulator/include/torsio/plant_fields.hpp."""
    structures = (*plant.HANDS, *_EMULATED)
    body = (
        "\n".join(map(cpp.names, plant.ENUMERATIONS))
        + "\n"
        + "".join(map(cpp.field_list, structures))
    )
    return _sdk_header(
        "The fields of the emulated knob's structures by name, as fields.hpp has the others.",
        ("<array>", "<string_view>", "torsio/field.hpp", "torsio/plant.hpp"),
        body,
        PLANT_LISTS,
    )


def emulator_rows() -> str:
    """Write emulator/rows.hpp."""
    body = "".join(map(cpp.host_structure, plant.ROWS)) + "".join(map(cpp.field_list, plant.ROWS))
    return _sdk_header(
        "Rows of the records that a plant alone and a closed loop give.",
        ("<cstdint>", "<string_view>", "torsio/field.hpp"),
        body,
        PLANT_LISTS,
    )


def emulator_beginnings() -> str:
    """Write emulator/beginnings.hpp."""
    body = "".join(map(cpp.host_structure, plant.BEGINNINGS))
    body += "".join(map(cpp.field_list, plant.BEGINNINGS))
    return _sdk_header(
        "How a plant and a closed loop may begin, if not at rest.",
        ("<cstdint>", "<limits>", "<string_view>", "torsio/field.hpp"),
        body,
        PLANT_LISTS,
    )


FILES = {
    "sdk/include/torsio/scene.hpp": sdk_scene,
    "sdk/include/torsio/config.hpp": sdk_config,
    "sdk/include/torsio/emulator_options.hpp": sdk_emulator_options,
    "sdk/include/torsio/telemetry.hpp": sdk_telemetry,
    "sdk/include/torsio/fields.hpp": sdk_fields,
    "sdk/conversion/wire_types.hpp": sdk_wire_types,
    "emulator/include/torsio/plant.hpp": emulator_plant,
    "emulator/include/torsio/plant_fields.hpp": emulator_plant_fields,
    "emulator/beginnings.hpp": emulator_beginnings,
    "emulator/rows.hpp": emulator_rows,
}
