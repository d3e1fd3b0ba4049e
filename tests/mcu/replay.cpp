// The same stream of encoder counts and commands on every processor: prints checksums over all that
// the device puts out, which must be the same ones everywhere.
#include <cstdint>
#include <cstring>
#include <new>
#include <span>
#include <string_view>

#include "device/config_store.hpp"
#include "port.hpp"
#include "scenes.hpp"

namespace {

using namespace torsio;
using mcu::Bench;

alignas(Bench) unsigned char room[sizeof(Bench)];

/// xorshift32 (Marsaglia 2003).
struct Random {
  std::uint32_t state = 2463534242U;
  std::uint32_t next() {
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state;
  }
};

class Checksum {
 public:
  void add(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) value_ = (value_ ^ byte) * 16777619U;
  }
  void add(float value) {
    std::uint8_t bytes[4];
    std::memcpy(bytes, &value, sizeof bytes);
    add(bytes);
  }
  std::uint32_t value() const { return value_; }

 private:
  std::uint32_t value_ = 2166136261U;
};

/// Turns the knob at random, in and out of reach of the effects, and gathers every output.
void play(Bench& bench, Random& random, int ticks, Checksum& sum) {
  static std::uint32_t count = 0;
  int speed = 0;
  for (int n = 0; n < ticks; ++n) {
    if (n % 32 == 0) speed = static_cast<int>(random.next() % 21) - 10;
    count += static_cast<std::uint32_t>(speed);
    bench.device().service();
    const device::TickOutputs out = bench.tick(count);
    sum.add(out.motor_command_nm);
    sum.add(out.brake_command_nm);
    protocol::ReportBytes bytes;
    while (bench.device().next_input(bytes)) sum.add(bytes);
  }
}

void line(std::string_view name, const Checksum& sum) {
  for (const char c : name) {
    const char text[2] = {c, 0};
    mcu::print(text);
  }
  mcu::print(" ");
  mcu::print(sum.value());
  mcu::print("\n");
}

template <class Fill>
void run(std::string_view name, protocol::Law law, std::uint16_t active, Fill&& fill) {
  Bench& bench = *new (room) Bench(100'000);
  Random random;
  Checksum sum;
  protocol::ControlConfig config;
  config.law = law;
  config.watchdog_s = 60;
  config.motor_slew_nm_per_s = law == protocol::Law::motor_only ? 20.0F : 0.0F;
  bench.set(config);
  fill(bench);
  bench.send(protocol::Commit{1, 0, active});
  bench.send(protocol::Stream{1, 0, 3});
  bench.command(protocol::Op::arm);
  play(bench, random, 600, sum);
  protocol::LocalModel model{2, 0, 0.01F, 1 << 28, 0.4F, 0.002F, 0.01F};
  (void)bench.device().receive(protocol::encode(model));
  play(bench, random, 200, sum);  // past its deadline: the device fails passive
  line(name, sum);
}

}  // namespace

int main() {
  mcu::for_each_kind([]<class Report>(std::string_view name, const Report& report) {
    run(name, protocol::Law::paper, 1, [&report](Bench& bench) { bench.send(report); });
  });
  unsigned kinds = 0;
  mcu::for_each_kind([&kinds](std::string_view, const auto&) { ++kinds; });
  const auto all = static_cast<std::uint16_t>((1U << kinds) - 1);
  for (std::uint8_t law = 0; law < protocol::Enumerators<protocol::Law>::names.size(); ++law) {
    mcu::print("all, ");
    const std::string_view name = protocol::Enumerators<protocol::Law>::names[law];
    run(name, static_cast<protocol::Law>(law), all, [](Bench& bench) {
      protocol::CurvePoints points;
      points.points = 8;
      for (int i = 0; i < 8; ++i) {
        points.torque_nm[static_cast<unsigned>(i)] = 0.004F * static_cast<float>(i * i % 5 - 2);
      }
      bench.send(points);
      std::uint8_t slot = 0;
      mcu::for_each_kind([&](std::string_view, auto report) {
        report.target.slot = slot++;
        bench.send(report);
      });
    });
  }
}
