#include "conversion/configuration.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "device/config_rules.hpp"
#include "torsio/error.hpp"

namespace torsio::conversion {

protocol::ActuatorConfig to_wire(const ActuatorConfig& config) {
  const protocol::ActuatorConfig wire = convert(config);
  const protocol::Verdict verdict = device::check_consistent(wire);
  if (verdict.ok()) return wire;
  if (verdict.field == protocol::field_index<protocol::ActuatorConfig>("counter_bits")) {
    throw InvalidArgument("counter_bits is " + std::to_string(config.counter_bits) +
                          ", too few for counts_per_rev, which is " +
                          std::to_string(config.counts_per_rev) +
                          ": the counter must not wrap within half a turn");
  }
  throw InvalidArgument("brake_torque_min_nm is " + number_text(config.brake_torque_min_nm) +
                        ", above brake_torque_max_nm, which is " +
                        number_text(config.brake_torque_max_nm));
}

protocol::ActuatorConfig to_wire(const ActuatorConfig& config, device::WiringRule rule,
                                 const protocol::BoardConfig& board) {
  const protocol::ActuatorConfig wire = to_wire(config);
  if (rule != nullptr && rule(board, wire.encoder_index_pin)) {
    throw InvalidArgument("encoder_index_pin is " + std::to_string(config.encoder_index_pin) +
                          ": this pin has another job");
  }
  return wire;
}

protocol::BoardConfig to_wire(const BoardConfig& config, device::WiringRule rule,
                              std::uint8_t index_pin) {
  const protocol::BoardConfig wire = convert(config);
  const auto conflict = rule != nullptr ? rule(wire, index_pin) : std::nullopt;
  if (conflict) {
    throw InvalidArgument(
        std::string(protocol::field_name<protocol::BoardConfig>(conflict->field)) + " is " +
        std::to_string(conflict->pin) + ": " + std::string(conflict->reason));
  }
  return wire;
}

protocol::ShaftConfig to_wire(const ShaftConfig& config) {
  const protocol::ShaftConfig wire = convert(config);
  const protocol::Verdict verdict = device::check_consistent(wire);
  if (verdict.ok()) return wire;
  const std::string field(protocol::field_name<protocol::ShaftConfig>(verdict.field));
  if (field.ends_with("_nm_per_rad")) {
    throw InvalidArgument(field + " is 0: the torque must grow beyond a knee");
  }
  // A twist is refused for the knee before it.
  const std::array knees_rad{wire.knee_1_rad, wire.knee_2_rad, wire.knee_3_rad, wire.knee_4_rad};
  const std::size_t before =
      (verdict.field - protocol::field_index<protocol::ShaftConfig>("knee_2_rad")) / 2U;
  const std::string is = field + " is " + number_text(knees_rad[before + 1]);
  if (knees_rad[before] == 0.0F) {
    throw InvalidArgument(is + ", but there is no knee before it: give knee_" +
                          std::to_string(before + 1) + "_rad first");
  }
  throw InvalidArgument(is + ", not beyond the knee before it, which is at " +
                        number_text(knees_rad[before]));
}

}  // namespace torsio::conversion
