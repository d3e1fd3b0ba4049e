/// @file
/// A transport moves whole reports, and nothing else. Everything above works the same over a cable,
/// over the emulated device and over the fakes of the tests.
#pragma once

#include <chrono>
#include <cstdint>

#include "protocol/codec.hpp"

namespace torsio {

/// An open connection to one device. `read` and `advance_to` belong to one thread at a time; the
/// other members may be called from any thread at any time.
class Transport {
 public:
  Transport() = default;
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;
  virtual ~Transport() = default;

  /// Lets go of the device. Called once, when nobody is in `read` any more; what comes after it
  /// throws Closed.
  virtual void close() noexcept = 0;

  /// Sends an output report.
  /// @returns false if there is no room now: let a frame pass and try again
  /// @throws Disconnected
  [[nodiscard]] virtual bool write(const protocol::ReportBytes& report) = 0;

  /// Takes the next input report, and waits for it if time is real.
  /// @returns false if none came in time
  /// @throws Disconnected, but not before everything that arrived has been read
  [[nodiscard]] virtual bool read(protocol::ReportBytes& report,
                                  std::chrono::nanoseconds timeout) = 0;

  /// @returns false if the device stalled the request
  /// @throws Disconnected
  [[nodiscard]] virtual bool get_feature(std::uint8_t id, protocol::ReportBytes& report) = 0;
  [[nodiscard]] virtual bool set_feature(const protocol::ReportBytes& report) = 0;

  /// True if time passes only in advance_to().
  [[nodiscard]] virtual bool time_is_virtual() const { return false; }

  /// The time in which time-outs count.
  [[nodiscard]] virtual std::int64_t now_ns() const {
    using std::chrono::steady_clock;
    return std::chrono::nanoseconds(steady_clock::now().time_since_epoch()).count();
  }

  /// Virtual time only: lets time pass up to `time_ns`.
  virtual void advance_to(std::int64_t time_ns) { static_cast<void>(time_ns); }
};

}  // namespace torsio
