/// @file
/// A device that started as a dial, with a hand on it and a host that reads what it sends.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "device/config_store.hpp"
#include "device/rig.hpp"

namespace torsio::test {

/// A torque other than 0, to a share of itself. doctest compares numbers of less than 1 with 1.
inline doctest::Approx near_nm(double nm, double share = 1e-3) {
  return doctest::Approx(nm).scale(0).epsilon(share);
}

struct DialOptions {
  protocol::DialUse use = protocol::DialUse::wheel;
  std::uint8_t detents = 24;
  float torque_nm = 0.005F;
  std::uint32_t counts_per_rev = 8192;
  protocol::Toggle coarse = protocol::Toggle::off;
  std::uint8_t fast_steps = 1;
  protocol::Toggle reversed = protocol::Toggle::off;
};

class DialRig : public Rig {
 public:
  /// The host's sums.
  struct Heard {
    long wheel = 0;
    long pan = 0;
    int louder = 0;
    int quieter = 0;
    int tenths = 0;         // of a degree, of a radial controller
    std::uint8_t puck = 0;  // its button
    std::uint8_t buttons = 0;
    int reports = 0;
    int news = 0;   // reports that say something
    int ups = 0;    // REL_WHEEL or REL_HWHEEL of Linux, to larger angles
    int downs = 0;  // and to smaller ones
  };

  explicit DialRig(const DialOptions& options = {}) : Rig({}, stored(options)) {
    device->set_connected(true);
    tick(3);
    listen(3);
    heard = {};
  }

  /// Linux and Windows ask for this when a wheel offers it.
  void ask_for_fine() {
    REQUIRE(device->dial().set_feature(std::array<std::uint8_t, 2>{3, 0x05}));
    unit_ = 1;
  }

  /// One report in each tick, as on the bus.
  void listen(int ticks = 1) {
    for (int i = 0; i < ticks; ++i) {
      tick();
      std::array<std::uint8_t, 64> report{};
      const std::size_t size = device->dial().next_input(report);
      if (size != 0) hear(report, size);
    }
  }

  /// Takes reports and throws them away, as Linux does in the 50 ms after an open.
  void discard(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      tick();
      std::array<std::uint8_t, 64> lost{};
      if (device->dial().next_input(lost) != 0) device->dial().input_over(true);
    }
  }

  /// Takes a report.
  void hear(const std::array<std::uint8_t, 64>& report, std::size_t size) {
    device->dial().input_over(true);
    ++heard.reports;
    if (report[0] == 1) {
      REQUIRE(size == 8);
      CHECK(report[2] == 0);
      CHECK(report[3] == 0);
      if (report[1] != heard.buttons || i16(report, 4) != 0 || i16(report, 6) != 0) ++heard.news;
      heard.buttons = report[1];
      heard.wheel += i16(report, 4);
      heard.pan += i16(report, 6);
      // As drivers/hid/hid-input.c of Linux has it, hidinput_handle_scroll().
      sum_ += unit_ * (i16(report, 6) - i16(report, 4));
      heard.ups += std::max(sum_ / 120, 0);
      heard.downs += std::max(-sum_ / 120, 0);
      sum_ -= sum_ / 120 * 120;
    } else if (report[0] == 4) {
      REQUIRE(size == 4);
      CHECK(std::abs(i16(report, 2)) <= 3600);
      heard.puck = report[1];
      heard.tenths += i16(report, 2);
    } else {
      REQUIRE(report[0] == 2);
      REQUIRE(size == 2);
      // A key goes down only when no key is down.
      CHECK((keys_ == 0 || report[1] == 0));
      heard.louder += report[1] == 1 ? 1 : 0;
      heard.quieter += report[1] == 2 ? 1 : 0;
      keys_ = report[1];
    }
  }

  /// Where the encoder has come to by other ways.
  void put_at(std::int64_t counts) { at_ = counts; }

  /// Turns the knob to a place, by so many counts a tick.
  void turn_to(std::int64_t counts, int counts_a_tick) {
    while (at_ != counts) {
      const std::int64_t left = counts - at_;
      const std::int64_t step = left > counts_a_tick    ? counts_a_tick
                                : left < -counts_a_tick ? -counts_a_tick
                                                        : left;
      at_ += step;
      inputs.encoder_count += static_cast<std::uint32_t>(step);
      listen();
    }
  }

  protocol::Owner owner() { return get<protocol::Health>().owner; }
  bool key_down() const { return keys_ != 0; }

  Heard heard;

 private:
  static device::StoredSlots stored(const DialOptions& options) {
    device::Config config;
    config.game.personality = protocol::Personality::dial;
    config.game.dial_use = options.use;
    config.game.dial_detents = options.detents;
    config.game.dial_torque_nm = options.torque_nm;
    config.game.dial_coarse = options.coarse;
    config.game.dial_fast_steps = options.fast_steps;
    config.game.reversed = options.reversed;
    config.control.law = protocol::Law::motor_only;
    config.actuator.counts_per_rev = options.counts_per_rev;
    device::StoredSlots slots = device::empty_slots();
    const device::SlotWrite write = device::ConfigStore(slots).prepare(config);
    slots.slot.at(write.slot) = write.bytes;
    return slots;
  }
  static int i16(const std::array<std::uint8_t, 64>& bytes, std::size_t at) {
    return static_cast<std::int16_t>(bytes.at(at) | (bytes.at(at + 1) << 8));
  }

  std::int64_t at_ = 0;
  std::uint8_t keys_ = 0;
  int unit_ = 120;
  int sum_ = 0;
};

}  // namespace torsio::test
