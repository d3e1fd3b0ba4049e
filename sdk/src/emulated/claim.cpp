#include "emulated/claim.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <mutex>
#include <utility>

#include "torsio/error.hpp"

namespace torsio {
namespace {

struct NamedDevice {
  bool open = false;
  device::StoredSlots stored = device::empty_slots();
};

struct Registry {
  std::mutex mutex;
  std::map<std::string, NamedDevice> devices;
};

Registry& registry() {
  // Never destroyed: a knob in static storage may be closed after everything else.
  static Registry& instance = *new Registry;
  return instance;
}

}  // namespace

Claim::Claim(std::string name) : name_(std::move(name)) {
  if (name_.empty()) return;
  const bool usable = name_.size() <= 16 && std::ranges::all_of(name_, [](unsigned char c) {
                        return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
                      });
  if (!usable) {
    throw InvalidArgument("\"" + name_ +
                          "\" cannot name an emulated knob: use 1 to 16 letters, digits, '-', "
                          "'_' and '.'");
  }
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  if (std::exchange(all.devices[name_].open, true)) {
    throw DeviceBusy("emulated:" + name_ + " is open already; close it there first");
  }
}
device::StoredSlots Claim::stored() const {
  if (name_.empty()) return device::empty_slots();
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  return all.devices[name_].stored;
}

void Claim::release(const device::StoredSlots* stored) {
  if (name_.empty()) return;
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  NamedDevice& device = all.devices[name_];
  device.open = false;
  if (stored != nullptr) device.stored = *stored;
  name_.clear();
}

}  // namespace torsio
