/// @file
/// A device with a scene, for the programs that measure and compare.
#pragma once

#include <cstdint>

#include "device/device.hpp"
#include "protocol/codec.hpp"

namespace torsio::mcu {

/// Main loop and control interrupt in turn, and the host's side of the protocol.
class Bench {
 public:
  explicit Bench(std::uint32_t control_period_ns)
      : device_(board(control_period_ns), device::empty_slots()) {}

  device::TickOutputs tick(std::uint32_t encoder_count) {
    inputs_.encoder_count = encoder_count;
    return device_.tick(inputs_);
  }

  /// Sends a report and lets the device act on it; the encoder rests.
  template <class Report>
  void send(const Report& report) {
    (void)device_.receive(protocol::encode(report));
    settle();
  }
  template <class Report>
  void set(const Report& report) {
    (void)device_.set_feature(protocol::encode(report));
    settle();
  }
  void command(protocol::Op op) { send(protocol::Command{1, 0, op}); }

  void settle() {
    for (int i = 0; i < 3; ++i) {
      device_.service();
      (void)device_.tick(inputs_);
      protocol::ReportBytes bytes;
      while (device_.next_input(bytes)) {
      }
    }
  }

  device::Device& device() { return device_; }

 private:
  static device::BoardInfo board(std::uint32_t control_period_ns) {
    device::BoardInfo info;
    info.control_period_ns = control_period_ns;
    return info;
  }

  device::Device device_;
  device::TickInputs inputs_;
};

/// One report for each kind of effect, playing wherever the knob is.
template <class Visit>
void for_each_kind(Visit&& visit) {
  using namespace protocol;
  const auto named = [&](auto report) { visit(Layout<decltype(report)>::name, report); };
  Timing timing;
  timing.attack_s = 0.01F;
  timing.attack_level = 0.25F;
  timing.duration_s = 50;
  timing.fade_s = 0.5F;
  named(Wall{{1, 0, 0}, 0, Side::below, 1.4F, 0.002F});
  named(Spring{{1, 0, 0}, 123456789, 0.7F, 0.01F, 0.06F});
  named(Damper{{1, 0, 0}, 0.003F, 0.05F});
  named(Friction{{1, 0, 0}, 0.02F, 1.5F});
  named(Inertia{{1, 0, 0}, 2e-5F, 0.05F});
  named(Constant{{1, 0, 0}, 0.03F, timing});
  named(Ramp{{1, 0, 0}, -0.02F, 0.04F, timing});
  named(Periodic{{1, 0, 0}, Waveform::sine, 0.03F, 0.01F, 12.5F, 0.25F, timing});
  named(Detents{{1, 0, 0}, 987654321, std::uint64_t{24} << 32, 0.03F, DetentProfile::sine});
  named(EndStops{{1, 0, 0}, -(std::int64_t{1} << 30), std::int64_t{1} << 30, 2.0F, 0.001F});
  named(Texture{{1, 0, 0}, 200, 0.02F, Grain::noise, 42});
  Curve curve;
  curve.target = {1, 0, 0};
  curve.first_point = 0;
  curve.points = 8;
  curve.span_turns_q32 = std::uint64_t{1} << 31;
  curve.ends = Ends::repeat;
  named(curve);
  named(Impact{{1, 0, 0}, 0, Side::below, 0.01F, 300.0F, 5e-3F, 0.01F, 5e-3F, 0.05F});
}

}  // namespace torsio::mcu
