// Several threads on one knob that the kernel has.
#include <doctest/doctest.h>

#include "sdk/busy_threads.hpp"
#include "torsio/knob.hpp"
#include "virtual_knob.hpp"

using namespace torsio;

TEST_CASE("calls of several threads on an attached knob all get their answers") {
  test::VirtualKnob plugged({"--serial", "THREADS"});
  plugged.plug();
  Knob knob = Knob::open("THREADS");
  knob.arm();
  {
    const test::BusyThreads threads(knob);
    CHECK(knob.record(0.5).size() == 500);
  }
  CHECK(knob.state() == State::armed);
  CHECK(knob.statistics().samples_lost == 0);
  knob.close();
}
