// The host knows where a ball is and lets the knob feel it. A hundred times a second it streams a
// local model: a spring to the ball's place. The device renders the spring at its own rate, so it
// feels stiff although the host is slow.
#include <cmath>
#include <exception>
#include <iostream>

#include "torsio/knob.hpp"

int main(int argc, char** argv) try {
  torsio::Knob knob = torsio::Knob::open(argc > 1 ? argv[1] : "emulated");
  knob.arm();
  for (int step = 0; step < 300; ++step) {
    const double time_s = 0.01 * step;
    knob.stream_local_model({.angle_rad = 0.5 * std::sin(2.0 * time_s),
                             .stiffness_nm_per_rad = 0.5,
                             .damping_nm_s_per_rad = 1e-3,
                             .deadline_s = 0.05});
    knob.sleep(0.01);
    if (step % 50 == 0) {
      std::cout << time_s << " s: the knob is at " << knob.position_rad() << " rad\n";
    }
  }
  knob.stream_local_model({.deadline_s = 0.0});  // the end, in good order
  knob.disarm();

  const torsio::LinkStatistics statistics = knob.statistics();
  if (statistics.local_models_refused > 0) {
    std::cerr << "the device refused some: " << statistics.last_refusal << '\n';
    return 1;
  }
} catch (const std::exception& error) {
  std::cerr << "stream_local_model: " << error.what() << '\n';
  return 1;
}
