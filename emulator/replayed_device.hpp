/// @file
/// The firmware's device without a plant: it is given the inputs that another one had, and says
/// what it does then.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "device/config_store.hpp"
#include "device/device.hpp"
#include "protocol/codec.hpp"
#include "torsio/plant.hpp"

namespace torsio::emulator {

/// On the same sources the same inputs give the same outputs, to the bit. A device that ran in
/// other circumstances also had a host that was slow to fetch reports; this one's fetches at every
/// tick.
class ReplayedDevice {
 public:
  struct Output {
    std::uint64_t tick;  ///< control ticks that had run when it was fetched
    protocol::ReportBytes report;
  };

  /// Without power.
  explicit ReplayedDevice(const device::BoardInfo& board) : board_(board) {}

  /// Gives the device the next input. Without power the device ignores it.
  /// @throws std::invalid_argument if these bytes are no input of this kind
  void take(InputKind kind, std::span<const std::uint8_t> bytes);

  /// @returns not ok: the device stalled the request, or has no power
  [[nodiscard]] protocol::Status get_feature(std::uint8_t id, protocol::ReportBytes& report);

  /// Input reports that the device has sent since the last call.
  [[nodiscard]] std::vector<Output> take_outputs();

  /// Control ticks that have run.
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }

 private:
  bool take_report(InputKind kind, std::span<const std::uint8_t> bytes);
  bool take_signal(InputKind kind, std::span<const std::uint8_t> bytes);
  bool take_surrounding(InputKind kind, std::span<const std::uint8_t> bytes);
  void set_powered(bool powered);
  bool settle();
  void tick(std::uint32_t count);

  device::BoardInfo board_;
  device::StoredSlots stored_ = device::empty_slots();
  std::unique_ptr<device::Device> device_;
  device::TickInputs inputs_{};
  bool connected_ = true;
  std::optional<std::size_t> power_cut_bytes_;
  std::uint64_t ticks_ = 0;
  std::vector<Output> outputs_;
};

}  // namespace torsio::emulator
