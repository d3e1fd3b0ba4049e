// When the host gets samples. USB 2.0, 5.7.4: the host asks once in a frame and gets what lies in
// the endpoint. So these tests check the age of a prompt report's newest sample, also on a machine
// that stalls.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

#include "emulator/usbip/pacer.hpp"
#include "protocol/axis_samples.hpp"
#include "protocol/codec.hpp"
#include "protocol/reports.hpp"
#include "rig.hpp"

using namespace usbip_test;
using torsio::protocol::Telemetry;

namespace {

constexpr std::int64_t kTickNs = 100'000;
constexpr int kTicksPerFrame = 10;

/// A knob that streams promptly, and a host that asks in every frame.
struct PromptRig {
  torsio::emulator::usbip::UsbKnob knob{{.control_period_ns = kTickNs, .serial = "RIG-1"}};
  Client client{knob};
  bool rounds;  // the device's main loop runs behind every tick, as on a board

  PromptRig(std::uint8_t decimation, bool rounds_at_ticks) : rounds(rounds_at_ticks) {
    client.attach();
    client.configure();
    client.submit_in(1, 64);
    client.submit_out(1, padded({0x12, 1, 0, 0, decimation, 1}, 64));
    for (int i = 0; i < 10; ++i) (void)frame();
  }

  /// @returns ticks since the newest sample was taken, if there was one
  std::optional<std::int64_t> frame() {
    client.session().frame();
    std::optional<std::int64_t> age;
    while (const auto reply = client.reply()) {
      if (reply->data.empty()) continue;
      torsio::protocol::ReportBytes bytes{};
      std::ranges::copy(reply->data, bytes.begin());
      if (Telemetry report; torsio::protocol::decode(bytes, report).ok()) {
        const auto newest = static_cast<std::int64_t>(
            report.tick + (torsio::protocol::samples_of(report.axis_samples) - 1U) *
                              std::uint64_t{report.decimation});
        age = knob.device().time_ns() / kTickNs - newest;
      }
      client.submit_in(1, 64);
    }
    for (int tick = 0; rounds && tick < kTicksPerFrame; ++tick) {
      knob.go_on(tick * kTickNs + 1);
      (void)client.get_feature(0x03);  // whatever the stack is asked gives it a round
    }
    knob.advance();
    return age;
  }
};

}  // namespace

TEST_CASE("a prompt report is filled just before the host asks for it") {
  for (const bool rounds : {false, true}) {
    for (const int decimation : {1, 2, 5, 10}) {
      CAPTURE(rounds);
      CAPTURE(decimation);
      PromptRig rig(static_cast<std::uint8_t>(decimation), rounds);
      // A quarter of a frame, and the tick within which it begins.
      const int early = rounds ? 3 : 0;
      for (int frame = 0; frame < 20; ++frame) {
        const auto age = rig.frame();
        REQUIRE(age);
        CHECK(*age <= decimation + early);
      }
    }
  }
}

TEST_CASE("prompt reports are as new behind an answer that has taken a frame") {
  for (const bool rounds : {false, true}) {
    CAPTURE(rounds);
    PromptRig rig(10, rounds);
    for (std::uint8_t n = 0; n < 5; ++n) {
      rig.client.submit_out(1, command(n, kDisarm));
      int without = 0;
      for (int frame = 0; frame < 10; ++frame) {
        const auto age = rig.frame();
        if (!age) ++without;
        if (age) CHECK(*age <= 10 + (rounds ? 3 : 0));
      }
      CHECK(without == 1);  // the answer's frame
    }
  }
}

TEST_CASE("whoever asks in the middle of a frame gets the clock of that moment") {
  torsio::emulator::usbip::UsbKnob knob{{.control_period_ns = kTickNs, .serial = "RIG-1"}};
  Client client{knob};
  client.attach();
  client.configure();
  const auto ticks = [&] {
    torsio::protocol::ReportBytes bytes{};
    std::ranges::copy(client.get_feature(0x02).data, bytes.begin());
    torsio::protocol::Clock clock;
    REQUIRE(torsio::protocol::decode(bytes, clock).ok());
    return clock.tick;
  };
  const std::uint64_t begin = ticks();
  knob.go_on(450'000);
  CHECK(ticks() == begin + 5);  // the tick at the frame's begin is one
  knob.go_on(200'000);          // never back
  CHECK(ticks() == begin + 5);
  knob.go_on(5'000'000);
  CHECK(ticks() == begin + 10);
  knob.advance();
  CHECK(ticks() == begin + 10);
  knob.advance();
  CHECK(ticks() == begin + 20);
}

TEST_CASE("a machine that stalls and a driver that is late lose no sample at 4,000 a second") {
  using torsio::emulator::usbip::Pacer;
  constexpr std::int64_t kFastestNs = 250'000;
  torsio::emulator::usbip::UsbKnob knob{{.control_period_ns = kFastestNs, .serial = "RIG-1"}};
  Client client{knob};
  client.attach();
  client.configure();
  client.submit_in(1, 64);
  client.submit_out(1, padded({0x12, 1, 0, 0, 1, 0}, 64));

  Pacer pacer(Pacer::Time{});
  std::uint64_t next_tick = 0;
  int gaps = 0;
  const auto listen = [&] {
    while (const auto reply = client.reply()) {
      if (reply->data.empty()) continue;
      torsio::protocol::ReportBytes bytes{};
      std::ranges::copy(reply->data, bytes.begin());
      if (Telemetry report; torsio::protocol::decode(bytes, report).ok()) {
        if (next_tick != 0 && report.tick != next_tick) ++gaps;
        next_tick = report.tick + torsio::protocol::samples_of(report.axis_samples);
      }
      client.submit_in(1, 64);
    }
  };
  const auto reach = [&](int ms, bool driver_runs) {
    while (pacer.take(Pacer::Time{} + std::chrono::milliseconds(ms))) {
      client.frame();
      if (driver_runs) listen();
    }
  };
  int now_ms = 0;
  for (const int stall_ms : {9, 12, 15, 18, 21, 30}) {
    for (int i = 0; i < 50; ++i) reach(++now_ms, true);
    reach(now_ms += stall_ms, false);  // nothing ran, and the world catches up at once
    for (int late = 0; late < 5; ++late) reach(++now_ms, false);
    listen();
  }
  CHECK(next_tick > 4 * 6 * 50);
  CHECK(gaps == 0);
}
