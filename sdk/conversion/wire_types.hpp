/// @file
/// Which structure of the protocol carries which of the user's.
///
/// Printed from the field lists in firmware/protocol/definition/ by `./dev generate`; change those
/// instead.
#pragma once

#include "protocol/configuration.hpp"
#include "protocol/effects.hpp"
#include "protocol/reports.hpp"
#include "torsio/config.hpp"
#include "torsio/scene.hpp"

namespace torsio {

/// `type` is what travels for a user's structure.
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

}  // namespace torsio
