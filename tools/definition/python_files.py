"""Prints files for Python users."""

from __future__ import annotations

import textwrap

from emulator.definition import plant, rows
from firmware.protocol.definition import configurations, constants, costs, effects, reports, told
from firmware.protocol.definition import enumerations as e
from tools.definition import python
from tools.definition.shared import LISTS, PLANT_LISTS, TREE, with_printed

_IMPORTS = """\
from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass
from typing import Literal, TypeAlias

from torsio.common import checks

{all}
"""


_BOARD_COST = '''\
from __future__ import annotations

from dataclasses import dataclass
from typing import Final

{all}


@dataclass(frozen=True)
class BoardCost:
    """Cost of a tick on a board.

    Attributes
    ----------
    period_ns
        From tick to tick.
    empty_ns
        The control interrupt's time with an empty scene.
    instruction_ns
        Of a further instruction.
    empty
        Instructions of an armed tick with an empty scene.
    law
        That the law adds as soon as an effect plays.
    laws
        That each law adds to that, if it was counted.
    effects
        That each effect adds, by the name of its class, if it was counted.
    """

    period_ns: int
    empty_ns: int
    instruction_ns: float
    empty: int
    law: int
    laws: dict[str, int]
    effects: dict[str, int]


'''


def python_scenes() -> str:
    """Write the module of effects."""
    body = _IMPORTS.replace("{", "{{").replace("}", "}}").replace("{{all}}", "{all}")
    body = body.replace(
        "import checks\n",
        "import checks\nfrom torsio.printed.effect_methods import EffectMethods\n",
    )
    body += python.number(
        constants.MAX_TORQUE_NM,
        "Largest torque of any effect. The actuator's own limits are lower.",
    )
    body += '\n\nclass Effect(EffectMethods):\n    """Base class of all effects."""\n\n    __slots__ = ()\n'
    body += '\n\nScene: TypeAlias = Effect | Iterable[Effect]\n"""Effects for `Knob.play`."""\n'
    body += "".join(map(python.data_class, (effects.TIMING, *effects.EFFECTS)))
    body += python.data_class(reports.EXCITATION)
    return python.module(
        "Scenes: what the knob shall feel like.\n\n"
        "A scene is one effect or a list of up to 16, whose torques add up. Torques are torques on the "
        "knob,\npositive along positive angle; angles are measured from the device's zero. All "
        "quantities are in SI\nunits, named by the suffix, and given by keyword.\n\n"
        "The classes only hold values. Their ranges are checked when they are played, before anything "
        "is\nsent to the device.",
        LISTS,
        body,
        ("Effect", "Excitation", "Scene", "Timing", *(of.name for of in effects.EFFECTS)),
    )


def python_plant() -> str:
    """Write the module with the parts of an emulated knob."""
    body = (
        "from __future__ import annotations\n\nfrom collections.abc import Iterable\n"
        "from dataclasses import KW_ONLY, dataclass\nfrom typing import Literal\n\n"
        "from torsio.common import checks\nfrom torsio.printed.plant_methods import CoggingShapes, PlantMethods\n\n"
        "{all}\n"
    )
    body += "".join(
        map(python.data_class, (*plant.PARTS, plant.PLANT_PARAMS, plant.ELECTRICS_STATE))
    )
    return python.module(
        "The parts of an emulated knob. Defaults: the reference actuator.",
        PLANT_LISTS,
        body,
        (*(of.name for of in plant.PARTS), plant.PLANT_PARAMS.name, plant.ELECTRICS_STATE.name),
    )


def python_hands() -> str:
    """Write the module of hands."""
    body = (
        "from __future__ import annotations\n\nfrom collections.abc import Callable, Iterable, Sequence\n"
        "from dataclasses import KW_ONLY, dataclass\nfrom typing import TypeAlias\n\n"
        "from torsio.common import checks\n\n{all}\n\n"
        "Profile: TypeAlias = float | Iterable[Sequence[float]]\n"
        '"""Values for the fields of hands, which keep them as a tuple of pairs."""\n'
        "\nHandFunction: TypeAlias = Callable[[float, float, float], float]\n"
        f'"""{textwrap.fill(plant.HAND_FUNCTION, 97)}\n"""\n'
        '\n\nclass Hand(checks.ByName):\n    """Base class of all hands."""\n\n    __slots__ = ()\n'
    )
    body += "".join(map(python.data_class, plant.HANDS))
    return python.module(
        "Hands that hold an emulated knob.\n\n"
        "A profile is a piecewise-linear function of time: knots ``(time_s, value)`` as any iterable "
        "of pairs\nor an array of shape (n, 2), or one number for a constant. The first value holds "
        "before the first\nknot, the last one after the last. Time 0 is when the hand takes over.",
        PLANT_LISTS,
        body,
        ("Hand", "HandFunction", "Profile", *(of.name for of in plant.HANDS)),
    )


def python_emulator_options() -> str:
    """Write the module with an emulated knob's options and inputs."""
    known = {of.name for of in configurations.CONFIGURATIONS}
    configured = known & {f.of.name for f in plant.EMULATOR_OPTIONS.fields if f.of}
    body = (
        "from __future__ import annotations\n\nfrom dataclasses import KW_ONLY, dataclass\n"
        "from typing import Literal\n\nfrom torsio.common import checks\n"
        f"from torsio.printed.config import {', '.join(sorted(configured))}\n"
        "from torsio.printed.hands import Hand, NoHand\nfrom torsio.printed.plant import PlantParams\n\n{all}\n"
    )
    body += f'\nEMULATED_SERIAL = "{plant.EMULATED_SERIAL}"\n'
    body += '"""Serial number of an emulated or virtual knob that is told no other."""\n'
    body += python.data_class(plant.EMULATOR_OPTIONS) + python.data_class(plant.LINK_FAULTS)
    body += python.data_class(plant.DEVICE_INPUT, told=True)
    listed = (plant.EMULATOR_OPTIONS, plant.LINK_FAULTS, plant.DEVICE_INPUT)
    return python.module(
        "How to make an emulated knob, and what happens to it.",
        f"{LISTS}\n# and {PLANT_LISTS}",
        body,
        ("EMULATED_SERIAL", *(of.name for of in listed)),
    )


def python_beginnings() -> str:
    """Write the module of how a plant and a closed loop may begin."""
    body = "from __future__ import annotations\n\nfrom dataclasses import KW_ONLY, dataclass\n\n"
    body += "from torsio.common import checks\n\n{all}\n"
    body += "".join(map(python.data_class, plant.BEGINNINGS))
    return python.module(
        "How a plant and a closed loop may begin, if not at rest.",
        PLANT_LISTS,
        body,
        (of.name for of in plant.BEGINNINGS),
    )


def python_configurations() -> str:
    """Write the module of configurations."""
    body = (
        "from __future__ import annotations\n\nfrom dataclasses import KW_ONLY, dataclass\n"
        "from typing import Final, Literal, TypeAlias\n\nfrom torsio.common import checks\n\n{all}\n\n"
        f"Law: TypeAlias = {python.literal_type(e.LAW)}\n"
        '"""How motor and brake share the torque."""\n'
    )
    body += python.number(constants.MAX_TORQUE_NM, "Largest torque that a limit can be set to.")
    body += python.number(constants.MIN_CONTROL_RATE_HZ, "Slowest control rate of a device.")
    body += python.number(constants.MAX_CONTROL_RATE_HZ, "Fastest control rate of a device.")
    body += python.number(
        constants.EMULATED_CONTROL_PERIOD_NS,
        "A control period of the emulated device, unless it is told another.",
    )
    body += python.number(
        constants.LET_GO_S,
        "A torque's way to zero when somebody disarms, where the passive ramp is not shorter.",
    )
    body += python.number(
        constants.EXCITATION_STILL_S,
        "For so long an excitation's servo may ask for all its torque and see no count.",
    )
    body += "".join(map(python.data_class, configurations.CONFIGURATIONS))
    names = [of.name for of in configurations.CONFIGURATIONS]
    body += f'\n\nConfig: TypeAlias = {" | ".join(names)}\n"""One of them."""\n'
    body += "\nCONFIGS: Final[dict[str, type[Config]]] = {{\n"
    body += "".join(f'    "{name.removesuffix("Config").lower()}": {name},\n' for name in names)
    body += '}}\n"""All there are; the report of one is called NAME_config."""\n'
    return python.module(
        "Configuration of the device. Defaults: the reference actuator.\n\n"
        "It can be set only while the device is disarmed, and is lost at power-off unless\n`Knob.save` "
        "keeps it.",
        LISTS,
        body,
        ("CONFIGS", "Law", *names),
    )


def knob() -> str:
    """Write the methods of `torsio.Knob` that ask for one configuration."""
    file = "bindings/python/torsio/knob/knob.py"
    questions = "".join(
        f"    def {of.snake}(self) -> configs.{of.name}:\n"
        f'        """Ask the device for its `{of.name}`."""\n'
        f"        return self._configuration.ask(configs.{of.name})\n\n"
        for of in configurations.CONFIGURATIONS
    )
    text = (TREE / file).read_text(encoding="utf-8")
    return with_printed(file, text, questions, "    # {}: generated by ./dev generate\n")


def python_told() -> str:
    """Write the module with the structures that a knob returns."""
    body = (
        "from __future__ import annotations\n\nfrom dataclasses import dataclass\n"
        "from typing import Literal, TypeAlias\n\n{all}\n\n"
        f"State: TypeAlias = {python.literal_type(e.STATE)}\n"
        '"""Whether the device makes torque."""\n'
    )
    body += "".join(python.data_class(of, told=True) for of in told.TOLD)
    return python.module(
        "A knob's reports about itself: identity, clock, health, and the state of the cable.",
        LISTS,
        body,
        ("State", *(of.name for of in told.TOLD)),
    )


def python_telemetry() -> str:
    """Write the module of telemetry's rows."""
    body = (
        "from __future__ import annotations\n\nfrom typing import Any, Final, TypeAlias\n\n"
        "import numpy as np\nimport numpy.typing as npt\n\n{all}\n\n"
        'Record: TypeAlias = npt.NDArray[np.void]\n"""A structured array."""\n'
    )
    body += python.record_type("TELEMETRY_DTYPE", told.TELEMETRY_SAMPLE)
    body += python.record_type("TRUTH_DTYPE", rows.TRUTH_SAMPLE)
    body += python.record_type("PLANT_DTYPE", rows.PLANT_ROW)
    body += python.record_type("LOOP_DTYPE", rows.LOOP_ROW)
    body += python.flags(e.FLAG)
    return python.module(
        "Measurements of the device and true values of the emulator, as NumPy structured arrays.\n\n"
        "Records are arrays of shape (n_samples,) with the columns below: ``log[\"angle_rad\"]`` is an "
        "array of\nangles, ``log[0]`` the first sample. Padding bytes are zero.",
        LISTS,
        body,
        (
            "FLAG_STATE_MASK", "LOOP_DTYPE", "PLANT_DTYPE", "Record", "TELEMETRY_DTYPE",
            "TRUTH_DTYPE",
            *(f"FLAG_{bit.name.upper()}" for bit in e.FLAG.bits),
        ),
    )  # fmt: skip


def python_statuses() -> str:
    """Write the module of names that only tools and messages need."""
    names = "".join(f'    "{value.name}",\n' for value in e.STATUS.values)
    advice = "".join(
        f'    "{bit.name}": (\n'
        + "".join(
            f'        "{line}"\n' for line in textwrap.wrap(bit.advice, 84, drop_whitespace=False)
        )
        + "    ),\n"
        for bit in e.FAULT.bits
    )
    body = (
        "from __future__ import annotations\n\nfrom typing import Final\n\n{all}\n\n"
        f'STATUS_NAMES: Final = (\n{names})\n"""Names of the status codes, by code."""\n\n'
        f'FAULT_ADVICE: Final = {{{{\n{advice}}}}}\n"""Advice for each fault of the device."""\n'
    )
    text = "Names of the protocol's numbers, and what to do about them."
    return python.module(text, LISTS, body, ("FAULT_ADVICE", "STATUS_NAMES"))


def python_board_costs() -> str:
    """Write the module with a scene's cost on each board, from counts of one or two effects."""
    boards = ""
    for board, counted in costs.INSTRUCTIONS.items():
        empty, one, two = (counted[f"walls {count}"] for count in range(3))
        law = (one - empty) - (two - one)
        laws = {
            of.name: counted[key] - one
            for of in e.LAW.values
            if (key := f"walls, {of.name} 1" if of.name != "paper" else "walls 1") in counted
        }
        each = {
            of.name: counted[key] - empty - law
            for of in effects.EFFECTS
            if (key := f"{of.snake} 1") in counted
        }
        time = costs.TIMES_NS[board]
        boards += (
            f'    "{board}": BoardCost(\n'
            f"        period_ns={time['period']},\n        empty_ns={time['empty']},\n"
            f"        instruction_ns={time['instruction']},\n        empty={empty},\n"
            f"        law={law},\n"
            + "".join(
                f"        {table}={{{{\n"
                + "".join(f'            "{name}": {count},\n' for name, count in rows.items())
                + "        }},\n"
                for table, rows in (("laws", laws), ("effects", each))
            )
            + "    ),\n"
        )
    body = _BOARD_COST + f"BOARDS: Final = {{{{\n{boards}}}}}\n"
    body += '"""By the name of the board\'s folder."""\n'
    text = "Instructions and time of a control tick on each board, by the effects that play."
    return python.module(text, LISTS, body, ("BOARDS", "BoardCost"))


FILES = {
    "bindings/python/torsio/printed/board_costs.py": python_board_costs,
    "bindings/python/torsio/printed/plant.py": python_plant,
    "bindings/python/torsio/printed/beginnings.py": python_beginnings,
    "bindings/python/torsio/printed/hands.py": python_hands,
    "bindings/python/torsio/printed/emulator_options.py": python_emulator_options,
    "bindings/python/torsio/printed/scenes.py": python_scenes,
    "bindings/python/torsio/printed/config.py": python_configurations,
    "bindings/python/torsio/knob/knob.py": knob,
    "bindings/python/torsio/printed/told.py": python_told,
    "bindings/python/torsio/telemetry.py": python_telemetry,
    "bindings/python/torsio/printed/statuses.py": python_statuses,
}
