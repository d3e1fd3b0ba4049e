// The SDK's half of the USB benchmark, against a knob that is plugged in; bench_usb.py runs it.
#include <sys/resource.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <vector>

#include "torsio/knob.hpp"

namespace {

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// User and system time of this process.
double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Prints the seconds of each round trip, one a line.
void trips(const char* path, int warm_up, int trips) {
  torsio::Knob knob = torsio::Knob::open(path, {.command_timeout_s = 5.0});
  for (int i = 0; i < warm_up + trips; ++i) {
    const double begin = seconds_now();
    knob.disarm();
    if (i >= warm_up) std::printf("%.9f\n", seconds_now() - begin);
  }
}

/// Prints samples read, samples that are missing between them, seconds and CPU seconds.
void telemetry(const char* path, double rate_hz, double duration_s) {
  torsio::Knob knob = torsio::Knob::open(path, {.command_timeout_s = 5.0});
  const double true_rate_hz = knob.start_telemetry(rate_hz);
  const auto step = static_cast<std::uint64_t>(knob.info().control_rate_hz / true_rate_hz + 0.5);
  std::vector<torsio::TelemetrySample> samples(4096);
  std::uint64_t read = 0;
  std::uint64_t missing = 0;
  std::uint64_t next_tick = 0;
  const double cpu_begin = cpu_seconds();
  const double begin = seconds_now();
  while (seconds_now() - begin < duration_s) {
    const std::size_t count = knob.read(samples, 1.0);
    for (std::size_t i = 0; i < count; ++i) {
      if (read++ > 0) missing += (samples[i].tick - next_tick) / step;
      next_tick = samples[i].tick + step;
    }
  }
  std::printf("%llu %llu %.6f %.6f\n", static_cast<unsigned long long>(read),
              static_cast<unsigned long long>(missing), seconds_now() - begin,
              cpu_seconds() - cpu_begin);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fputs(
        "usage: bench_usb trips PATH WARM_UP TRIPS | bench_usb telemetry PATH RATE_HZ SECONDS\n",
        stderr);
    return 2;
  }
  try {
    if (std::strcmp(argv[1], "trips") == 0) {
      trips(argv[2], std::atoi(argv[3]), std::atoi(argv[4]));
    } else {
      telemetry(argv[2], std::atof(argv[3]), std::atof(argv[4]));
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_usb: %s\n", error.what());
    return 1;
  }
  return 0;
}
