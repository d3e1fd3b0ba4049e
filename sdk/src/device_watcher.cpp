#include "device_watcher.hpp"

#include <system_error>
#include <utility>

#include "conversion/field_check.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

using std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto kPollPeriod = 500ms;  // where no notices come
// After a notice, and while a device waits for its permission: the kernel's list of devices and
// udev follow the notice, usually by less than this.
constexpr auto kSettlePeriod = 50ms;
constexpr auto kSettleTime = 500ms;

std::chrono::nanoseconds patience(const WatchOptions& options) {
  constexpr double kLongestS = 60.0;
  const double time_s = options.permission_timeout_s;
  if (!(time_s >= 0.0 && time_s <= kLongestS)) {
    throw InvalidArgument("permission_timeout_s is " + number_text(time_s) +
                          ", allowed are 0 to 60 s");
  }
  return std::chrono::nanoseconds(whole_ns("permission_timeout_s", time_s));
}

}  // namespace

DeviceWatcher::DeviceWatcher(WatchSource source, DeviceWatch::Callback callback,
                             const WatchOptions& options)
    : source_(std::move(source)),
      callback_(std::move(callback)),
      directory_(source_.directory, source_.prefix),  // before the first look
      changes_(patience(options)),
      settled_at_(steady_clock::now()) {
  // Here and not in the thread: what comes or goes after the constructor is an event.
  if (options.include_present) {
    first_events_ = changes_.update(present(), steady_clock::now());
  } else {
    changes_.adopt(present(), steady_clock::now());
  }
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error& error) {
    throw Error(std::string("cannot watch for devices: ") + error.what());
  }
}

DeviceWatcher::~DeviceWatcher() {
  try {
    stop();
  } catch (...) {  // NOLINT(bugprone-empty-catch): of the callback, which nobody asked for
  }
}

std::optional<DeviceEvent> DeviceWatcher::next(double timeout_s) {
  const auto deadline =
      steady_clock::now() + std::chrono::nanoseconds(whole_ns("timeout_s", timeout_s));
  std::unique_lock lock(mutex_);
  news_.wait_until(lock, deadline, [&] { return !events_.empty() || ended_; });
  if (events_.empty()) {
    lock.unlock();
    rethrow_failure();
    return std::nullopt;
  }
  DeviceEvent event = std::move(events_.front());
  events_.pop_front();
  return event;
}

void DeviceWatcher::stop() {
  stopping_ = true;
  directory_.wake();
  // The callback's own thread cannot wait for itself.
  if (std::this_thread::get_id() == thread_id_.load()) return;
  {
    const std::lock_guard join(join_mutex_);
    if (thread_.joinable()) thread_.join();
  }
  rethrow_failure();
}

void DeviceWatcher::run() noexcept {
  thread_id_ = std::this_thread::get_id();
  try {
    watch();
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
  }
  end();
}

void DeviceWatcher::watch() {
  deliver(std::exchange(first_events_, {}));
  while (!stopping_) {
    look();
    if (stopping_ || !directory_.wait(time_to_next_look())) continue;
    settled_at_ = steady_clock::now() + kSettleTime;
    for (const std::string& path : directory_.take_removed()) deliver(changes_.remove(path));
  }
}

void DeviceWatcher::look() { deliver(changes_.update(present(), steady_clock::now())); }

/// Devices that are there. A file that has gone may stay on the kernel's list for a moment.
std::vector<ListedDevice> DeviceWatcher::present() const {
  std::vector<ListedDevice> devices = source_.look();
  std::erase_if(devices,
                [&](const ListedDevice& device) { return directory_.is_gone(device.path); });
  return devices;
}

std::optional<std::chrono::milliseconds> DeviceWatcher::time_to_next_look() const {
  if (changes_.waiting() || steady_clock::now() < settled_at_) return kSettlePeriod;
  if (!directory_.has_notices()) return kPollPeriod;
  return std::nullopt;
}

void DeviceWatcher::deliver(const std::vector<DeviceEvent>& events) {
  for (const DeviceEvent& event : events) {
    if (stopping_) return;
    if (callback_) {
      callback_(event);
      continue;
    }
    {
      const std::lock_guard lock(mutex_);
      events_.push_back(event);
    }
    news_.notify_all();
  }
}

void DeviceWatcher::end() noexcept {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  news_.notify_all();
}

void DeviceWatcher::rethrow_failure() {
  std::exception_ptr failure;
  {
    const std::lock_guard lock(mutex_);
    failure = std::exchange(failure_, nullptr);
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace torsio
