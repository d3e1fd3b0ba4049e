/// @file
/// All configurations, to go through.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include <string_view>
#include <tuple>

#include "torsio/knob.hpp"

namespace torsio {

/// A configuration by its name, and how a knob is asked for it.
template <class Config>
struct ConfigKind {
  using Type = Config;
  std::string_view name;
  Config (Knob::*get)();
};

/// The last is about the values of the others.
inline constexpr std::tuple kConfigKinds{
    ConfigKind<ActuatorConfig>{"actuator_config", &Knob::actuator_config},
    ConfigKind<ControlConfig>{"control_config", &Knob::control_config},
    ConfigKind<BoardConfig>{"board_config", &Knob::board_config},
    ConfigKind<GameConfig>{"game_config", &Knob::game_config},
    ConfigKind<ShaftConfig>{"shaft_config", &Knob::shaft_config},
    ConfigKind<CalibrationConfig>{"calibration_config", &Knob::calibration_config}};

}  // namespace torsio
