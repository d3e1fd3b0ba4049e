#include "emulator/replay.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <variant>

#include "device/prepare.hpp"
#include "emulator/plant/require.hpp"
#include "protocol/codec.hpp"
#include "protocol/registry.hpp"

namespace torsio::emulator {
namespace {

using torsio::ReplayRow;
using torsio::emulator::ClosedLoopOptions;
using torsio::emulator::EffectReport;

constexpr std::int64_t kShortestLoopNs = 1'000;
constexpr std::int64_t kLongestLoopNs = 1'000'000'000;

template <class Report>
[[noreturn]] void refuse(const protocol::Verdict& verdict) {
  throw std::invalid_argument(std::string(protocol::Layout<Report>::name) + ": " +
                              std::string(protocol::field_name<Report>(verdict.field)) +
                              " is outside what docs/reference/protocol.md allows");
}

template <class Report>
void require_valid(const Report& report) {
  protocol::Verdict verdict = protocol::check(report);
  if constexpr (requires { device::check_consistent(report); }) {
    if (verdict.ok()) verdict = device::check_consistent(report);
  }
  if (!verdict.ok()) refuse<Report>(verdict);
}

device::LoopConfig loop_config(const ClosedLoopOptions& options) {
  require_valid(options.actuator);
  require_valid(options.control);
  require_valid(options.shaft);
  device::Config config;
  config.actuator = options.actuator;
  config.control = options.control;
  config.shaft = options.shaft;
  return device::make_loop_config(config, static_cast<std::uint32_t>(options.control_period_ns));
}

}  // namespace

core::Scene make_scene(const ClosedLoopOptions& options, const core::Resolution& resolution) {
  require(options.scene.size() <= core::kMaxEffects, "the scene has more than 16 effects");
  require(options.curve_torque_nm.size() <= core::kCurvePoolPoints,
          "the curves have more than 1024 points");
  core::Scene scene;
  for (const EffectReport& effect : options.scene) {
    const std::uint8_t slot = scene.active;
    std::visit(
        [&]<class Report>(const Report& report) {
          require_valid(report);
          const protocol::Verdict verdict =
              device::prepare(report, resolution, scene.effect.at(slot));
          if (!verdict.ok()) refuse<Report>(verdict);
        },
        effect);
    scene.order.at(slot) = slot;
    ++scene.active;
  }
  std::ranges::copy(options.curve_torque_nm, scene.curve_torque_nm.begin());
  return scene;
}

ControlSetup make_control_setup(const ClosedLoopOptions& options) {
  const std::int64_t period_ns = options.control_period_ns;
  require(period_ns >= kShortestLoopNs && period_ns <= kLongestLoopNs,
          "control_period_ns must be within 1000 and 1000000000, is " + std::to_string(period_ns));
  const device::LoopConfig config = loop_config(options);
  return {config, make_scene(options, config.controller.motion.resolution)};
}

void replay(const ClosedLoopOptions& options, std::span<const std::uint32_t> counts,
            std::span<torsio::ReplayRow> rows) {
  require(counts.size() == rows.size(), "as many rows as counts");
  const ControlSetup setup = make_control_setup(options);
  core::ControllerState state;
  state.tick = options.first_tick;
  const core::ControllerParams& params = setup.config.controller;
  core::Plan plan = core::plan_of(params, state.bound, {&setup.scene});
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (plan.once) plan = core::plan_of(params, state.bound, {&setup.scene});
    const core::ControllerOutputs out = core::control(state, params, plan, counts[i]);
    rows[i] = {.position_counts = out.motion.position_counts,
               .speed_rad_s = out.motion.speed_rad_s,
               .desired_torque_nm = out.desired_torque_nm,
               .motor_command_nm = out.motor_command_nm,
               .brake_command_nm = out.brake_command_nm,
               .spring_torque_nm = out.spring_torque_nm,
               .numeric_error = out.numeric_error};
  }
}

}  // namespace torsio::emulator
