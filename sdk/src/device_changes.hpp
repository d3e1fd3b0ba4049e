/// @file
/// Changes between two looks at the devices.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "torsio/hotplug.hpp"

namespace torsio {

/// Turns lists of devices into arrivals and departures. It has no clock; the caller gives the time.
class DeviceChanges {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit DeviceChanges(std::chrono::nanoseconds patience) : patience_(patience) {}

  /// Takes a list of all devices that are there at `now`.
  /// @returns departures, then arrivals. A device with a `problem` arrives when that is solved, or
  ///          after `patience`, and then again when it is solved
  std::vector<DeviceEvent> update(const std::vector<ListedDevice>& present, Time now);

  /// The device at a path was seen to go, and maybe another one came into its place.
  /// @returns its departure, if it had arrived
  std::vector<DeviceEvent> remove(const std::string& path);

  /// Takes what is there as known.
  void adopt(const std::vector<ListedDevice>& present, Time now);

  /// True while a device is held back.
  [[nodiscard]] bool waiting() const;

 private:
  struct Known {
    ListedDevice device;
    Time since;
    bool reported;
  };

  const std::chrono::nanoseconds patience_;
  std::map<std::string, Known> known_;  // by path
};

}  // namespace torsio
