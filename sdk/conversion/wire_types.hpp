/// @file
/// The protocol's structure for each of the user's, and the units of each report.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "protocol/configuration.hpp"
#include "protocol/effects.hpp"
#include "protocol/reports.hpp"
#include "torsio/config.hpp"
#include "torsio/scene.hpp"

namespace torsio {

/// `type` is the report's structure for a user's structure.
template <class Host>
struct WireType;

template <>
struct WireType<Timing> {
  using type = protocol::Timing;
};
template <>
struct WireType<Wall> {
  using type = protocol::Wall;
};
template <>
struct WireType<Spring> {
  using type = protocol::Spring;
};
template <>
struct WireType<Damper> {
  using type = protocol::Damper;
};
template <>
struct WireType<Friction> {
  using type = protocol::Friction;
};
template <>
struct WireType<Inertia> {
  using type = protocol::Inertia;
};
template <>
struct WireType<Constant> {
  using type = protocol::Constant;
};
template <>
struct WireType<Ramp> {
  using type = protocol::Ramp;
};
template <>
struct WireType<Periodic> {
  using type = protocol::Periodic;
};
template <>
struct WireType<Detents> {
  using type = protocol::Detents;
};
template <>
struct WireType<EndStops> {
  using type = protocol::EndStops;
};
template <>
struct WireType<Texture> {
  using type = protocol::Texture;
};
template <>
struct WireType<Curve> {
  using type = protocol::Curve;
};
template <>
struct WireType<Impact> {
  using type = protocol::Impact;
};
template <>
struct WireType<LocalModel> {
  using type = protocol::LocalModel;
};
template <>
struct WireType<Excitation> {
  using type = protocol::Excitation;
};
template <>
struct WireType<ActuatorConfig> {
  using type = protocol::ActuatorConfig;
};
template <>
struct WireType<ControlConfig> {
  using type = protocol::ControlConfig;
};
template <>
struct WireType<BoardConfig> {
  using type = protocol::BoardConfig;
};
template <>
struct WireType<GameConfig> {
  using type = protocol::GameConfig;
};
template <>
struct WireType<ShaftConfig> {
  using type = protocol::ShaftConfig;
};
template <>
struct WireType<CalibrationConfig> {
  using type = protocol::CalibrationConfig;
};

/// How users know a number that a report counts in a unit of its own.
struct ReportUnit {
  std::string_view unit;
  std::string_view ending;       ///< of the name in the report
  std::string_view told_ending;  ///< of the name in SI units
};

inline constexpr std::array<ReportUnit, 6> kReportUnits{{
    {"ns", "_ns", "_s"},
    {"ms", "_ms", "_s"},
    {"torque_step_nm", "", "_nm"},
    {"speed_step_rad_s", "", "_rad_s"},
    {"2^-14 of the supply", "", ""},
    {"1/32767", "", ""},
}};

/// The number in SI units; it is counted in unit `index` of kReportUnits, or in none of them.
template <std::size_t index, class Number>
Number in_si(Number counted, [[maybe_unused]] const protocol::Identity& device) {
  if constexpr (index == 0) return Number{1e-9} * counted;
  if constexpr (index == 1) return Number{1e-3} * counted;
  if constexpr (index == 2) return counted * Number{device.torque_step_nm};
  if constexpr (index == 3) return counted * Number{device.speed_step_rad_s};
  if constexpr (index == 4) return counted * Number{0x1p-14};
  if constexpr (index == 5) return counted / Number{32767};
  return counted;
}

namespace conversion {

/// @throws InvalidArgument that names a field which does not go with the others
protocol::ActuatorConfig to_wire(const ActuatorConfig& config);
protocol::ShaftConfig to_wire(const ShaftConfig& config);

}  // namespace conversion

}  // namespace torsio
