// The lock of a device on Windows; test_device_lock.cpp has what POSIX must stand.
#ifdef _WIN32
#include <doctest/doctest.h>

#include "device_lock.hpp"
#include "torsio/error.hpp"

using namespace torsio;

namespace {

constexpr const char* kPath = R"(\\?\hid#vid_1209&pid_0001#7&2a0#{4d1e55b2})";

}  // namespace

TEST_CASE("a device is locked once, whatever the case of its name, and free again afterwards") {
  {
    const DeviceLock lock(kPath);
    CHECK_THROWS_AS(DeviceLock{kPath}, DeviceBusy);
    CHECK_THROWS_AS(DeviceLock(R"(\\?\HID#VID_1209&PID_0001#7&2A0#{4D1E55B2})"), DeviceBusy);
    const DeviceLock other(R"(\\?\hid#vid_1209&pid_0001#7&2a1#{4d1e55b2})");
  }
  CHECK_NOTHROW(DeviceLock{kPath});
}
#endif
