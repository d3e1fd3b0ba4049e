#include "config_encoding.hpp"

#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

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

/// A GPIO's number as far as it travels; what its job allows is checked with the other fields.
std::uint8_t pin(std::string_view name, int number) {
  return whole_number<std::uint8_t>(name, number, 0, 29);
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
  wire.knob_inertia_kg_m2 = narrow(config.knob_inertia_kg_m2);
  wire.knob_coulomb_nm = narrow(config.knob_coulomb_nm);
  wire.knob_viscous_nm_s_per_rad = narrow(config.knob_viscous_nm_s_per_rad);
  wire.motor_time_constant_s = narrow(config.motor_time_constant_s);
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

protocol::BoardConfig to_wire(const BoardConfig& config, device::WiringRule rule) {
  protocol::BoardConfig wire;
  wire.supply_v = narrow(config.supply_v);
  wire.motor_torque_constant_nm_per_a = narrow(config.motor_torque_constant_nm_per_a);
  wire.motor_current_max_a = narrow(config.motor_current_max_a);
  wire.motor_resistance_ohm = narrow(config.motor_resistance_ohm);
  wire.motor_inductance_h = narrow(config.motor_inductance_h);
  wire.current_bandwidth_hz = narrow(config.current_bandwidth_hz);
  wire.current_sense_v_per_a = narrow(config.current_sense_v_per_a);
  wire.brake_torque_constant_nm_per_a = narrow(config.brake_torque_constant_nm_per_a);
  wire.brake_current_max_a = narrow(config.brake_current_max_a);
  wire.brake_resistance_ohm = narrow(config.brake_resistance_ohm);
  wire.motor_reversed = to_wire(config.motor_reversed);
  wire.encoder_pin = pin("encoder_pin", config.encoder_pin);
  wire.motor_pin = pin("motor_pin", config.motor_pin);
  wire.brake_pin = pin("brake_pin", config.brake_pin);
  wire.enable_pin = pin("enable_pin", config.enable_pin);
  wire.emergency_stop_pin = pin("emergency_stop_pin", config.emergency_stop_pin);
  wire.driver_fault_pin = pin("driver_fault_pin", config.driver_fault_pin);
  wire.current_sense_pin = pin("current_sense_pin", config.current_sense_pin);
  wire.light_pin = pin("light_pin", config.light_pin);
  check_fields(wire);
  const auto conflict = rule != nullptr ? rule(wire) : std::nullopt;
  if (conflict) {
    throw InvalidArgument(
        std::string(protocol::field_name<protocol::BoardConfig>(conflict->field)) + " is " +
        std::to_string(conflict->pin) + ": " + std::string(conflict->reason));
  }
  return wire;
}

protocol::GameConfig to_wire(const GameConfig& config) {
  protocol::GameConfig wire;
  wire.enabled = to_wire(config.enabled);
  wire.range_deg = narrow(config.range_deg);
  wire.torque_max_nm = narrow(config.torque_max_nm);
  wire.gain = narrow(config.gain);
  wire.spring_gain = narrow(config.spring_gain);
  wire.speed_full_rad_s = narrow(config.speed_full_rad_s);
  wire.acceleration_full_rad_s2 = narrow(config.acceleration_full_rad_s2);
  wire.blend_s = narrow(config.blend_s);
  wire.silence_s = narrow(config.silence_s);
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
          .encoder_reversed = from_wire(wire.encoder_reversed),
          .knob_inertia_kg_m2 = widen(wire.knob_inertia_kg_m2),
          .knob_coulomb_nm = widen(wire.knob_coulomb_nm),
          .knob_viscous_nm_s_per_rad = widen(wire.knob_viscous_nm_s_per_rad),
          .motor_time_constant_s = widen(wire.motor_time_constant_s)};
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

BoardConfig from_wire(const protocol::BoardConfig& wire) {
  return {.supply_v = widen(wire.supply_v),
          .motor_torque_constant_nm_per_a = widen(wire.motor_torque_constant_nm_per_a),
          .motor_current_max_a = widen(wire.motor_current_max_a),
          .motor_resistance_ohm = widen(wire.motor_resistance_ohm),
          .motor_inductance_h = widen(wire.motor_inductance_h),
          .current_bandwidth_hz = widen(wire.current_bandwidth_hz),
          .current_sense_v_per_a = widen(wire.current_sense_v_per_a),
          .brake_torque_constant_nm_per_a = widen(wire.brake_torque_constant_nm_per_a),
          .brake_current_max_a = widen(wire.brake_current_max_a),
          .brake_resistance_ohm = widen(wire.brake_resistance_ohm),
          .motor_reversed = from_wire(wire.motor_reversed),
          .encoder_pin = wire.encoder_pin,
          .motor_pin = wire.motor_pin,
          .brake_pin = wire.brake_pin,
          .enable_pin = wire.enable_pin,
          .emergency_stop_pin = wire.emergency_stop_pin,
          .driver_fault_pin = wire.driver_fault_pin,
          .current_sense_pin = wire.current_sense_pin,
          .light_pin = wire.light_pin};
}

GameConfig from_wire(const protocol::GameConfig& wire) {
  return {.enabled = from_wire(wire.enabled),
          .range_deg = widen(wire.range_deg),
          .torque_max_nm = widen(wire.torque_max_nm),
          .gain = widen(wire.gain),
          .spring_gain = widen(wire.spring_gain),
          .speed_full_rad_s = widen(wire.speed_full_rad_s),
          .acceleration_full_rad_s2 = widen(wire.acceleration_full_rad_s2),
          .blend_s = widen(wire.blend_s),
          .silence_s = widen(wire.silence_s)};
}

}  // namespace torsio
