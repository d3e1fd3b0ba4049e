/// @file
/// From an effect as it travels to an effect as the tick wants it.
#pragma once

#include "core/effects.hpp"
#include "core/scene.hpp"
#include "protocol/effects.hpp"
#include "protocol/reports.hpp"
#include "protocol/status.hpp"

namespace torsio::device {

/// Prepares an effect whose fields are each in range.
/// @returns inconsistent or out_of_range with the field, if the fields do not fit each other or
/// this
///          encoder and rate; `effect` is then untouched
protocol::Verdict prepare(const protocol::Wall& in, const core::Resolution& r,
                          core::Effect& effect);
protocol::Verdict prepare(const protocol::Spring& in, const core::Resolution& r,
                          core::Effect& effect);
protocol::Verdict prepare(const protocol::Damper& in, const core::Resolution& r,
                          core::Effect& effect);
protocol::Verdict prepare(const protocol::Friction& in, const core::Resolution& r,
                          core::Effect& effect);
protocol::Verdict prepare(const protocol::Inertia& in, const core::Resolution& r,
                          core::Effect& effect);
protocol::Verdict prepare(const protocol::Constant& in, const core::Resolution& r,
                          core::Effect& effect);
protocol::Verdict prepare(const protocol::Ramp& in, const core::Resolution& r,
                          core::Effect& effect);
protocol::Verdict prepare(const protocol::Periodic& in, const core::Resolution& r,
                          core::Effect& effect);
protocol::Verdict prepare(const protocol::Detents& in, const core::Resolution& r,
                          core::Effect& effect);
protocol::Verdict prepare(const protocol::EndStops& in, const core::Resolution& r,
                          core::Effect& effect);
protocol::Verdict prepare(const protocol::Texture& in, const core::Resolution& r,
                          core::Effect& effect);
protocol::Verdict prepare(const protocol::Curve& in, const core::Resolution& r,
                          core::Effect& effect);

core::LocalModel prepare(const protocol::LocalModel& in, const core::Resolution& r);

}  // namespace torsio::device
