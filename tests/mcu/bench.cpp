// How many instructions a tick of the whole device takes, scene by scene; see measure.hpp.
#include <cstdint>
#include <new>
#include <string_view>

#include "measure.hpp"
#include "scenes.hpp"

namespace {

using namespace torsio;
using mcu::Bench;

alignas(Bench) unsigned char room[sizeof(Bench)];

void measure(std::string_view name, unsigned effects, Bench& bench) {
  mcu::measure(name, effects, [&bench](std::uint32_t count) { (void)bench.tick(count); });
}

/// A device that is armed, past its soft start, with the effects of `fill` in its scene.
template <class Fill>
void run(std::string_view name, unsigned effects, Fill&& fill) {
  Bench& bench = *new (room) Bench(50'000);
  protocol::ControlConfig config;
  config.passive_ramp_s = 0;
  config.watchdog_s = 60;
  bench.set(config);
  fill(bench);
  bench.send(protocol::Commit{1, 0, static_cast<std::uint16_t>((1U << effects) - 1)});
  bench.command(protocol::Op::arm);
  for (int i = 0; i < 300; ++i) (void)bench.tick(0);
  if (bench.device().state() != protocol::State::armed) mcu::print("not armed\n");
  measure(name, effects, bench);
}

}  // namespace

int main() {
  {
    Bench& bench = *new (room) Bench(50'000);
    for (int i = 0; i < 10; ++i) (void)bench.tick(0);
    measure("disarmed", 0, bench);
  }
  for (const unsigned effects : {0U, 1U, 2U, 4U, 8U, 16U}) {
    run("walls", effects, [effects](Bench& bench) {
      for (unsigned slot = 0; slot < effects; ++slot) {
        protocol::Wall wall{{1, 0, static_cast<std::uint8_t>(slot)}};
        wall.side = protocol::Side::below;
        wall.angle_turns_q32 = std::int64_t{1} << 30;
        wall.stiffness_nm_per_rad = 0.01F;
        wall.damping_nm_s_per_rad = 1e-4F;
        bench.send(wall);
      }
    });
  }
  mcu::for_each_kind([]<class Report>(std::string_view name, const Report& report) {
    run(name, 1, [&report](Bench& bench) { bench.send(report); });
  });
}
