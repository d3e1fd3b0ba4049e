// The public DeviceWatch over the watcher of this system.
#include <utility>

#include "device_watcher.hpp"
#include "hid_transport.hpp"
#include "torsio/hotplug.hpp"

namespace torsio {
namespace {

std::vector<ListedDevice> list_unopened() {
  std::vector<ListedDevice> devices;
  for (const HidListing& hid : list_hid()) {
    devices.push_back({.path = hid.path,
                       .serial = hid.serial,
                       .product = hid.product,
                       .board = {},
                       .transport = "hid",
                       .problem = permission_problem(hid.path)});
  }
  return devices;
}

}  // namespace

class DeviceWatch::Impl : public DeviceWatcher {
 public:
  Impl(Callback callback, const WatchOptions& options)
      : DeviceWatcher({.look = &list_unopened, .directory = hid_files_directory()},
                      std::move(callback), options) {}
};

DeviceWatch::DeviceWatch(const WatchOptions& options) : DeviceWatch(Callback{}, options) {}
DeviceWatch::DeviceWatch(Callback callback, const WatchOptions& options)
    : impl_(std::make_unique<Impl>(std::move(callback), options)) {}

// A child that was forked has not got the thread: there the watch is stopped.

DeviceWatch::~DeviceWatch() {
  if (!impl_->is_here()) [[maybe_unused]]
    const Impl* left_to_the_parent = impl_.release();
}

std::optional<DeviceEvent> DeviceWatch::next(double timeout_s) {
  return impl_->is_here() ? impl_->next(timeout_s) : std::nullopt;
}
void DeviceWatch::stop() {
  if (impl_->is_here()) impl_->stop();
}
bool DeviceWatch::is_stopped() const { return !impl_->is_here() || impl_->is_stopped(); }

}  // namespace torsio
