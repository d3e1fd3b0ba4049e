#include "conversion/configuration.hpp"

#include <optional>
#include <string>

#include "torsio/error.hpp"

namespace torsio::conversion {

protocol::ActuatorConfig to_wire(const ActuatorConfig& config) {
  const protocol::ActuatorConfig wire = convert(config);
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

protocol::ControlConfig to_wire(const ControlConfig& config) { return convert(config); }

protocol::BoardConfig to_wire(const BoardConfig& config, device::WiringRule rule) {
  const protocol::BoardConfig wire = convert(config);
  const auto conflict = rule != nullptr ? rule(wire) : std::nullopt;
  if (conflict) {
    throw InvalidArgument(
        std::string(protocol::field_name<protocol::BoardConfig>(conflict->field)) + " is " +
        std::to_string(conflict->pin) + ": " + std::string(conflict->reason));
  }
  return wire;
}

protocol::GameConfig to_wire(const GameConfig& config) { return convert(config); }

}  // namespace torsio::conversion
