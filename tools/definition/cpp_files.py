"""Prints files for C++ users, and for the emulator."""

from __future__ import annotations

from emulator.definition import plant, rows
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

_EMULATED = (*plant.PARTS, plant.PLANT_PARAMS, plant.LINK_FAULTS, *rows.TOLD)


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


_CONFIGURE = (
    "Sets a whole configuration: fields that were left at their defaults take these, whatever the "
    "device had. To change some and keep the rest there is update(). Another counts_per_rev also "
    "empties the scene; a board's wiring takes effect when the device starts the next time, if it "
    "was saved. A calibration is of the values of actuator and shaft that the device has now."
)
_CONFIGURE_THROWS = (
    "@throws InvalidArgument that names the field, also for a pin with two jobs; Refused "
    "(not_disarmed)"
)
_UPDATE = (
    "Changes fields of a configuration and keeps the rest: "
    "`knob.update([](ControlConfig& control) { control.law = Law::compensated; })`. "
    "The type that `change` takes says which one."
)


def _each_configuration(line: str, *first: str) -> str:
    """Write a line for each configuration, the first with a comment that counts for all."""
    lines = [line.format(config=of.name, snake=of.snake) for of in configurations.CONFIGURATIONS]
    return (
        "".join(map(cpp.comment, first))
        + f"{lines[0]}\n"
        + "".join(f"{one}  ///< as above\n" for one in lines[1:])
    )


def sdk_knob_configurations() -> str:
    """Write sdk/include/torsio/knob_configurations.hpp."""
    body = (
        "/// The members of a Knob that are about one configuration each.\n"
        "class TORSIO_EXPORT KnobConfigurations {\n public:\n"
        + _each_configuration("[[nodiscard]] {config} {snake}();", "The device's present values.")
        + _each_configuration(
            "void configure(const {config}& config);", _CONFIGURE, _CONFIGURE_THROWS
        )
        + _each_configuration(
            "void update(const std::function<void({config}&)>& change);",
            _UPDATE,
            "@throws as configure(), and what `change` throws",
        )
        + "\n protected:\n  KnobConfigurations() = default;\n};\n"
    )
    return _sdk_header(
        "A knob's configurations, one by one.",
        ("<functional>", "torsio/config.hpp", "torsio/export.hpp"),
        body,
    )


def sdk_knob_configurations_source() -> str:
    """Write sdk/src/knob_configurations.cpp."""
    own = "KnobConfigurations::"
    body = "".join(
        f"{of.name} {own}{of.snake}() {{ return Knob::Impl::of(*this).config<{of.name}>(); }}\n"
        f"void {own}configure(const {of.name}& config) {{ Knob::Impl::of(*this).configure(config); }}\n"
        f"void {own}update(const std::function<void({of.name}&)>& change) {{\n"
        "Knob::Impl::update(*this, change);\n}\n\n"
        for of in configurations.CONFIGURATIONS
    )
    return (
        cpp.comment(cpp.GENERATED.format(lists=LISTS), "//")
        + '#include "torsio/knob_configurations.hpp"\n\n#include "knob_impl.hpp"\n\n'
        + f"namespace torsio {{\n\n{body}}}  // namespace torsio\n"
    )


def sdk_config_kinds() -> str:
    """Write sdk/conversion/config_kinds.hpp."""
    kinds = ",\n".join(
        f'ConfigKind<{of.name}>{{"{of.snake}", &Knob::{of.snake}}}'
        for of in configurations.CONFIGURATIONS
    )
    return _sdk_header(
        "All configurations, to go through.",
        ("<string_view>", "<tuple>", "torsio/knob.hpp"),
        "/// A configuration by its name, and how a knob is asked for it.\n"
        "template <class Config>\nstruct ConfigKind {\nusing Type = Config;\nstd::string_view name;\n"
        "Config (Knob::*get)();\n};\n\n"
        "/// The last is about the values of the others.\n"
        f"inline constexpr std::tuple kConfigKinds{{\n{kinds}}};\n",
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
        + cpp.report_units(REPORT_UNITS)
        + "\nnamespace conversion {\n\n"
        + "/// @throws InvalidArgument that names a field which does not go with the others\n"
        + "".join(
            f"protocol::{of.name} to_wire(const {of.name}& config);\n"
            for of in configurations.WITH_RULES
        )
        + "\n}  // namespace conversion\n",
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
    body = "".join(map(cpp.host_structure, rows.ROWS)) + "".join(map(cpp.field_list, rows.ROWS))
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
    "sdk/include/torsio/knob_configurations.hpp": sdk_knob_configurations,
    "sdk/src/knob_configurations.cpp": sdk_knob_configurations_source,
    "sdk/conversion/config_kinds.hpp": sdk_config_kinds,
    "sdk/include/torsio/emulator_options.hpp": sdk_emulator_options,
    "sdk/include/torsio/telemetry.hpp": sdk_telemetry,
    "sdk/include/torsio/fields.hpp": sdk_fields,
    "sdk/conversion/wire_types.hpp": sdk_wire_types,
    "emulator/include/torsio/plant.hpp": emulator_plant,
    "emulator/include/torsio/plant_fields.hpp": emulator_plant_fields,
    "emulator/beginnings.hpp": emulator_beginnings,
    "emulator/rows.hpp": emulator_rows,
}
