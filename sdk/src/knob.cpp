#include "torsio/knob.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <map>
#include <mutex>
#include <numbers>
#include <optional>
#include <utility>

#include "connection.hpp"
#include "conversion/configuration.hpp"
#include "known_boards.hpp"
#include "protocol/registry.hpp"
#include "protocol_names.hpp"
#include "scene_player.hpp"
#include "session.hpp"

namespace torsio {
namespace {

// Full speed USB polls once in a millisecond. Where the user names no rate a tenth of that is left
// for acknowledgements and events. At the full rate each of these makes telemetry a millisecond
// later, for good; the device's buffer of 64 samples has room for a dozen of them.
constexpr double kMaxSampleRateHz = 1000.0 * protocol::samples_per_report;
constexpr double kEasySampleRateHz = 900.0 * protocol::samples_per_report;

// Of one recording, which is held in memory: a day of samples at 1,000 a second, about 6 GB.
constexpr double kMaxRecordedSamples = 1e8;

// In the ring, and of one read(): an hour at the highest rate, 1 GB. More is a slip of the pen.
constexpr std::size_t kMaxHeldSamples = std::size_t{1} << 24U;

/// Control ticks from sample to sample at the highest rate that is not above `sample_rate_hz`; a
/// little room for control rates that were computed.
double fewest_ticks(double control_rate_hz, double sample_rate_hz) {
  return std::ceil(control_rate_hz / std::min(control_rate_hz, sample_rate_hz) * (1 - 1e-9));
}

/// @throws ProtocolMismatch, Error, Disconnected
protocol::Identity identify(Transport& transport) {
  protocol::ReportBytes bytes{};
  if (!transport.get_feature(protocol::Layout<protocol::Identity>::id, bytes)) {
    throw Error("the device does not say who it is; is it a Torsio knob?");
  }
  // Fingerprint and version have their place in every version of the protocol, and only they.
  const auto byte = [&](std::size_t at) { return static_cast<std::uint32_t>(bytes.at(at)); };
  const std::uint32_t fingerprint = byte(1) | byte(2) << 8U | byte(3) << 16U | byte(4) << 24U;
  const std::uint32_t version = byte(5) | byte(6) << 8U;
  if (fingerprint != protocol::fingerprint()) {
    throw ProtocolMismatch(
        "the device speaks protocol version " + std::to_string(version) + " (fingerprint " +
        hex32(fingerprint) + "), this library version " +
        std::to_string(protocol::protocol_version) + " (fingerprint " +
        hex32(protocol::fingerprint()) +
        "): install firmware and library of the same release, update the older of the two");
  }
  protocol::Identity identity;
  if (!protocol::decode(bytes, identity).ok() || identity.control_period_ns == 0 ||
      identity.counts_per_rev == 0) {
    throw Error("the device's identity is damaged; unplug it and plug it in again");
  }
  return identity;
}

DeviceInfo describe(const protocol::Identity& identity, const Connection& connection) {
  DeviceInfo info;
  info.path = connection.path;
  const auto end = std::ranges::find(identity.serial, std::uint8_t{0});
  info.serial.assign(identity.serial.begin(), end);
  info.product = connection.product;
  info.board = board_name(identity.board);
  for (const std::uint8_t part : identity.firmware_version) {
    if (!info.firmware_version.empty()) info.firmware_version += ".";
    info.firmware_version += std::to_string(part);
  }
  info.transport = connection.kind;
  info.protocol_version = identity.version;
  info.fingerprint = identity.fingerprint;
  info.axes = identity.axes;
  info.effects = identity.effects;
  info.curve_points = identity.curve_points;
  info.control_rate_hz = 1e9 / identity.control_period_ns;
  info.counts_per_rev = identity.counts_per_rev;
  info.torque_step_nm = static_cast<double>(identity.torque_step_nm);
  info.speed_step_rad_s = static_cast<double>(identity.speed_step_rad_s);
  return info;
}

/// @throws InvalidArgument
std::size_t checked_samples(std::string_view name, std::size_t samples, std::size_t min) {
  if (samples >= min && samples <= kMaxHeldSamples) return samples;
  throw InvalidArgument(std::string(name) + " is " + std::to_string(samples) + ", allowed are " +
                        std::to_string(min) + " to " + std::to_string(kMaxHeldSamples));
}

SessionOptions session_options(const OpenOptions& options) {
  return {.command_timeout_ns = whole_ns("command_timeout_s", options.command_timeout_s),
          .ring_samples = checked_samples("ring_samples", options.ring_samples, 1),
          .interrupted = options.interrupted};
}

template <class Config>
Config changed(Config config, const std::function<void(Config&)>& change) {
  change(config);
  return config;
}

}  // namespace

class Knob::Impl {
 public:
  Impl(Connection connection, const OpenOptions& options)
      : identity_(identify(*connection.transport)),
        info_(describe(identity_, connection)),
        command_timeout_ns_(session_options(options).command_timeout_ns),
        session(std::move(connection.transport), session_options(options)),
        player(session) {
    if (connection.make_emulator) emulator = connection.make_emulator(session);
    session.set_identity(identity_);
    session.note(session.get<protocol::Health>());
    note(session.get<protocol::ControlConfig>());
  }

  void command(protocol::Op op) { session.request(protocol::Command{0, 0, op}); }

  void play(const Scene& scene) {
    const protocol::Identity device = identity();
    player.play(conversion::encode(
        conversion::to_wire(scene, {.effects = device.effects,
                                    .curve_points = device.curve_points,
                                    .counts_per_rev = device.counts_per_rev,
                                    .control_period_ns = device.control_period_ns})));
  }

  [[nodiscard]] protocol::Identity identity() const {
    const std::lock_guard lock(mutex_);
    return identity_;
  }
  [[nodiscard]] DeviceInfo info() const {
    const std::lock_guard lock(mutex_);
    return info_;
  }

  Clock clock() {
    const auto clock = session.get<protocol::Clock>();
    const double turns = static_cast<double>(clock.position_counts) / identity().counts_per_rev;
    return {clock.tick, 1e-9 * static_cast<double>(clock.time_ns), clock.position_counts,
            turns * 2.0 * std::numbers::pi};
  }

  void note(const protocol::ControlConfig& config) {
    session.set_watchdog(static_cast<double>(config.watchdog_s));
    autonomous_ = config.autonomous == protocol::Toggle::on;
  }

  /// The configuration has changed: units may be others, and the scene may be gone.
  void look_again() {
    const auto identity = session.get<protocol::Identity>();
    {
      const std::lock_guard lock(mutex_);
      identity_ = identity;
      info_.counts_per_rev = identity.counts_per_rev;
      info_.torque_step_nm = static_cast<double>(identity.torque_step_nm);
    }
    session.set_identity(identity);
    note(session.get<protocol::ControlConfig>());
    player.forget();
  }

  double start_telemetry(std::optional<double> rate_hz) {
    const double control_rate_hz = 1e9 / identity().control_period_ns;
    const double highest_hz = std::min(control_rate_hz, kMaxSampleRateHz);
    const double lowest_hz = control_rate_hz / 255.0;
    double ticks = fewest_ticks(control_rate_hz, kEasySampleRateHz);
    if (rate_hz) {
      // The comparison is also false for NaN; a little room for rates that were computed.
      if (!(*rate_hz >= lowest_hz * (1 - 1e-9) && *rate_hz <= highest_hz * (1 + 1e-9))) {
        throw InvalidArgument("rate_hz is " + number_text(*rate_hz) + ", allowed are " +
                              number_text(lowest_hz) + " to " + number_text(highest_hz) +
                              " Hz with this knob; without a rate it takes the highest that "
                              "leaves room for answers");
      }
      ticks = std::clamp(std::round(control_rate_hz / *rate_hz),
                         fewest_ticks(control_rate_hz, kMaxSampleRateHz), 255.0);
    }
    session.set_position(session.get<protocol::Clock>().position_counts);
    session.stream(static_cast<std::uint8_t>(ticks));
    decimation_ = static_cast<unsigned>(ticks);
    return control_rate_hz / ticks;
  }

  void stop_telemetry() {
    session.stream(0);
    decimation_ = 0;
  }

  std::vector<TelemetrySample> record(double duration_s, std::optional<double> rate_hz) {
    const std::int64_t duration_ns = whole_ns("duration_s", duration_s);
    if (rate_hz) start_telemetry(rate_hz);
    const unsigned decimation = decimation_;
    const bool starts = decimation == 0;
    const double control_rate_hz = 1e9 / identity().control_period_ns;
    const double longest_s =
        kMaxRecordedSamples *
        (starts ? fewest_ticks(control_rate_hz, kEasySampleRateHz) : decimation) / control_rate_hz;
    if (duration_s > longest_s) {
      throw InvalidArgument("duration_s is " + number_text(duration_s) + ", allowed are 0 to " +
                            number_text(longest_s) +
                            " s at this rate; for more take samples with read() as they come");
    }
    if (starts) start_telemetry({});
    const auto first_tick = session.get<protocol::Clock>().tick;
    const auto ticks = static_cast<std::uint64_t>(
        std::llround(static_cast<double>(duration_ns) / identity().control_period_ns));
    const std::int64_t report_ns =
        std::int64_t{protocol::samples_per_report} * decimation_ * identity().control_period_ns;
    std::vector<TelemetrySample> samples = session.collect(
        first_tick, first_tick + ticks, decimation_, command_timeout_ns_ + report_ns);
    if (starts) stop_telemetry();
    return samples;
  }

  void close() noexcept { session.close(!autonomous_); }

 private:
  mutable std::mutex mutex_;  // guards the next two
  protocol::Identity identity_;
  DeviceInfo info_;
  const std::int64_t command_timeout_ns_;
  std::atomic<bool> autonomous_{false};
  std::atomic<unsigned> decimation_{0};  // of telemetry; 0: off

 public:
  Session session;
  ScenePlayer player;
  std::unique_ptr<Emulator> emulator;
};

Knob::Knob(Connection connection, const OpenOptions& options)
    : impl_(std::make_unique<Impl>(std::move(connection), options)) {}
Knob::Knob(Knob&&) noexcept = default;

Knob& Knob::operator=(Knob&& other) noexcept {
  if (this != &other) {
    close();
    impl_ = std::move(other.impl_);
  }
  return *this;
}

Knob::~Knob() { close(); }

Knob::Impl& Knob::impl() const {
  if (!is_open()) throw Closed("the knob was closed; open it again");
  return *impl_;
}

void Knob::close() noexcept {
  if (impl_ != nullptr) impl_->close();
}

bool Knob::is_open() const noexcept { return impl_ != nullptr && impl_->session.is_open(); }

DeviceInfo Knob::info() const { return impl().info(); }
State Knob::state() const { return impl().session.state(); }
LinkStatistics Knob::statistics() const { return impl().session.statistics(); }
bool Knob::is_emulated() const { return impl().emulator != nullptr; }

Emulator& Knob::emulator() const {
  if (!is_emulated()) throw Error("this knob is real hardware: it has no emulated world");
  return *impl().emulator;
}

std::vector<std::string> Knob::faults() { return health().faults; }

Health Knob::health() {
  const auto health = impl().session.get<protocol::Health>();
  impl().session.note(health);
  return {.state = static_cast<State>(health.state),
          .faults = fault_names(health.faults),
          .reports_accepted = health.reports_accepted,
          .reports_refused = health.reports_refused,
          .samples_dropped = health.samples_dropped,
          .tick_overruns = health.tick_overruns,
          .tick_time_s = 1e-9 * health.tick_time_ns,
          .tick_time_max_s = 1e-9 * health.tick_time_max_ns,
          .saves = health.saves,
          .owner = static_cast<Owner>(health.owner)};
}

GameStatus Knob::game_status() {
  const auto monitor = impl().session.get<protocol::GameMonitor>();
  const DeviceInfo info = impl().info();
  return {.time_s = static_cast<double>(monitor.tick) / info.control_rate_hz,
          .owner = static_cast<Owner>(monitor.owner),
          .paused = monitor.paused == protocol::Toggle::on,
          .enabled = monitor.enabled == protocol::Toggle::on,
          .gain = monitor.gain / 32767.0,
          .torque_nm = monitor.torque * info.torque_step_nm,
          .updates = monitor.updates,
          .effects = monitor.effects};
}

std::vector<GameEffect> Knob::game_effects() {
  const DeviceInfo info = impl().info();
  std::map<int, GameEffect> found;
  // Each report shows the next few, so this many show all, unless a game makes some meanwhile.
  int reports = 1;
  for (int n = 0; n < reports; ++n) {
    const auto monitor = impl().session.get<protocol::GameMonitor>();
    const int rows = static_cast<int>(monitor.effect.size());
    reports = std::max(reports, (monitor.effects + rows - 1) / rows);
    for (const protocol::GameEffect& effect : monitor.effect) {
      if (effect.block == 0) continue;
      found[effect.block] = {.block = effect.block,
                             .kind = static_cast<GameEffectKind>(effect.kind),
                             .state = static_cast<GameEffectState>(effect.state),
                             .torque_nm = effect.torque * info.torque_step_nm,
                             .updates = effect.updates,
                             .silent_s = 1e-3 * effect.silent_ms};
    }
  }
  std::vector<GameEffect> effects;
  for (const auto& [block, effect] : found) effects.push_back(effect);
  return effects;
}

Clock Knob::clock() { return impl().clock(); }
double Knob::position_rad() { return impl().clock().angle_rad; }

void Knob::arm() { impl().command(protocol::Op::arm); }
void Knob::disarm() { impl().command(protocol::Op::disarm); }
void Knob::relax() { impl().command(protocol::Op::relax); }
void Knob::clear_fault() { impl().command(protocol::Op::clear_fault); }
void Knob::save() { impl().command(protocol::Op::save); }

void Knob::stop() {
  impl().command(protocol::Op::stop);
  impl().player.forget();
}

void Knob::zero() {
  impl().command(protocol::Op::zero);
  impl().session.set_position(impl().session.get<protocol::Clock>().position_counts);
}

void Knob::play(const Scene& scene) { impl().play(scene); }

void Knob::stream_local_model(const LocalModel& model) {
  const protocol::ReportBytes report = protocol::encode(conversion::to_wire(model));
  impl().session.send_while_armed(report);
}

ActuatorConfig Knob::actuator_config() {
  return conversion::convert_back<ActuatorConfig>(impl().session.get<protocol::ActuatorConfig>());
}

ControlConfig Knob::control_config() {
  return conversion::convert_back<ControlConfig>(impl().session.get<protocol::ControlConfig>());
}

BoardConfig Knob::board_config() {
  return conversion::convert_back<BoardConfig>(impl().session.get<protocol::BoardConfig>());
}

GameConfig Knob::game_config() {
  return conversion::convert_back<GameConfig>(impl().session.get<protocol::GameConfig>());
}

void Knob::configure(const ActuatorConfig& config) {
  impl().session.set(conversion::to_wire(config));
  impl().look_again();
}

void Knob::configure(const ControlConfig& config) {
  impl().session.set(conversion::to_wire(config));
  impl().look_again();
}

void Knob::configure(const BoardConfig& config) {
  impl().session.set(conversion::to_wire(config, wiring_rule(impl().identity().board)));
}

void Knob::configure(const GameConfig& config) { impl().session.set(conversion::to_wire(config)); }

void Knob::update(const std::function<void(ActuatorConfig&)>& change) {
  configure(changed(actuator_config(), change));
}

void Knob::update(const std::function<void(ControlConfig&)>& change) {
  configure(changed(control_config(), change));
}

void Knob::update(const std::function<void(BoardConfig&)>& change) {
  configure(changed(board_config(), change));
}

void Knob::update(const std::function<void(GameConfig&)>& change) {
  configure(changed(game_config(), change));
}

void Knob::load_defaults() {
  impl().command(protocol::Op::load_defaults);
  impl().look_again();
}

double Knob::start_telemetry(std::optional<double> rate_hz) {
  return impl().start_telemetry(rate_hz);
}
void Knob::stop_telemetry() { impl().stop_telemetry(); }

std::size_t Knob::read(std::span<TelemetrySample> out, double timeout_s) {
  return impl().session.read(out, whole_ns("timeout_s", timeout_s));
}

std::vector<TelemetrySample> Knob::read(std::size_t max_samples, double timeout_s) {
  std::vector<TelemetrySample> samples(checked_samples("max_samples", max_samples, 0));
  samples.resize(read(std::span(samples), timeout_s));
  return samples;
}

std::vector<TelemetrySample> Knob::record(double duration_s, std::optional<double> rate_hz) {
  return impl().record(duration_s, rate_hz);
}

void Knob::sleep(double duration_s) { impl().session.sleep(whole_ns("duration_s", duration_s)); }

bool Knob::wait_for(State state, double timeout_s) {
  return impl().session.wait_for(state, whole_ns("timeout_s", timeout_s));
}

}  // namespace torsio
