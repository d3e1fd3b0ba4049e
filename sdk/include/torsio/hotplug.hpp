/// @file
/// Notices of knobs that are plugged in or pulled out.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "torsio/export.hpp"
#include "torsio/knob.hpp"

namespace torsio {

/// A knob was plugged in or pulled out.
struct DeviceEvent {
  /// Kind of the event.
  enum class Kind : std::uint8_t { arrived, departed };

  Kind kind;  ///< what happened
  /// As list_devices() has it, but without `board`: a watch never opens the device, so you can.
  ListedDevice device;
};

/// Options of a watch.
struct WatchOptions {
  /// Report the knobs that are there already as arrivals, first of all.
  bool include_present = true;
  /// How long a knob that may not be opened yet is held back. udev sets the permission a moment
  /// after the device appears; past this time it is reported with its `problem`. 0 to 60.
  double permission_timeout_s = 2.0;
};

/// Watches for knobs to arrive and depart, from its construction until stop().
///
/// On Linux the kernel's notices about `/dev` wake it: it costs nothing while nothing happens, and
/// needs no privileges. Where there are none (another system, no inotify left, a hidapi backend
/// whose devices are no files) it looks twice a second. A knob that was reported with a `problem`
/// is reported as arrived once more when it can be opened. It does not tell of emulated
/// knobs.
///
/// Every member may be called from any thread.
class TORSIO_EXPORT DeviceWatch {
 public:
  /// Gets one event after the other.
  using Callback = std::function<void(const DeviceEvent&)>;

  /// Keeps the events for next().
  /// @throws InvalidArgument if the time is out of range; Error if the system gives no thread or
  ///         no descriptor
  explicit DeviceWatch(const WatchOptions& options = {});

  /// Calls back from a thread of the watch, one event after the other, without a lock. The callback
  /// may open knobs and call stop(). Its exception ends the watch, and stop() throws it.
  explicit DeviceWatch(Callback callback, const WatchOptions& options = {});

  ~DeviceWatch();  ///< as stop(), but throws nothing; not from the callback
  DeviceWatch(const DeviceWatch&) = delete;
  DeviceWatch& operator=(const DeviceWatch&) = delete;

  /// Takes the oldest event, and waits for one if there is none. Nothing comes here if there is a
  /// callback.
  /// @returns nothing if the time is over, or the watch was stopped and all events are taken
  /// @throws InvalidArgument if `timeout_s` is negative or no number; Error if looking for devices
  ///         failed
  [[nodiscard]] std::optional<DeviceEvent> next(double timeout_s);

  /// Ends the watch. When it returns no callback runs any more, except when it is called from the
  /// callback. May be called twice. @throws what the callback threw, once
  void stop();
  [[nodiscard]] bool is_stopped() const;  ///< also true once an error has ended it

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace torsio
