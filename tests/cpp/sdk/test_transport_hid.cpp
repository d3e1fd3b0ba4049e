// hid_transport.cpp on a fake hidapi: discovery, opening and its errors, the lock, and unplugging.
#include <doctest/doctest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "device_lock.hpp"
#include "hid_files.hpp"
#include "sdk/errors.hpp"
#include "sdk/fake_hidapi.hpp"
#include "torsio/knob.hpp"

using namespace torsio;
using namespace std::chrono_literals;
using test::contains;
using test::FakeBus;
using test::message_of;

namespace {

const std::string kPath = "/dev/hidraw-fake0";

}  // namespace

TEST_CASE("discovery lists plugged-in knobs once and the emulated one last") {
  FakeBus bus;
  bus.plug_in({.path = kPath, .serial = L"A1", .times_listed = 3});
  bus.plug_in({.path = "/dev/hidraw-fake1", .usage_page = 0x01, .usage = 0x04});  // its game side
  bus.plug_in({.path = "/dev/hidraw-fake2", .vendor_id = 0x046D});                // a mouse
  const std::vector<ListedDevice> listed = list_devices();
  REQUIRE(listed.size() == 2);
  CHECK(listed[0].path == kPath);
  CHECK(listed[0].serial == "A1");
  CHECK(listed[0].product == "Torsio knob");
  CHECK(listed[0].board == "emulated");
  CHECK(listed[0].transport == "hid");
  CHECK(listed[0].problem.empty());
  CHECK(listed[1].path == "emulated");
  CHECK(listed[1].transport == "emulated");
}

TEST_CASE("discovery goes by the interface where the backend reports no usage") {
  FakeBus bus;
  bus.plug_in({.path = "1-1:1.0", .usage_page = 0, .usage = 0, .interface_number = 0});
  bus.plug_in({.path = "1-1:1.1", .usage_page = 0, .usage = 0, .interface_number = 1});
  const std::vector<ListedDevice> listed = list_devices();
  REQUIRE(listed.size() == 2);
  CHECK(listed[0].path == "1-1:1.0");
}

#ifndef _WIN32  // which lets every user open every knob
TEST_CASE("discovery says why a knob cannot be opened") {
  FakeBus bus;
  bus.plug_in({.path = kPath, .open_error = "Permission denied"});
  CHECK(contains(list_devices().at(0).problem, "60-torsio.rules"));
}
#endif

TEST_CASE("an empty selector opens the only knob, and a serial number or path names one of two") {
  FakeBus bus;
  CHECK(contains(message_of<DeviceNotFound>([] { (void)Knob::open(); }), "no knob is plugged in"));

  bus.plug_in({.path = kPath, .serial = L"A1"});
  CHECK(Knob::open().info().path == kPath);

  bus.plug_in({.path = "/dev/hidraw-fake1", .serial = L"B2"});
  const std::string both = message_of<DeviceNotFound>([] { (void)Knob::open(); });
  CHECK(contains(both, kPath));
  CHECK(contains(both, "/dev/hidraw-fake1"));
  CHECK(Knob::open("B2").info().path == "/dev/hidraw-fake1");
  CHECK(Knob::open(kPath).info().path == kPath);

  const std::string unknown = message_of<DeviceNotFound>([] { (void)Knob::open("C3"); });
  CHECK(contains(unknown, "C3"));
  CHECK(contains(unknown, "A1"));
}

TEST_CASE("opening without permission says what to do about it on this system") {
  FakeBus bus;
  bus.plug_in({.path = kPath, .open_error = "Permission denied"});
  const std::string message = message_of<PermissionDenied>([] { (void)Knob::open(kPath); });
  CHECK(contains(message, kPath));
#ifdef _WIN32
  CHECK(contains(message, "another program may have it"));
#else
  CHECK(contains(message, "60-torsio.rules"));
  CHECK(contains(message, "uaccess"));
#endif
}

TEST_CASE("opening a device that vanished meanwhile is DeviceNotFound") {
  FakeBus bus;
  bus.plug_in({.path = kPath, .open_error = "No such file or directory"});
  CHECK_THROWS_AS((void)Knob::open(kPath), DeviceNotFound);
}

#ifndef _WIN32  // whose knobs are no files
TEST_CASE("a file that is not a hidraw node never reaches hidapi, and leaves no lock file") {
  FakeBus bus;
  const std::string file = bus.lock_directory() + "/file";
  const std::string link = bus.lock_directory() + "/link";
  std::ofstream(file).close();
  std::filesystem::create_symlink("/dev/null", link);
  for (const std::string& path : {std::string("/dev/null"), std::string("/dev"), file, link}) {
    CAPTURE(path);
    bus.plug_in({.path = path});  // hidapi would open it
    const std::string message = message_of<DeviceNotFound>([&] { (void)Knob::open(path); });
    CHECK(message.starts_with(path + " is not a HID device"));
    CHECK(contains(message, "list_devices()"));
  }
  for (const auto& left : std::filesystem::directory_iterator(bus.lock_directory())) {
    CHECK(left.path().extension() != ".lock");
  }
}
#endif

TEST_CASE("a device that cannot be opened leaves no lock file, and no success is its reason") {
  FakeBus bus;
  bus.plug_in({.path = kPath, .open_error = "Success"});
  const std::string message = message_of<DeviceNotFound>([] { (void)Knob::open(kPath); });
  CHECK(contains(message, "no reason given"));
  CHECK_FALSE(contains(message, "Success"));
  CHECK(std::filesystem::is_empty(bus.lock_directory()));
}

#ifndef _WIN32  // whose knobs are no files
TEST_CASE("the lock of a device is the same by whatever name, and can be had after its removal") {
  const FakeBus bus;
  const std::string link = bus.lock_directory() + "/knob";
  std::filesystem::create_symlink("/dev/null", link);
  {
    DeviceLock by_link(link);
    CHECK(contains(message_of<DeviceBusy>([] { const DeviceLock again("/dev/null"); }),
                   "/dev/null is open already"));
    CHECK(std::filesystem::exists(bus.lock_directory() + "/torsio-dev-null.lock"));
    by_link.remove_file();
    CHECK_FALSE(std::filesystem::exists(bus.lock_directory() + "/torsio-dev-null.lock"));
  }
  const DeviceLock again("/dev/null");
  CHECK_THROWS_AS(DeviceLock{link}, DeviceBusy);
}
#endif

TEST_CASE("a second open of the same device is DeviceBusy until the first is closed") {
  FakeBus bus;
  bus.plug_in({.path = kPath});
  Knob first = Knob::open(kPath);
  CHECK(contains(message_of<DeviceBusy>([] { (void)Knob::open(kPath); }), kPath));
  CHECK(contains(list_devices().at(0).problem, "open already"));
  first.play(Wall{.stiffness_nm_per_rad = 1.0});  // the first goes on
  first.close();
  CHECK(Knob::open(kPath).is_open());
  protocol::ReportBytes report{};
  CHECK_FALSE(open_hid(kPath)->read(report, 0ns));  // it says nothing unasked
}

TEST_CASE("a device with other report layouts is a ProtocolMismatch that names both versions") {
  FakeBus bus;
  bus.plug_in({.path = kPath, .on_get_feature = [](protocol::ReportBytes& report) {
                 if (report[0] != 0x01) return;
                 report.fill(0xEE);  // a future identity: only fingerprint and version are known
                 report = {0x01, 0x78, 0x56, 0x34, 0x12, 0x07, 0x00};
               }});
  const std::string message = message_of<ProtocolMismatch>([] { (void)Knob::open(kPath); });
  CHECK(contains(message, "version 7"));
  CHECK(contains(message, "0x12345678"));
  CHECK(contains(message, "version 1"));
  CHECK(contains(message, "update"));
  CHECK(bus.open_handles(kPath) == 0);
}

TEST_CASE("emulator options for a real knob are refused before it is opened") {
  FakeBus bus;
  bus.plug_in({.path = kPath, .serial = L"A1"});
  for (const std::string& selector : {kPath, std::string("A1"), std::string()}) {
    const auto open = [&] { (void)Knob::open(selector, {.emulator = EmulatorOptions{}}); };
    CHECK(contains(message_of<InvalidArgument>(open), "only for an emulated knob"));
  }
  CHECK(Knob::open(kPath).is_open());
}

TEST_CASE("a knob over a backend that allows one handle works with that one") {
  FakeBus bus;
  bus.plug_in({.path = kPath, .handles_allowed = 1});
  Knob knob = Knob::open(kPath);
  knob.arm();
  CHECK(knob.record(0.05).size() == 50);
}

TEST_CASE("signs of life keep an idle knob armed longer than its watchdog") {
  FakeBus bus;
  bus.plug_in({.path = kPath});
  Knob knob = Knob::open(kPath);
  ControlConfig config = knob.control_config();
  config.watchdog_s = 0.2;
  knob.configure(config);
  knob.arm();
  knob.sleep(0.6);
  CHECK(knob.health().state == State::armed);
}

TEST_CASE("closing disarms the device and gives every handle back") {
  FakeBus bus;
  bus.plug_in({.path = kPath});
  {
    Knob knob = Knob::open(kPath);
    knob.arm();
  }
  CHECK(bus.open_handles(kPath) == 0);
  CHECK(Knob::open(kPath).state() == State::disarmed);
}

TEST_CASE("an unplug wakes a waiting call at once, and every later call says so") {
  for (const bool armed : {false, true}) {
    CAPTURE(armed);
    FakeBus bus;
    bus.plug_in({.path = kPath});
    Knob knob = Knob::open(kPath);
    if (armed) knob.arm();
    const auto begin = std::chrono::steady_clock::now();
    std::thread puller([&] {
      std::this_thread::sleep_for(50ms);
      bus.unplug(kPath);
    });
    CHECK(contains(message_of<Disconnected>([&] { knob.sleep(30.0); }), kPath));
    puller.join();
    CHECK(std::chrono::steady_clock::now() - begin < 5s);
    CHECK(knob.state() == State::disconnected);
    CHECK(knob.is_open());
    CHECK_THROWS_AS(knob.arm(), Disconnected);
    CHECK_THROWS_AS(knob.play(Scene{}), Disconnected);
    CHECK_THROWS_AS((void)knob.health(), Disconnected);
    CHECK_THROWS_AS((void)knob.control_config(), Disconnected);
    CHECK_THROWS_AS(knob.configure(ControlConfig{}), Disconnected);
    CHECK_THROWS_AS((void)knob.record(0.1), Disconnected);
    knob.close();
    knob.close();
    CHECK_THROWS_AS((void)knob.state(), Closed);
  }
}

#ifndef _WIN32  // whose knobs are no files
TEST_CASE("a file that opens but does not answer as a knob never gets to hidapi") {
  // As for a knob that is unplugged while it is opened.
  CHECK_THROWS_AS((void)keep_open("/dev/null"), DeviceNotFound);
  // hidapi reports files that it cannot open, and other objects.
  CHECK(keep_open("/no/such/file").use_count() == 0);
  CHECK(keep_open("1-1:1.0").use_count() == 0);
}
#endif
