/// @file
/// From an effect as it travels to an effect as the tick wants it.
#pragma once

#include "core/effects.hpp"
#include "core/excitation.hpp"
#include "core/scene.hpp"
#include "protocol/effects.hpp"
#include "protocol/reports.hpp"
#include "protocol/status.hpp"

namespace torsio::device {

/// Prepares an effect whose fields are each in range.
/// @param in one of protocol::EffectReports
/// @returns inconsistent or out_of_range with the field, if the fields do not fit each other or
///          this encoder and rate; `effect` is then untouched
template <class EffectReport>
protocol::Verdict prepare(const EffectReport& in, const core::Resolution& r, core::Effect& effect);

core::LocalModel prepare(const protocol::LocalModel& in, const core::Resolution& r);
core::Excitation prepare(const protocol::Excitation& in, const core::Resolution& r);

}  // namespace torsio::device
