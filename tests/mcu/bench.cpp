// How many instructions a tick of the whole device takes, scene by scene; see measure.hpp.
#include <cstdint>
#include <new>
#include <string_view>
#include <utility>

#include "measure.hpp"
#include "scenes.hpp"

namespace {

using namespace torsio;
using mcu::Bench;

alignas(Bench) unsigned char room[sizeof(Bench)];

// Keeps the compiler from leaving out the code that makes the outputs.
volatile float motor_nm;
volatile float brake_nm;
volatile bool enabled;

void measure(std::string_view name, unsigned effects, Bench& bench) {
  mcu::measure(name, effects, [&bench](std::uint32_t count) {
    const device::TickOutputs out = bench.tick(count);
    motor_nm = out.motor_command_nm;
    brake_nm = out.brake_command_nm;
    enabled = out.enabled;
  });
}

/// A device that is armed, with the first so many effects of `fill` in its scene.
template <class Fill>
void run(std::string_view name, unsigned effects, Fill&& fill, float soft_start_s = 0,
         protocol::Law law = protocol::Law::paper) {
  Bench& bench = *new (room) Bench(50'000);
  protocol::ControlConfig config;
  config.law = law;
  config.passive_ramp_s = soft_start_s;
  config.watchdog_s = 60;
  bench.set(config);
  fill(bench);
  bench.send(protocol::Commit{1, 0, static_cast<std::uint16_t>((1U << effects) - 1)});
  bench.command(protocol::Op::arm);
  for (int i = 0; i < 300; ++i) (void)bench.tick(0);
  if (bench.device().state() != protocol::State::armed) mcu::print("not armed\n");
  measure(name, effects, bench);
}

void write_walls(Bench& bench, unsigned walls, float stiffness_nm_per_rad = 0.01F) {
  for (unsigned slot = 0; slot < walls; ++slot) {
    protocol::Wall wall{{1, 0, static_cast<std::uint8_t>(slot)}};
    wall.side = protocol::Side::below;
    wall.angle_turns_q32 = std::int64_t{1} << 30;
    wall.stiffness_nm_per_rad = stiffness_nm_per_rad;
    wall.damping_nm_s_per_rad = 1e-4F;
    bench.send(wall);
  }
}

}  // namespace

int main() {
  {
    Bench& bench = *new (room) Bench(50'000);
    for (int i = 0; i < 10; ++i) (void)bench.tick(0);
    measure("disarmed", 0, bench);
  }
  for (const unsigned effects : {0U, 1U, 2U, 4U, 8U, 16U}) {
    run("walls", effects, [effects](Bench& bench) { write_walls(bench, effects); });
  }
  run("walls, 16 written", 1, [](Bench& bench) { write_walls(bench, 16); });
  run("walls, telemetry", 1, [](Bench& bench) {
    write_walls(bench, 1);
    bench.send(protocol::Stream{1, 0, 40});  // the ring has room for all that is measured
  });
  // Each of these ticks decides anew which effects play.
  run("walls, soft start", 1, [](Bench& bench) { write_walls(bench, 1); }, 1.0F);
  for (const auto& [name, law] :
       {std::pair<std::string_view, protocol::Law>{"walls, calibrated", protocol::Law::calibrated},
        {"walls, compensated", protocol::Law::compensated},
        {"walls, parallel", protocol::Law::parallel},
        {"walls, motor_only", protocol::Law::motor_only}}) {
    run(name, 1, [](Bench& bench) { write_walls(bench, 1); }, 0, law);
  }
  const auto stiff = [](Bench& bench) { write_walls(bench, 1, 300.0F); };
  run("stiff wall, calibrated", 1, stiff, 0, protocol::Law::calibrated);
  mcu::for_each_kind([]<class Report>(std::string_view name, const Report& report) {
    run(name, 1, [&report](Bench& bench) { bench.send(report); });
  });
}
