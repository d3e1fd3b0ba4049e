#include "sdk/fake_hidapi.hpp"

#include <hidapi.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "environment.hpp"

namespace torsio::test {
namespace {

constexpr std::int64_t kFrameNs = 1'000'000;

struct Plugged {
  FakePort port;
  std::shared_ptr<emulator::EmulatedDevice> device;
  bool present = true;
  int handles = 0;
};

struct Bus {
  std::mutex mutex;
  std::map<std::string, Plugged> ports;
  std::wstring last_error;
};

Bus& bus() {
  static Bus instance;
  return instance;
}

wchar_t* copy_of(const std::wstring& text) {
  auto* copy = new wchar_t[text.size() + 1];
  std::copy_n(text.c_str(), text.size() + 1, copy);
  return copy;
}

}  // namespace

FakeBus::FakeBus() {
  set_variable("XDG_RUNTIME_DIR", lock_directory().c_str());
  const std::lock_guard lock(bus().mutex);
  bus().ports.clear();
}

FakeBus::~FakeBus() {
  set_variable("XDG_RUNTIME_DIR", nullptr);
  const std::lock_guard lock(bus().mutex);
  bus().ports.clear();
}

void FakeBus::plug_in(const FakePort& port, emulator::EmulatedDeviceOptions options) {
  const std::lock_guard lock(bus().mutex);
  bus().ports[port.path] = {port, std::make_shared<emulator::EmulatedDevice>(std::move(options)),
                            true, 0};
}

void FakeBus::unplug(const std::string& path) {
  const std::lock_guard lock(bus().mutex);
  bus().ports.at(path).present = false;
}

void FakeBus::set_emergency_stop(const std::string& path, bool pressed) {
  const std::lock_guard lock(bus().mutex);
  bus().ports.at(path).device->set_emergency_stop(pressed);
}

int FakeBus::open_handles(const std::string& path) const {
  const std::lock_guard lock(bus().mutex);
  return bus().ports.at(path).handles;
}

}  // namespace torsio::test

using torsio::protocol::ReportBytes;
using torsio::test::bus;
using torsio::test::Plugged;

struct hid_device_ {
  std::string path;
};

namespace {

/// The device behind a handle, with the bus locked; null once it is unplugged.
Plugged* behind(hid_device* handle) {
  const auto found = bus().ports.find(handle->path);
  return found == bus().ports.end() || !found->second.present ? nullptr : &found->second;
}

ReportBytes report_from(const unsigned char* data, size_t length) {
  ReportBytes report{};
  std::copy_n(data, std::min(length, report.size()), report.begin());
  return report;
}

}  // namespace

extern "C" {

struct hid_device_info* hid_enumerate(unsigned short vendor_id, unsigned short product_id) {
  const std::lock_guard lock(bus().mutex);
  hid_device_info* first = nullptr;
  for (auto& [path, plugged] : bus().ports) {
    const torsio::test::FakePort& port = plugged.port;
    if (!plugged.present || port.vendor_id != vendor_id || port.product_id != product_id) continue;
    for (int i = 0; i < port.times_listed; ++i) {
      auto* info = new hid_device_info{};
      info->path = strdup(path.c_str());
      info->serial_number = torsio::test::copy_of(port.serial);
      info->product_string = torsio::test::copy_of(port.product);
      info->usage_page = port.usage_page;
      info->usage = port.usage;
      info->interface_number = port.interface_number;
      info->next = first;
      first = info;
    }
  }
  return first;
}

void hid_free_enumeration(struct hid_device_info* info) {
  while (info != nullptr) {
    hid_device_info* const next = info->next;
    free(info->path);
    delete[] info->serial_number;
    delete[] info->product_string;
    delete info;
    info = next;
  }
}

hid_device* hid_open_path(const char* path) {
  const std::lock_guard lock(bus().mutex);
  const auto found = bus().ports.find(path);
  if (found == bus().ports.end() || !found->second.present) {
    bus().last_error = L"No such file or directory";
    return nullptr;
  }
  Plugged& plugged = found->second;
  if (!plugged.port.open_error.empty() || plugged.handles >= plugged.port.handles_allowed) {
    bus().last_error.assign(plugged.port.open_error.begin(), plugged.port.open_error.end());
    return nullptr;
  }
  ++plugged.handles;
  return new hid_device{path};
}

void hid_close(hid_device* handle) {
  if (handle == nullptr) return;
  const std::lock_guard lock(bus().mutex);
  const auto found = bus().ports.find(handle->path);
  if (found != bus().ports.end()) --found->second.handles;
  delete handle;
}

int hid_write(hid_device* handle, const unsigned char* data, size_t length) {
  const std::lock_guard lock(bus().mutex);
  Plugged* const plugged = behind(handle);
  if (plugged == nullptr) return -1;
  while (!plugged->device->write(report_from(data, length))) plugged->device->advance(1'000'000);
  return static_cast<int>(length);
}

int hid_read_timeout(hid_device* handle, unsigned char* data, size_t length, int milliseconds) {
  for (int waited = 0;; ++waited) {
    {
      const std::lock_guard lock(bus().mutex);
      Plugged* const plugged = behind(handle);
      if (plugged == nullptr) return -1;
      ReportBytes report;
      if (plugged->device->read(report)) {
        const size_t bytes = std::min(length, report.size());
        std::copy_n(report.begin(), bytes, data);
        return static_cast<int>(bytes);
      }
      if (waited >= milliseconds) return 0;
      plugged->device->advance(torsio::test::kFrameNs);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

int hid_send_feature_report(hid_device* handle, const unsigned char* data, size_t length) {
  const std::lock_guard lock(bus().mutex);
  Plugged* const plugged = behind(handle);
  if (plugged == nullptr) return -1;
  return plugged->device->set_feature({data, length}).ok() ? static_cast<int>(length) : -1;
}

int hid_get_feature_report(hid_device* handle, unsigned char* data, size_t length) {
  const std::lock_guard lock(bus().mutex);
  Plugged* const plugged = behind(handle);
  if (plugged == nullptr) return -1;
  ReportBytes report;
  if (plugged->device->get_feature(data[0], report) != torsio::protocol::Status::ok) return -1;
  if (plugged->port.on_get_feature) plugged->port.on_get_feature(report);
  const size_t bytes = std::min(length, report.size());
  std::copy_n(report.begin(), bytes, data);
  return static_cast<int>(bytes);
}

// So that it is known for a libusb backend, as its paths are no files.
hid_device* hid_libusb_wrap_sys_device(std::intptr_t, int) { return nullptr; }

const wchar_t* hid_error(hid_device* handle) {
  // As hidapi does: the text belongs to the library and lives until the next call.
  return handle == nullptr ? bus().last_error.c_str() : L"";
}

}  // extern "C"
