/// @file
/// Jobs of pins on the RP2040 and the RP2350. Device and host ask the same question: the device to
/// refuse, the host to say why.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "device/wiring.hpp"
#include "protocol/configuration.hpp"
#include "protocol/registry.hpp"

namespace torsio::boards::rp2 {

/// Pins that boards of the Pico's layout use themselves, bit n for GPn: the power supply's mode and
/// the bus voltage.
inline constexpr std::uint32_t kPicoPins = (1U << 23) | (1U << 24);

inline constexpr std::uint8_t kFirstAdcPin = 26;

/// No pin has two jobs. A job that needs its own hardware unit gets one. No pin is one that the
/// board uses itself.
/// @param index_pin of the encoder's index; 0: it has none
/// @param taken     pins that the board uses itself, bit n for GPn
constexpr std::optional<device::PinConflict> find_pin_conflict(const protocol::BoardConfig& config,
                                                               std::uint8_t index_pin,
                                                               std::uint32_t taken) {
  using device::PinConflict;
  using protocol::BoardConfig;
  using protocol::field_index;
  constexpr auto motor = field_index<BoardConfig>("motor_pin");
  constexpr auto brake = field_index<BoardConfig>("brake_pin");
  // The two inputs of a bridge are the two outputs of one of the eight PWM units.
  constexpr std::string_view odd = "a bridge's first pin must be even";
  const auto unit = [](std::uint8_t pin) { return (pin / 2) % 8; };
  if (config.motor_pin % 2 != 0) return PinConflict{motor, config.motor_pin, odd};
  if (config.brake_pin % 2 != 0) return PinConflict{brake, config.brake_pin, odd};
  if (unit(config.brake_pin) == unit(config.motor_pin)) {
    return PinConflict{brake, config.brake_pin, "the motor has this PWM unit; pins 16 apart share"};
  }
  constexpr auto supply = field_index<BoardConfig>("supply_sense_pin");
  const bool watches_supply = config.supply_sense_pin != 0;
  if (watches_supply && config.supply_sense_pin < kFirstAdcPin) {
    return PinConflict{supply, config.supply_sense_pin, "only GP26, GP27 and GP28 can measure"};
  }
  if (watches_supply && 1.25F * config.supply_v > 3.3F * config.supply_sense_ratio) {
    return PinConflict{field_index<BoardConfig>("supply_sense_ratio"), config.supply_sense_ratio,
                       "a quarter more than supply_v must be below 3.3 V at the pin"};
  }
  struct Use {
    std::uint8_t first_pin;
    std::uint8_t pins;
    std::uint8_t field;
  };
  const std::array uses{
      Use{index_pin, std::uint8_t{index_pin != 0}, protocol::kNoField},
      Use{config.encoder_pin, 2, field_index<BoardConfig>("encoder_pin")},
      Use{config.motor_pin, 2, motor},
      Use{config.brake_pin, 2, brake},
      Use{config.enable_pin, 1, field_index<BoardConfig>("enable_pin")},
      Use{config.emergency_stop_pin, 1, field_index<BoardConfig>("emergency_stop_pin")},
      Use{config.driver_fault_pin, 1, field_index<BoardConfig>("driver_fault_pin")},
      Use{config.current_sense_pin, 1, field_index<BoardConfig>("current_sense_pin")},
      Use{config.supply_sense_pin, std::uint8_t{watches_supply}, supply},
      Use{config.light_pin, 1, field_index<BoardConfig>("light_pin")},
  };
  for (const Use& use : uses) {
    const std::uint32_t pins = ((1U << use.pins) - 1) << use.first_pin;
    if ((taken & pins) != 0) {
      const bool first = (taken >> use.first_pin & 1U) != 0;
      return PinConflict{use.field, use.first_pin,
                         first ? "this pin has another job" : "the next pin has another job"};
    }
    taken |= pins;
  }
  return {};
}

}  // namespace torsio::boards::rp2
