"""A method for each configuration."""

# Printed from the field lists in firmware/protocol/definition/ by `./dev generate`;
# change those instead.

from __future__ import annotations

from typing import TypeVar

from torsio.printed.config import (
    ActuatorConfig,
    BoardConfig,
    CalibrationConfig,
    Config,
    ControlConfig,
    GameConfig,
    ShaftConfig,
)

__all__ = [
    "ConfigQuestions",
]

_Config = TypeVar("_Config", bound=Config)


class ConfigQuestions:
    """A method for each configuration of a device."""

    def config(self, kind: type[_Config]) -> _Config:
        """Ask the device for one."""
        raise NotImplementedError

    def actuator_config(self) -> ActuatorConfig:
        """Ask the device for its `ActuatorConfig`."""
        return self.config(ActuatorConfig)

    def control_config(self) -> ControlConfig:
        """Ask the device for its `ControlConfig`."""
        return self.config(ControlConfig)

    def board_config(self) -> BoardConfig:
        """Ask the device for its `BoardConfig`."""
        return self.config(BoardConfig)

    def game_config(self) -> GameConfig:
        """Ask the device for its `GameConfig`."""
        return self.config(GameConfig)

    def shaft_config(self) -> ShaftConfig:
        """Ask the device for its `ShaftConfig`."""
        return self.config(ShaftConfig)

    def calibration_config(self) -> CalibrationConfig:
        """Ask the device for its `CalibrationConfig`."""
        return self.config(CalibrationConfig)
