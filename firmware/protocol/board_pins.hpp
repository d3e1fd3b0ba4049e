/// @file
/// Which pins may have which job. Device and host ask the same question: the device to refuse, the
/// host to say why.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "protocol/configuration.hpp"
#include "protocol/registry.hpp"

namespace torsio::protocol {

struct PinConflict {
  std::uint8_t field = 0;  // of BoardConfig
  std::uint8_t pin = 0;    // its value
  std::string_view reason;
};

/// No pin has two jobs, what needs a hardware unit of its own gets one, and no pin is one that the
/// board uses itself.
constexpr std::optional<PinConflict> find_pin_conflict(const BoardConfig& config, Board board) {
  constexpr auto motor = field_index<BoardConfig>("motor_pin");
  constexpr auto brake = field_index<BoardConfig>("brake_pin");
  // The two inputs of a bridge are the two outputs of one PWM unit, of which there are eight.
  constexpr std::string_view odd = "a bridge's first pin must be even";
  const auto unit = [](std::uint8_t pin) { return (pin / 2) % 8; };
  if (config.motor_pin % 2 != 0) return PinConflict{motor, config.motor_pin, odd};
  if (config.brake_pin % 2 != 0) return PinConflict{brake, config.brake_pin, odd};
  if (unit(config.brake_pin) == unit(config.motor_pin)) {
    return PinConflict{brake, config.brake_pin, "the motor has this PWM unit; pins 16 apart share"};
  }
  struct Use {
    std::uint8_t first_pin;
    std::uint8_t pins;
    std::uint8_t field;
  };
  const std::array uses{
      Use{config.encoder_pin, 2, field_index<BoardConfig>("encoder_pin")},
      Use{config.motor_pin, 2, motor},
      Use{config.brake_pin, 2, brake},
      Use{config.enable_pin, 1, field_index<BoardConfig>("enable_pin")},
      Use{config.emergency_stop_pin, 1, field_index<BoardConfig>("emergency_stop_pin")},
      Use{config.driver_fault_pin, 1, field_index<BoardConfig>("driver_fault_pin")},
      Use{config.current_sense_pin, 1, field_index<BoardConfig>("current_sense_pin")},
      Use{config.light_pin, 1, field_index<BoardConfig>("light_pin")},
  };
  // Power supply mode and bus voltage.
  constexpr std::uint32_t everywhere = (1U << 23) | (1U << 24);
  // The RP2040's USB controller is helped out of a bus reset by way of this one (erratum E5).
  const std::uint32_t here = board == Board::pico ? 1U << 15 : 0;
  std::uint32_t taken = everywhere | here;
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

}  // namespace torsio::protocol
