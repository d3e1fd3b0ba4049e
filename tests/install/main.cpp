#include <cstdio>
#include <torsio/knob.hpp>
#include <vector>

// A hand leans on a wall with a constant torque: the knob comes to rest inside the wall.
int main() {
  constexpr double kPushNm = 0.05;
  constexpr double kFrictionNm = 0.01;  // more than the emulated actuator has
  const torsio::Wall wall{.angle_rad = 0.1, .stiffness_nm_per_rad = 1.0};

  torsio::OpenOptions options{.emulator = torsio::EmulatorOptions{}};
  options.emulator->hand = torsio::TorqueHand{{{0.0, kPushNm}}};
  torsio::Knob knob = torsio::Knob::open("emulated", options);
  knob.play(wall);
  knob.arm();
  const std::vector<torsio::TelemetrySample> samples = knob.record(2.0);
  if (samples.empty()) {
    std::puts("no telemetry");
    return 1;
  }
  const double depth_rad = samples.back().angle_rad - wall.angle_rad;
  std::printf("%zu samples, %.4f rad inside the wall\n", samples.size(), depth_rad);
  const bool balanced = depth_rad > (kPushNm - kFrictionNm) / wall.stiffness_nm_per_rad &&
                        depth_rad < (kPushNm + kFrictionNm) / wall.stiffness_nm_per_rad;
  return balanced ? 0 : 1;
}
