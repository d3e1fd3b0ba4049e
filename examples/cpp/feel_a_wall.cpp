// Feel a wall. `feel_a_wall` pushes an emulated knob into it; `feel_a_wall /dev/hidraw3` is for
// you.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <vector>

#include "torsio/knob.hpp"

int main(int argc, char** argv) try {
  torsio::Knob knob = torsio::Knob::open(argc > 1 ? argv[1] : "emulated");
  knob.play(torsio::Wall{.angle_rad = 0.1, .stiffness_nm_per_rad = 1.4});
  knob.arm();
  if (knob.is_emulated()) {  // a real one is pushed by you
    knob.emulator().set_hand(torsio::TorqueHand{{{0.0, 0.0}, {0.8, 0.05}}});
  }
  double largest_rad = 0.0;
  double strongest_nm = 0.0;
  for (const torsio::TelemetrySample& sample : knob.record(1.0)) {
    largest_rad = std::max(largest_rad, sample.angle_rad);
    strongest_nm =
        std::max(strongest_nm, -double{sample.spring_torque_nm} - double{sample.motor_command_nm});
  }
  std::printf("turned by %.3f rad, the wall pushed back with %.0f mN m\n", largest_rad,
              1e3 * strongest_nm);
} catch (const std::exception& error) {
  std::fprintf(stderr, "feel_a_wall: %s\n", error.what());
  return 1;
}
