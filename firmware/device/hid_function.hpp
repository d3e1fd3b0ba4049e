/// @file
/// The function behind a HID interface. Reports begin with their id.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace torsio::device {

class HidFunction {
 public:
  /// Writes the feature report `id`.
  /// @returns its size; 0 stalls the request
  virtual std::size_t get_feature(std::uint8_t id, std::span<std::uint8_t> report) = 0;

  /// Writes the input report `id` as things are, and leaves what next_input() has to tell.
  /// @returns its size; 0 stalls the request
  virtual std::size_t get_input(std::uint8_t id, std::span<std::uint8_t> report) = 0;

  /// Takes a feature report.
  /// @returns false to stall the request; nothing has changed then
  virtual bool set_feature(std::span<const std::uint8_t> report) = 0;

  /// Takes an output report.
  /// @returns false if there is no room now; it is offered again, and the host waits meanwhile
  virtual bool receive(std::span<const std::uint8_t> report) = 0;

  /// Writes the next input report.
  /// @returns its size; 0 if there is none
  virtual std::size_t next_input(std::span<std::uint8_t> report) = 0;

  /// The host has taken the last input report, or never will.
  virtual void input_over(bool /*taken*/) {}

 protected:
  ~HidFunction() = default;
};

}  // namespace torsio::device
