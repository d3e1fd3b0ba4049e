/// @file
/// A device on the bench with a game on its other interface. Reports are written here byte by byte,
/// from the tables of docs/reference/games.md.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <vector>

#include "device/rig.hpp"

namespace torsio::test {

constexpr std::uint8_t kConstant = 1, kRamp = 2, kSquare = 3, kSine = 4, kTriangle = 5, kSawUp = 6,
                       kSawDown = 7, kSpring = 8, kDamper = 9, kInertia = 10, kFriction = 11;
constexpr std::uint16_t kEast = 8192;   // a quarter of 32767: from the right
constexpr std::uint16_t kWest = 24575;  // from the left: pushes to larger angles
constexpr std::uint16_t kWithoutEnd = 0xFFFF;
constexpr double kCountRad = 2 * std::numbers::pi / 8192;

/// Bytes and 16-bit numbers in little-endian order.
struct Bytes {
  std::vector<std::uint8_t> data;

  Bytes& u8(int value) {
    data.push_back(static_cast<std::uint8_t>(value));
    return *this;
  }
  Bytes& u16(int value) { return u8(value & 0xFF).u8((value >> 8) & 0xFF); }
};

/// A torque other than 0, to a share of itself. doctest compares numbers of less than 1 with 1.
inline doctest::Approx about(double nm, double share = 1e-3) {
  return doctest::Approx(nm).scale(0).epsilon(share);
}

struct EffectOptions {
  int duration_ms = kWithoutEnd;
  int delay_ms = 0;
  int gain = 32767;
  int trigger = 0;
  int repeat_ms = 0;
  int enable = 2;
  int direction = kWest;
};

class GameRig : public Rig {
 public:
  static constexpr float kFullNm = 0.08F;

  explicit GameRig(std::uint32_t period_ns = 1'000'000) : Rig(board(period_ns)) {
    protocol::ControlConfig control;
    control.law = protocol::Law::motor_only;
    REQUIRE(set(control).ok());
    configure([](protocol::GameConfig&) {});
  }

  template <class Change>
  void configure(Change&& change) {
    protocol::GameConfig config;
    config.torque_max_nm = kFullNm;
    config.blend_s = 0;
    change(config);
    REQUIRE(set(config).ok());
  }

  void write(const Bytes& bytes) { device->game().receive(bytes.data); }

  /// Create New Effect, then Block Load. @returns block index and status
  std::array<int, 2> load(int type) {
    const Bytes create = Bytes{}.u8(0x21).u8(type).u16(0);
    REQUIRE(device->game().set_feature(create.data));
    std::array<std::uint8_t, 64> answer{};
    REQUIRE(device->game().get_feature(0x22, answer) == 5);
    REQUIRE(answer[0] == 0x22);
    return {answer[1], answer[2]};
  }
  int create(int type) {
    const auto [block, status] = load(type);
    REQUIRE(status == 1);
    types_[static_cast<std::size_t>(block)] = type;
    return block;
  }
  void set_effect(int block, const EffectOptions& o = {}) {
    write(Bytes{}
              .u8(0x11)
              .u8(block)
              .u8(types_[static_cast<std::size_t>(block)])
              .u16(o.duration_ms)
              .u16(o.repeat_ms)
              .u16(o.delay_ms)
              .u16(o.gain)
              .u8(o.trigger)
              .u8(o.enable)
              .u16(o.direction)
              .u16(0));
  }
  void constant(int block, int magnitude) { write(Bytes{}.u8(0x15).u8(block).u16(magnitude)); }
  void ramp(int block, int start, int end) {
    write(Bytes{}.u8(0x16).u8(block).u16(start).u16(end));
  }
  void periodic(int block, int magnitude, int offset, int phase, int period_ms) {
    write(Bytes{}.u8(0x14).u8(block).u16(magnitude).u16(offset).u16(phase).u16(period_ms));
  }
  void envelope(int block, int attack_level, int attack_ms, int fade_level, int fade_ms) {
    write(Bytes{}.u8(0x12).u8(block).u16(attack_level).u16(fade_level).u16(attack_ms).u16(fade_ms));
  }
  struct ConditionOptions {
    int offset = 0;
    int positive = 32767;
    int negative = 32767;
    int positive_saturation = 32767;
    int negative_saturation = 32767;
    int dead_band = 0;
    int parameter_block = 0;
  };
  void condition(int block, const ConditionOptions& o) {
    write(Bytes{}
              .u8(0x13)
              .u8(block)
              .u8(o.parameter_block)
              .u16(o.offset)
              .u16(o.positive)
              .u16(o.negative)
              .u16(o.positive_saturation)
              .u16(o.negative_saturation)
              .u16(o.dead_band));
  }
  void start(int block, int loops = 1) { operate(block, 1, loops); }
  void start_solo(int block) { operate(block, 2, 1); }
  void stop(int block) { operate(block, 3, 0); }
  void operate(int block, int operation, int loops) {
    write(Bytes{}.u8(0x1A).u8(block).u8(operation).u8(loops));
  }
  void free(int block) { write(Bytes{}.u8(0x1B).u8(block)); }
  void control(int what) { write(Bytes{}.u8(0x1C).u8(what)); }
  void gain(int value) { write(Bytes{}.u8(0x1D).u16(value)); }

  /// A constant force that plays from the next tick on.
  int play_constant(int magnitude, const EffectOptions& options = {}) {
    const int block = create(kConstant);
    set_effect(block, options);
    constant(block, magnitude);
    start(block);
    return block;
  }

  /// A condition that plays from the next tick on.
  int play_condition(int type, const ConditionOptions& options) {
    const int block = create(type);
    set_effect(block);
    condition(block, options);
    start(block);
    return block;
  }

  /// Turns the knob by so many counts in each of so many ticks.
  void turn(int counts, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      inputs.encoder_count += static_cast<std::uint32_t>(counts);
      tick();
    }
  }

  /// Motor torque of each of the next ticks.
  std::vector<float> torques(int ticks) {
    std::vector<float> nm;
    for (int i = 0; i < ticks; ++i) {
      tick();
      nm.push_back(outputs.motor_command_nm);
    }
    return nm;
  }
  protocol::Owner owner() { return get<protocol::Health>().owner; }

 private:
  static device::BoardInfo board(std::uint32_t period_ns) {
    device::BoardInfo info;
    info.control_period_ns = period_ns;
    info.has_bootloader = true;
    return info;
  }

  std::array<int, 256> types_{};
};

}  // namespace torsio::test
