/// @file
/// The parts of a Knob.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "connection.hpp"
#include "conversion/configuration.hpp"
#include "conversion/reading.hpp"
#include "conversion/wire_types.hpp"
#include "known_boards.hpp"
#include "scene_player.hpp"
#include "session.hpp"
#include "swing_warnings.hpp"
#include "telemetry_stream.hpp"
#include "torsio/knob.hpp"

namespace torsio {

class Knob::Impl {
 public:
  Impl(Connection connection, const OpenOptions& options);

  /// @throws Closed
  static Impl& of(KnobConfigurations& part) { return static_cast<Knob&>(part).impl(); }

  std::string play(const Scene& scene) {
    const protocol::Identity device = identity();
    const conversion::EncodedScene encoded = conversion::encode(
        conversion::to_wire(scene, {.effects = device.effects,
                                    .curve_points = device.curve_points,
                                    .counts_per_rev = device.counts_per_rev,
                                    .control_period_ns = device.control_period_ns}));
    player.play(encoded);
    std::vector<protocol::ReportBytes> reports = encoded.pieces;
    for (const auto& slot : encoded.slots) reports.push_back(slot.report);
    const bool moves = warnings.keep(reports);
    return warnings.of_all(reports, moves);
  }

  std::string stream(const LocalModel& model) {
    const protocol::ReportBytes report = protocol::encode(conversion::to_wire(model));
    session.requests.send_while_armed(report);
    return warnings.of(model, report);
  }

  [[nodiscard]] protocol::Identity identity() const {
    const std::lock_guard lock(mutex_);
    return identity_;
  }
  [[nodiscard]] DeviceInfo info() const {
    const std::lock_guard lock(mutex_);
    return info_;
  }

  /// A report in the user's structure, without values that need more than one of its numbers.
  template <class Host, class Report>
  Host read(const Report& report) const {
    return conversion::read<Host>(report, identity());
  }

  Clock clock() {
    const auto report = session.requests.get<protocol::Clock>();
    auto clock = read<Clock>(report);
    clock.angle_rad = conversion::angle_rad(report.position_counts, identity());
    return clock;
  }

  template <class Config>
  Config config() {
    using Wire = typename WireType<Config>::type;
    return conversion::convert_back<Config>(session.requests.get<Wire>());
  }

  template <class Config>
  void configure(const Config& config) {
    const device::WiringRule rule = wiring_rule(identity().board);
    if constexpr (std::is_same_v<Config, BoardConfig>) {
      const auto actuator = session.requests.get<protocol::ActuatorConfig>();
      session.requests.set(conversion::to_wire(config, rule, actuator.encoder_index_pin));
    } else if constexpr (std::is_same_v<Config, ActuatorConfig>) {
      session.requests.set(
          conversion::to_wire(config, rule, session.requests.get<protocol::BoardConfig>()));
    } else if constexpr (std::is_same_v<Config, ControlConfig>) {
      const protocol::ControlConfig wire = conversion::to_wire(config);
      while_unsure([&] { session.requests.set(wire); });
    } else {
      session.requests.set(conversion::to_wire(config));
    }
    // Units, signs of life and warnings of a scene depend on these.
    if constexpr (std::is_same_v<Config, ActuatorConfig> || std::is_same_v<Config, ControlConfig>) {
      look_again();
    }
  }

  template <class Config>
  static void update(KnobConfigurations& part, const std::function<void(Config&)>& change) {
    Config changed = of(part).template config<Config>();
    change(changed);
    of(part).configure(changed);
  }

  /// Until the device has said whether it is autonomous, close() lets go.
  void while_unsure(const std::function<void()>& change) {
    const bool was = autonomous_.exchange(false);
    try {
      change();
    } catch (const Refused&) {
      autonomous_ = was;
      throw;
    }
  }

  void note(const protocol::ControlConfig& config) {
    session.link.set_watchdog(static_cast<double>(config.watchdog_s));
    autonomous_ = config.autonomous == protocol::Toggle::on;
  }

  /// The configuration has changed: units may be others, and the scene may be gone.
  void look_again() {
    const auto identity = session.requests.get<protocol::Identity>();
    bool had_other_counts = false;
    {
      const std::lock_guard lock(mutex_);
      had_other_counts = identity_.counts_per_rev != identity.counts_per_rev;
      identity_ = identity;
      conversion::read_into(info_, identity, identity);
    }
    session.set_identity(identity);
    note(session.requests.get<protocol::ControlConfig>());
    warnings.forget_configurations();
    if (had_other_counts) {
      forget_scene();
    } else {
      player.forget();
    }
  }

  void forget_scene() {
    player.forget_playing();
    warnings.keep({});
  }

  bool close() noexcept { return session.close(!autonomous_); }
  void disarm_to_close() noexcept {
    if (!autonomous_ && session.link.is_open()) session.disarm_quietly();
  }

  Session session;
  ScenePlayer player;
  TelemetryStream telemetry;
  SwingWarnings warnings;
  std::unique_ptr<Emulator> emulator;

 private:
  Impl(const protocol::Identity& identity, Connection& connection, const OpenOptions& options);

  mutable std::mutex mutex_;  // guards the next two
  protocol::Identity identity_;
  DeviceInfo info_;
  std::atomic<bool> autonomous_{false};
};

}  // namespace torsio
