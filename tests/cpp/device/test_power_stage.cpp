// The boards' power stage on a fake chip: its promises for any order and any measurement.
// tests/board runs the real binary.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "boards/rp2/power_stage.cpp"

using torsio::boards::PowerStage;
using torsio::device::PowerBoard;
using torsio::device::TickOutputs;
using torsio::protocol::BoardConfig;
using torsio::protocol::Toggle;

namespace {

constexpr std::uint16_t kHalfPeriod = 150'000'000 / 40'000 / 2;  // steps of a PWM period

struct StageBench {
  explicit StageBench(BoardConfig of = {}, PowerBoard on = {50'000, 50'000, false},
                      int readings = 300)
      : config(of), board(on), zero_steps(1000) {
    fake::chip = {};
    stage.emplace(config, board, 20e-3F);
    measure(0.0);
    apply({}, readings);
  }
  /// The current sensor's reading.
  void measure(double amperes) {
    const double steps = amperes * static_cast<double>(config.current_sense_v_per_a) / 3.3 * 4096;
    fake::adc.result = static_cast<std::uint32_t>(std::lround(zero_steps + steps));
  }
  void apply(const TickOutputs& outputs, int ticks = 1) {
    for (; ticks > 0; --ticks) {
      stage->begin();
      stage->apply(outputs);
    }
  }
  /// Share of the supply on the motor, with its sign.
  double motor() const {
    const auto& [a, b] = fake::chip.pwm[pwm_gpio_to_slice_num(config.motor_pin)];
    return (static_cast<double>(b) - static_cast<double>(a)) / kHalfPeriod;
  }
  double brake() const {
    const auto& [a, b] = fake::chip.pwm[pwm_gpio_to_slice_num(config.brake_pin)];
    return (static_cast<double>(b) - static_cast<double>(a)) / kHalfPeriod;
  }
  bool lets_go(std::uint8_t pin) const {
    return fake::chip.pwm[pwm_gpio_to_slice_num(pin)] ==
           std::array<std::uint16_t, 2>{kHalfPeriod, kHalfPeriod};
  }
  bool enabled() const { return gpio_get(config.enable_pin); }

  BoardConfig config;
  PowerBoard board;
  std::optional<PowerStage> stage;
  double zero_steps;
};

TickOutputs on(float motor_nm, float brake_nm = 0.0F) { return {motor_nm, brake_nm, true}; }

}  // namespace

TEST_CASE("a power stage starts with everything off, and is on only while it is told so") {
  StageBench bench;
  CHECK_FALSE(bench.enabled());
  CHECK(bench.lets_go(bench.config.motor_pin));
  CHECK(bench.lets_go(bench.config.brake_pin));
  bench.apply(on(0.02F, 0.05F));
  CHECK(bench.enabled());
  CHECK(bench.motor() > 0.0);
  CHECK(bench.brake() > 0.0);
  bench.apply({0.02F, 0.05F, false});
  CHECK_FALSE(bench.enabled());
  CHECK(bench.lets_go(bench.config.motor_pin));
  CHECK(bench.lets_go(bench.config.brake_pin));
}

TEST_CASE("the motor is never asked for more than its current, either way") {
  BoardConfig config;
  config.motor_current_max_a = 1.0F;
  for (const float sign : {1.0F, -1.0F}) {
    StageBench bench(config);
    // At the limit only the unknown resistance of the winding matters.
    bench.measure(static_cast<double>(sign));
    bench.apply(on(sign * 100.0F));
    CHECK(std::abs(bench.motor()) < 0.02);
    bench.measure(1.2 * static_cast<double>(sign));
    bench.apply(on(sign * 100.0F));
    CHECK(bench.motor() * static_cast<double>(sign) < 0.0);  // too much: back
  }
}

TEST_CASE("the sign of the torque is the sign of the voltage, and turns with a reversed motor") {
  for (const bool reversed : {false, true}) {
    for (const double sign : {1.0, -1.0}) {
      BoardConfig config;
      config.motor_reversed = reversed ? Toggle::on : Toggle::off;
      StageBench bench(config);
      bench.apply(on(static_cast<float>(sign) * 0.02F));
      CHECK(bench.motor() * sign * (reversed ? -1.0 : 1.0) > 0.0);
      // The measured current counts from the same side.
      const double wanted =
          sign * 0.02 / static_cast<double>(config.motor_torque_constant_nm_per_a);
      StageBench settled(config);
      settled.measure(reversed ? -wanted : wanted);
      settled.apply(on(static_cast<float>(sign) * 0.02F));
      CHECK(std::abs(settled.motor()) < 0.02);
    }
  }
}

TEST_CASE("the brake's coil never gets more than its current, nor more than the supply") {
  BoardConfig config;
  config.brake_current_max_a = 0.1F;
  StageBench bench(config);
  bench.apply(on(0.0F, 100.0F));
  const double share =
      0.1 * static_cast<double>(config.brake_resistance_ohm) / static_cast<double>(config.supply_v);
  REQUIRE(share < 1.0);
  CHECK(bench.brake() == doctest::Approx(share).scale(0).epsilon(0.01));
  config.brake_current_max_a = 100.0F;
  StageBench full(config);
  full.apply(on(0.0F, 100.0F));
  CHECK(full.brake() == 1.0);
}

TEST_CASE("the brake's coil gets the current of the torque that is asked for") {
  StageBench bench;
  for (const double torque_nm : {0.0, 0.01, 0.02, 0.04}) {
    bench.apply(on(0.0F, static_cast<float>(torque_nm)));
    const double amperes =
        torque_nm / static_cast<double>(bench.config.brake_torque_constant_nm_per_a);
    const double share = amperes * static_cast<double>(bench.config.brake_resistance_ohm) /
                         static_cast<double>(bench.config.supply_v);
    CHECK(bench.brake() == doctest::Approx(share).scale(0.01).epsilon(0.01));
  }
}

TEST_CASE("a current of more than one and a half times the limit is a fault after three ticks") {
  BoardConfig config;
  config.motor_current_max_a = 2.0F;
  for (const double sign : {1.0, -1.0}) {
    StageBench bench(config, {50'000, 50'000, false}, 1);
    bench.zero_steps = 2000;
    bench.measure(0.0);
    bench.apply({}, 20000);  // learns where zero is
    bench.measure(2.9 * sign);
    bench.apply(on(0.0F), 50);
    CHECK(bench.stage->find_faults() == 0);
    bench.measure(3.1 * sign);
    bench.apply(on(0.0F), 2);
    CHECK(bench.stage->find_faults() == 0);  // noise
    bench.measure(0.0);
    bench.apply(on(0.0F));
    bench.measure(3.1 * sign);
    bench.apply(on(0.0F), 2);
    CHECK(bench.stage->find_faults() == 0);  // counts from the beginning
    bench.apply(on(0.0F));
    CHECK(bench.stage->find_faults() == torsio::protocol::fault::actuator);
    bench.apply(on(0.0F), 300);
    CHECK((bench.stage->find_faults() & torsio::protocol::fault::actuator) !=
          0);  // and goes on counting as one
    bench.measure(0.0);
    bench.apply({});
    CHECK(bench.stage->find_faults() == 0);
  }
}

TEST_CASE("a bridge that reports an error is a fault as long as it does") {
  StageBench bench;
  CHECK(bench.stage->find_faults() == 0);
  gpio_put(bench.config.driver_fault_pin, false);
  CHECK(bench.stage->find_faults() == torsio::protocol::fault::actuator);
  gpio_put(bench.config.driver_fault_pin, true);
  CHECK(bench.stage->find_faults() == 0);
}

TEST_CASE("where zero is, is learned only while the motor has no power") {
  StageBench bench;
  bench.measure(1.0);
  bench.apply(on(0.0F), 3000);
  // Still taken for a current: the loop works against it.
  CHECK(bench.motor() < 0.0);
}

TEST_CASE("the interrupt comes 1 us before the middle of the pulse, where the current is read") {
  StageBench bench;
  bench.stage->start(nullptr);
  const std::size_t step_unit = 0;  // the first that is free
  for (std::size_t unit = 0; unit < fake::chip.counter.size(); ++unit)
    CHECK(fake::chip.counter[unit] == (unit == step_unit ? 150 : 0));
}

TEST_CASE("where zero is, is the mean of the readings before") {
  StageBench bench({}, {50'000, 50'000, false}, 0);
  for (int i = 0; i < 64; ++i) {
    bench.measure(i % 2 == 0 ? 0.02 : -0.02);
    bench.apply({});
  }
  bench.measure(0.0);
  bench.apply(on(0.0F));
  CHECK(std::abs(bench.motor()) < 1e-3);
}

TEST_CASE("where zero is, is learned again once the power has gone") {
  StageBench bench;
  bench.apply(on(0.05F), 10);
  bench.measure(0.2);  // the sensor has drifted
  bench.apply({}, 20000);
  bench.apply(on(0.0F));
  CHECK(std::abs(bench.motor()) < 1e-3);
}

TEST_CASE("what the current loop has wound up is forgotten when the power goes") {
  StageBench bench;
  bench.measure(0.0);
  bench.apply(on(0.05F), 2000);
  const double wound_up = bench.motor();
  bench.apply({});
  bench.apply(on(0.05F));
  const double fresh = bench.motor();
  StageBench other;
  other.apply(on(0.05F));
  CHECK(fresh == other.motor());
  CHECK(wound_up >= fresh);
  bench.apply({});
  bench.apply(on(0.0F));
  CHECK(std::abs(bench.motor()) < 1e-3);
}

TEST_CASE("the supply is measured between two measurements of the current") {
  namespace fault = torsio::protocol::fault;
  BoardConfig config;
  config.supply_sense_pin = 27;
  config.current_sense_pin = 28;
  StageBench bench(config, {100'000, 100'000, false}, 1);
  fake::adc.started.clear();
  const auto run = [&](int steps, double supply_v) {
    for (int i = 0; i < steps; ++i) {
      // The last conversion's result.
      if (fake::adc.input == 1)
        fake::adc.result = static_cast<std::uint32_t>(supply_v / 11 / 3.3 * 4096);
      bench.stage->begin();
      REQUIRE(fake::adc.input == 2);
      bench.measure(0.0);
      bench.stage->apply({});
    }
  };
  run(100, 12.0);
  CHECK(std::ranges::count(fake::adc.started, 2U) == 100);
  CHECK(std::ranges::count(fake::adc.started, 1U) == 20);
  CHECK(bench.stage->find_faults() == 0);
  run(16, 24.0);
  CHECK(bench.stage->find_faults() == fault::supply);
  run(1100, 12.0);  // it must stay for a while
  CHECK(bench.stage->find_faults() == 0);
}

TEST_CASE("cutting the power needs no object and takes the pins from the PWM") {
  StageBench bench;
  bench.apply(on(0.05F, 0.05F));
  torsio::boards::cut_power();
  CHECK_FALSE(bench.enabled());
  for (const unsigned pin : {0U, 1U}) {
    CHECK_FALSE(gpio_get(bench.config.motor_pin + pin));
    CHECK_FALSE(gpio_get(bench.config.brake_pin + pin));
    CHECK(fake::chip.function[bench.config.motor_pin + pin] == GPIO_FUNC_SIO);
    CHECK(fake::chip.function[bench.config.brake_pin + pin] == GPIO_FUNC_SIO);
  }
}

TEST_CASE("two power stages have parts of their own, start together and go off together") {
  StageBench first;
  BoardConfig config;
  config.motor_pin = 14;
  config.brake_pin = 18;
  config.enable_pin = 20;
  config.driver_fault_pin = 21;
  config.current_sense_pin = 28;
  PowerStage second(config, first.board, 20e-3F);
  CHECK(fake::chip.function[first.config.motor_pin] == GPIO_FUNC_PWM);
  CHECK(fake::chip.function[first.config.brake_pin] == GPIO_FUNC_PWM);
  first.stage->start(nullptr);
  constexpr std::uint32_t kBridges = 1U << 3 | 1U << 4 | 1U << 7 | 1U << 1;  // of 6, 8, 14 and 18
  CHECK((fake::chip.running & kBridges) == kBridges);
  CHECK(fake::chip.running != kBridges);  // and one for the steps
  second.begin();
  CHECK(fake::adc.input == 2);
  second.apply(on(0.05F, 0.05F));
  CHECK_FALSE(first.enabled());
  first.stage->begin();
  CHECK(fake::adc.input == 0);
  first.stage->apply(on(0.05F, 0.05F));
  torsio::boards::cut_power();
  for (const BoardConfig& its : {first.config, config}) {
    CHECK_FALSE(gpio_get(its.enable_pin));
    CHECK(fake::chip.function[its.motor_pin] == GPIO_FUNC_SIO);
    CHECK(fake::chip.function[its.brake_pin] == GPIO_FUNC_SIO);
  }
}

TEST_CASE("a board that predicts has the same signs, limits and memory") {
  const PowerBoard fast{25'000, 25'000, true};
  for (const double sign : {1.0, -1.0}) {
    for (const bool reversed : {false, true}) {
      BoardConfig config;
      config.motor_reversed = reversed ? Toggle::on : Toggle::off;
      config.motor_current_max_a = 1.0F;
      StageBench bench(config, fast);
      bench.apply(on(static_cast<float>(sign) * 0.005F));
      const double first = bench.motor();
      CHECK(first * sign * (reversed ? -1.0 : 1.0) > 0.0);
      bench.apply(on(static_cast<float>(sign) * 0.005F), 500);
      bench.apply({});
      bench.apply(on(static_cast<float>(sign) * 0.005F));
      CHECK(bench.motor() == first);
      // A current that flows already is not taken for one that was not expected.
      StageBench flowing(config, fast);
      flowing.measure((reversed ? -0.2 : 0.2) * sign);
      flowing.apply(on(static_cast<float>(sign) * 0.01F));
      CHECK(flowing.motor() * sign * (reversed ? -1.0 : 1.0) > 0.0);
      // A winding at its limit gets the voltage of its resistance, 2.5 V of 12.
      StageBench limited(config, fast);
      limited.measure((reversed ? -1.0 : 1.0) * sign);
      limited.apply(on(static_cast<float>(sign) * 100.0F));
      limited.stage->begin();
      CHECK(limited.motor() * sign * (reversed ? -1.0 : 1.0) < 0.5);
      limited.measure((reversed ? -1.3 : 1.3) * sign);
      limited.apply(on(static_cast<float>(sign) * 100.0F));
      CHECK(limited.motor() * sign * (reversed ? -1.0 : 1.0) < 0.0);
    }
  }
}

TEST_CASE("between two ticks the current loop goes on with what the last one wanted") {
  StageBench bench(BoardConfig{}, {25'000, 25'000, true});
  bench.apply(on(0.02F));
  const double first = bench.motor();
  bench.measure(0.6);
  bench.stage->begin();
  bench.stage->apply();
  CHECK(bench.enabled());
  CHECK(bench.motor() < first);
  bench.apply({});
  bench.stage->begin();
  bench.stage->apply();
  CHECK_FALSE(bench.enabled());
}

TEST_CASE("a coil whose inductance is known is driven both ways, within its current") {
  BoardConfig config;
  config.brake_inductance_h = 2.4F;
  config.brake_current_max_a = 0.1F;
  StageBench bench(config);
  bench.apply(on(0.0F, 100.0F));
  CHECK(bench.brake() > 0.1 * 40 / 12);  // on its way there
  bench.apply(on(0.0F, 100.0F), 40'000);
  CHECK(bench.brake() == doctest::Approx(0.1 * 40 / 12).scale(0).epsilon(0.01));
  bench.apply(on(0.0F, 0.0F));
  CHECK(bench.brake() < 0.1 * 40 / 12);
  config.brake_inductance_h = 24.0F;  // slower than it shall be
  StageBench slow(config);
  slow.apply(on(0.0F, 100.0F), 40'000);
  slow.apply(on(0.0F, 0.0F));
  CHECK(slow.brake() < 0.0);
  slow.apply(on(0.0F, 0.0F), 40'000);
  CHECK(slow.brake() == doctest::Approx(0.0));
}

TEST_CASE("what a coil still has when the power comes back is not forgotten") {
  BoardConfig config;
  config.brake_inductance_h = 2.4F;
  StageBench bench(config);
  const auto again = [&](int ticks_off) {
    bench.apply(on(0.0F, 0.1F), 10'000);
    bench.apply({}, ticks_off);
    bench.apply(on(0.0F, 0.0F));
    return bench.brake();
  };
  // 0.1 / 0.44 A runs back in L/R ln(1 + 0.227 / 0.3) = 33.8 ms.
  CHECK(again(600) < -0.05);  // 30 ms
  CHECK(again(700) == 0.0);   // 35 ms
}
