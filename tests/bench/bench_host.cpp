// One repeat of the host benchmark in C++: prints nanoseconds per command and per telemetry sample.
// bench_host.py does the same work in Python and compares.
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "torsio/knob.hpp"

namespace {

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double command_ns(torsio::Knob& knob, int commands) {
  const double begin = seconds_now();
  for (int i = 0; i < commands; ++i) {
    knob.play(torsio::Wall{.angle_rad = 0.1, .stiffness_nm_per_rad = 1.0 + 1e-4 * i});
  }
  return (seconds_now() - begin) / commands * 1e9;
}

double sample_ns(torsio::Knob& knob, double duration_s) {
  const double begin = seconds_now();
  const auto samples = knob.record(duration_s);
  return (seconds_now() - begin) / static_cast<double>(samples.size()) * 1e9;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: bench_host COMMANDS RECORD_SECONDS\n", stderr);
    return 2;
  }
  torsio::Knob knob = torsio::Knob::open("emulated");
  knob.arm();
  command_ns(knob, 100);  // warm up
  const double command = command_ns(knob, std::atoi(argv[1]));
  knob.start_telemetry();
  const double sample = sample_ns(knob, std::atof(argv[2]));
  std::printf("%.3f %.3f\n", command, sample);
  return 0;
}
