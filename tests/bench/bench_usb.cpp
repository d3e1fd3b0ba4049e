// The SDK's half of the USB benchmark, against a knob that is plugged in; bench_usb.py runs it.
#include <sys/resource.h>

#include <chrono>
#include <cmath>
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

/// Seconds of this computer's clock less the device's, and the uncertainty. The device tells the
/// time of its last tick. The answer that came back soonest after its tick counts.
struct ClockOffset {
  double seconds = 0;
  double error_s = 0;
};
ClockOffset offset_of(torsio::Knob& knob) {
  ClockOffset best{1e18, 0.0};
  for (int i = 0; i < 50; ++i) {
    const double before = seconds_now();
    const double device_s = knob.clock().time_s;
    const double error_s = 0.5 * (seconds_now() - before);
    const ClockOffset found{before + error_s - device_s, error_s};
    if (found.seconds + found.error_s < best.seconds + best.error_s) best = found;
  }
  return best;
}

/// Prints how far off the ages may be and how many steps were late, then how old the newest sample
/// is in each step of a loop, in seconds.
void loop(const char* path, double rate_hz, double period_s, std::uint64_t steps) {
  torsio::Knob knob = torsio::Knob::open(path, {.command_timeout_s = 5.0});
  knob.start_telemetry(rate_hz, true);
  (void)knob.latest();
  const ClockOffset first = offset_of(knob);
  std::vector<double> ages;
  std::uint64_t late_steps = 0;
  for (const torsio::Step step : knob.every(period_s)) {
    const double newest_s = knob.latest().time_s;
    ages.push_back(seconds_now() - first.seconds - newest_s);
    late_steps = step.late_steps;
    if (ages.size() == steps) break;
  }
  const ClockOffset last = offset_of(knob);
  std::printf("%.9f\n%llu\n", first.error_s + std::abs(last.seconds - first.seconds),
              static_cast<unsigned long long>(late_steps));
  for (const double age_s : ages) std::printf("%.9f\n", age_s);
}

}  // namespace

int main(int argc, char** argv) {
  const bool is_loop = argc > 1 && std::strcmp(argv[1], "loop") == 0;
  if (argc != (is_loop ? 6 : 5)) {
    std::fputs(
        "usage: bench_usb trips PATH WARM_UP TRIPS | bench_usb telemetry PATH RATE_HZ SECONDS | "
        "bench_usb loop PATH RATE_HZ PERIOD_S STEPS\n",
        stderr);
    return 2;
  }
  try {
    if (std::strcmp(argv[1], "trips") == 0) {
      trips(argv[2], std::atoi(argv[3]), std::atoi(argv[4]));
    } else if (is_loop) {
      loop(argv[2], std::atof(argv[3]), std::atof(argv[4]), std::strtoull(argv[5], nullptr, 10));
    } else {
      telemetry(argv[2], std::atof(argv[3]), std::atof(argv[4]));
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_usb: %s\n", error.what());
    return 1;
  }
  return 0;
}
