/// @file
/// The conversation with one device: its parts, and how it ends.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "device_state.hpp"
#include "link.hpp"
#include "requests.hpp"
#include "sample_feed.hpp"

namespace torsio {

struct SessionOptions {
  std::int64_t command_timeout_ns = 1'000'000'000;
  std::size_t ring_samples = 65536;
  std::function<bool()> interrupted;
};

/// Each part may use those above it. Reports come in here, and go to the parts that they concern.
class Session : private Link::Receiver {
 public:
  Session(std::unique_ptr<Transport> transport, SessionOptions options);
  ~Session() override;  ///< as close()

  /// Disarms if `disarm_first` and the device is armed, and lets go of it. After the order it waits
  /// for the device, not long, and for an event's callback that runs. @returns false if the way did
  /// not take the order to disarm
  bool close(bool disarm_first) noexcept;
  /// The first of it: the torque off. Asks nobody, throws nothing.
  void disarm_quietly() noexcept;

  /// Units of what the device sends.
  void set_identity(const protocol::Identity& identity);
  [[nodiscard]] LinkStatistics statistics();

  Link link;
  DeviceState device;
  Requests requests;
  SampleFeed samples;

 private:
  bool take(const Link::Locked& locked, const protocol::ReportBytes& report) override;
  void lose(const Link::Locked& locked) override { device.lose(locked); }
  [[nodiscard]] bool is_armed(const Link::Locked& locked) const override {
    return device.is_armed(locked);
  }
  void tell() override { device.events.tell(); }
  void hear(const Link::Locked& locked, const protocol::Telemetry& report) {
    samples.take(locked, report);
  }
  void hear(const Link::Locked& locked, const protocol::Acknowledgement& answer);
  void hear(const Link::Locked& locked, const protocol::Event& event);

  std::atomic<bool> closing_{false};  // somebody does
  std::atomic<bool> untold_{false};   // armed, and the way did not take the order to disarm
};

}  // namespace torsio
