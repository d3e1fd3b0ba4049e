// The knobs in the kernel's files, on a tree laid out as sysfs is
// (Documentation/ABI/testing/ sysfs-bus-usb and sysfs-class-hidraw, docs of HID_ID in
// drivers/hid/hid-core.c).
#include <doctest/doctest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "hidraw_listing.hpp"
#include "protocol/usb_ids.hpp"
#include "temporary_directory.hpp"

using torsio::HidListing;
using torsio::list_hidraw;
namespace fs = std::filesystem;

namespace {

using namespace std::string_view_literals;
// Usage page of the vendor's own, usage 1, application collection; and a joystick's.
constexpr std::string_view kVendor = "\x06\x00\xFF\x09\x01\xA1\x01\x85\x01\xC0"sv;
constexpr std::string_view kGame = "\x05\x01\x09\x04\xA1\x01\x85\x21\xC0"sv;

std::string our_id() {
  char text[64];
  std::snprintf(text, sizeof text, "0003:%08X:%08X", unsigned{torsio::protocol::usb_vendor_id},
                unsigned{torsio::protocol::usb_product_id});
  return text;
}

class Sysfs {
 public:
  /// An interface of a USB device, with the device of the HID bus and its hidraw device in it.
  void plug(int number, std::string_view descriptor, const std::string& id = our_id(),
            const std::string& serial = "SERIAL", const std::string& product = "Torsio knob") {
    const fs::path usb = root() / ("devices/1-" + std::to_string(number));
    const fs::path hid = usb / "1-1:1.0" / "0003:1209:0001.0001";
    const std::string name = "hidraw" + std::to_string(number);
    const fs::path raw = hid / "hidraw" / name;
    fs::create_directories(raw);
    fs::create_directories(root() / "class");
    std::ofstream(usb / "product") << product << '\n';
    std::ofstream(hid / "uevent") << "DRIVER=hid-generic\nHID_ID=" << id << "\nHID_NAME=Torsio "
                                  << product << "\nHID_UNIQ=" << serial << "\nMODALIAS=hid:b0003\n";
    std::ofstream(hid / "report_descriptor", std::ios::binary) << descriptor;
    std::ofstream(raw / "uevent") << "MAJOR=240\nMINOR=" << number << "\nDEVNAME=" << name << '\n';
    fs::create_symlink(hid, raw / "device");
    fs::create_symlink(raw, root() / "class" / name);
  }

  /// Takes away the files that a leaving device has lost already.
  void lose(int number, const std::string& file) {
    const fs::path entry = root() / "class" / ("hidraw" + std::to_string(number));
    const fs::path lost = fs::canonical(entry / file);
    if (fs::is_symlink(entry / file)) {
      fs::remove(entry / file);
    } else {
      fs::remove_all(lost);
    }
  }

  [[nodiscard]] std::vector<HidListing> list() const { return list_hidraw(root() / "class"); }
  [[nodiscard]] fs::path root() const { return directory_.path(); }

 private:
  torsio::test::TemporaryDirectory directory_;
};

std::vector<std::string> paths(const std::vector<HidListing>& listed) {
  std::vector<std::string> paths;
  for (const HidListing& hid : listed) paths.push_back(hid.path);
  return paths;
}

}  // namespace

TEST_CASE("hidraw: the vendor interface of each knob is listed, in the order of the numbers") {
  Sysfs sysfs;
  sysfs.plug(10, kVendor, our_id(), "TEN");
  sysfs.plug(2, kVendor, our_id(), "TWO",
             "Torsio kn\xC3\xB6"
             "b");
  sysfs.plug(3, kGame);
  const auto listed = sysfs.list();
  REQUIRE(paths(listed) == std::vector<std::string>{"/dev/hidraw2", "/dev/hidraw10"});
  CHECK(listed[0].serial == "TWO");
  CHECK(listed[0].product == "Torsio kn??b");
  CHECK(listed[1].serial == "TEN");
  CHECK(listed[1].product == "Torsio knob");
}

TEST_CASE("hidraw: devices of others are left out, whatever they say") {
  Sysfs sysfs;
  int number = 0;
  for (const char* id : {"0003:0000046D:0000C24F", "", "0003", "0003:", "0003:zz:1",
                         "::", "0003:1:", "0003:99999999999999999999:1"}) {
    sysfs.plug(number++, kVendor, id);
  }
  for (const std::string_view descriptor : {""sv, "\x06"sv, "\x06\x00"sv, "\xFE\xFF\xFF"sv,
                                            "\x09\x01"sv, "\xA1\x01\x06\x00\xFF\x09\x01"sv}) {
    sysfs.plug(number++, descriptor);
  }
  CHECK(sysfs.list().empty());
}

TEST_CASE("hidraw: a device that leaves meanwhile is left out, and the others stay") {
  for (const char* lost : {"device/uevent", "device/report_descriptor", "uevent", "device", "."}) {
    CAPTURE(lost);
    Sysfs sysfs;
    sysfs.plug(0, kVendor);
    sysfs.plug(1, kVendor);
    sysfs.plug(2, kVendor);
    sysfs.lose(1, lost);
    CHECK(paths(sysfs.list()) == std::vector<std::string>{"/dev/hidraw0", "/dev/hidraw2"});
  }
}

TEST_CASE("hidraw: a file that opens and cannot be read is that of a device that leaves") {
  for (const char* lost : {"device/uevent", "device/report_descriptor", "uevent"}) {
    CAPTURE(lost);
    Sysfs sysfs;
    sysfs.plug(0, kVendor);
    sysfs.plug(1, kVendor);
    const fs::path file = fs::canonical(sysfs.root() / "class/hidraw0" / lost);
    fs::remove(file);
    fs::create_directory(file);  // opens, and each read of it fails
    CHECK(paths(sysfs.list()) == std::vector<std::string>{"/dev/hidraw1"});
  }
}

TEST_CASE("hidraw: a system without such devices has no knobs") {
  Sysfs sysfs;
  CHECK(sysfs.list().empty());
  CHECK(list_hidraw(sysfs.root() / "class/hidraw0/device").empty());
}
