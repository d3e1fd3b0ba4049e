#include "emulator/closed_loop.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "device/prepare.hpp"
#include "emulator/plain_bytes.hpp"
#include "emulator/plant/require.hpp"
#include "emulator/truth.hpp"
#include "protocol/effects.hpp"

namespace torsio::emulator {
namespace {

constexpr std::uint32_t kMostDelayTicks = 1000;

}  // namespace

ClosedLoop::ClosedLoop(const ClosedLoopOptions& options)
    : period_ns_(options.control_period_ns),
      setup_(std::make_shared<const ControlSetup>(make_control_setup(options))),
      effects_(options.scene),
      power_(make_power_path(options.plant, options.control_period_ns, options.sensor_seed)),
      plant_(options.plant, options.hand,
             power_ ? power_->step_ns() : std::min(options.step_ns, options.control_period_ns),
             options.make_stepper),
      encoder_(options.encoder) {
  require(options.delay_ticks <= kMostDelayTicks,
          "delay_ticks must be at most 1000, is " + std::to_string(options.delay_ticks));
  late_.resize(options.delay_ticks);
  if (power_) {
    power_->power_up(options.board.value_or(matching_board(*options.plant.electrics)),
                     options.actuator.brake_time_constant_s);
    power_->rest(plant_);
  }
  controller_.tick = options.first_tick;
  if (options.initial) plant_.set_state(*options.initial);
  if (options.spin_up) spin_up(*options.spin_up);
}

void ClosedLoop::run(std::uint64_t ticks, std::span<LoopRow> rows, std::uint32_t every) {
  require(every > 0, "every must be > 0");
  std::uint32_t until_row = 0;
  std::size_t filled = 0;
  for (std::uint64_t i = 0; i < ticks; ++i) {
    LoopRow* row = nullptr;
    if (until_row == 0 && filled < rows.size()) row = &rows[filled++];
    until_row = until_row == 0 ? every - 1 : until_row - 1;
    sense(row);
    act();
  }
}

void ClosedLoop::spin_up(const SpinUp& spin_up) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  require(positive(std::abs(spin_up.motor_command_nm)),
          "spin_up: motor_command_nm must be finite and not 0");
  require(positive(spin_up.speed_rad_s), "spin_up: speed_rad_s must be finite and > 0");
  require(positive(spin_up.longest_s), "spin_up: longest_s must be finite and > 0");
  const double direction = spin_up.motor_command_nm > 0.0 ? 1.0 : -1.0;
  const double end_ns = 1e9 * spin_up.longest_s + static_cast<double>(plant_.state().time_ns);
  hold_command({.motor_command_nm = spin_up.motor_command_nm});
  while (direction * plant_.state().knob_speed_rad_s() < spin_up.speed_rad_s) {
    if (static_cast<double>(plant_.state().time_ns) > end_ns) {
      throw std::runtime_error("spin_up: the knob does not reach " +
                               std::to_string(spin_up.speed_rad_s) + " rad/s within " +
                               std::to_string(spin_up.longest_s) + " s");
    }
    sense(nullptr);
    act();
  }
  release_command();

  // Here and now become 0, for the plant and for the device, which samples here at the next tick.
  const std::uint32_t here = encoder_.sample(plant_.state().knob_angle);
  PlantState state = plant_.state();
  state.knob_angle = {};
  state.time_ns = 0;
  plant_.set_state(state);
  const core::MotionParams& params = setup_->config.controller.motion;
  core::MotionState& motion = controller_.motion;
  const std::uint32_t shift = (here - encoder_.sample(state.knob_angle)) << params.counter_shift;
  const std::uint32_t moved = (here << params.counter_shift) - motion.last_count;
  const std::int32_t delta = static_cast<std::int32_t>(moved) >> params.counter_shift;
  motion.last_count -= shift;
  motion.position_counts = params.reversed ? delta : -delta;
}

void ClosedLoop::hold_command(const Command& command) {
  // Neither is true of NaN.
  require(std::abs(command.motor_command_nm) <= protocol::max_torque_nm,
          "motor_command_nm must be within -100 and 100, is " +
              std::to_string(command.motor_command_nm));
  require(command.brake_command_nm >= 0.0 && command.brake_command_nm <= protocol::max_torque_nm,
          "brake_command_nm must be 0 to 100, is " + std::to_string(command.brake_command_nm));
  held_ = command;
}

void ClosedLoop::set_scene(const ClosedLoopOptions& options) {
  const device::LoopConfig& config = setup_->config;
  core::Scene scene = make_scene(options, config.controller.motion.resolution);
  const auto bytes = [](const EffectReport& effect) {
    return std::visit([](const auto& report) { return protocol::encode(report); }, effect);
  };
  std::uint16_t fresh = 0;
  for (std::size_t slot = 0; slot < options.scene.size(); ++slot) {
    const bool same = slot < effects_.size() && bytes(options.scene[slot]) == bytes(effects_[slot]);
    if (!same) fresh |= static_cast<std::uint16_t>(1U << slot);
  }
  setup_ = std::make_shared<const ControlSetup>(config, scene);
  effects_ = options.scene;
  controller_.bound.new_scene = true;
  core::restart_effects(controller_.scene, fresh, controller_.tick);
}

void ClosedLoop::stream(const protocol::LocalModel& model) {
  const core::ControllerParams& params = setup_->config.controller;
  const core::LocalModel next = device::prepare(model, params.motion.resolution);
  core::change_local_model(controller_, params, local_ ? &*local_ : nullptr, &next);
  local_ = next;
}

void ClosedLoop::sense(LoopRow* row) {
  const core::ControllerParams& params = setup_->config.controller;
  const core::Play play{&setup_->scene, local_ ? &*local_ : nullptr};
  const core::Plan plan =
      held_ ? core::idle_plan(params) : core::plan_of(params, controller_.bound, play);
  const std::uint32_t count = encoder_.sample(plant_.state().knob_angle);
  const core::ControllerOutputs out = core::control(controller_, params, plan, count);
  decided_ = {.motor_command_nm = static_cast<double>(out.motor_command_nm),
              .brake_command_nm = static_cast<double>(out.brake_command_nm)};
  if (row != nullptr) {
    const Command& command = held_ ? *held_ : decided_;
    tell_truth(plant_, *row);
    row->position_counts = out.motion.position_counts;
    row->estimated_speed_rad_s = out.motion.speed_rad_s;
    row->desired_torque_nm =
        plan.bounds ? core::asked_torque(controller_, plan) : out.desired_torque_nm;
    row->motor_command_nm = static_cast<float>(command.motor_command_nm);
    row->brake_command_nm = static_cast<float>(command.brake_command_nm);
    row->sensed_spring_torque_nm = out.spring_torque_nm;
    row->sensed_brake_capacity_nm = out.brake_capacity_nm;
    row->motor_saturated = out.motor_saturated;
    row->brake_saturated = out.brake_saturated;
    row->numeric_error = out.numeric_error;
  }
}

void ClosedLoop::act() {
  if (held_) {
    decided_ = *held_;
    controller_.slew.motor_command_nm = static_cast<float>(decided_.motor_command_nm);
    controller_.brake_command_nm = static_cast<float>(decided_.brake_command_nm);
  }
  follow(decided_);
}

void ClosedLoop::set_seed(std::uint64_t seed) {
  EncoderParams params = encoder_.params();
  params.seed = seed;
  encoder_ = Encoder(params);
}

void ClosedLoop::save(std::vector<std::uint8_t>& into) const {
  const Memory memory{controller_, plant_.memory(), encoder_, held_, decided_, next_late_};
  add_bytes(into, std::span(&memory, 1));
  add_bytes(into, std::span(late_));
}

std::span<const std::uint8_t> ClosedLoop::restore(std::span<const std::uint8_t> from) {
  Memory memory{controller_, plant_.memory(), encoder_, held_, decided_, next_late_};
  from = take_bytes(from, std::span(&memory, 1));
  controller_ = memory.controller;
  plant_.set_memory(memory.plant);
  encoder_ = memory.encoder;
  held_ = memory.held;
  decided_ = memory.decided;
  next_late_ = memory.next_late;
  return take_bytes(from, std::span(late_));
}

void ClosedLoop::take(const Command& command) {
  if (power_) {
    power_->run(plant_, {.motor_command_nm = static_cast<float>(command.motor_command_nm),
                         .brake_command_nm = static_cast<float>(command.brake_command_nm),
                         .enabled = true});
    return;
  }
  plant_.set_command(command);
  plant_.advance(period_ns_);
}

void ClosedLoop::follow(const Command& command) {
  if (late_.empty()) {
    take(command);
    return;
  }
  take(late_[next_late_]);
  late_[next_late_] = command;
  next_late_ = next_late_ + 1 == late_.size() ? 0 : next_late_ + 1;
}

}  // namespace torsio::emulator
