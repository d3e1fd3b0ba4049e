/// @file
/// All configurations, to go through.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <tuple>

#include "protocol/configuration.hpp"

namespace torsio::protocol {

/// Their reports.
using AllConfigurations = std::tuple<ActuatorConfig, ControlConfig, BoardConfig, GameConfig,
                                     ShaftConfig, CalibrationConfig>;

/// One of each.
struct Configurations {
  ActuatorConfig actuator;
  ControlConfig control;
  BoardConfig board;
  GameConfig game;
  ShaftConfig shaft;
  CalibrationConfig calibration;
};

/// Some of them.
struct GivenConfigurations {
  std::optional<ActuatorConfig> actuator{};
  std::optional<ControlConfig> control{};
  std::optional<BoardConfig> board{};
  std::optional<GameConfig> game{};
  std::optional<ShaftConfig> shaft{};
  std::optional<CalibrationConfig> calibration{};
};

/// Where a report has its place among them.
template <class Report>
struct PlaceOf;
template <>
struct PlaceOf<ActuatorConfig> {
  static constexpr auto value = &Configurations::actuator;
};
template <>
struct PlaceOf<ControlConfig> {
  static constexpr auto value = &Configurations::control;
};
template <>
struct PlaceOf<BoardConfig> {
  static constexpr auto value = &Configurations::board;
};
template <>
struct PlaceOf<GameConfig> {
  static constexpr auto value = &Configurations::game;
};
template <>
struct PlaceOf<ShaftConfig> {
  static constexpr auto value = &Configurations::shaft;
};
template <>
struct PlaceOf<CalibrationConfig> {
  static constexpr auto value = &Configurations::calibration;
};

template <class Report>
concept Configuration = requires { PlaceOf<Report>::value; };

/// Calls `visit(part)` for each.
template <class All, class Visit>
constexpr void for_each_configuration(All& all, Visit&& visit) {
  visit(all.actuator);
  visit(all.control);
  visit(all.board);
  visit(all.game);
  visit(all.shaft);
  visit(all.calibration);
}

}  // namespace torsio::protocol
