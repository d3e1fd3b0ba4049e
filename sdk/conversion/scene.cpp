#include "conversion/scene.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <string>
#include <string_view>
#include <variant>

#include "conversion/convert.hpp"
#include "conversion/turns.hpp"
#include "core/angle.hpp"
#include "device/prepare.hpp"
#include "torsio/error.hpp"

namespace torsio::conversion {
namespace {

[[noreturn]] void refuse(std::string_view what) { throw InvalidArgument(std::string(what)); }

/// What does not travel under its own name, and ranges that depend on the device, one function for
/// each effect that has any.
class Rules {
 public:
  Rules(const SceneLimits& limits, std::vector<float>& pool) : limits_(limits), pool_(pool) {}

  template <class Host, class Wire>
  void apply(const Host&, Wire&) {}

  /// Notches in a turn as 2^-32.
  void apply(const Detents& in, protocol::Detents& wire) {
    if (in.per_turn.has_value() == in.pitch_rad.has_value()) {
      refuse("give exactly one of per_turn and pitch_rad");
    }
    const bool by_pitch = in.pitch_rad.has_value();
    const double given = by_pitch ? *in.pitch_rad : *in.per_turn;
    constexpr auto kMostQ32 = static_cast<std::int64_t>(protocol::max_cycles_per_turn_q32);
    const std::int64_t counted_q32 = std::int64_t{limits_.counts_per_rev} << 31;
    const std::int64_t most_q32 = std::min(counted_q32, kMostQ32);
    const double most = static_cast<double>(most_q32) * 0x1p-32;
    // Rounded before it is compared, so that the pitch of two counts is one of the allowed ones.
    const std::int64_t q32 =
        by_pitch ? quotient_q32(kTurnRad, {given}) : quotient_q32({given}, {1.0});
    if (q32 < 1 || q32 > most_q32) {
      refuse(
          (by_pitch ? "pitch_rad is " : "per_turn is ") + number_text(given) + ", allowed are " +
          (by_pitch ? number_text(kTurnRad.value / most) + " to " +
                          number_text(kTurnRad.value * 0x1p32) + " rad"
                    : number_text(0x1p-32) + " to " + number_text(most)) +
          (counted_q32 > kMostQ32 ? "" : " (a notch takes at least two counts of this encoder)"));
    }
    wire.per_turn_q32 = static_cast<std::uint64_t>(q32);
  }

  void apply(const Periodic& in, protocol::Periodic&) { check_frequency(in.frequency_hz, 0.0); }
  void apply(const Impact& in, protocol::Impact&) { check_frequency(in.frequency_hz, 1.0); }

  void apply(const Texture& in, protocol::Texture&) {
    const auto most =
        static_cast<std::uint16_t>(std::min<std::uint32_t>(limits_.counts_per_rev / 2, 0xFFFF));
    static_cast<void>(whole_number<std::uint16_t>("grains_per_turn", in.grains_per_turn, 1, most));
  }

  void apply(const Curve& in, protocol::Curve& wire) {
    const std::size_t room = limits_.curve_points - pool_.size();
    if (in.torque_nm.size() < 2 || in.torque_nm.size() > room) {
      refuse("torque_nm has " + std::to_string(in.torque_nm.size()) + " points, allowed are 2 to " +
             std::to_string(room) + " (all curves of a scene share " +
             std::to_string(limits_.curve_points) + ")");
    }
    wire.span_turns_q32 = span_turns_q32(in.span_rad);
    wire.first_point = static_cast<std::uint16_t>(pool_.size());
    wire.points = static_cast<std::uint16_t>(in.torque_nm.size());
    for (std::size_t i = 0; i < in.torque_nm.size(); ++i) {
      // False for NaN.
      if (!(std::abs(in.torque_nm[i]) <= kMaxTorqueNm)) {
        refuse("torque_nm[" + std::to_string(i) + "] is " + number_text(in.torque_nm[i]) +
               ", allowed are " + number_text(-kMaxTorqueNm) + " to " + number_text(kMaxTorqueNm) +
               " N m");
      }
      pool_.push_back(narrow(in.torque_nm[i]));
    }
  }

  /// Asks the device whether the fields go together.
  template <class Host, class Wire>
  void ask(const Host& in, const Wire& wire) const {
    core::Effect prepared;
    const protocol::Verdict verdict = device::prepare(
        wire, core::make_resolution(limits_.counts_per_rev, limits_.control_period_ns), prepared);
    if (!verdict.ok()) refuse(told(in, protocol::field_name<Wire>(verdict.field)));
  }

 private:
  void check_frequency(double frequency_hz, double least_hz) const {
    const double most_hz = 0.5e9 / limits_.control_period_ns;
    if (frequency_hz >= least_hz && frequency_hz <= most_hz) return;  // false for NaN
    refuse("frequency_hz is " + number_text(frequency_hz) + ", allowed are " +
           number_text(least_hz) + " to " + number_text(most_hz) +
           " Hz (half of this device's control rate)");
  }

  template <class Host>
  [[nodiscard]] std::string told(const Host& in, std::string_view field) const {
    if constexpr (requires { in.timing; }) {
      const Timing& timing = in.timing;
      if (field == "fade_s") {
        return "fade_s is " + number_text(timing.fade_s) +
               " s but duration_s is 0: an endless effect cannot fade, give it a duration";
      }
      if (field == "duration_s" && timing.duration_s == 0.0) {
        return "duration_s is 0, but a ramp needs a duration";
      }
      if (field == "duration_s") {
        return "attack_s and fade_s, which are " + number_text(timing.attack_s) + " and " +
               number_text(timing.fade_s) + " s, each in whole ticks of " +
               number_text(1e-9 * limits_.control_period_ns) +
               " s, are together longer than duration_s, which is " +
               number_text(timing.duration_s) + " s";
      }
    }
    if constexpr (requires { in.upper_rad; }) {
      return "upper_rad is " + number_text(in.upper_rad) + ", below lower_rad, which is " +
             number_text(in.lower_rad);
    }
    return std::string(field) + " does not go with the other fields";
  }

  [[nodiscard]] std::uint64_t span_turns_q32(double span_rad) const {
    constexpr auto kMost = static_cast<std::int64_t>(protocol::max_span_turns_q32);
    const auto two_counts = static_cast<std::int64_t>(std::ceil(0x1p33 / limits_.counts_per_rev));
    const auto least =
        std::max(two_counts, static_cast<std::int64_t>(protocol::min_span_turns_q32));
    const std::int64_t turns = quotient_q32({span_rad}, kTurnRad);
    if (turns < least || turns > kMost) {
      const auto text = [](std::int64_t q32) {
        return number_text(static_cast<double>(q32) * kTurnRad.value / 0x1p32);
      };
      refuse("span_rad is " + number_text(span_rad) + ", allowed are " + text(least) + " to " +
             text(kMost) + " rad");
    }
    return static_cast<std::uint64_t>(turns);
  }

  const SceneLimits& limits_;
  std::vector<float>& pool_;
};

}  // namespace

ConvertedScene to_wire(const Scene& scene, const SceneLimits& limits) {
  if (scene.size() > limits.effects) {
    throw InvalidArgument("the scene has " + std::to_string(scene.size()) +
                          " effects, the device can play " + std::to_string(limits.effects) +
                          " at once");
  }
  ConvertedScene converted;
  Rules rules(limits, converted.curve_torque_nm);
  const auto convert_one = [&]<class Host>(const Host& effect) {
    using Wire = typename WireType<Host>::type;
    const auto slot = static_cast<std::uint8_t>(converted.effects.size());
    try {
      Wire wire;
      rules.apply(effect, wire);
      convert_fields(effect, wire);
      wire.target.slot = slot;
      check_fields(wire);
      rules.ask(effect, wire);
      converted.effects.emplace_back(wire);
    } catch (const InvalidArgument& error) {
      throw InvalidArgument("effect " + std::to_string(slot) + " (" +
                            std::string(protocol::Layout<Wire>::name) + "): " + error.what());
    }
  };
  for (const Effect& effect : scene) std::visit(convert_one, effect);
  return converted;
}

protocol::LocalModel to_wire(const LocalModel& model) {
  try {
    return convert(model);
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(std::string("local model: ") + error.what());
  }
}

protocol::Excitation to_wire(const Excitation& excitation) {
  try {
    return convert(excitation);
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(std::string("excitation: ") + error.what());
  }
}

}  // namespace torsio::conversion
