#include "torsio/knob.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "conversion/energies.hpp"
#include "conversion/reading.hpp"
#include "conversion/stability.hpp"
#include "knob_impl.hpp"
#include "limits.hpp"
#include "protocol/registry.hpp"
#include "protocol_names.hpp"

namespace torsio {
namespace {

// In the ring, and of one read(): an hour at the highest rate, 1 GB. More is a slip of the pen.
constexpr std::size_t kMaxHeldSamples = std::size_t{1} << 24U;

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
  if (!protocol::drives(fingerprint)) {
    throw ProtocolMismatch(
        "the device speaks protocol version " + std::to_string(version) + " (fingerprint " +
        hex32(fingerprint) + "), this library version " +
        std::to_string(protocol::protocol_version) + " (fingerprint " +
        hex32(protocol::fingerprint()) +
        "): install firmware and library of the same release, update the older of the two");
  }
  protocol::Identity identity;
  if (!protocol::decode(bytes, identity).ok()) {
    throw Error("the device's identity is damaged; unplug it and plug it in again");
  }
  return identity;
}

DeviceInfo describe(const protocol::Identity& identity, const Connection& connection) {
  auto info = conversion::read<DeviceInfo>(identity, identity);
  info.path = connection.path;
  const auto end = std::ranges::find(identity.serial, std::uint8_t{0});
  info.serial.assign(identity.serial.begin(), end);
  std::ranges::replace_if(info.serial, [](char c) { return c < ' ' || c > '~'; }, '?');
  info.product = connection.product;
  info.board = board_name(identity.board);
  for (const std::uint8_t part : identity.firmware_version) {
    if (!info.firmware_version.empty()) info.firmware_version += ".";
    info.firmware_version += std::to_string(part);
  }
  info.transport = connection.kind;
  info.protocol_version = identity.version;
  info.control_rate_hz = 1e9 / identity.control_period_ns;
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

}  // namespace

Knob::Impl::Impl(Connection connection, const OpenOptions& options)
    : Impl(identify(*connection.transport), connection, options) {}

Knob::Impl::Impl(const protocol::Identity& identity, Connection& connection,
                 const OpenOptions& options)
    : session(std::move(connection.transport), session_options(options)),
      player(session.link, session.requests),
      telemetry(session.device, session.requests, session.samples,
                session_options(options).command_timeout_ns),
      warnings(session.requests, identity.control_period_ns),
      identity_(identity),
      info_(describe(identity, connection)) {
  if (connection.make_emulator) emulator = connection.make_emulator(session.link);
  session.set_identity(identity_);
  telemetry.set_control_period(identity_.control_period_ns);
  session.device.note(session.requests.get<protocol::Health>());
  note(session.requests.get<protocol::ControlConfig>());
  session.link.start();
}

Knob::Knob(Connection connection, const OpenOptions& options)
    : impl_(std::make_unique<Impl>(std::move(connection), options)) {}
Knob::Knob(Knob&&) noexcept = default;

Knob& Knob::operator=(Knob&& other) noexcept {
  if (this != &other) {
    close_and_drop();
    impl_ = std::move(other.impl_);
  }
  return *this;
}

Knob::~Knob() { close_and_drop(); }

void Knob::close_and_drop() noexcept {
  close();
  if (impl_ == nullptr || !impl_->session.link.is_held()) return;
  [[maybe_unused]] const Impl* left_to_the_reader = impl_.release();
}

Knob::Impl& Knob::impl() const {
  if (impl_ != nullptr) impl_->session.link.throw_unless_here();
  if (!is_open()) throw Closed("the knob was closed; open it again");
  return *impl_;
}

bool Knob::close() noexcept {
  if (impl_ == nullptr) return true;
  if (impl_->session.link.is_here()) return impl_->close();
  // Its threads are not here to be joined, nor its locks to be had.
  [[maybe_unused]] const Impl* left_to_the_parent = impl_.release();
  return true;
}

void Knob::disarm_to_close() noexcept {
  if (impl_ != nullptr) impl_->disarm_to_close();
}

bool Knob::is_open() const noexcept { return impl_ != nullptr && impl_->session.link.is_open(); }

DeviceInfo Knob::info() const { return impl().info(); }
State Knob::state() const { return impl().session.device.state(); }
StableStiffness Knob::stable_stiffness() {
  Impl& knob = impl();
  return conversion::stable_stiffness(knob.session.requests.get<protocol::ActuatorConfig>(),
                                      knob.session.requests.get<protocol::ControlConfig>(),
                                      knob.identity().control_period_ns);
}
std::optional<Disarm> Knob::last_disarm() const { return impl().session.device.last_disarm(); }
std::shared_ptr<ReportTap> Knob::tap(bool with_telemetry) {
  return impl().player.tap(with_telemetry);
}
ReportBytes Knob::feature(std::uint8_t report_id) {
  return impl().session.requests.get_feature(report_id);
}
LinkStatistics Knob::statistics() const { return impl().session.statistics(); }
bool Knob::is_emulated() const { return impl().emulator != nullptr; }

Emulator& Knob::emulator() const {
  if (!is_emulated()) throw Error("this knob is real hardware: it has no emulator");
  return *impl().emulator;
}

std::vector<std::string> Knob::faults() { return health().faults; }

Health Knob::health() {
  const auto report = impl().session.requests.get<protocol::Health>();
  impl().session.device.note(report);
  auto health = impl().read<Health>(report);
  health.faults = fault_names(report.faults);
  return health;
}

Energies Knob::energies() {
  return conversion::energies(impl().session.requests.get<protocol::Ledger>(), impl().identity());
}

MotorCurrent Knob::motor_current() {
  const auto sums = impl().session.requests.get<protocol::MotorCurrent>();
  auto current = impl().read<MotorCurrent>(sums);
  const double step_a = static_cast<double>(sums.a_per_step);
  const double zero = static_cast<double>(sums.zero);
  current.time_s = static_cast<double>(sums.periods) * current.period_s;
  current.angle_rad = conversion::angle_rad(sums.position_counts, impl().identity());
  current.current_a = (sums.reading - zero) * step_a;
  current.zero_a = zero * step_a;
  current.step_a = std::abs(step_a);
  current.current_sum_a = static_cast<double>(sums.reading_sum) * step_a;
  if (sums.a_per_nm > 0.0F) {
    current.torque_constant_nm_per_a = 1.0 / static_cast<double>(sums.a_per_nm);
  }
  return current;
}

Limits Knob::limits() {
  const protocol::Identity device = impl().identity();
  const auto actuator = impl().session.requests.get<protocol::ActuatorConfig>();
  const auto control = impl().session.requests.get<protocol::ControlConfig>();
  return limits_of(actuator, control, impl().session.requests.get<protocol::BoardConfig>(),
                   impl().session.requests.get<protocol::CalibrationConfig>(),
                   moves_parts(device.board));
}

GameStatus Knob::game_status() {
  const auto monitor = impl().session.requests.get<protocol::GameMonitor>();
  auto status = impl().read<GameStatus>(monitor);
  status.time_s = conversion::time_s(monitor.tick, impl().identity());
  return status;
}

std::vector<GameEffect> Knob::game_effects() {
  std::map<int, GameEffect> found;
  // Each report shows the next few, so this many show all, unless a game makes some meanwhile.
  int reports = 1;
  for (int n = 0; n < reports; ++n) {
    const auto monitor = impl().session.requests.get<protocol::GameMonitor>();
    const int rows = static_cast<int>(monitor.effect.size());
    reports = std::max(reports, (monitor.effects + rows - 1) / rows);
    for (const protocol::GameEffect& effect : monitor.effect) {
      if (effect.block != 0) found[effect.block] = impl().read<GameEffect>(effect);
    }
  }
  std::vector<GameEffect> effects;
  for (const auto& [block, effect] : found) effects.push_back(effect);
  return effects;
}

Clock Knob::clock() { return impl().clock(); }
double Knob::position_rad() { return impl().clock().angle_rad; }

void Knob::arm() { impl().session.requests.command(protocol::Op::arm); }
void Knob::disarm() { impl().session.requests.command(protocol::Op::disarm); }
void Knob::relax() { impl().session.requests.command(protocol::Op::relax); }
void Knob::clear_fault() { impl().session.requests.command(protocol::Op::clear_fault); }
void Knob::save() { impl().session.requests.command(protocol::Op::save); }

void Knob::stop() {
  impl().session.requests.command(protocol::Op::stop);
  impl().forget_scene();
}

void Knob::zero() {
  impl().session.requests.command(protocol::Op::zero);
  impl().session.samples.set_position(
      impl().session.requests.get<protocol::Clock>().position_counts);
}

std::string Knob::play(const Scene& scene) { return impl().play(scene); }

std::string Knob::stream_local_model(const LocalModel& model) { return impl().stream(model); }

void Knob::excite(const Excitation& excitation) {
  impl().session.requests.request(conversion::to_wire(excitation));
}

void Knob::load_defaults() {
  impl().while_unsure([this] { impl().session.requests.command(protocol::Op::load_defaults); });
  impl().look_again();
}

std::vector<Event> Knob::events(double timeout_s) {
  return impl().session.device.take_events(whole_ns("timeout_s", timeout_s));
}

void Knob::on_event(std::function<void(const Event&)> callback) {
  impl().session.device.events.set_callback(std::move(callback));
}

double Knob::start_telemetry(std::optional<double> rate_hz, bool prompt) {
  return impl().telemetry.start(rate_hz, prompt);
}
void Knob::stop_telemetry() { impl().telemetry.stop(); }
TelemetrySample Knob::latest() { return impl().telemetry.latest(); }

std::size_t Knob::read(std::span<TelemetrySample> out, double timeout_s) {
  return impl().session.samples.read(out, whole_ns("timeout_s", timeout_s));
}

std::vector<TelemetrySample> Knob::read(std::size_t max_samples, double timeout_s) {
  std::vector<TelemetrySample> samples(checked_samples("max_samples", max_samples, 0));
  samples.resize(read(std::span(samples), timeout_s));
  return samples;
}

TelemetryRecord Knob::record(double duration_s, std::optional<double> rate_hz,
                             bool must_stay_armed) {
  TelemetryRecord samples;
  try {
    record(samples, duration_s, rate_hz, must_stay_armed);
  } catch (Error& error) {
    error.keep_samples(std::make_shared<const std::vector<TelemetrySample>>(std::move(samples)));
    throw;
  }
  return samples;
}

void Knob::record(TelemetryRecord& into, double duration_s, std::optional<double> rate_hz,
                  bool must_stay_armed) {
  impl().telemetry.record(into, whole_ns("duration_s", duration_s), rate_hz, must_stay_armed);
}

void Knob::sleep(double duration_s) {
  impl().session.link.sleep(whole_ns("duration_s", duration_s));
}

Steps Knob::every(double period_s) {
  // False for NaN.
  if (!(period_s >= 1e-4 && period_s <= 3600.0)) {
    throw InvalidArgument("period_s is " + number_text(period_s) +
                          ", allowed are 0.0001 to 3600 s");
  }
  return {impl().session, whole_ns("period_s", period_s)};
}

Step Steps::wait() {
  Link& link = session_->link;
  link.throw_unless_here();
  if (!begin_ns_) {
    begin_ns_ = link.now_ns();
    due_ns_ = *begin_ns_;
  }
  const std::int64_t overdue = std::max<std::int64_t>(link.now_ns() - due_ns_, 0) / period_ns_;
  next_.late_steps += static_cast<std::uint64_t>(overdue);
  due_ns_ += overdue * period_ns_;
  link.sleep(std::max<std::int64_t>(due_ns_ - link.now_ns(), 0));
  const Step step{next_.index, 1e-9 * static_cast<double>(due_ns_ - *begin_ns_), next_.late_steps};
  ++next_.index;
  due_ns_ += period_ns_;
  return step;
}

bool Knob::wait_for(State state, double timeout_s) {
  return impl().session.device.wait_for(state, whole_ns("timeout_s", timeout_s));
}

}  // namespace torsio
