#include "conversion/configuration.hpp"

#include <array>
#include <cstddef>
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
  const std::array knees_rad{wire.knee_1_rad, wire.knee_2_rad, wire.knee_3_rad, wire.knee_4_rad};
  const std::array stiffnesses{wire.knee_1_nm_per_rad, wire.knee_2_nm_per_rad,
                               wire.knee_3_nm_per_rad, wire.knee_4_nm_per_rad};
  for (std::size_t i = 0; i < knees_rad.size(); ++i) {
    if (knees_rad[i] == 0.0F) continue;
    const std::string knee = "knee_" + std::to_string(i + 1);
    if (i > 0 && knees_rad[i] <= knees_rad[i - 1]) {
      throw InvalidArgument(knee + "_rad is " + number_text(knees_rad[i]) +
                            ", not beyond the knee before it, which is at " +
                            number_text(knees_rad[i - 1]));
    }
    if (i > 0 && knees_rad[i - 1] == 0.0F) {
      throw InvalidArgument(knee + "_rad is " + number_text(knees_rad[i]) +
                            ", but there is no knee before it: give knee_" + std::to_string(i) +
                            "_rad first");
    }
    if (stiffnesses[i] == 0.0F) {
      throw InvalidArgument(knee + "_nm_per_rad is 0: the torque must grow beyond a knee");
    }
  }
  return wire;
}

}  // namespace torsio::conversion
