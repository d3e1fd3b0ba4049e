// Where angle 0 is after a power cycle: by the encoder's index, and by its faults.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <utility>

#include "device/index_watch.hpp"
#include "emulator/emulated_device.hpp"
#include "protocol/registry.hpp"

namespace protocol = torsio::protocol;
using namespace torsio::emulator;
using protocol::Centre;
using protocol::Op;

namespace {

constexpr std::uint32_t kTurnCounts = 1024;

EmulatedDeviceOptions options_with(IndexPulse index, std::uint64_t seed = 0) {
  protocol::ActuatorConfig actuator;
  actuator.counts_per_rev = kTurnCounts;
  actuator.encoder_index_pin = 4;
  protocol::ControlConfig control;
  control.autonomous = protocol::Toggle::on;
  return {.seed = seed,
          .control_period_ns = 100'000,
          .encoder = {.counts_per_rev = kTurnCounts, .index = index},
          .hand = PrescribedMotion{Profile({{0, 0.0}})},
          .given = {.actuator = actuator, .control = control}};
}

/// A knob in a hand that turns it slowly enough for every count to be seen.
struct Turned {
  explicit Turned(IndexPulse index = IndexPulse::works, std::uint64_t seed = 0)
      : device(options_with(index, seed)) {}

  void turn_to(double turns) {
    constexpr double kTurnsPerS = 5.0;
    const std::int64_t begin_ns = device.next_tick_ns();
    const auto lasts_ns = static_cast<std::int64_t>(1e9 * std::abs(turns - at_turns) / kTurnsPerS);
    constexpr double kTurnRad = 2.0 * std::numbers::pi;
    device.set_hand(PrescribedMotion{
        Profile({{begin_ns, at_turns * kTurnRad}, {begin_ns + lasts_ns + 1, turns * kTurnRad}})});
    device.advance(lasts_ns + 2'000'000);
    at_turns = turns;
  }
  void command(Op op) {
    REQUIRE(device.write(protocol::encode(protocol::Command{1, 0, op})));
    device.advance(20'000'000);
  }
  template <class Report>
  Report get() const {
    protocol::ReportBytes bytes;
    REQUIRE(device.get_feature(protocol::Layout<Report>::id, bytes) == protocol::Status::ok);
    Report report{};
    REQUIRE(protocol::decode(bytes, report).ok());
    return report;
  }
  Centre centre() const { return get<protocol::Health>().centre; }
  double position_turns() const {
    return static_cast<double>(get<protocol::Clock>().position_counts) / kTurnCounts;
  }
  /// Makes the place its centre, keeps it, and takes the power away while somebody turns on.
  void keep_centre_at(double turns, double then_turns) {
    turn_to(turns);
    command(Op::zero);
    command(Op::save);
    device.set_powered(false);
    turn_to(then_turns);
    device.set_powered(true);
  }

  EmulatedDevice device;
  double at_turns = 0.0;
};

const doctest::Approx near(double turns) { return doctest::Approx(turns).epsilon(0.0005); }

/// A disc of 1000 counts a turn that is turned from place to place, in half counts.
/// @param begin, end of its pulse, in half counts
torsio::device::IndexWatch watch_disc(int begin, int end, int step,
                                      std::initializer_list<int> places) {
  torsio::device::IndexWatch watch;
  int half = *places.begin();
  for (const int place : places) {
    while (half != place) {
      const int next = half + (place > half ? step : -step);
      watch.told = (next + 2000 - begin) % 2000 < end - begin;
      watch.watch(half / 2, 1000);
      half = next;
    }
  }
  return watch;
}

using Known = torsio::device::IndexWatch::Known;

}  // namespace

TEST_CASE("a pulse has one place, whichever way it is passed and however wide it is") {
  for (const auto& [begin, end] : {std::pair{4, 6}, {5, 7}, {5, 6}, {0, 80}, {101, 148}}) {
    CAPTURE(begin);
    CAPTURE(end);
    const auto up = watch_disc(begin, end, 1, {1000, 5000});
    const auto down = watch_disc(begin, end, 1, {5000, 1000});
    CHECK((up.found() && down.found()));
    CHECK(up.at_counts == down.at_counts + 1000);
    CHECK(std::abs(up.at_counts - 2000 - (begin + end) / 4) <= 1);
  }
}

TEST_CASE("a pulse that is left where it was entered, or passed fast, has no place") {
  CHECK(watch_disc(0, 80, 1, {1900, 2040, 1900, 2040, 1900}).known == Known::nothing);
  CHECK(watch_disc(0, 80, 1, {2100, 2040, 2100, 2040, 2100}).known == Known::nothing);
  CHECK(watch_disc(0, 80, 4, {1900, 5900}).known == Known::nothing);
  CHECK(watch_disc(0, 80, 4, {5900, 1900}).known == Known::nothing);
  // A pulse passed to and fro is not two a turn apart.
  CHECK_FALSE(watch_disc(0, 80, 1, {1900, 2100, 1900, 2100}).found());
  for (const int fast : {1, 2}) {
    torsio::device::IndexWatch watch;
    watch.see(true, fast, 10, 1000);
    watch.see(false, 3 - fast, 12, 1000);
    CHECK(watch.known == Known::nothing);
  }
}

TEST_CASE("two pulses a turn apart settle the place, and two that are two turns apart do not") {
  torsio::device::IndexWatch watch;
  const auto pass = [&](std::int64_t place) {
    watch.see(true, 1, place, 1000);
    watch.see(false, 1, place + 1, 1000);
  };
  pass(10);
  pass(2010);
  CHECK_FALSE(watch.found());
  pass(3010);
  CHECK(watch.found());
  pass(3500);  // a spark
  CHECK(watch.at_counts == 3010);
}

TEST_CASE("the index brings the centre back after a power cycle, whichever way the knob turns") {
  for (const auto& [found_at, expected] : {std::pair{3.5, 1.2}, std::pair{-0.4, -2.7}}) {
    Turned knob;
    CHECK(knob.centre() == Centre::awaits_index);
    knob.turn_to(2.5);
    CHECK(knob.centre() == Centre::index);
    CHECK(knob.position_turns() == near(2.5));  // nothing was kept yet
    knob.keep_centre_at(2.3, 1.9);
    CHECK(knob.centre() == Centre::awaits_index);
    CHECK(knob.position_turns() == 0.0);
    knob.turn_to(found_at);
    CHECK(knob.centre() == Centre::index);
    CHECK(knob.position_turns() == near(expected));
  }
}

TEST_CASE("the centre moves only while nobody has the actuator") {
  Turned knob;
  knob.turn_to(2.5);
  knob.keep_centre_at(2.3, 1.9);
  knob.command(Op::arm);
  knob.turn_to(3.5);
  CHECK(knob.centre() == Centre::index);
  CHECK(knob.position_turns() == near(1.6));
  knob.command(Op::disarm);
  CHECK(knob.position_turns() == near(1.2));
}

TEST_CASE("a zero holds until the next start, and a save without an index keeps the last centre") {
  Turned knob;
  knob.turn_to(2.5);
  knob.keep_centre_at(2.3, 1.9);
  knob.command(Op::zero);
  knob.command(Op::save);
  knob.turn_to(3.5);
  CHECK(knob.position_turns() == near(1.6));
  knob.device.set_powered(false);
  knob.device.set_powered(true);
  knob.turn_to(1.5);
  CHECK(knob.position_turns() == near(1.5 - 2.3 - 1.0));  // by whole turns it is where it was
}

TEST_CASE("another encoder, or one the other way round, has no kept centre") {
  for (const bool reversed : {false, true}) {
    Turned knob;
    knob.turn_to(2.5);
    knob.turn_to(2.3);
    auto actuator = knob.get<protocol::ActuatorConfig>();
    if (reversed) actuator.encoder_reversed = protocol::Toggle::on;
    if (!reversed) actuator.counts_per_rev = 2 * kTurnCounts;
    REQUIRE(knob.device.set_feature(protocol::encode(actuator)).ok());
    knob.device.advance(5'000'000);
    CHECK(knob.centre() == Centre::awaits_index);
  }
}

TEST_CASE("without a pulse, with two in a turn and amid sparks the centre stays where it was") {
  for (const IndexPulse index : {IndexPulse::missing, IndexPulse::doubled, IndexPulse::noisy}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      CAPTURE(static_cast<int>(index));
      CAPTURE(seed);
      Turned knob(index, seed);
      for (const double turns : {3.2, -0.2, 0.2, -1.4, 2.1}) knob.turn_to(turns);
      CHECK(knob.centre() == Centre::awaits_index);
      CHECK(knob.position_turns() == near(2.1));
    }
  }
}

TEST_CASE("a pin with another job is refused to the index, and an index's pin to others") {
  Turned knob;
  auto actuator = knob.get<protocol::ActuatorConfig>();
  for (const int taken : {3, 6, 23}) {  // the encoder's B, the motor, the board itself
    actuator.encoder_index_pin = static_cast<std::uint8_t>(taken);
    const auto verdict = knob.device.set_feature(protocol::encode(actuator));
    CHECK(verdict.status == protocol::Status::inconsistent);
    CHECK(protocol::field_name<protocol::ActuatorConfig>(verdict.field) == "encoder_index_pin");
  }
  auto board = knob.get<protocol::BoardConfig>();
  board.motor_pin = 4;
  const auto verdict = knob.device.set_feature(protocol::encode(board));
  CHECK(protocol::field_name<protocol::BoardConfig>(verdict.field) == "motor_pin");
}

TEST_CASE("of two reports that do not go together the second is refused, though both were taken") {
  Turned knob;
  auto actuator = knob.get<protocol::ActuatorConfig>();
  actuator.encoder_index_pin = 20;
  auto board = knob.get<protocol::BoardConfig>();
  board.light_pin = 20;
  REQUIRE(knob.device.set_feature(protocol::encode(actuator)).ok());
  REQUIRE(knob.device.set_feature(protocol::encode(board)).ok());
  knob.device.advance(5'000'000);
  CHECK(knob.get<protocol::ActuatorConfig>().encoder_index_pin == 20);
  CHECK(knob.get<protocol::BoardConfig>().light_pin != 20);
}
