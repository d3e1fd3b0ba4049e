/// @file
/// The way to a device, for those who bring their own: across a network, through a recorder, from a
/// simulation.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <vector>

#include "torsio/export.hpp"

namespace torsio {

class Emulator;

/// A report as it travels: its id, its fields, zeros; docs/reference/protocol.md has them all.
using ReportBytes = std::array<std::uint8_t, 64>;

/// A report that travelled: one that was sent, or an acknowledgement or event that came.
struct LoggedReport {
  std::uint64_t tick = 0;  ///< control ticks of the newest thing that the device had said by then
  bool sent = false;       ///< by this end
  ReportBytes bytes{};     ///< as it travelled
};

/// Result of Knob::tap(). May be used from any thread.
class TORSIO_EXPORT ReportTap {
 public:
  ReportTap() = default;
  ReportTap(const ReportTap&) = delete;
  ReportTap& operator=(const ReportTap&) = delete;
  virtual ~ReportTap() = default;

  /// Takes what came since the last call, oldest first.
  [[nodiscard]] virtual std::vector<LoggedReport> take() = 0;
};

/// An open connection to one device. It moves whole reports, as USB HID does. Everything above
/// works the same over a cable, over the emulated device and over your own transport, which
/// Knob::open() takes. Open the connection before, in a constructor or a function; see
/// open_transport().
///
/// `read` and `advance_to` are called by one thread at a time. Any thread may call the others at
/// any time, also while another thread is in `read`. Every member but `read` must come back: to
/// close a knob waits for them.
///
/// A member that finds the device gone throws Disconnected. Anything else derived from
/// std::exception that comes out of `read` counts as Disconnected too, with its text.
class TORSIO_EXPORT Transport {
 public:
  Transport() = default;
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;
  virtual ~Transport() = default;

  /// Lets go of the device. Called once, when nobody is in `read` any more: a knob waits 5 s for
  /// that, and if need be its reading thread calls this later. What comes after it, or
  /// is under way in another thread, throws Closed. If no knob could be made of the transport it
  /// may be destroyed without this call.
  virtual void close() noexcept = 0;

  /// Sends an output report. May wait for its turn on the way, but not for an answer.
  /// @returns false if there is no room now: let a millisecond pass and try again
  /// @throws Disconnected
  [[nodiscard]] virtual bool write(const ReportBytes& report) = 0;

  /// Takes the next input report. Waits for it if time is real, but no longer than `timeout`, which
  /// is at most 20 ms; if time is virtual it does not wait.
  /// @returns false if none came in time
  /// @throws Disconnected, but not before everything that arrived has been read
  [[nodiscard]] virtual bool read(ReportBytes& report, std::chrono::nanoseconds timeout) = 0;

  /// Asks for the feature report `id`, and waits for it.
  /// @returns false if the device stalled the request
  /// @throws Disconnected
  [[nodiscard]] virtual bool get_feature(std::uint8_t id, ReportBytes& report) = 0;

  /// Sends a feature report, and waits until the device has taken it.
  /// @returns false if the device stalled the request
  /// @throws Disconnected
  [[nodiscard]] virtual bool set_feature(const ReportBytes& report) = 0;

  /// True if time passes only in advance_to(). The same answer always.
  [[nodiscard]] virtual bool time_is_virtual() const { return false; }

  /// The time in which time-outs count, since whenever.
  [[nodiscard]] virtual std::int64_t now_ns() const {
    using std::chrono::steady_clock;
    return std::chrono::nanoseconds(steady_clock::now().time_since_epoch()).count();
  }

  /// Virtual time only: lets time pass up to `time_ns`; nothing if that is past.
  virtual void advance_to(std::int64_t time_ns) { static_cast<void>(time_ns); }

  /// The world round an emulated device, which lives as long as the transport; null for others.
  [[nodiscard]] virtual Emulator* emulator() { return nullptr; }
};

}  // namespace torsio
