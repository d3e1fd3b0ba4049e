"""Prints files for users of C."""

from __future__ import annotations

from emulator.definition import plant, rows
from firmware.protocol.definition import configurations, effects, reports, told
from firmware.protocol.definition import enumerations as e
from tools.definition import c, cpp
from tools.definition.shared import (
    CONFIG_ENUMERATIONS,
    DEVICE_ENUMERATIONS,
    EFFECT_ENUMERATIONS,
    KNOT,
    LISTS,
    PLANT_LISTS,
)

# C has no hand that is a function: nothing calls back into a program there.
_HANDS = tuple(of for of in plant.HANDS if of.host_fields and of is not plant.FEEDBACK_HAND)
_INPUTS = (
    effects.TIMING, *effects.EFFECTS, reports.LOCAL_MODEL, reports.EXCITATION, *configurations.CONFIGURATIONS,
    *_HANDS, *plant.PARTS, plant.PLANT_PARAMS, plant.LINK_FAULTS, plant.EMULATOR_OPTIONS,
)  # fmt: skip
_ENUMERATIONS = (
    *EFFECT_ENUMERATIONS, *CONFIG_ENUMERATIONS, *DEVICE_ENUMERATIONS, e.DISARM_REASON,
    plant.ENCODER_ROUNDING, plant.CURRENT_SENSOR,
)  # fmt: skip
_SAMPLES = (told.TELEMETRY_SAMPLE, rows.TRUTH_SAMPLE)
_TOLD = (*told.TOLD, plant.ELECTRICS_STATE)
_STRUCTURES = (*_INPUTS, *_TOLD, *_SAMPLES)


def c_types() -> str:
    """Write sdk/c/include/torsio_types.h."""
    body = "".join(map(c.enumeration, _ENUMERATIONS)) + c.bits(e.FLAG) + c.bits(e.FAULT)
    body += cpp.comment(KNOT)
    body += "typedef struct torsio_knot {\ndouble time_s;\ndouble value;\n} torsio_knot;\n\n"
    body += "".join(map(c.structure, _STRUCTURES))
    body += cpp.comment(
        "Put an effect behind those that a scene has; ranges are checked when it is played."
    )
    body += "".join(map(c.adder, effects.EFFECTS)) + "\n"
    body += cpp.comment(
        "Read a configuration, or set a whole one, which the device takes while it is disarmed: to "
        "change a field, read, change, set. `torsio_knob_save` keeps it over power-off."
    )
    body += "".join(map(c.configuration, configurations.CONFIGURATIONS))
    return c.header(
        "The enumerations and structures of torsio.h, which includes this. Quantities are in SI units, "
        "torques are torques on the knob, positive along positive angle. `torsio_..._init` fills in a "
        "structure's size and defaults; a structure whose size is wrong is refused. `torsio_..._name` "
        "gives the name of an enumeration's value as messages have it, NULL if there is none.",
        f"{LISTS} and {PLANT_LISTS}",
        ("<stdbool.h>", "<stddef.h>", "<stdint.h>", '"torsio_base.h"'),
        "TORSIO_TYPES_H",
        body,
    )


def c_structures() -> str:
    """Write sdk/c/src/structures.hpp."""
    body = f"inline constexpr std::array<std::string_view, {len(e.FAULT.bits)}> kFaultNames{{"
    body += ", ".join(f'"{bit.name}"' for bit in e.FAULT.bits) + "};\n\n"
    body += "/// Bits of the faults with these names; a later device may have some without a bit.\n"
    body += (
        "inline std::uint32_t fault_bits(const std::vector<std::string>& names) {\n"
        "std::uint32_t bits = 0;\nfor (const std::string& name : names) {\n"
        "for (std::size_t i = 0; i < kFaultNames.size(); ++i) {\n"
        "if (kFaultNames.at(i) == name) bits |= std::uint32_t{1} << i;\n}\n}\nreturn bits;\n}\n\n"
    )
    body += "".join(map(c.reader, _INPUTS)) + "\n"
    body += "".join(map(c.writer, (*_INPUTS, *_TOLD))) + "\n"
    body += "// Samples go over as they are.\n" + "".join(map(c.same_layout, _SAMPLES))
    return cpp.header(
        "Converts C's structures to C++'s and back.",
        f"{LISTS} and {PLANT_LISTS}",
        (
            "<array>", "<cstddef>", "<cstdint>", "<string>", "<string_view>", "<vector>",
            "c_values.hpp", "torsio/config.hpp", "torsio/plant.hpp", "torsio/scene.hpp",
            "torsio/emulator_options.hpp", "torsio/telemetry.hpp", "torsio_types.h",
        ),
        "torsio::c",
        body,
    )  # fmt: skip


def c_functions() -> str:
    """Write sdk/c/src/structures.cpp."""
    body = "".join(
        f"const char *{c.c_name(named)}_name(std::int32_t value) {{ "
        f"return torsio::c::value_name<torsio::{named.name}>(value); }}\n"
        for named in _ENUMERATIONS
    )
    body += "\n" + "".join(
        f"torsio_result {c.c_name(of)}_init({c.c_name(of)} *structure) {{ "
        f"return torsio::c::init<torsio::{of.name}>(structure); }}\n"
        for of in (*_INPUTS, *_TOLD)
        if c.has_size(of)
    )
    body += "\n" + "".join(
        c.definition(c.adder(of), f'return torsio::c::add(scene, effect, "{c.c_name(of)}");')
        for of in effects.EFFECTS
    )
    body += "\n"
    for of in configurations.CONFIGURATIONS:
        read, write = c.configuration(of).splitlines()
        own, member = f'"{c.c_name(of)}"', f"&torsio::Knob::{c.snake(of.name)}"
        body += c.definition(read, f"return torsio::c::get(knob, config, {own}, {member});")
        body += c.definition(
            write, f"return torsio::c::configure<torsio::{of.name}>(knob, config, {own});"
        )
    return (
        "// The functions of torsio_types.h.\n//\n"
        + cpp.comment(cpp.GENERATED.format(lists=f"{LISTS} and {PLANT_LISTS}"), "//")
        + '#include "handles.hpp"\n#include "structures.hpp"\n#include "torsio.h"\n'
        + '#include "torsio/fields.hpp"\n#include "torsio/plant_fields.hpp"\n\n'
        + body
    )


FILES = {
    "sdk/c/include/torsio_types.h": c_types,
    "sdk/c/src/structures.hpp": c_structures,
    "sdk/c/src/structures.cpp": c_functions,
}
