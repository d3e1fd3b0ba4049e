// The SDK over a transport that misbehaves in ways no emulated device does.
#include <doctest/doctest.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <utility>

#include "protocol/codec.hpp"
#include "protocol/registry.hpp"
#include "sdk/errors.hpp"
#include "torsio/knob.hpp"
#include "torsio/transport.hpp"

using namespace torsio;
using test::contains;
using test::message_of;

namespace {

/// The fake device's behaviour; shared with the test.
struct Script {
  protocol::Identity identity{.fingerprint = protocol::fingerprint()};
  bool stalls = false;
  bool accepts_config = true;
  bool closed = false;
  bool answers = true;
  std::uint8_t status = 0;
  std::uint8_t field = protocol::kNoField;
  std::deque<ReportBytes> input;
  int room = 1 << 30;                // reports until the queue is full
  std::int64_t sample_every_ns = 0;  // telemetry with ticks that count up; 0: none
};

class FakeTransport final : public Transport {
 public:
  explicit FakeTransport(std::shared_ptr<Script> script) : script_(std::move(script)) {}

  void close() noexcept override { script_->closed = true; }

  bool write(const ReportBytes& report) override {
    if (script_->room == 0) return false;
    --script_->room;
    answer(report);
    return true;
  }

  bool read(ReportBytes& report, std::chrono::nanoseconds /*timeout*/) override {
    if (script_->input.empty()) return false;
    report = script_->input.front();
    script_->input.pop_front();
    return true;
  }

  bool get_feature(std::uint8_t id, ReportBytes& report) override {
    if (script_->stalls) return false;
    switch (id) {
      case 0x01:
        report = protocol::encode(script_->identity);
        return true;
      case 0x02:
        report = protocol::encode(protocol::Clock{});
        return true;
      case 0x03:
        report = protocol::encode(protocol::Health{});
        return true;
      case 0x04:
        report = protocol::encode(protocol::ActuatorConfig{});
        return true;
      case 0x05:
        report = protocol::encode(protocol::ControlConfig{});
        return true;
      default:
        return false;
    }
  }

  bool set_feature(const ReportBytes& report) override {
    if (script_->accepts_config) answer(report);
    return script_->accepts_config;
  }

  bool time_is_virtual() const override { return true; }
  std::int64_t now_ns() const override { return now_ns_; }
  void advance_to(std::int64_t time_ns) override {
    now_ns_ = time_ns;
    if (script_->room == 0) script_->room = 1;
    if (script_->sample_every_ns > 0 && now_ns_ >= next_sample_ns_) {
      script_->input.push_back(
          protocol::encode(protocol::Telemetry{.decimation = 1, .tick = next_tick_++}));
      next_sample_ns_ = now_ns_ + script_->sample_every_ns;
    }
  }

 private:
  void answer(const ReportBytes& report) {
    if (!script_->answers) return;
    protocol::Acknowledgement answer;
    answer.sequence = static_cast<std::uint16_t>(report[1] | report[2] << 8);
    answer.report = report[0];
    answer.status = script_->status;
    answer.field = script_->field;
    script_->input.push_back(protocol::encode(answer));
  }

  std::shared_ptr<Script> script_;
  std::int64_t now_ns_ = 0;
  std::int64_t next_sample_ns_ = 0;
  std::uint64_t next_tick_ = 0;
};

Knob open(const std::shared_ptr<Script>& script) {
  return Knob::open(std::make_unique<FakeTransport>(script));
}

}  // namespace

TEST_CASE("another fingerprint is a ProtocolMismatch that names both and what to do") {
  const auto script = std::make_shared<Script>();
  script->identity.fingerprint ^= 1U;
  script->identity.version = 2;
  const std::string message = message_of<ProtocolMismatch>([&] { (void)open(script); });
  CHECK(contains(message, "version 2"));
  CHECK(contains(message, "version 1"));
  CHECK(contains(message, "update the older"));
}

TEST_CASE("a device that does not say who it is cannot be opened") {
  const auto script = std::make_shared<Script>();
  script->stalls = true;
  CHECK(contains(message_of<Error>([&] { (void)open(script); }), "Torsio knob?"));
  script->stalls = false;
  script->identity.counts_per_rev = 0;
  CHECK(contains(message_of<Error>([&] { (void)open(script); }), "damaged"));
}

TEST_CASE("a silent device is a Timeout, and the next call works again") {
  const auto script = std::make_shared<Script>();
  Knob knob = open(script);
  script->answers = false;
  CHECK_THROWS_AS(knob.arm(), Timeout);
  CHECK_THROWS_AS(knob.play(Constant{.torque_nm = 0.01}), Timeout);
  CHECK_THROWS_AS(knob.configure(ControlConfig{}), Timeout);
  CHECK_THROWS_AS((void)knob.record(0.1), Timeout);
  script->answers = true;
  knob.arm();
  CHECK_THROWS_AS((void)knob.record(0.1), Timeout);  // acknowledged, but no sample comes
}

TEST_CASE("a device whose world is slow is waited for as long as its samples come") {
  const auto script = std::make_shared<Script>();
  script->identity.control_period_ns = 1'000'000;
  script->sample_every_ns = 700'000'000;
  Knob knob = open(script);
  CHECK(knob.record(0.004).size() == 4);  // takes 2.8 s
  script->sample_every_ns = 0;
  CHECK_THROWS_AS((void)knob.record(0.004), Timeout);
}

TEST_CASE("a refusal is told in words: why, which report, which field") {
  const auto script = std::make_shared<Script>();
  Knob knob = open(script);
  script->status = static_cast<std::uint8_t>(protocol::Status::out_of_range);
  script->field = protocol::field_index<protocol::Wall>("stiffness_nm_per_rad");
  try {
    knob.play(Wall{.stiffness_nm_per_rad = 1});
    FAIL("no error");
  } catch (const Refused& refused) {
    CHECK(refused.status() == "out_of_range");
    CHECK(refused.report() == "wall");
    CHECK(refused.field() == "stiffness_nm_per_rad");
    CHECK(contains(refused.what(), "stiffness_nm_per_rad"));
    CHECK(contains(refused.what(), "docs/reference/protocol.md"));
  }
  script->status = 99;  // from a newer device
  script->field = protocol::kNoField;
  CHECK(contains(message_of<Refused>([&] { knob.arm(); }), "status 99"));
}

TEST_CASE("after a refused scene the next one is written whole") {
  const auto script = std::make_shared<Script>();
  Knob knob = open(script);
  const Scene scene{Wall{.stiffness_nm_per_rad = 1}, Constant{.torque_nm = 0}};
  knob.play(scene);
  script->status = static_cast<std::uint8_t>(protocol::Status::empty_slot);
  CHECK_THROWS_AS(knob.play(scene), Refused);
  script->status = 0;
  const std::uint64_t before = knob.statistics().reports_sent;
  knob.play(scene);
  CHECK(knob.statistics().reports_sent - before == 3);
}

TEST_CASE("a stalled configuration is Refused") {
  const auto script = std::make_shared<Script>();
  Knob knob = open(script);
  script->accepts_config = false;
  CHECK_THROWS_AS(knob.configure(ControlConfig{}), Refused);
  CHECK_THROWS_AS((void)knob.game_config(), Error);
}

TEST_CASE("a full queue to the device makes the sender wait for it to empty") {
  const auto script = std::make_shared<Script>();
  Knob knob = open(script);
  script->room = 2;
  knob.play(Scene(16, Constant{.torque_nm = 0.01}));
  CHECK(knob.statistics().reports_sent == 17);
}

TEST_CASE("input that is not ours is counted and otherwise ignored") {
  const auto script = std::make_shared<Script>();
  Knob knob = open(script);
  ReportBytes garbage{};
  garbage.fill(0xFF);
  script->input.push_back(garbage);
  garbage[0] = 0x40;
  script->input.push_back(garbage);
  knob.arm();
  CHECK(knob.statistics().reports_undecodable == 2);
  CHECK(knob.statistics().samples_received == 0);
}

TEST_CASE("whatever goes wrong, the transport is closed in the end") {
  const auto script = std::make_shared<Script>();
  {
    const Knob knob = open(script);
  }
  CHECK(script->closed);
}
