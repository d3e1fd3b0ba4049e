// Telemetry and time: complete, exact, repeatable, and the same however calls cut the time.
#include <doctest/doctest.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "protocol/axis_samples.hpp"
#include "sample_ring.hpp"
#include "sdk/errors.hpp"
#include "sdk/wrapped_transport.hpp"
#include "telemetry_decoder.hpp"
#include "torsio/knob.hpp"

using namespace torsio;
using test::contains;
using test::message_of;

namespace {

OpenOptions turning(double rate_hz = 1000.0) {
  OpenOptions options{.emulator = EmulatorOptions{}};
  options.emulator->control_rate_hz = rate_hz;
  options.emulator->hand = PrescribedMotion{{{0.0, 0.0}, {1000.0, 1000.0}}};  // 1 rad/s
  return options;
}

/// Has the first report of a stream reach back by a sample.
class Straddling final : public test::WrappedTransport {
 public:
  /// @param begin_tick gets when the stream began, as the device acknowledges it
  Straddling(std::unique_ptr<Transport> inner, std::uint64_t& begin_tick)
      : WrappedTransport(std::move(inner)), begin_tick_(begin_tick) {}
  bool read(ReportBytes& bytes, std::chrono::nanoseconds timeout) override {
    if (!WrappedTransport::read(bytes, timeout)) return false;
    protocol::Acknowledgement answer;
    protocol::Telemetry report;
    if (protocol::decode(bytes, answer).ok()) {
      if (answer.report == protocol::Layout<protocol::Stream>::id) begin_tick_ = answer.tick;
    } else if (protocol::decode(bytes, report).ok() && std::exchange(is_first_, false)) {
      report.tick = begin_tick_ - 1;
      bytes = protocol::encode(report);
    }
    return true;
  }

 private:
  std::uint64_t& begin_tick_;
  bool is_first_ = true;
};

std::vector<TelemetrySample> wall_in_pieces(std::uint64_t seed, double piece_s) {
  OpenOptions options{.emulator = EmulatorOptions{}};
  options.emulator->seed = seed;
  options.emulator->control_rate_hz = 10e3;
  options.emulator->hand = TorqueHand{{{0.0, 0.0}, {0.5, 0.07}, {1.0, 0.0}}};
  Knob knob = Knob::open("emulated", options);
  knob.emulator().set_link_faults({.drop_input = seed == 0 ? 0.0 : 0.01});
  knob.arm();
  knob.play(Wall{.angle_rad = 0.02, .stiffness_nm_per_rad = 1.4});
  knob.start_telemetry();
  for (double left_s = 1.0; left_s > 1e-9; left_s -= piece_s) {
    knob.sleep(std::min(piece_s, left_s));
  }
  return knob.read(100'000, 0.0);
}

}  // namespace

TEST_CASE("record returns every tick of its span, in order, with time and angle that fit") {
  Knob knob = Knob::open("emulated", turning());
  const std::vector<TelemetrySample> log = knob.record(1.0);
  REQUIRE(log.size() == 1000);
  CHECK(knob.statistics().samples_lost == 0);
  for (std::size_t i = 0; i < log.size(); ++i) {
    CHECK(log[i].tick == log[0].tick + i);
    CHECK(log[i].time_s == doctest::Approx(1e-3 * static_cast<double>(log[i].tick)));
    // The encoder floors: the angle trails the true one by less than a count.
    CHECK(log[i].angle_rad <= log[i].time_s + 1e-9);
    CHECK(log[i].angle_rad > log[i].time_s - 2 * std::numbers::pi / 8192 - 1e-9);
  }
}

TEST_CASE("a recording of more samples than memory holds is InvalidArgument at every rate") {
  Knob knob = Knob::open("emulated");
  const std::uint64_t sent = knob.statistics().reports_sent;
  const std::string message = message_of<InvalidArgument>([&] { (void)knob.record(1e9); });
  CHECK(contains(message, "duration_s is 1e+09, allowed are 0 to 100000 s"));
  CHECK(contains(message, "read()"));
  CHECK_THROWS_AS((void)knob.record(100'000.5), InvalidArgument);
  CHECK(knob.statistics().reports_sent == sent);
  knob.start_telemetry(100.0);
  CHECK(contains(message_of<InvalidArgument>([&] { (void)knob.record(1'000'001.0); }),
                 "0 to 1000000 s"));
  CHECK(knob.record(0.1).size() == 10);
}

TEST_CASE("a ring or a read of more samples than memory holds is InvalidArgument") {
  constexpr std::size_t kMost = 16'777'216;
  for (const std::size_t samples : {std::size_t{0}, kMost + 1, SIZE_MAX}) {
    OpenOptions options;
    options.ring_samples = samples;
    CHECK(contains(message_of<InvalidArgument>([&] { (void)Knob::open("emulated", options); }),
                   "ring_samples is " + std::to_string(samples) + ", allowed are 1 to 16777216"));
  }
  Knob knob = Knob::open("emulated");
  CHECK(contains(message_of<InvalidArgument>([&] { (void)knob.read(kMost + 1, 0.0); }),
                 "max_samples is 16777217, allowed are 0 to 16777216"));
  CHECK(knob.read(0, 0.0).empty());
}

TEST_CASE("two recordings that follow each other do not overlap") {
  Knob knob = Knob::open("emulated", turning());
  knob.start_telemetry();
  const auto first = knob.record(0.1);
  const auto second = knob.record(0.1);
  CHECK(first.size() == 100);
  CHECK(second.size() == 100);
  CHECK(second.front().tick > first.back().tick);
}

TEST_CASE("telemetry runs at the rate asked for, as near as whole ticks allow") {
  Knob knob = Knob::open("emulated", turning(10e3));
  CHECK(knob.start_telemetry(1000.0) == 1000.0);
  CHECK(knob.record(0.5).size() == 500);
  CHECK(knob.start_telemetry(3000.0) == doctest::Approx(10e3 / 3));
  CHECK(knob.start_telemetry() == doctest::Approx(10e3 / 3));
  const auto log = knob.record(0.3);
  CHECK(log.size() == 1000);
  CHECK(log[1].tick - log[0].tick == 3);
  CHECK(knob.statistics().samples_lost == 0);
  CHECK(knob.health().samples_dropped == 0);
}

TEST_CASE("telemetry at 4,000 samples a second loses none, and has room for a dozen answers") {
  for (const double control_rate_hz : {4e3, 8e3, 20e3}) {
    CAPTURE(control_rate_hz);
    Knob knob = Knob::open("emulated", turning(control_rate_hz));
    CHECK(knob.start_telemetry(4000.0) == doctest::Approx(4000.0));
    for (int i = 0; i < 12; ++i) knob.disarm();  // each is answered
    const auto log = knob.record(5.0);
    CHECK(log.size() == 20'000);
    CHECK(log.back().tick - log.front().tick == 19'999 * (log[1].tick - log[0].tick));
    CHECK(knob.statistics().samples_lost == 0);
    CHECK(knob.health().samples_dropped == 0);
    CHECK_THROWS_AS(knob.start_telemetry(4001.0), InvalidArgument);
  }
}

TEST_CASE("a rate that cannot be had is InvalidArgument with the range") {
  Knob slow = Knob::open("emulated");
  CHECK(contains(message_of<InvalidArgument>([&] { slow.start_telemetry(2000.0); }),
                 "rate_hz is 2000, allowed are 3.921569 to 1000 Hz"));
  CHECK_THROWS_AS(slow.start_telemetry(1.0), InvalidArgument);
  CHECK_THROWS_AS(slow.start_telemetry(std::numeric_limits<double>::quiet_NaN()), InvalidArgument);
  CHECK_THROWS_AS((void)slow.record(-1.0), InvalidArgument);
  CHECK_THROWS_AS((void)slow.record(std::numeric_limits<double>::quiet_NaN()), InvalidArgument);
}

TEST_CASE("stopping telemetry keeps what was not read, starting forgets it") {
  Knob knob = Knob::open("emulated", turning());
  knob.start_telemetry();
  knob.sleep(0.1);
  knob.stop_telemetry();
  knob.sleep(0.1);
  const auto kept = knob.read(1000, 0.0);
  CHECK(kept.size() >= 96);
  CHECK(kept.size() <= 104);
  CHECK(knob.read(1000, 0.05).empty());

  knob.start_telemetry();
  knob.sleep(0.1);
  const std::uint64_t now = knob.clock().tick;
  knob.start_telemetry(500.0);
  for (const TelemetrySample& sample : knob.read(1000, 0.1)) CHECK(sample.tick >= now);
  CHECK(knob.statistics().samples_lost == 0);
}

TEST_CASE("a full ring loses the oldest samples and counts them") {
  OpenOptions options = turning();
  options.ring_samples = 100;
  Knob knob = Knob::open("emulated", options);
  knob.start_telemetry();
  knob.sleep(1.0);
  const auto kept = knob.read(1000, 0.0);
  CHECK(kept.size() == 100);
  CHECK(kept.back().tick > 990);
  const LinkStatistics statistics = knob.statistics();
  CHECK(statistics.samples_lost == statistics.samples_received - 100);
  const std::uint64_t lost = statistics.samples_lost;
  CHECK(knob.record(1.0).size() == 1000);  // recording takes them out as they come
  // Samples behind its end, in its last report.
  CHECK(knob.statistics().samples_lost < lost + protocol::samples_per_report);
}

TEST_CASE(
    "of a report that reaches back behind the begin of its stream the older samples are left out") {
  std::uint64_t begin_tick = 0;
  Knob knob = Knob::open(std::make_unique<Straddling>(open_transport("emulated"), begin_tick));
  knob.sleep(0.1);
  knob.start_telemetry();
  knob.sleep(0.05);
  const auto samples = knob.read(1000, 0.1);
  REQUIRE(begin_tick != 0);
  REQUIRE(samples.size() > 10);
  CHECK(samples.front().tick >= begin_tick);
}

TEST_CASE("what comes behind a recording can still be read") {
  Knob knob = Knob::open("emulated");
  knob.start_telemetry();
  for (int ticks = 10; ticks < 15; ++ticks) {  // some end within a report
    const auto recorded = knob.record(1e-3 * ticks);
    const auto next = knob.read(1000, 0.1);
    REQUIRE_FALSE(next.empty());
    CHECK(next.front().tick == recorded.back().tick + 1);
  }
}

TEST_CASE("samples that are lost on the way are counted as gaps") {
  Knob knob = Knob::open("emulated", turning());
  knob.start_telemetry();
  knob.emulator().set_link_faults({.drop_input = 0.2});
  knob.sleep(1.0);
  knob.emulator().set_link_faults({});
  knob.sleep(0.02);
  const auto log = knob.read(10'000, 0.0);
  const std::uint64_t span = log.back().tick - log.front().tick + 1;
  CHECK(log.size() < span);
  // Reports lost before the first that arrived cannot be known, so the span begins with that.
  CHECK(knob.statistics().samples_lost == span - log.size());
}

TEST_CASE("the same seed gives identical telemetry, another one does not") {
  const auto reference = wall_in_pieces(1, 1.0);
  CHECK(reference.size() > 3000);
  CHECK(wall_in_pieces(1, 1.0) == reference);
  CHECK(wall_in_pieces(2, 1.0) != reference);
}

TEST_CASE("telemetry is the same however calls cut the time") {
  const auto reference = wall_in_pieces(1, 1.0);
  CHECK(wall_in_pieces(1, 0.1) == reference);
  CHECK(wall_in_pieces(1, 0.0073) == reference);
  CHECK(wall_in_pieces(1, 0.00031) == reference);
}

TEST_CASE("virtual time passes exactly as long as asked, and not in calls that do not wait") {
  Knob knob = Knob::open("emulated");
  Emulator& world = knob.emulator();
  CHECK(world.time_s() == 0.0);
  (void)knob.health();
  (void)knob.clock();
  (void)knob.control_config();
  CHECK(world.time_s() == 0.0);
  knob.sleep(0.0123456);
  CHECK(world.time_s() == doctest::Approx(0.0123456).scale(0).epsilon(1e-12));
  world.advance(1.0);
  CHECK(world.time_s() == doctest::Approx(1.0123456).scale(0).epsilon(1e-12));
  CHECK(knob.read(1, 0.5).empty());
  CHECK(world.time_s() == doctest::Approx(1.5123456).scale(0).epsilon(1e-12));
  CHECK_FALSE(knob.wait_for(State::fault, 0.25));
  CHECK(world.time_s() == doctest::Approx(1.7623456).scale(0).epsilon(1e-12));
  CHECK(knob.clock().time_s == doctest::Approx(1.763));
}

TEST_CASE("truth fits telemetry tick by tick") {
  OpenOptions options = turning();
  options.emulator->log_truth = true;
  Knob knob = Knob::open("emulated", options);
  const auto log = knob.record(0.1);
  const auto truth = knob.emulator().truth();
  for (const TelemetrySample& sample : log) {
    const TruthSample& match = truth.at(sample.tick);
    CHECK(match.time_s == doctest::Approx(sample.time_s));
    CHECK(std::abs(match.angle_rad - sample.angle_rad) < 2 * std::numbers::pi / 8192 + 1e-9);
  }
}

TEST_CASE("truth without a log is an error that says how to get one") {
  Knob knob = Knob::open("emulated");
  CHECK(contains(message_of<Error>([&] { (void)knob.emulator().truth(); }), "log_truth"));
}

TEST_CASE("recording at a rate starts telemetry at that rate") {
  Knob knob = Knob::open("emulated", turning());
  const auto log = knob.record(0.1, 100.0);
  REQUIRE(log.size() == 10);
  for (std::size_t i = 1; i < log.size(); ++i) CHECK(log[i].tick - log[i - 1].tick == 10);
}

TEST_CASE("every call that waits can be interrupted, and what the callback throws comes through") {
  OpenOptions options;
  bool interrupt = false;
  options.interrupted = [&] { return interrupt; };
  Knob knob = Knob::open("emulated", options);
  knob.sleep(1.0);
  interrupt = true;
  CHECK_THROWS_AS(knob.sleep(1e6), Interrupted);
  CHECK_THROWS_AS((void)knob.record(1e5), Interrupted);
  CHECK_THROWS_AS((void)knob.wait_for(State::fault, 1e6), Interrupted);
  knob.stop_telemetry();
  (void)knob.read(100'000, 0.0);
  CHECK_THROWS_AS((void)knob.read(1, 1e6), Interrupted);
  interrupt = false;
  knob.arm();  // and goes on unchanged

  OpenOptions throwing;
  throwing.interrupted = []() -> bool { throw std::logic_error("mine"); };
  Knob other = Knob::open("emulated", throwing);
  CHECK_THROWS_WITH_AS(other.sleep(1e6), "mine", std::logic_error);
}

TEST_CASE("a waiting call asks at least every 20 ms whether it is interrupted") {
  using Clock = std::chrono::steady_clock;
  OpenOptions options;
  int asked = 0;
  options.interrupted = [&] { return ++asked == 10; };
  Knob knob = Knob::open("emulated", options);
  const auto begin = Clock::now();
  CHECK_THROWS_AS(knob.sleep(1e6), Interrupted);
  // Ten times 10 ms, and not the 1e6 s; a busy machine may take its time.
  CHECK(Clock::now() - begin < std::chrono::minutes(2));
}

TEST_CASE("sample ring keeps the newest and says when it lost one") {
  SampleRing ring(3);
  const auto at = [](std::uint64_t tick) {
    TelemetrySample sample{};
    sample.tick = tick;
    return sample;
  };
  for (std::uint64_t tick = 1; tick <= 3; ++tick) {
    CHECK(ring.push(at(tick)));
  }
  CHECK_FALSE(ring.push(at(4)));
  CHECK(ring.size() == 3);
  CHECK(ring.front().tick == 2);
  std::vector<TelemetrySample> out(5);
  CHECK(ring.pop(out) == 3);
  CHECK(out[0].tick == 2);
  CHECK(out[2].tick == 4);
  CHECK(ring.size() == 0);
  SampleRing smallest(0);  // holds one sample
  CHECK(smallest.push(at(1)));
  CHECK_FALSE(smallest.push(at(2)));
}

TEST_CASE("decoder counts a gap only where a stream goes on") {
  TelemetryDecoder decoder;
  const auto missing = [&](std::uint64_t tick, std::uint8_t decimation) {
    protocol::Telemetry report;
    report.axis_samples = protocol::pack_axis_samples(0, 1);
    report.tick = tick;
    report.decimation = decimation;
    return decoder.decode(report, [](const TelemetrySample&) {});
  };
  CHECK(missing(100, 1) == 0);
  CHECK(missing(101, 1) == 0);
  CHECK(missing(105, 1) == 3);
  CHECK(missing(10, 1) == 0);   // an older one
  CHECK(missing(200, 2) == 0);  // another rate
  CHECK(missing(206, 2) == 2);
  CHECK(missing(300, 0) == 0);  // no device says so
  CHECK(missing(400, 0) == 0);
}

TEST_CASE("decoder unwraps positions across 32 bits in both directions") {
  TelemetryDecoder decoder;
  protocol::Identity identity;
  identity.counts_per_rev = 4;
  decoder.configure(identity);
  const auto position = [&](std::int64_t true_counts) {
    protocol::Telemetry report;
    report.decimation = 1;
    report.base_counts = static_cast<std::int32_t>(static_cast<std::uint32_t>(true_counts));
    std::int64_t counts = 0;
    decoder.decode(report, [&](const TelemetrySample& sample) { counts = sample.position_counts; });
    return counts;
  };
  const std::int64_t start = 5'000'000'000;
  decoder.set_position(start);
  for (std::int64_t at = start; at < start + 10'000'000'000; at += 2'000'000'000) {
    CHECK(position(at) == at);
  }
  for (std::int64_t at = start + 8'000'000'000; at > -10'000'000'000; at -= 2'000'000'000) {
    CHECK(position(at) == at);
  }
}

TEST_CASE("decoder gives every field its own value, in SI units") {
  TelemetryDecoder decoder;
  protocol::Identity identity;
  identity.control_period_ns = 100'000;
  identity.counts_per_rev = 1000;
  identity.torque_step_nm = 0.5F;
  identity.speed_step_rad_s = 0.25F;
  decoder.configure(identity);
  protocol::Telemetry report;
  report.axis_samples = protocol::pack_axis_samples(0, 2);
  report.decimation = 10;
  report.flags = flag::brake_saturated | 1;
  report.tick = 2000;
  report.base_counts = -250;
  report.sample[0] = {0, 0, 0, 0, 0, 0};
  report.sample[1] = {-250, -4, 6, -8, 10, -12};
  std::vector<TelemetrySample> samples;
  CHECK(decoder.decode(report, [&](const auto& sample) { samples.push_back(sample); }) == 0);
  REQUIRE(samples.size() == 2);
  CHECK(samples[0].tick == 2000);
  CHECK(samples[0].time_s == doctest::Approx(0.2));
  CHECK(samples[0].position_counts == -250);
  CHECK(samples[0].angle_rad == doctest::Approx(-std::numbers::pi / 2));
  CHECK(samples[1].tick == 2010);
  CHECK(samples[1].time_s == doctest::Approx(0.201));
  CHECK(samples[1].position_counts == -500);
  CHECK(samples[1].angle_rad == doctest::Approx(-std::numbers::pi));
  CHECK(samples[1].speed_rad_s == -1.0F);
  CHECK(samples[1].desired_torque_nm == 3.0F);
  CHECK(samples[1].motor_command_nm == -4.0F);
  CHECK(samples[1].brake_capacity_nm == 5.0F);
  CHECK(samples[1].spring_torque_nm == -6.0F);
  CHECK(samples[1].flags == (flag::brake_saturated | 1));

  report.tick = 2050;  // 2020, 2030 and 2040 are missing
  CHECK(decoder.decode(report, [](const auto&) {}) == 3);
  decoder.begin_stream();
  report.tick = 9000;
  CHECK(decoder.decode(report, [](const auto&) {}) == 0);
}
