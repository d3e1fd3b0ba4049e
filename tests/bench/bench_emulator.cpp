// The cost of emulation in CPU time of one core; prints one JSON object a line.
//
//   device   the whole emulated device in closed loop, the host's end of the cable included
//   part     each part of it alone, fed with what it was fed there
//   loop     plant, encoder and law alone, where each waits for the other as in the device
//   plant    the plant alone, with and without parts that a scene may name
//
// Measurements take turns over the repeats, and the least of each counts: what else the machine
// does only ever adds.

#include <time.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "device/device.hpp"
#include "emulator/closed_loop.hpp"
#include "emulator/emulated_device.hpp"
#include "protocol/axis_samples.hpp"
#include "protocol/registry.hpp"

namespace {

namespace device = torsio::device;
namespace protocol = torsio::protocol;
using namespace torsio::emulator;
using protocol::ReportBytes;

constexpr protocol::Wall kWall{.target = {1, 0, 0}, .stiffness_nm_per_rad = 1.432F};

double cpu_ns() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

volatile double g_sink = 0.0;  // keeps results from being optimised away

/// A hand that pushes into a wall and comes out, again and again.
Hand busy_hand(double seconds) {
  std::vector<ProfileKnot> knots;
  for (std::int64_t i = 0; i <= static_cast<std::int64_t>(seconds); ++i) {
    knots.push_back({i * 1'000'000'000, i % 2 == 0 ? 0.0 : 0.18});
  }
  return ImpedanceHand{1e-4, 1.0, 10e-3, Profile(std::move(knots))};
}

template <class Report>
void send(EmulatedDevice& device, const Report& report) {
  if (!device.write(protocol::encode(report))) std::abort();
}

std::unique_ptr<EmulatedDevice> make_device(std::int64_t period_ns, double seconds) {
  protocol::ControlConfig control;
  control.autonomous = protocol::Toggle::on;  // this host sends nothing while it measures
  auto device =
      std::make_unique<EmulatedDevice>(EmulatedDeviceOptions{.control_period_ns = period_ns,
                                                             .hand = busy_hand(seconds + 1.0),
                                                             .given = {.control = control}});
  send(*device, kWall);
  send(*device, protocol::Commit{2, 0, 1});
  send(*device, protocol::Command{3, 0, protocol::Op::arm});
  // Telemetry at 1 kHz whatever the control rate.
  send(*device,
       protocol::Stream{
           4, 0, static_cast<std::uint8_t>(std::max<std::int64_t>(1, 1'000'000 / period_ns))});
  device->advance(50'000'000);
  return device;
}

/// Reads and decodes what has arrived.
std::uint64_t drain(EmulatedDevice& device) {
  std::uint64_t samples = 0;
  ReportBytes bytes;
  while (device.read(bytes)) {
    protocol::Telemetry telemetry;
    if (protocol::decode(bytes, telemetry).ok())
      samples += protocol::samples_of(telemetry.axis_samples);
  }
  return samples;
}

/// Inputs and outputs of the device's firmware in a closed loop.
struct Recording {
  std::vector<Command> commands;
  std::vector<Angle> angles;
  std::vector<std::uint32_t> counts;
};

Recording record(std::int64_t period_ns, double seconds) {
  const auto device = make_device(period_ns, seconds);
  Encoder encoder;
  Recording recording;
  const auto ticks = static_cast<std::int64_t>(seconds * 1e9) / period_ns;
  for (std::int64_t i = 0; i < ticks; ++i) {
    recording.angles.push_back(device->plant().state().knob_angle);
    recording.counts.push_back(encoder.sample(recording.angles.back()));
    device->advance(period_ns);
    recording.commands.push_back(device->plant().command());
    drain(*device);
  }
  return recording;
}

struct Measurement {
  std::string json;  // keys that say what it is
  std::int64_t ticks;
  std::int64_t period_ns;
  std::function<double()> run;  // CPU time, ns
  double best_ns = std::numeric_limits<double>::infinity();
};

double run_device(std::int64_t period_ns, double seconds) {
  const auto device = make_device(period_ns, seconds);
  std::uint64_t samples = 0;
  const double begin = cpu_ns();
  for (double done_s = 0.0; done_s < seconds; done_s += 0.016) {
    device->advance(16'000'000);
    samples += drain(*device);
  }
  const double took = cpu_ns() - begin;
  if (samples < static_cast<std::uint64_t>(900.0 * seconds)) std::abort();
  return took;
}

double run_loop(std::int64_t period_ns, double seconds) {
  ClosedLoop loop(
      {.control_period_ns = period_ns, .hand = busy_hand(seconds + 1.0), .scene = {kWall}});
  loop.run(50'000'000 / static_cast<std::uint64_t>(period_ns), {});  // as long as to make a device
  const double begin = cpu_ns();
  loop.run(static_cast<std::uint64_t>(seconds * 1e9) / static_cast<std::uint64_t>(period_ns), {});
  const double took = cpu_ns() - begin;
  g_sink = g_sink + loop.plant().state().knob_angle_rad();
  return took;
}

double run_plant(Plant& plant, const std::vector<Command>& commands, std::int64_t period_ns) {
  plant.set_command({});
  plant.set_state({});
  const double begin = cpu_ns();
  for (const Command& command : commands) {
    plant.set_command(command);
    plant.advance(period_ns);
  }
  const double took = cpu_ns() - begin;
  g_sink = g_sink + plant.state().knob_angle_rad();
  return took;
}

double run_encoder(const std::vector<Angle>& angles) {
  Encoder encoder;
  std::uint32_t sum = 0;
  const double begin = cpu_ns();
  for (const Angle& angle : angles) sum += encoder.sample(angle);
  const double took = cpu_ns() - begin;
  g_sink = g_sink + sum;
  return took;
}

/// The firmware alone: the control loop, or the main loop too.
double run_firmware(const std::vector<std::uint32_t>& counts, std::int64_t period_ns,
                    bool main_loop) {
  device::BoardInfo board;
  board.control_period_ns = static_cast<std::uint32_t>(period_ns);
  device::Device device(board, device::empty_slots());
  device.set_connected(true);
  protocol::ControlConfig control;
  control.autonomous = protocol::Toggle::on;
  (void)device.set_feature(protocol::encode(control));
  device.service();
  (void)device.tick({});
  const auto give = [&](const auto& report) {
    if (!device.receive(protocol::encode(report))) std::abort();
    device.service();
    (void)device.tick({.encoder_count = counts.front()});
  };
  give(kWall);
  give(protocol::Commit{2, 0, 1});
  give(protocol::Command{3, 0, protocol::Op::arm});
  if (main_loop) {
    give(protocol::Stream{
        4, 0, static_cast<std::uint8_t>(std::max<std::int64_t>(1, 1'000'000 / period_ns))});
  }
  const std::int64_t ticks_per_frame = 1'000'000 / period_ns;
  ReportBytes bytes{};
  double sum = 0.0;
  const double begin = cpu_ns();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (main_loop) {
      device.service();
      if (static_cast<std::int64_t>(i) % ticks_per_frame == 0) (void)device.next_input(bytes);
    }
    sum += static_cast<double>(device.tick({.encoder_count = counts[i]}).motor_command_nm);
  }
  const double took = cpu_ns() - begin;
  g_sink = g_sink + sum;
  return took;
}

/// Numbers that the plant carries from step to step.
int states(const PlantParams& params) {
  const int shafts = !params.spring_and_brake ? 1 : params.belt ? 3 : 2;
  const int lags = (params.motor_time_constant_s > 0.0 ? 1 : 0) +
                   (shafts > 1 && params.brake_time_constant_s > 0.0 ? 1 : 0);
  return 1 + shafts + (shafts - 1) + lags + (params.brake_hysteresis ? 1 : 0);
}

std::string text(const char* kind, const char* name, const std::string& more = "") {
  return std::string("\"kind\": \"") + kind + "\", \"name\": \"" + name + "\"" + more;
}

}  // namespace

int main(int count, char** arguments) {
  const double seconds = count > 1 ? std::atof(arguments[1]) : 8.0;
  const int repeats = count > 2 ? std::atoi(arguments[2]) : 7;

  std::vector<Measurement> measurements;
  std::vector<std::shared_ptr<void>> kept;
  const auto keep_plant = [&](const PlantParams& params, std::int64_t step_ns) {
    auto plant = std::make_shared<Plant>(params, busy_hand(seconds + 1.0), step_ns);
    kept.push_back(plant);
    return plant;
  };

  for (const std::int64_t period_ns : {1'000'000, 100'000}) {
    auto recording = std::make_shared<Recording>(record(period_ns, seconds));
    kept.push_back(recording);
    const auto ticks = static_cast<std::int64_t>(recording->commands.size());
    const auto add = [&](std::string json, std::function<double()> run) {
      measurements.push_back({std::move(json), ticks, period_ns, std::move(run)});
    };
    add(text("device", "all"), [=] { return run_device(period_ns, seconds); });
    add(text("loop", "plant_and_law"), [=] { return run_loop(period_ns, seconds); });
    add(text("part", "control"), [=] { return run_firmware(recording->counts, period_ns, false); });
    add(text("part", "control_and_protocol"),
        [=] { return run_firmware(recording->counts, period_ns, true); });
    add(text("part", "encoder"), [=] { return run_encoder(recording->angles); });

    const PlantParams basis;
    {
      const auto plant = keep_plant(basis, period_ns);
      add(text("part", "plant"), [=] { return run_plant(*plant, recording->commands, period_ns); });
    }
    const auto add_plant = [&](const char* name, const std::function<void(PlantParams&)>& change) {
      PlantParams params = basis;
      change(params);
      const auto plant = keep_plant(params, period_ns);
      add(text("plant", name, ", \"states\": " + std::to_string(states(params))),
          [=] { return run_plant(*plant, recording->commands, period_ns); });
    };
    add_plant("without_spring_and_brake", [](PlantParams& p) { p.spring_and_brake = false; });
    add_plant("basis", [](PlantParams&) {});
    add_plant("brake_hysteresis", [](PlantParams& p) { p.brake_hysteresis = BrakeHysteresis{}; });
    add_plant("shaft_hardening", [](PlantParams& p) { p.shaft_hardening = ShaftHardening{}; });
    add_plant("cogging", [](PlantParams& p) { p.cogging = sine_cogging(12, 2e-3); });
    add_plant("belt", [](PlantParams& p) { p.belt = Belt{}; });
    add_plant("all_parts", [](PlantParams& p) {
      p.brake_hysteresis = BrakeHysteresis{};
      p.shaft_hardening = ShaftHardening{};
      p.cogging = sine_cogging(12, 2e-3);
      p.belt = Belt{};
    });
  }

  for (int i = 0; i < repeats; ++i) {
    for (Measurement& each : measurements) each.best_ns = std::min(each.best_ns, each.run());
  }
  for (const Measurement& each : measurements) {
    const double per_tick = each.best_ns / static_cast<double>(each.ticks);
    std::printf("{%s, \"control_rate_hz\": %g, \"ns_per_tick\": %.1f, \"realtime_factor\": %.0f}\n",
                each.json.c_str(), 1e9 / static_cast<double>(each.period_ns), per_tick,
                static_cast<double>(each.period_ns) / per_tick);
  }
}
