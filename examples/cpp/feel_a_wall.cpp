// Feel a wall. `feel_a_wall` pushes an emulated knob into it; `feel_a_wall /dev/hidraw3` is for
// you.
#include <exception>
#include <iostream>

#include "torsio/knob.hpp"

int main(int argc, char** argv) try {
  torsio::OpenOptions options;
  options.emulator.hand = torsio::TorqueHand{{{0.0, 0.0}, {1.0, 0.075}, {2.0, 0.0}}};

  torsio::Knob knob = torsio::Knob::open(argc > 1 ? argv[1] : "emulated", options);
  knob.arm();
  knob.play(torsio::Wall{.angle_rad = 0.05, .stiffness_nm_per_rad = 1.43});

  const std::vector<torsio::TelemetrySample> log = knob.record(2.0);
  for (std::size_t i = 0; i < log.size(); i += 200) {
    std::cout << log[i].time_s << " s: " << log[i].angle_rad << " rad, the wall pushes with "
              << log[i].desired_torque_nm << " N m\n";
  }
} catch (const std::exception& error) {
  std::cerr << "feel_a_wall: " << error.what() << '\n';
  return 1;
}
