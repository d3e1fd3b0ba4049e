"""A knob's whole configuration as a text to keep.

It is the JSON that `torsio config dump` prints and `torsio config load` takes.
"""

from __future__ import annotations

from torsio.common import checks
from torsio.knob import Knob, need_knob

__all__ = ["dump_config", "load_config"]


def dump_config(knob: Knob) -> str:
    """Give the configuration that a knob has.

    There is an object for each of `torsio.CONFIGS`, as in `actuator_config`, with its fields by
    name.
    """
    need_knob(knob)
    return knob._configuration.dump()


def load_config(knob: Knob, text: str) -> None:
    """Set what such a text has, and save it.

    Fields that it does not name stay. If the knob refuses a part, everything stays.

    Raises
    ------
    InvalidArgument
        It is no such text, or has a field or a value that the knob does not take.
    Refused
        Somebody has the actuator.
    """
    need_knob(knob)
    knob._configuration.load(checks.text("text", text))
