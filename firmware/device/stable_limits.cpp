#include "device/stable_limits.hpp"

#include "core/math.hpp"

namespace torsio::device {
namespace {

constexpr float kPi = 0.5F * core::kTwoPi;

}  // namespace

StableLimits make_stable_limits(const Config& config, float period_s) {
  const protocol::ActuatorConfig& actuator = config.actuator;
  const float torque_nm = core::larger(game_torque_max_nm(config), 1e-6F);
  // Half a period of hold, one period until the power stage has the command, and the motor.
  const float delay_s = 1.5F * period_s + actuator.motor_time_constant_s;
  const float inertia = actuator.knob_inertia_kg_m2;
  const float count_rad = core::kTwoPi / static_cast<float>(actuator.counts_per_rev);
  // Dry friction takes 4 f / (pi a) from an oscillation of amplitude a, for a torque of k a that
  // does not exceed the cap.
  const float dry = (4.0F / kPi) * actuator.knob_coulomb_nm * core::square_root(inertia) / delay_s;
  const float held = dry / torque_nm;
  const float root =
      0.5F *
      (held + core::square_root(held * held + 4.0F * actuator.knob_viscous_nm_s_per_rad / delay_s));

  StableLimits most;
  most.quantised = 2.0F * actuator.knob_coulomb_nm / count_rad;
  most.stiffness = core::smaller(root * root, most.quantised);
  const float filter_s = 2.0F / (core::kTwoPi * config.control.speed_bandwidth_hz);
  most.damping = 0.25F * kPi * inertia / (filter_s + delay_s);
  most.inertia = 0.5F * inertia;
  most.bristle = dry * dry;
  return most;
}

float bristle_nm_per_rad(const StableLimits& limits, float held_nm) {
  return core::smaller(limits.bristle / (held_nm * held_nm), limits.quantised);
}

float game_torque_max_nm(const Config& config) {
  const float share = static_cast<float>(config.game.torque_max_percent) * 0.01F;
  return core::smaller(config.game.torque_max_nm, share * motor_max_nm(config));
}

}  // namespace torsio::device
