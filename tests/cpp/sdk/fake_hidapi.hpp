/// @file
/// Stands in for hidapi under hid_transport.cpp: the same functions, over emulated devices that are
/// plugged into a bus of the test's own. A frame takes about a millisecond of real time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "emulator/emulated_device.hpp"
#include "protocol/usb_ids.hpp"
#include "temporary_directory.hpp"

namespace torsio::test {

struct FakePort {
  std::string path{};
  std::wstring serial = L"FAKE";
  std::wstring product = L"Torsio knob";
  unsigned short vendor_id = protocol::usb_vendor_id;
  unsigned short product_id = protocol::usb_product_id;
  unsigned short usage_page = 0xFF00;
  unsigned short usage = 0x01;
  int interface_number = 0;
  int times_listed = 1;           ///< hidapi lists an interface once per collection
  std::string open_error{};       ///< not empty: hid_open_path fails, and says this
  int handles_allowed = 1 << 30;  ///< the libusb backend lets in only one
  /// May change a feature report on its way to the host.
  std::function<void(protocol::ReportBytes&)> on_get_feature{};
};

/// The bus. Tests of one process run one after the other, so there is one for all of them; each
/// test starts with an empty one. Lock files go to a directory of their own meanwhile, because
/// tests of several processes run side by side.
class FakeBus {
 public:
  FakeBus();
  ~FakeBus();
  FakeBus(const FakeBus&) = delete;
  FakeBus& operator=(const FakeBus&) = delete;

  void plug_in(const FakePort& port, emulator::EmulatedDeviceOptions options = {});
  void unplug(const std::string& path);
  void set_emergency_stop(const std::string& path, bool pressed);
  [[nodiscard]] int open_handles(const std::string& path) const;
  [[nodiscard]] const std::string& lock_directory() const { return lock_directory_.path(); }

 private:
  TemporaryDirectory lock_directory_;
};

}  // namespace torsio::test
