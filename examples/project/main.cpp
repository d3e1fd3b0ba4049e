#include <cstdio>
#include <vector>

#include "torsio/knob.hpp"

// A hand leans on a wall with 50 mN m: the knob comes to rest inside the wall.
int main() try {
  const torsio::Wall wall{.angle_rad = 0.1, .stiffness_nm_per_rad = 1.0};
  torsio::OpenOptions options{.emulator = torsio::EmulatorOptions{}};
  options.emulator->hand = torsio::TorqueHand{.torque_nm = {{0.0, 0.05}}};
  torsio::Knob knob = torsio::Knob::open("emulated", options);  // without a name: the real one
  knob.play(wall);
  knob.arm();
  const std::vector<torsio::TelemetrySample> samples = knob.record(2.0);
  std::printf("%zu samples, %.4f rad inside the wall\n", samples.size(),
              samples.back().angle_rad - wall.angle_rad);
  return 0;
} catch (const torsio::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
