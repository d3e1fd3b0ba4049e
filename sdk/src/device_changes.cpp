#include "device_changes.hpp"

#include <algorithm>

namespace torsio {
namespace {

using Kind = DeviceEvent::Kind;

}  // namespace

std::vector<DeviceEvent> DeviceChanges::update(const std::vector<ListedDevice>& present, Time now) {
  std::vector<DeviceEvent> events;
  for (auto at = known_.begin(); at != known_.end();) {
    const auto there = std::ranges::find(present, at->first, &ListedDevice::path);
    // Another knob at the same path is another knob.
    if (there != present.end() && there->serial == at->second.device.serial) {
      ++at;
      continue;
    }
    if (at->second.reported) events.push_back({Kind::departed, at->second.device});
    at = known_.erase(at);
  }
  for (const ListedDevice& device : present) {
    Known& known = known_.try_emplace(device.path, Known{device, now, false}).first->second;
    const bool solved = known.reported && !known.device.problem.empty() && device.problem.empty();
    const bool ready = device.problem.empty() || now - known.since >= patience_;
    known.device = device;
    if (solved || (!known.reported && ready)) {
      known.reported = true;
      events.push_back({Kind::arrived, device});
    }
  }
  return events;
}

std::vector<DeviceEvent> DeviceChanges::remove(const std::string& path) {
  std::vector<DeviceEvent> events;
  const auto known = known_.find(path);
  if (known == known_.end()) return events;
  if (known->second.reported) events.push_back({Kind::departed, known->second.device});
  known_.erase(known);
  return events;
}

void DeviceChanges::adopt(const std::vector<ListedDevice>& present, Time now) {
  for (const ListedDevice& device : present) known_[device.path] = {device, now, true};
}

bool DeviceChanges::waiting() const {
  return std::ranges::any_of(known_, [](const auto& entry) { return !entry.second.reported; });
}

}  // namespace torsio
