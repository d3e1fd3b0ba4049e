#include "hid_transport.hpp"

#include <hidapi.h>

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

#include "device_lock.hpp"
#include "fair_mutex.hpp"
#include "hid_files.hpp"
#include "protocol/registry.hpp"
#include "protocol/usb_ids.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

// hidapi's functions that take no device share state.
std::mutex& hidapi_mutex() {
  static std::mutex mutex;
  return mutex;
}

struct CloseHid {
  void operator()(hid_device* device) const { hid_close(device); }
};
using HidDevice = std::unique_ptr<hid_device, CloseHid>;

std::string narrow_text(const wchar_t* text) {
  std::string out;
  for (; text != nullptr && *text != L'\0'; ++text) {
    out += *text > 31 && *text < 127 ? static_cast<char>(*text) : '?';
  }
  return out;
}

bool is_knob(const hid_device_info& info) {
  if (info.usage_page == protocol::usb_usage_page) return info.usage == protocol::usb_usage;
  // hidapi's libusb backend does not read report descriptors: there the interface has to do.
  return info.usage_page == 0 && info.interface_number == 0;
}

std::string last_error(hid_device* device) {
  const std::string text = narrow_text(hid_error(device));
  // hidapi calls it a success where it has kept no error.
  return text.empty() || text == "Success" ? "no reason given" : text;
}

[[noreturn]] void throw_cannot_open(const std::string& path) {
  const std::string reason = last_error(nullptr);
  const bool forbidden = !permission_problem(path).empty() ||
                         reason.find("ermission") != std::string::npos ||
                         reason.find("ACCESS") != std::string::npos ||
                         reason.find("denied") != std::string::npos;  // Windows
  if (forbidden) throw PermissionDenied(permission_text(path));
  throw DeviceNotFound("cannot open " + path + " (" + reason +
                       "); list_devices() and `torsio list` show what is there");
}

class HidTransport final : public Transport {
 public:
  explicit HidTransport(const std::string& path) : path_(path), lock_(std::in_place, path) {
    const std::lock_guard guard(hidapi_mutex());
    writer_.reset(hid_open_path(path.c_str()));
    if (writer_ == nullptr) {
      lock_->remove_file();
      throw_cannot_open(path);
    }
    // hidapi's handles are not made for two threads: each call replaces the handle's error text.
    // So the reading thread gets one of its own. The libusb backend lets nobody in twice, but it
    // keeps no error text either, so there one handle serves both.
    reader_.reset(hid_open_path(path.c_str()));
  }

  void close() noexcept override {
    const std::lock_guard<FairMutex> guard(mutex_);
    reader_.reset();
    writer_.reset();
    lock_.reset();
  }

  bool write(const ReportBytes& report) override {
    const std::lock_guard<FairMutex> guard(mutex_);
    if (hid_write(open_handle(), report.data(), report.size()) < 0) throw_gone();
    return true;
  }

  bool read(ReportBytes& report, std::chrono::nanoseconds timeout) override {
    // Not under the lock: this is the one call that waits. close() comes when nobody reads.
    hid_device* device = reader_ != nullptr ? reader_.get() : writer_.get();
    if (device == nullptr) throw Closed("the device was closed");
    const auto timeout_ms = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
    const int bytes = hid_read_timeout(device, report.data(), report.size(),
                                       static_cast<int>(std::max<std::int64_t>(timeout_ms, 0)));
    if (bytes < 0) throw_gone();
    // A shorter report cannot be one of ours; it fails to decode and is counted.
    if (bytes > 0) std::fill(report.begin() + bytes, report.end(), std::uint8_t{0});
    return bytes > 0;
  }

  bool get_feature(std::uint8_t id, ReportBytes& report) override {
    const std::lock_guard<FairMutex> guard(mutex_);
    return ask(id, report) || (throw_unless_there(), false);
  }

  bool set_feature(const ReportBytes& report) override {
    const std::lock_guard<FairMutex> guard(mutex_);
    return hid_send_feature_report(open_handle(), report.data(), report.size()) >= 0 ||
           (throw_unless_there(), false);
  }

 private:
  hid_device* open_handle() const {
    if (writer_ == nullptr) throw Closed("the device was closed");
    return writer_.get();
  }

  bool ask(std::uint8_t id, ReportBytes& report) {
    report.fill(0);
    report[0] = id;
    return hid_get_feature_report(open_handle(), report.data(), report.size()) > 0;
  }

  /// hidapi does not tell a stalled request from a lost device; a device that is there answers for
  /// its identity.
  void throw_unless_there() {
    ReportBytes report{};
    if (!ask(protocol::Layout<protocol::Identity>::id, report)) throw_gone();
  }

  [[noreturn]] void throw_gone() const {
    throw Disconnected(
        "the knob at " + path_ +
        " is gone: it was unplugged or lost its power; open it again when it is back");
  }

  const std::string path_;
  std::optional<DeviceLock> lock_;
  // One call at a time on writer_. A thread that asks for feature reports without end must not keep
  // out the signs of life, nor the thread that reads, which sends them.
  FairMutex mutex_;
  HidDevice writer_;
  HidDevice reader_;
};

}  // namespace

std::vector<HidListing> list_hid() {
  if (auto listed = list_hid_files()) return *std::move(listed);
  const std::lock_guard guard(hidapi_mutex());
  std::vector<HidListing> found;
  hid_device_info* const first = hid_enumerate(protocol::usb_vendor_id, protocol::usb_product_id);
  for (const hid_device_info* info = first; info != nullptr; info = info->next) {
    if (!is_knob(*info) || info->path == nullptr) continue;
    // An interface is listed once for each of its collections.
    if (std::ranges::find(found, info->path, &HidListing::path) != found.end()) continue;
    found.push_back(
        {info->path, narrow_text(info->serial_number), narrow_text(info->product_string)});
  }
  hid_free_enumeration(first);
  return found;
}

std::unique_ptr<Transport> open_hid(const std::string& path) {
  // Both before there is a lock file.
  refuse_other_files(path);
  const auto kept = keep_open(path);
  return std::make_unique<HidTransport>(path);
}

}  // namespace torsio
