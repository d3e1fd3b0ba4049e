#include "config_encoding.hpp"

#include <array>
#include <charconv>
#include <cstdint>
#include <string>

#include "field_check.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

static_assert(static_cast<int>(Law::motor_only) == static_cast<int>(protocol::Law::motor_only));

protocol::Toggle to_wire(bool on) { return on ? protocol::Toggle::on : protocol::Toggle::off; }
bool from_wire(protocol::Toggle toggle) { return toggle == protocol::Toggle::on; }

/// The double that a person would write for this float: 0.1F comes back as 0.1.
double widen(float value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  double shortest = 0.0;
  std::from_chars(text.data(), end, shortest);
  return shortest;
}

}  // namespace

protocol::ActuatorConfig to_wire(const ActuatorConfig& config) {
  protocol::ActuatorConfig wire;
  wire.motor_torque_max_nm = narrow(config.motor_torque_max_nm);
  wire.brake_torque_max_nm = narrow(config.brake_torque_max_nm);
  wire.brake_torque_min_nm = narrow(config.brake_torque_min_nm);
  wire.brake_drag_nm = narrow(config.brake_drag_nm);
  wire.brake_time_constant_s = narrow(config.brake_time_constant_s);
  wire.spring_stiffness_nm_per_rad = narrow(config.spring_stiffness_nm_per_rad);
  wire.counts_per_rev = config.counts_per_rev;
  wire.counter_bits = whole_number<std::uint8_t>("counter_bits", config.counter_bits, 8, 32);
  wire.encoder_reversed = to_wire(config.encoder_reversed);
  check_fields(wire);
  if (wire.brake_torque_min_nm > wire.brake_torque_max_nm) {
    throw InvalidArgument("brake_torque_min_nm is " + number_text(config.brake_torque_min_nm) +
                          ", above brake_torque_max_nm, which is " +
                          number_text(config.brake_torque_max_nm));
  }
  if (wire.counter_bits < 32 && wire.counts_per_rev / 2 >= 1U << (wire.counter_bits - 1)) {
    throw InvalidArgument("counter_bits is " + std::to_string(config.counter_bits) +
                          ", too few for counts_per_rev, which is " +
                          std::to_string(config.counts_per_rev) +
                          ": the counter must not wrap within half a turn");
  }
  return wire;
}

protocol::ControlConfig to_wire(const ControlConfig& config) {
  protocol::ControlConfig wire;
  wire.law = static_cast<protocol::Law>(config.law);
  wire.beta = narrow(config.beta);
  wire.speed_bandwidth_hz = narrow(config.speed_bandwidth_hz);
  wire.motor_torque_cap_nm = narrow(config.motor_torque_cap_nm);
  wire.brake_torque_cap_nm = narrow(config.brake_torque_cap_nm);
  wire.motor_slew_nm_per_s = narrow(config.motor_slew_nm_per_s);
  wire.speed_limit_rad_s = narrow(config.speed_limit_rad_s);
  wire.watchdog_s = narrow(config.watchdog_s);
  wire.passive_ramp_s = narrow(config.passive_ramp_s);
  wire.passive_brake_nm = narrow(config.passive_brake_nm);
  wire.autonomous = to_wire(config.autonomous);
  check_fields(wire);
  return wire;
}

ActuatorConfig from_wire(const protocol::ActuatorConfig& wire) {
  return {.motor_torque_max_nm = widen(wire.motor_torque_max_nm),
          .brake_torque_max_nm = widen(wire.brake_torque_max_nm),
          .brake_torque_min_nm = widen(wire.brake_torque_min_nm),
          .brake_drag_nm = widen(wire.brake_drag_nm),
          .brake_time_constant_s = widen(wire.brake_time_constant_s),
          .spring_stiffness_nm_per_rad = widen(wire.spring_stiffness_nm_per_rad),
          .counts_per_rev = wire.counts_per_rev,
          .counter_bits = wire.counter_bits,
          .encoder_reversed = from_wire(wire.encoder_reversed)};
}

ControlConfig from_wire(const protocol::ControlConfig& wire) {
  return {.law = static_cast<Law>(wire.law),
          .beta = widen(wire.beta),
          .speed_bandwidth_hz = widen(wire.speed_bandwidth_hz),
          .motor_torque_cap_nm = widen(wire.motor_torque_cap_nm),
          .brake_torque_cap_nm = widen(wire.brake_torque_cap_nm),
          .motor_slew_nm_per_s = widen(wire.motor_slew_nm_per_s),
          .speed_limit_rad_s = widen(wire.speed_limit_rad_s),
          .watchdog_s = widen(wire.watchdog_s),
          .passive_ramp_s = widen(wire.passive_ramp_s),
          .passive_brake_nm = widen(wire.passive_brake_nm),
          .autonomous = from_wire(wire.autonomous)};
}

}  // namespace torsio
