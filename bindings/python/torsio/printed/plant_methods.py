"""Methods of the plant's printed data classes."""

from __future__ import annotations

from math import pi, sin
from typing import Any, TypeVar

from torsio import _torsio
from torsio.common import checks
from torsio.printed.config import ActuatorConfig, ShaftConfig

_Shape = TypeVar("_Shape", bound="CoggingShapes")


class CoggingShapes(checks.ByName):
    """Ways to make a table of cogging."""

    def __init__(self, **fields: Any) -> None:
        """Be a data class with `periods_per_rev` and `torque_nm`."""
        raise NotImplementedError

    @classmethod
    def sine(
        cls: type[_Shape], *, periods_per_rev: int, amplitude_nm: float, points: int = 16
    ) -> _Shape:
        """Make a sine wave of so many corners a period."""
        count = checks.whole("points", points, 2, 64)
        amplitude_nm = checks.number("amplitude_nm", amplitude_nm)
        wave = tuple(amplitude_nm * sin(2 * pi * i / count) for i in range(count))
        return cls(periods_per_rev=periods_per_rev, torque_nm=wave)


class PlantMethods(checks.ByName):
    """Questions to a plant."""

    def matching_config(self) -> ActuatorConfig:
        """Give the configuration of a device that was calibrated perfectly to this plant."""
        return ActuatorConfig(**_torsio.matching_config(self))  # type: ignore[arg-type]

    def matching_shaft(self) -> ShaftConfig:
        """Give the same of its shaft: the knee where it hardens."""
        return ShaftConfig(**_torsio.matching_shaft(self))  # type: ignore[arg-type]
