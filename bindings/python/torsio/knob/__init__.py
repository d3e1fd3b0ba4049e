"""A knob and its parts."""

from torsio.knob.knob import Knob

__all__ = ["Knob"]
