"""A knob and its parts."""

from torsio.knob.knob import Knob, need_knob

__all__ = ["Knob", "need_knob"]
