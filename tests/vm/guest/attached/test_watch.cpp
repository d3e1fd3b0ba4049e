// A watch in C++ over knobs that the kernel has.
#include <doctest/doctest.h>

#include <optional>
#include <string>

#include "torsio/hotplug.hpp"
#include "torsio/knob.hpp"
#include "virtual_knob.hpp"

namespace {

constexpr double kLongestS = 30.0;

void check_next(torsio::DeviceWatch& watch, torsio::DeviceEvent::Kind kind,
                const std::string& serial) {
  const std::optional<torsio::DeviceEvent> event = watch.next(kLongestS);
  REQUIRE(event.has_value());
  CHECK(event->kind == kind);
  CHECK(event->device.serial == serial);
}

}  // namespace

TEST_CASE("a watch tells of an attached knob's arrivals and departures") {
  using Kind = torsio::DeviceEvent::Kind;
  torsio::DeviceWatch watch;
  torsio::test::VirtualKnob knob({"--serial", "WATCHED"});
  knob.plug();
  for (int i = 0; i < 2; ++i) {
    check_next(watch, Kind::arrived, "WATCHED");
    CHECK(torsio::Knob::open("WATCHED").info().serial == "WATCHED");
    knob.unplug();
    check_next(watch, Kind::departed, "WATCHED");
    knob.plug();
  }
  check_next(watch, Kind::arrived, "WATCHED");
  CHECK_FALSE(watch.next(0.0).has_value());
}
