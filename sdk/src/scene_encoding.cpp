#include "scene_encoding.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "field_check.hpp"
#include "protocol/effects.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

constexpr long double kTurnRad = 2.0L * std::numbers::pi_v<long double>;

// Choices keep their number from the user to the wire.
static_assert(static_cast<int>(Side::below) == static_cast<int>(protocol::Side::below));
static_assert(static_cast<int>(Waveform::sawtooth_down) ==
              static_cast<int>(protocol::Waveform::sawtooth_down));
static_assert(static_cast<int>(DetentProfile::click) ==
              static_cast<int>(protocol::DetentProfile::click));
static_assert(static_cast<int>(Grain::noise) == static_cast<int>(protocol::Grain::noise));
static_assert(static_cast<int>(Ends::repeat) == static_cast<int>(protocol::Ends::repeat));

[[noreturn]] void refuse(std::string_view what) { throw InvalidArgument(std::string(what)); }

protocol::Timing wire_timing(const Timing& in) {
  if (in.duration_s > 0.0 && in.attack_s + in.fade_s > in.duration_s) {
    refuse("attack_s and fade_s together are " + number_text(in.attack_s + in.fade_s) +
           " s, longer than duration_s, which is " + number_text(in.duration_s) + " s");
  }
  if (in.duration_s == 0.0 && in.fade_s > 0.0) {
    refuse("fade_s is " + number_text(in.fade_s) +
           " s but duration_s is 0: an endless effect cannot fade, give it a duration");
  }
  return {narrow(in.delay_s),  narrow(in.duration_s), narrow(in.attack_level),
          narrow(in.attack_s), narrow(in.fade_level), narrow(in.fade_s)};
}

/// Notches in a turn as 2^-32.
std::uint64_t per_turn_q32(const Detents& in, const protocol::Identity& device) {
  if (in.per_turn.has_value() == in.pitch_rad.has_value()) {
    refuse("give exactly one of per_turn and pitch_rad");
  }
  const bool by_pitch = in.pitch_rad.has_value();
  const long double given = by_pitch ? *in.pitch_rad : *in.per_turn;
  const long double per_turn = by_pitch ? kTurnRad / given : given;
  // Rounded before it is compared, so that the pitch of two counts is one of the allowed ones.
  const long double q32 = std::round(per_turn * 0x1p32L);
  const long double most_q32 = device.counts_per_rev * 0x1p31L;
  // The comparison is also false for NaN.
  if (!(q32 >= 1.0L && q32 <= most_q32)) {
    const long double most = most_q32 / 0x1p32L;
    const auto text = [](long double value) { return number_text(static_cast<double>(value)); };
    refuse((by_pitch ? "pitch_rad is " : "per_turn is ") + text(given) + ", allowed are " +
           (by_pitch ? text(kTurnRad / most) + " to " + text(kTurnRad * 0x1p32L) + " rad"
                     : text(0x1p-32L) + " to " + text(most)) +
           " (a notch takes at least two counts of this encoder)");
  }
  return static_cast<std::uint64_t>(q32);
}

/// Effects to reports. Curve points go into a common pool on the way.
class Encoder {
 public:
  explicit Encoder(const protocol::Identity& device) : device_(device) {}

  EncodedScene::Slot encode(const Effect& effect, std::uint8_t slot) {
    return std::visit(
        [&](const auto& in) {
          auto report = wire(in);
          report.target.slot = slot;
          check_fields(report);
          return EncodedScene::Slot{protocol::encode(report)};
        },
        effect);
  }

  EncodedScene::Slot encode(const Curve& curve, std::uint8_t slot) {
    const std::size_t first = pool_.size();
    protocol::Curve report = wire(curve);
    report.target.slot = slot;
    check_fields(report);
    for (const double torque_nm : curve.torque_nm) pool_.push_back(narrow(torque_nm));
    constexpr std::size_t kPiece = protocol::curve_points_per_report;
    return {protocol::encode(report), first / kPiece, (pool_.size() + kPiece - 1) / kPiece};
  }

  [[nodiscard]] std::vector<protocol::ReportBytes> pieces() const {
    std::vector<protocol::ReportBytes> pieces;
    for (std::size_t first = 0; first < pool_.size(); first += protocol::curve_points_per_report) {
      protocol::CurvePoints piece;
      const auto count =
          std::min<std::size_t>(pool_.size() - first, protocol::curve_points_per_report);
      piece.first_point = static_cast<std::uint16_t>(first);
      piece.points = static_cast<std::uint8_t>(count);
      std::copy_n(pool_.begin() + static_cast<std::ptrdiff_t>(first), count,
                  piece.torque_nm.begin());
      pieces.push_back(protocol::encode(piece));
    }
    return pieces;
  }

 private:
  static protocol::Wall wire(const Wall& in) {
    return {{},
            turns_q32("angle_rad", in.angle_rad),
            static_cast<protocol::Side>(in.side),
            narrow(in.stiffness_nm_per_rad),
            narrow(in.damping_nm_s_per_rad)};
  }
  static protocol::Spring wire(const Spring& in) {
    return {{},
            turns_q32("angle_rad", in.angle_rad),
            narrow(in.stiffness_nm_per_rad),
            narrow(in.deadband_rad),
            narrow(in.torque_limit_nm)};
  }
  static protocol::Damper wire(const Damper& in) {
    return {{}, narrow(in.damping_nm_s_per_rad), narrow(in.torque_limit_nm)};
  }
  static protocol::Friction wire(const Friction& in) {
    return {{}, narrow(in.torque_nm), narrow(in.stiffness_nm_per_rad)};
  }
  static protocol::Inertia wire(const Inertia& in) {
    return {{}, narrow(in.inertia_kg_m2), narrow(in.torque_limit_nm)};
  }
  static protocol::Constant wire(const Constant& in) {
    return {{}, narrow(in.torque_nm), wire_timing(in.timing)};
  }
  static protocol::Ramp wire(const Ramp& in) {
    if (in.timing.duration_s == 0.0) {
      refuse("duration_s is 0, but a ramp needs a duration");
    }
    return {{}, narrow(in.start_torque_nm), narrow(in.end_torque_nm), wire_timing(in.timing)};
  }
  [[nodiscard]] protocol::Periodic wire(const Periodic& in) const {
    const double highest_hz = 0.5e9 / device_.control_period_ns;
    if (in.frequency_hz > highest_hz) {
      refuse("frequency_hz is " + number_text(in.frequency_hz) + ", allowed are 0 to " +
             number_text(highest_hz) + " Hz (half of this device's control rate)");
    }
    return {{},
            static_cast<protocol::Waveform>(in.waveform),
            narrow(in.amplitude_nm),
            narrow(in.offset_nm),
            narrow(in.frequency_hz),
            narrow(in.phase_turns),
            wire_timing(in.timing)};
  }
  [[nodiscard]] protocol::Detents wire(const Detents& in) const {
    return {{},
            turns_q32("angle_rad", in.angle_rad),
            per_turn_q32(in, device_),
            narrow(in.torque_nm),
            static_cast<protocol::DetentProfile>(in.profile),
            narrow(in.width)};
  }
  static protocol::EndStops wire(const EndStops& in) {
    if (in.upper_rad < in.lower_rad) {
      refuse("upper_rad is " + number_text(in.upper_rad) + ", below lower_rad, which is " +
             number_text(in.lower_rad));
    }
    return {{},
            turns_q32("lower_rad", in.lower_rad),
            turns_q32("upper_rad", in.upper_rad),
            narrow(in.stiffness_nm_per_rad),
            narrow(in.damping_nm_s_per_rad)};
  }
  [[nodiscard]] protocol::Texture wire(const Texture& in) const {
    const auto most =
        static_cast<std::uint16_t>(std::min<std::uint32_t>(device_.counts_per_rev / 2, 0xFFFF));
    return {{},
            whole_number<std::uint16_t>("grains_per_turn", in.grains_per_turn, 1, most),
            narrow(in.torque_nm),
            static_cast<protocol::Grain>(in.grain),
            in.seed};
  }
  [[nodiscard]] protocol::Curve wire(const Curve& in) const {
    const std::size_t room = device_.curve_points - pool_.size();
    if (in.torque_nm.size() < 2 || in.torque_nm.size() > room) {
      refuse("torque_nm has " + std::to_string(in.torque_nm.size()) + " points, allowed are 2 to " +
             std::to_string(room) + " (all curves of a scene share " +
             std::to_string(device_.curve_points) + ")");
    }
    for (std::size_t i = 0; i < in.torque_nm.size(); ++i) {
      if (std::abs(in.torque_nm[i]) <= kMaxTorqueNm) continue;  // false for NaN
      refuse("torque_nm[" + std::to_string(i) + "] is " + number_text(in.torque_nm[i]) +
             ", allowed are " + number_text(-kMaxTorqueNm) + " to " + number_text(kMaxTorqueNm) +
             " N m");
    }
    return {{},
            turns_q32("angle_rad", in.angle_rad),
            span_turns_q32(in.span_rad),
            static_cast<protocol::Ends>(in.ends),
            static_cast<std::uint16_t>(pool_.size()),
            static_cast<std::uint16_t>(in.torque_nm.size())};
  }
  [[nodiscard]] std::uint64_t span_turns_q32(double span_rad) const {
    const std::int64_t turns = turns_q32("span_rad", span_rad);
    constexpr auto kMost = static_cast<std::int64_t>(protocol::max_span_turns_q32);
    const auto least = static_cast<std::int64_t>(std::ceil(0x1p33L / device_.counts_per_rev));
    if (turns < least || turns > kMost) {
      const auto text = [](std::int64_t q32) {
        return number_text(static_cast<double>(q32 * kTurnRad / 0x1p32L));
      };
      refuse("span_rad is " + number_text(span_rad) + ", allowed are " + text(least) + " to " +
             text(kMost) + " rad");
    }
    return static_cast<std::uint64_t>(turns);
  }

  const protocol::Identity& device_;
  std::vector<float> pool_;
};

std::string_view effect_name(const Effect& effect) {
  constexpr std::array<std::string_view, std::variant_size_v<Effect>> kNames{
      "wall", "spring",   "damper",  "friction",  "inertia", "constant",
      "ramp", "periodic", "detents", "end_stops", "texture", "curve"};
  return kNames.at(effect.index());
}

}  // namespace

EncodedScene encode_scene(const Scene& scene, const protocol::Identity& device) {
  if (scene.size() > device.effects) {
    throw InvalidArgument("the scene has " + std::to_string(scene.size()) +
                          " effects, the device can play " + std::to_string(device.effects) +
                          " at once");
  }
  EncodedScene encoded;
  Encoder encoder(device);
  for (const Effect& effect : scene) {
    const auto slot = static_cast<std::uint8_t>(encoded.slots.size());
    try {
      const auto* curve = std::get_if<Curve>(&effect);
      encoded.slots.push_back(curve != nullptr ? encoder.encode(*curve, slot)
                                               : encoder.encode(effect, slot));
    } catch (const InvalidArgument& error) {
      throw InvalidArgument("effect " + std::to_string(slot) + " (" +
                            std::string(effect_name(effect)) + "): " + error.what());
    }
  }
  encoded.pieces = encoder.pieces();
  return encoded;
}

protocol::ReportBytes encode_local_model(const LocalModel& model) {
  try {
    const protocol::LocalModel report{0,
                                      0,
                                      narrow(model.torque_nm),
                                      turns_q32("angle_rad", model.angle_rad),
                                      narrow(model.stiffness_nm_per_rad),
                                      narrow(model.damping_nm_s_per_rad),
                                      narrow(model.deadline_s)};
    check_fields(report);
    return protocol::encode(report);
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(std::string("local model: ") + error.what());
  }
}

}  // namespace torsio
