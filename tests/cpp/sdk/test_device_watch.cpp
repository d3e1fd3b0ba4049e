// Arrivals and departures: the comparison of lists, the thread that watches a directory, and the
// public class over a fake hidapi. The kernel's part is played by a directory of plain files.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>
#include <limits>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "device_watcher.hpp"
#include "sdk/errors.hpp"
#include "sdk/fake_hidapi.hpp"
#include "temporary_directory.hpp"
#include "torsio/hotplug.hpp"

using namespace torsio;
using namespace std::chrono_literals;
using test::contains;
using test::FakeBus;
using test::message_of;
using Kind = DeviceEvent::Kind;

namespace {

// Longer than any event takes on a busy machine; only a failing test waits so long.
constexpr double kLongS = 20.0;

ListedDevice knob_at(const std::string& path, const std::string& serial,
                     const std::string& problem = {}) {
  return {.path = path,
          .serial = serial,
          .product = "knob",
          .board = {},
          .transport = "hid",
          .problem = problem};
}

/// "+path" for an arrival, "-path" for a departure, with "!" if there is a problem.
std::string text(const DeviceEvent& event) {
  return (event.kind == Kind::arrived ? "+" : "-") +
         std::filesystem::path(event.device.path).filename().string() +
         (event.device.problem.empty() ? "" : "!");
}

using Texts = std::vector<std::string>;

/// A directory in the part of /dev, and its files in the part of the kernel's list of devices.
class FakeDev {
 public:
  /// Puts the device on the list, then makes its file, as the kernel does.
  void plug_in(const std::string& name, const std::string& problem = {}) {
    set(name, problem);
    std::ofstream(path() + "/" + name).close();
  }
  /// Removes the file first, and takes the device off the list when told.
  void remove_file(const std::string& name) { std::filesystem::remove(path() + "/" + name); }
  void forget(const std::string& name) {
    const std::lock_guard lock(mutex_);
    std::erase_if(devices_, [&](const auto& listed) { return listed.path == path() + "/" + name; });
  }
  void unplug(const std::string& name) {
    remove_file(name);
    forget(name);
  }
  /// As udev does: another attribute of the file.
  void allow(const std::string& name) {
    set(name, {});
    std::filesystem::permissions(path() + "/" + name, std::filesystem::perms::owner_all);
  }

  [[nodiscard]] WatchSource source() {
    return {.look =
                [this] {
                  const std::lock_guard lock(mutex_);
                  ++looks_;
                  return devices_;
                },
            .directory = path(),
            .prefix = "hidraw"};
  }
  [[nodiscard]] int looks() {
    const std::lock_guard lock(mutex_);
    return looks_;
  }
  [[nodiscard]] const std::string& path() const { return directory_.path(); }

 private:
  void set(const std::string& name, const std::string& problem) {
    forget(name);
    const std::lock_guard lock(mutex_);
    devices_.push_back(knob_at(path() + "/" + name, "S-" + name, problem));
  }

  test::TemporaryDirectory directory_;
  std::mutex mutex_;
  std::vector<ListedDevice> devices_;
  int looks_ = 0;
};

std::string next_text(DeviceWatcher& watcher) {
  const auto event = watcher.next(kLongS);
  return event ? text(*event) : "nothing";
}

}  // namespace

// The comparison ----------------------------------------------------------------------------------

// The thread --------------------------------------------------------------------------------------

TEST_CASE("a watcher reports what is there, what comes and what goes") {
  FakeDev dev;
  dev.plug_in("hidraw0");
  DeviceWatcher watcher(dev.source(), {}, {});
  CHECK(next_text(watcher) == "+hidraw0");
  dev.plug_in("hidraw1");
  const auto arrival = watcher.next(kLongS);
  REQUIRE(arrival);
  CHECK(text(*arrival) == "+hidraw1");
  CHECK(arrival->device.serial == "S-hidraw1");
  dev.unplug("hidraw0");
  CHECK(next_text(watcher) == "-hidraw0");
}

TEST_CASE("a watcher that leaves out what is there reports only what comes") {
  FakeDev dev;
  dev.plug_in("hidraw0");
  DeviceWatcher watcher(dev.source(), {}, {.include_present = false});
  dev.plug_in("hidraw1");
  CHECK(next_text(watcher) == "+hidraw1");
  dev.unplug("hidraw0");
  CHECK(next_text(watcher) == "-hidraw0");
}

#ifndef _WIN32  // where no files tell of arrivals
TEST_CASE("a watcher reports a knob that is pulled and back before anybody looked") {
  FakeDev dev;
  dev.plug_in("hidraw0");
  DeviceWatcher watcher(dev.source(), {}, {});
  CHECK(next_text(watcher) == "+hidraw0");
  dev.remove_file("hidraw0");  // all the while the list shows it
  dev.plug_in("hidraw0");
  CHECK(next_text(watcher) == "-hidraw0");
  CHECK(next_text(watcher) == "+hidraw0");
}

TEST_CASE("a watcher does not take a list that trails behind for a new arrival") {
  FakeDev dev;
  dev.plug_in("hidraw0");
  DeviceWatcher watcher(dev.source(), {}, {});
  CHECK(next_text(watcher) == "+hidraw0");
  dev.remove_file("hidraw0");
  CHECK(next_text(watcher) == "-hidraw0");
  dev.plug_in("hidraw1");  // makes it look again
  CHECK(next_text(watcher) == "+hidraw1");
  dev.forget("hidraw0");
  dev.plug_in("hidraw2");
  CHECK(next_text(watcher) == "+hidraw2");
}
#endif

TEST_CASE(
    "a watcher waits for the permission that udev gives, and for no longer than it was told") {
  FakeDev dev;
  DeviceWatcher patient(dev.source(), {}, {.permission_timeout_s = 60.0});
  DeviceWatcher hasty(dev.source(), {}, {.permission_timeout_s = 0.0});
  dev.plug_in("hidraw0", "no permission");
  CHECK(next_text(hasty) == "+hidraw0!");
  CHECK_FALSE(patient.next(0.0));
  dev.allow("hidraw0");
  CHECK(next_text(patient) == "+hidraw0");
  CHECK(next_text(hasty) == "+hidraw0");
}

TEST_CASE("a watcher notices a permission that comes long after the arrival") {
  FakeDev dev;
  DeviceWatcher watcher(dev.source(), {}, {.permission_timeout_s = 0.0});
  dev.plug_in("hidraw0", "no permission");
  CHECK(next_text(watcher) == "+hidraw0!");
  std::this_thread::sleep_for(700ms);  // the watcher sleeps again
  dev.allow("hidraw0");
  CHECK(next_text(watcher) == "+hidraw0");
}

#ifndef _WIN32  // where it looks twice a second
TEST_CASE("an idle watcher does not look at all") {
  FakeDev dev;
  dev.plug_in("hidraw0");
  DeviceWatcher watcher(dev.source(), {}, {});
  CHECK(next_text(watcher) == "+hidraw0");
  while (dev.looks() < 2) std::this_thread::sleep_for(1ms);  // one of the constructor
  std::this_thread::sleep_for(100ms);
  const int looks = dev.looks();
  std::ofstream(dev.path() + "/tty7").close();  // no business of ours
  std::this_thread::sleep_for(1s);
  CHECK(dev.looks() == looks);
}
#endif

TEST_CASE("a watcher without notices looks twice a second, also while nothing is there") {
  FakeDev dev;
  WatchSource source = dev.source();
  SUBCASE("no such directory") { source.directory = dev.path() + "/missing"; }
  SUBCASE("devices that are no files") { source.directory.clear(); }
  DeviceWatcher watcher(source, {}, {});
  while (dev.looks() < 4) std::this_thread::sleep_for(1ms);  // it goes on looking
  dev.plug_in("hidraw0");
  CHECK(next_text(watcher) == "+hidraw0");
  dev.unplug("hidraw0");
  CHECK(next_text(watcher) == "-hidraw0");
  std::this_thread::sleep_for(1s);
  CHECK(dev.looks() < 40);  // a period of 50 ms would give more by now, a busy loop thousands
}

TEST_CASE("stopping ends a waiting call, and every later one at once") {
  FakeDev dev;
  dev.plug_in("hidraw0");
  DeviceWatcher watcher(dev.source(), {}, {});
  std::atomic<int> taken = 0;
  auto waiting = std::async(std::launch::async, [&] {
    Texts all;
    for (; const auto event = watcher.next(kLongS); ++taken) all.push_back(text(*event));
    return all;
  });
  dev.plug_in("hidraw1");
  while (taken < 2) std::this_thread::sleep_for(1ms);
  watcher.stop();
  watcher.stop();
  CHECK(watcher.is_stopped());
  CHECK(waiting.get() == Texts{"+hidraw0", "+hidraw1"});
  CHECK_FALSE(watcher.next(kLongS));
}

TEST_CASE("a callback comes once per event, from another thread, and may stop its watch") {
  FakeDev dev;
  dev.plug_in("hidraw0");
  dev.plug_in("hidraw1");
  std::promise<std::thread::id> called;
  std::promise<DeviceWatcher*> made;
  std::atomic<int> calls = 0;
  DeviceWatcher watcher(dev.source(),
                        [&, watcher = made.get_future().share()](const DeviceEvent&) {
                          ++calls;
                          watcher.get()->stop();  // returns although this thread is the watch
                          called.set_value(std::this_thread::get_id());
                        },
                        {});
  made.set_value(&watcher);
  CHECK(called.get_future().get() != std::this_thread::get_id());
  watcher.stop();
  CHECK(watcher.is_stopped());
  CHECK(calls == 1);
  CHECK_FALSE(watcher.next(0.0));
}

TEST_CASE("what a callback throws ends the watch, and stop() throws it once") {
  FakeDev dev;
  dev.plug_in("hidraw0");
  dev.plug_in("hidraw1");
  std::atomic<int> calls = 0;
  DeviceWatcher watcher(dev.source(),
                        [&](const DeviceEvent&) {
                          ++calls;
                          throw std::runtime_error("from the callback");
                        },
                        {});
  while (!watcher.is_stopped()) std::this_thread::sleep_for(1ms);
  CHECK_THROWS_WITH(watcher.stop(), "from the callback");
  CHECK_NOTHROW(watcher.stop());
  CHECK(calls == 1);
}

TEST_CASE("a failing look ends the watch, and next() throws it") {
  DeviceWatcher watcher({.look = [looks = 0]() mutable -> std::vector<ListedDevice> {
                          if (++looks > 1) throw Error("no list");
                          return {};
                        }},
                        {}, {});
  CHECK_THROWS_WITH((void)watcher.next(kLongS), "no list");
  CHECK(watcher.is_stopped());
}

TEST_CASE("a watch refuses times that are none") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const FakeBus bus;
  for (const double time_s : {-1.0, kNan, 61.0}) {
    CAPTURE(time_s);
    CHECK(contains(
        message_of<InvalidArgument>([&] { DeviceWatch watch({.permission_timeout_s = time_s}); }),
        "permission_timeout_s is"));
  }
  DeviceWatch watch;
  CHECK_THROWS_AS((void)watch.next(-1.0), InvalidArgument);
  CHECK_THROWS_AS((void)watch.next(kNan), InvalidArgument);
  CHECK_FALSE(watch.next(0.0));
}

// Over hidapi -------------------------------------------------------------------------------------

// The fake is hidapi's libusb backend: there are no files, and the watch goes by the list alone.

TEST_CASE("a watch over hidapi sees a knob come where none was") {
  FakeBus bus;
  DeviceWatch watch;
  std::this_thread::sleep_for(100ms);  // it has looked, in vain
  bus.plug_in({.path = "1-1:1.0", .serial = L"A1"});
  const auto event = watch.next(kLongS);
  REQUIRE(event);
  CHECK(event->kind == Kind::arrived);
  CHECK(event->device.serial == "A1");
}

TEST_CASE("a watch over hidapi sees a knob go and come, and it opens again by its serial number") {
  FakeBus bus;
  bus.plug_in({.path = "1-1:1.0", .serial = L"A1"});
  bus.plug_in({.path = "1-2:1.0", .serial = L"B2"});
  std::promise<void> gone;
  std::promise<std::string> opened;
  DeviceWatch watch([&, was_gone = false](const DeviceEvent& event) mutable {
    CHECK(event.device.board.empty());
    CHECK(event.device.transport == "hid");
    if (event.device.serial != "B2") return;
    if (event.kind == Kind::departed) {
      was_gone = true;
      gone.set_value();
    } else if (was_gone) {
      opened.set_value(Knob::open("B2").info().path);  // under no lock
    }
  });
  Knob knob = Knob::open("B2");
  bus.unplug("1-2:1.0");
  gone.get_future().get();
  CHECK_THROWS_AS(knob.sleep(10.0), Disconnected);
  knob.close();
  bus.plug_in({.path = "1-3:1.0", .serial = L"B2"});
  CHECK(opened.get_future().get() == "1-3:1.0");
  watch.stop();
}
