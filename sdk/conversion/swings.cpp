#include "conversion/swings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <memory>
#include <numbers>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/scene.hpp"
#include "device/prepare.hpp"
#include "device/wall_parts.hpp"

namespace torsio::conversion {
namespace {

using Complex = std::complex<double>;
constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr std::size_t kSamples = 4096;  // of a turn
constexpr std::size_t kPhases = 16;     // of a swing
constexpr std::size_t kTones = 32;      // frequencies
constexpr double kSlowestRadS = 5.0;
constexpr double kWidestRad = 2.0;
// As in core/stability.hpp, for what a describing function leaves out.
constexpr double kTrusted = 0.84;
// Of virtual inertia; friction ends what the rest would make hum.
constexpr double kHeardInertia = 0.05;

/// The steepest that an effect gets, if it is a spring or none; without end otherwise.
double slope_of(const core::Effect& effect) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  const auto wall = [](const core::Wall& one) {
    return one.damping_nm_s_per_rad == 0.0F ? double{one.stiffness_nm_per_rad} : kUnknown;
  };
  return std::visit(
      [&]<class Effect>(const Effect& one) {
        if constexpr (std::is_same_v<Effect, core::Wall>) return wall(one);
        if constexpr (std::is_same_v<Effect, core::Spring>) return double{one.stiffness_nm_per_rad};
        if constexpr (std::is_same_v<Effect, core::EndStops>)
          return std::max(wall(one.lower), wall(one.upper));
        if constexpr (std::is_same_v<Effect, std::monostate> ||
                      std::is_same_v<Effect, core::Constant> ||
                      std::is_same_v<Effect, core::Ramp> || std::is_same_v<Effect, core::Periodic>)
          return 0.0;
        return kUnknown;
      },
      effect);
}

/// A law that bounds makes safe what depends on the angle alone, but no local model, which moves.
/// @returns false if the bytes are not this report, or nothing of it is to be judged
template <class Report>
bool read_as(const protocol::ReportBytes& bytes, Report& report, bool bounds = false) {
  if (bytes[0] != protocol::Layout<Report>::id || !protocol::decode(bytes, report).ok())
    return false;
  if (!bounds || std::is_same_v<Report, protocol::LocalModel>) return true;
  if constexpr (requires { report.damping_nm_s_per_rad; }) {
    if constexpr (requires { report.stiffness_nm_per_rad; }) report.stiffness_nm_per_rad = 0.0F;
    return report.damping_nm_s_per_rad != 0.0F;
  }
  return std::is_same_v<Report, protocol::Inertia>;
}

/// The steepest that all together get.
double slope_of(std::span<const protocol::ReportBytes> reports, const core::Resolution& resolution,
                bool bounds) {
  double sum = 0.0;
  const auto add = [&]<class Report>(const protocol::ReportBytes& bytes, Report& report) {
    core::Effect effect;
    if (read_as(bytes, report, bounds) && device::prepare(report, resolution, effect).ok())
      sum += slope_of(effect);
  };
  for (const protocol::ReportBytes& bytes : reports) {
    protocol::LocalModel local;
    if (read_as(bytes, local)) return std::numeric_limits<double>::infinity();
    std::apply([&](auto... effect) { (add(bytes, effect), ...); }, protocol::EffectReports{});
  }
  return sum;
}

/// Half a period for what is held, the motor's lag and the control's delay.
double late_s(const core::Parts& parts) {
  return 0.5 * double{parts.period_s} + double{parts.motor_time_constant_s + parts.delay_s};
}

/// The part of friction in (9).
double friction_nm_per_rad(const core::Parts& parts, double swing_rad) {
  return kTrusted * 8.0 / kTwoPi * double{parts.knob_coulomb_nm} / swing_rad;
}

/// What a count must switch, to either side, before few weights find a place to rest.
double heard_nm(const core::Parts& parts) { return 1.2 * double{parts.knob_coulomb_nm}; }

/// From one tone to the next; the last is half the control's rate.
double tone_step(const core::Parts& parts) {
  const double fastest_rad_s = 0.5 * kTwoPi / double{parts.period_s};
  return std::pow(fastest_rad_s / kSlowestRadS, 1.0 / (kTones - 1));
}

/// Whether springs of together this stiffness, or less, rest for sure. At little cost: the
/// imaginary part of (9) is positive where the real one is zero, in the widest swing that is so
/// stiff. This margin shrinks with the frequency: the first tone beyond covers all before it.
bool surely_rest(const core::Parts& parts, double stiffness_nm_per_rad) {
  // The most that the describing function of counts is in so many phases, and of a limit's ends.
  constexpr double kOfCounts = 1.51;
  constexpr double kOfLimit = 4.0 / std::numbers::pi;
  const double motor_nm = double{parts.motor_torque_max_nm};
  const double count_nm = stiffness_nm_per_rad * double{parts.rad_per_count};
  if (0.5 * count_nm > heard_nm(parts)) return false;
  const double step_nm = 0.5 * kOfCounts * count_nm;
  const double more = 1.0 / std::max(1.0 - step_nm / motor_nm, 0.01);
  const double spring = double{parts.spring_stiffness_nm_per_rad};
  const double share = double{parts.brake_share};
  double rad_s = kSlowestRadS;
  const double step = tone_step(parts);
  for (std::size_t i = 0; i < kTones; ++i, rad_s *= step) {
    const double cosine = std::cos(rad_s * late_s(parts));
    const double pushed = double{parts.knob_inertia_kg_m2} * rad_s * rad_s;
    if (cosine <= 0.0) return false;
    double pushes = pushed / (share + (1.0 - share) * cosine);
    if (share * pushes > spring) pushes = spring + (pushed - spring) / cosine;
    const double carried = std::min(spring, share * pushes);
    const double swing_rad = std::min(kWidestRad, kOfLimit * motor_nm * more / pushes);
    const double held =
        double{parts.knob_viscous_nm_s_per_rad} * rad_s + friction_nm_per_rad(parts, swing_rad);
    if (held <= (pushes - carried) * std::sin(rad_s * late_s(parts))) return false;
    if (pushes > kOfCounts * stiffness_nm_per_rad * more) return true;
  }
  return true;
}

/// A frequency, and what the device makes of the knob's swing at it.
struct Tone {
  double rad_s = 0;
  Complex speed;  // as core/motion.hpp estimates it
  Complex acceleration;
  Complex late;  // held for a period, and the motor's lag
};

/// The scene, as the device evaluates it.
class Played {
 public:
  Played(std::span<const protocol::ReportBytes> reports, const core::Resolution& resolution,
         bool bounds, float dampers_nm_s_per_rad)
      : resolution_(resolution), bounds_(bounds) {
    for (const protocol::ReportBytes& bytes : reports) {
      take(bytes, local_report_);
      take_points(bytes);
      std::apply([&](auto... effect) { (take(bytes, effect), ...); }, protocol::EffectReports{});
    }
    local_ = device::prepare(local_report_, resolution);
    const float asked = core::damping_nm_s_per_rad(scene_.get()) + local_.damping_nm_s_per_rad;
    if (bounds && asked > dampers_nm_s_per_rad) damping_share_ = dampers_nm_s_per_rad / asked;
  }

  [[nodiscard]] double torque_nm(core::SceneState& state, const core::Motion& motion) const {
    state.damping_share = damping_share_;
    return double{core::evaluate_scene(*scene_, state, motion, resolution_, 0) +
                  core::evaluate_local_model(local_, state, motion, resolution_)};
  }

  /// Positions that something is about, in counts.
  std::vector<std::int64_t> places{0};
  bool plays = false;         // anything but dampers, if the law bounds them
  bool feels_motion = false;  // speed or acceleration matter

 private:
  template <class Report>
  void take(const protocol::ReportBytes& bytes, Report& report) {
    if (!read_as(bytes, report, bounds_)) return;
    plays = plays || !bounds_ || !std::is_same_v<Report, protocol::Damper>;
    protocol::Layout<Report>::fields.apply(
        [&](const auto&... field) { (look_at(field.name, report.*field.member), ...); });
    if constexpr (requires { report.target; }) {
      core::Effect& effect = scene_->effect.at(scene_->active);
      if (device::prepare(report, resolution_, effect).ok()) {
        scene_->order.at(scene_->active) = scene_->active;
        ++scene_->active;
      }
    }
  }

  void take_points(const protocol::ReportBytes& bytes) {
    protocol::CurvePoints report;
    if (!read_as(bytes, report)) return;
    const std::size_t room = scene_->curve_torque_nm.size() - report.first_point;
    std::copy_n(report.torque_nm.begin(), std::min<std::size_t>(report.points, room),
                scene_->curve_torque_nm.begin() + report.first_point);
  }

  template <class Value>
  void look_at(std::string_view name, const Value& value) {
    if constexpr (std::is_same_v<Value, std::int64_t>) {
      places.push_back(core::make_origin(value, resolution_.counts_per_rev).counts);
    } else if constexpr (std::is_same_v<Value, float>) {
      const bool moves = name.ends_with("_s_per_rad") || name.ends_with("_kg_m2");
      feels_motion = feels_motion || (moves && value != 0.0F);
    }
  }

  core::Resolution resolution_;
  bool bounds_;
  float damping_share_ = 1.0F;
  std::unique_ptr<core::Scene> scene_ = std::make_unique<core::Scene>();
  protocol::LocalModel local_report_;
  core::LocalModel local_;
};

/// The knob and what plays, for swings of any frequency, amplitude and place: the loop that (9) of
/// docs/explanation/theory.md has for springs and dampers.
class Loop {
 public:
  Loop(const Played& played, const core::Parts& parts, double bandwidth_hz)
      : played_(played), parts_(parts) {
    const double period_s = double{parts.period_s};
    const double pole = std::exp(-kTwoPi * bandwidth_hz * period_s);
    double rad_s = kSlowestRadS;
    const double step = tone_step(parts);
    for (std::size_t i = 0; i < kTones; ++i, rad_s *= step) {
      const Complex tick = std::polar(1.0, -rad_s * period_s);
      const Complex rate = (1.0 - tick) / period_s;
      const Complex filter = (1.0 - pole) / (1.0 - pole * tick);
      const Complex speed = rate * filter * filter;
      tones_.at(i) = {rad_s, speed, rate * speed, std::polar(1.0, -rad_s * late_s(parts))};
    }
    for (std::size_t i = 0; i < phases_.size(); ++i) {
      phases_.at(i) = std::polar(1.0, kTwoPi * static_cast<double>(i) / kPhases);
    }
    for (const std::int64_t place : played.places) look_round(place);
  }

  /// Whether the motor drives a knob to and fro over the edge of a count. The device sees a square
  /// wave of one count, however little the knob moves.
  [[nodiscard]] bool hums() const {
    const double count_rad = double{parts_.rad_per_count};
    const Swing swing = make_swing(2.0 / std::numbers::pi * count_rad, true);
    return std::any_of(tones_.begin(), tones_.end(), [&](Tone tone) {
      tone.acceleration *= kHeardInertia;
      const Complex pushes_nm = swing.rad * follow(swing, tone) * tone.late;
      const double wide_rad =
          pushes_nm.real() / (double{parts_.knob_inertia_kg_m2} * tone.rad_s * tone.rad_s);
      return wide_rad > 0.0 && wide_rad < 0.5 * count_rad &&
             -pushes_nm.imag() > 4.0 / std::numbers::pi * heard_nm(parts_);
    });
  }

  [[nodiscard]] bool swings() const {
    for (double swing_rad = 0.5 * double{parts_.rad_per_count}; swing_rad < kWidestRad;
         swing_rad *= 1.2) {
      const Swing swing = make_swing(swing_rad, false);
      // By Nyquist's criterion: what grows turns it the other way round.
      double turned_rad = 0.0;
      Complex pushes;
      Complex before;
      for (const Tone& tone : tones_) {
        const bool is_first = &tone == &tones_.front();
        if (is_first || played_.feels_motion) pushes = push(swing, tone);
        const Complex now = at(pushes, swing_rad, tone);
        if (!is_first) turned_rad += std::arg(now * std::conj(before));
        before = now;
      }
      if (turned_rad < 0.0) return true;
    }
    return false;
  }

 private:
  /// A swing's way once round, and what the scene remembers before.
  struct Swing {
    double rad = 0.0;
    double rest_nm = 0.0;  // in its middle
    core::SceneState state{};
    std::array<core::Motion, kPhases> way{};
  };

  /// Torques within half a turn of a place, of a knob on the way there and on the way back.
  struct Surroundings {
    std::int64_t begin_counts = 0;
    std::array<double, kSamples> there_nm{}, back_nm{};
  };

  [[nodiscard]] double counts_of_sample(double sample) const {
    return sample * kTwoPi / kSamples / double{parts_.rad_per_count};
  }

  void look_round(std::int64_t place_counts) {
    const std::int64_t begin = place_counts - std::llround(counts_of_sample(kSamples / 2));
    for (const Surroundings& known : round_) {
      if (std::abs(static_cast<double>(known.begin_counts - begin)) <
          counts_of_sample(kSamples / 4))
        return;
    }
    Surroundings& round = round_.emplace_back();
    round.begin_counts = begin;
    core::SceneState state;
    core::Motion motion;
    for (std::size_t i = 0; i < kSamples; ++i) {
      motion.position_counts = begin + std::llround(counts_of_sample(static_cast<double>(i)));
      motion.speed_rad_s = 1.0F;
      round.there_nm.at(i) = round.back_nm.at(i) = played_.torque_nm(state, motion);
      if (!played_.feels_motion) continue;
      motion.speed_rad_s = -1.0F;
      round.back_nm.at(i) = played_.torque_nm(state, motion);
    }
  }

  /// The middle of the swing against which most is done.
  [[nodiscard]] std::int64_t steepest(double swing_rad) const {
    const auto half = static_cast<std::size_t>(std::max(swing_rad * kSamples / kTwoPi, 1.0));
    double most_nm = -1.0;
    std::size_t middle = 0;
    const Surroundings* where = nullptr;
    for (const Surroundings& round : round_) {
      const auto back = std::span(round.back_nm).first(kSamples - 2 * half);
      const auto there = std::span(round.there_nm).last(back.size());
      for (std::size_t i = 0; i < back.size(); ++i) {
        const double nm = back[i] - there[i];
        if (nm <= most_nm) continue;
        most_nm = nm;
        middle = half + i;
        where = &round;
      }
    }
    if (where == nullptr) return 0;
    return where->begin_counts + std::llround(counts_of_sample(static_cast<double>(middle)));
  }

  /// The count from which the next switches most.
  [[nodiscard]] std::int64_t steepest_count() const {
    const std::int64_t middle = steepest(0.0);
    const std::int64_t around = std::llround(counts_of_sample(1.0)) + 1;
    std::int64_t steepest = middle;
    double most_nm = 0.0;
    for (std::int64_t count = middle - around; count <= middle + around; ++count) {
      core::SceneState state;
      core::Motion motion{.position_counts = count};
      const double here_nm = played_.torque_nm(state, motion);
      ++motion.position_counts;
      motion.delta_rad = parts_.rad_per_count;
      const double nm = here_nm - played_.torque_nm(state, motion);
      if (nm > most_nm) steepest = count;
      most_nm = std::max(most_nm, nm);
    }
    return steepest;
  }

  /// A swing round the steepest place. The scene's memory depends on the way alone, so once round
  /// is enough for all tones.
  [[nodiscard]] Swing make_swing(double swing_rad, bool in_a_count) const {
    Swing swing{.rad = swing_rad};
    core::Motion motion;
    const std::int64_t middle_counts = in_a_count ? steepest_count() : steepest(swing_rad);
    motion.position_counts = middle_counts;
    swing.rest_nm = played_.torque_nm(swing.state, motion);
    for (std::size_t i = 0; i < phases_.size(); ++i) {
      const std::int64_t before = motion.position_counts;
      const double way = phases_.at(i).imag();
      const double counts =
          in_a_count ? (way > -0.1 ? 1.0 : 0.0) : swing_rad * way / double{parts_.rad_per_count};
      motion.position_counts = middle_counts + std::llround(counts);
      motion.delta_rad = static_cast<float>(motion.position_counts - before) * parts_.rad_per_count;
      if (i < kPhases) {
        static_cast<void>(played_.torque_nm(swing.state, motion));
      } else {
        swing.way.at(i - kPhases) = motion;
      }
    }
    return swing;
  }

  /// The device's answer to the knob's swing, as a share of it: the describing function of scene
  /// and motor.
  [[nodiscard]] Complex follow(const Swing& swing, const Tone& tone) const {
    core::SceneState state = swing.state;
    const double motor_nm = double{parts_.motor_torque_max_nm};
    Complex sum;
    for (std::size_t i = 0; i < kPhases; ++i) {
      const Complex phase = phases_.at(kPhases + i);
      core::Motion motion = swing.way.at(i);
      motion.speed_rad_s = static_cast<float>(swing.rad * (tone.speed * phase).imag());
      motion.acceleration_rad_s2 =
          static_cast<float>(swing.rad * (tone.acceleration * phase).imag());
      const double nm = played_.torque_nm(state, motion) - swing.rest_nm;
      sum += std::clamp(nm, -motor_nm, motor_nm) * std::conj(phase);
    }
    return sum * Complex(0.0, -2.0 / (kPhases * swing.rad));
  }

  [[nodiscard]] Complex push(const Swing& swing, const Tone& tone) const {
    const Complex pushes = follow(swing, tone);
    // (8'): a count is a step of the torque.
    const double step_nm = 0.5 * std::abs(pushes) * double{parts_.rad_per_count};
    return pushes / std::max(1.0 - step_nm / double{parts_.motor_torque_max_nm}, 0.01);
  }

  [[nodiscard]] Complex at(Complex pushes, double swing_rad, const Tone& tone) const {
    // The brake's part of a spring does not come late.
    const double carried = std::min(double{parts_.spring_stiffness_nm_per_rad},
                                    double{parts_.brake_share} * std::max(pushes.real(), 0.0));
    const double friction = friction_nm_per_rad(parts_, swing_rad);
    const Complex knob(-double{parts_.knob_inertia_kg_m2} * tone.rad_s * tone.rad_s,
                       double{parts_.knob_viscous_nm_s_per_rad} * tone.rad_s + friction);
    return knob + carried + (pushes - carried) * tone.late;
  }

  const Played& played_;
  core::Parts parts_;
  std::array<Tone, kTones> tones_;
  std::array<Complex, 2 * kPhases> phases_;  // the first time round for what remembers
  std::vector<Surroundings> round_;
};

}  // namespace

std::string swing_warning(std::span<const protocol::ReportBytes> reports,
                          const protocol::ActuatorConfig& actuator,
                          const protocol::ControlConfig& control, std::uint32_t control_period_ns,
                          std::atomic<double>& rests_nm_per_rad, bool host_moves) {
  const auto resolution = core::make_resolution(actuator.counts_per_rev, control_period_ns);
  const bool bounds = !host_moves && core::traits(static_cast<core::Law>(control.law)).bounds;
  const double slope_nm_per_rad = slope_of(reports, resolution, bounds);
  if (slope_nm_per_rad <= rests_nm_per_rad) return {};
  const core::Parts parts = device::wall_parts(actuator, control, resolution);
  if (surely_rest(parts, slope_nm_per_rad)) {
    rests_nm_per_rad = slope_nm_per_rad;
    return {};
  }
  const Played played(reports, resolution, bounds,
                      device::stable_damping(actuator, control, resolution.period_s));
  if (!played.plays) return {};
  const Loop loop(played, parts, double{control.speed_bandwidth_hz});
  const bool swings = loop.swings();
  if (!swings && !loop.hums()) return {};
  return (swings ? "let go, the knob may swing in this for ever: together the effects are stiffer, "
                   "damp more or have more inertia than its parts can render at " +
                       std::to_string(1'000'000'000 / control_period_ns) + " Hz"
                 : "at rest the knob may hum in this: a count of its encoder switches more torque "
                   "than its friction holds") +
         "; ask for less. The law 'calibrated' bounds scenes and local models, but no law bounds a "
         "wall's damping, inertia or what a host moves";
}

}  // namespace torsio::conversion
