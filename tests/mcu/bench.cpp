// Prints how many instructions a tick takes: `NAME EFFECTS INSTRUCTIONS`, the latter a hundred
// times too large so that it has two decimals.
#include <cstdint>
#include <new>
#include <string_view>

#include "port.hpp"
#include "scenes.hpp"

namespace {

using namespace torsio;
using mcu::Bench;

constexpr std::uint32_t kTicks = 2000;

alignas(Bench) unsigned char room[sizeof(Bench)];

void line(std::string_view name, unsigned effects, std::uint32_t instructions) {
  for (const char c : name) {
    const char text[2] = {c, 0};
    mcu::print(text);
  }
  mcu::print(" ");
  mcu::print(effects);
  mcu::print(" ");
  mcu::print(instructions);
  mcu::print("\n");
}

/// Instructions for a tick, times 100, with the knob moving to and fro inside the scene.
std::uint32_t measure(Bench& bench) {
  std::uint32_t count = 0;
  const std::uint32_t start = mcu::instructions();
  for (std::uint32_t n = 0; n < kTicks; ++n) {
    count += (n & 64U) != 0 ? 1U : 0xFFFFFFFFU;
    (void)bench.tick(count);
  }
  return (mcu::instructions() - start) / (kTicks / 100);
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
  line(name, effects, measure(bench));
}

}  // namespace

int main() {
  {
    Bench& bench = *new (room) Bench(50'000);
    for (int i = 0; i < 10; ++i) (void)bench.tick(0);
    line("disarmed", 0, measure(bench));
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
