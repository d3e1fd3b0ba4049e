#include "device/device.hpp"

#include <algorithm>
#include <new>
#include <type_traits>
#include <utility>

#include "device/prepare.hpp"
#include "protocol/registry.hpp"

namespace torsio::device {
namespace {

using protocol::Direction;
using protocol::Layout;
using protocol::Op;
using protocol::report_size;
using protocol::State;
using protocol::Status;
using protocol::Verdict;

Order order_of(Order::Kind kind) {
  Order order;
  order.kind = kind;
  return order;
}

Order refusal(Verdict verdict) {
  Order order;
  order.verdict = verdict;
  return order;
}

template <class Report>
std::uint8_t axis_of(const Report& report) {
  if constexpr (requires { report.target; }) {
    return report.target.axis;
  } else {
    return report.axis;
  }
}

/// Reports that the host may send in this direction.
template <class Report>
constexpr bool accepted_as(Direction direction) {
  constexpr bool read_only =
      std::is_same_v<Report, protocol::Identity> || std::is_same_v<Report, protocol::Clock> ||
      std::is_same_v<Report, protocol::Health> || std::is_same_v<Report, protocol::GameMonitor> ||
      std::is_same_v<Report, protocol::Ledger> || std::is_same_v<Report, protocol::MotorCurrent>;
  return Layout<Report>::direction == direction && !read_only && direction != Direction::input;
}

/// Once for all who call it: inlined it would take several kB of a small board's RAM.
template <class Report>
[[gnu::noinline]] Verdict decode_apart(std::span<const std::uint8_t> bytes, Report& report) {
  return protocol::decode(bytes, report);
}

/// Calls `visit(report, verdict)` with the report that the bytes hold, if the host may send it.
/// @returns false for an unknown id
template <class Visit>
bool decode_any(std::span<const std::uint8_t> bytes, Direction direction, Visit&& visit) {
  bool known = false;
  protocol::for_each_report<protocol::AllReports>([&]<class Report>(std::type_identity<Report>) {
    if constexpr (accepted_as<Report>(Layout<Report>::direction)) {
      if (known || bytes[0] != Layout<Report>::id || direction != Layout<Report>::direction) return;
      known = true;
      Report report{};
      Verdict verdict = decode_apart(bytes, report);
      if (verdict.ok() && axis_of(report) != 0) {
        verdict = {Status::bad_axis, protocol::field_index<Report>("axis")};
      }
      visit(report, verdict);
    }
  });
  return known;
}

/// The defaults are the reference actuator's, on this board.
Config default_config(const BoardInfo& board) {
  Config config;
  config.actuator.motor_time_constant_s = board.motor_lag_s;
  return config;
}

}  // namespace

Device::Device(const BoardInfo& board, const SlotViews& stored)
    : board_(board),
      store_(stored, board.wiring_rule),
      config_(store_.loaded().value_or(default_config(board))),
      personality_(config_.game.personality),
      wakes_host_(config_.game.remote_wakeup == protocol::Toggle::on),
      loop_config_(
          make_loop_config(config_, board.control_period_ns, trust_in(config_, board.moves_parts))),
      game_(config_, board.control_period_ns),
      dial_(config_, board.control_period_ns),
      guest_(personality_ == protocol::Personality::dial ? static_cast<GuestFunction&>(dial_)
                                                         : game_),
      loop_(loop_config_, guest_.player()) {}

core::Resolution Device::resolution() const { return loop_config_.controller.motion.resolution; }

bool Device::armed() const { return loop_.snapshot().state == State::armed; }

// Reports in ---------------------------------------------------------------------------------

bool Device::receive(std::span<const std::uint8_t> report) {
  Incoming incoming;
  incoming.length = static_cast<std::uint8_t>(std::min(report.size(), report_size + 1));
  std::copy_n(report.begin(), std::min(report.size(), report_size), incoming.bytes.begin());
  return inbox_.push(incoming);
}

Verdict Device::set_feature(std::span<const std::uint8_t> report) {
  Verdict verdict{Status::unknown_report};
  if (report.size() != report_size) {
    verdict = {Status::bad_length};
  } else {
    decode_any(report, Direction::feature, [&](const auto& content, Verdict found) {
      verdict = found;
      if (verdict.ok()) verdict = check_rules(content, config_, board_.wiring_rule);
    });
  }
  if (verdict.ok() && armed()) verdict = {Status::not_disarmed};
  if (verdict.ok()) {
    Incoming incoming;
    incoming.length = report_size;
    incoming.direction = Direction::feature;
    std::copy(report.begin(), report.end(), incoming.bytes.begin());
    if (!inbox_.push(incoming)) verdict = {Status::busy};
  }
  if (!verdict.ok()) ++stalled_;
  return verdict;
}

Order Device::read(const Incoming& incoming) {
  Order order;
  const std::span bytes(incoming.bytes);
  if (incoming.length != report_size) {
    order = refusal({Status::bad_length});
  } else {
    const bool known =
        decode_any(bytes, incoming.direction, [&](const auto& report, Verdict verdict) {
          order = verdict.ok() ? order_for(report) : refusal(verdict);
        });
    if (!known) order = refusal({Status::unknown_report});
  }
  // Every report that the host sends begins with its id and its sequence number, so that even what
  // cannot be read can be answered.
  order.report = incoming.length > 0 ? bytes[0] : 0;
  order.sequence = incoming.length > 2 ? static_cast<std::uint16_t>(bytes[1] | (bytes[2] << 8)) : 0;
  return order;
}

Order Device::order_for(const protocol::Command& command) {
  switch (command.op) {
    case Op::keep_alive: {
      Order order = order_of(Order::Kind::keep_alive);
      order.acknowledged = false;
      return order;
    }
    case Op::arm:
      return order_of(Order::Kind::arm);
    case Op::disarm:
      return order_of(Order::Kind::disarm);
    case Op::stop:
      scene_.clear();
      return order_of(Order::Kind::stop);
    case Op::zero:
      return order_of(Order::Kind::zero);
    case Op::relax:
      return order_of(Order::Kind::relax);
    case Op::save:
      return save();
    case Op::load_defaults:
      return configure(default_config(board_));
    case Op::clear_fault:
      return order_of(Order::Kind::clear_fault);
    case Op::bootloader:
      return enter_bootloader();
  }
  return refusal({Status::unsupported});
}

Order Device::order_for(const protocol::Commit& commit) {
  Order order = order_of(Order::Kind::play);
  order.verdict = {scene_.commit(commit.active, order.commit)};
  if (!order.verdict.ok()) {
    order.verdict.field = protocol::field_index<protocol::Commit>("active");
    return order;
  }
  return order;
}

Order Device::order_for(const protocol::Stream& stream) {
  Order order = order_of(Order::Kind::stream);
  order.decimation = stream.decimation;
  batch_.set_prompt(stream.prompt == protocol::Toggle::on);
  return order;
}

Order Device::order_for(const protocol::LocalModel& model) {
  Order order = order_of(Order::Kind::local_model);
  order.acknowledged = false;
  order.local_model = prepare(model, resolution());
  const float deadline_ticks = model.deadline_s / resolution().period_s;
  order.deadline_ticks = core::round_to_u32(deadline_ticks);
  // A deadline shorter than half a tick is still one, not the end of the stream.
  if (model.deadline_s > 0.0F && order.deadline_ticks == 0) order.deadline_ticks = 1;
  return order;
}

Order Device::order_for(const protocol::Excitation& excitation) {
  Order order = order_of(Order::Kind::excite);
  order.excitation = prepare(excitation, resolution());
  return order;
}

Order Device::order_for(const protocol::CurvePoints& points) {
  if (points.first_point + points.points > protocol::curve_pool_points) {
    return refusal({Status::inconsistent, protocol::field_index<protocol::CurvePoints>("points")});
  }
  scene_.put_points(points.first_point, std::span(points.torque_nm).first(points.points));
  return order_of(Order::Kind::settled);
}

template <class EffectReport>
Order Device::order_for(const EffectReport& report) {
  core::Effect effect;
  const Verdict verdict = prepare(report, resolution(), effect);
  if (!verdict.ok()) return refusal(verdict);
  scene_.put(report.target.slot, effect);
  return order_of(Order::Kind::settled);
}

template <protocol::Configuration Part>
Order Device::order_for(const Part& part) {
  // Only an order can arm, and none is on its way now. So the loop sees the same state.
  if (armed()) return refusal({Status::not_disarmed});
  // Another report may have come in between.
  if (const Verdict now = check_rules(part, config_, board_.wiring_rule); !now.ok()) {
    return refusal(now);
  }
  if constexpr (std::is_same_v<Part, protocol::CalibrationConfig>) {
    config_.calibrated_values = values_checksum(config_);
  }
  const std::uint32_t counts_per_rev = config_.actuator.counts_per_rev;
  config_.*protocol::PlaceOf<Part>::value = part;
  return reconfigure(counts_per_rev);
}

Order Device::configure(const Config& config) {
  if (armed()) return refusal({Status::not_disarmed});
  const std::uint32_t counts_per_rev = config_.actuator.counts_per_rev;
  config_ = config;
  return reconfigure(counts_per_rev);
}

/// @param counts_per_rev as it was before
Order Device::reconfigure(std::uint32_t counts_per_rev) {
  // A scene is prepared for one encoder, and the index has its place in one.
  const bool clears_scene = config_.actuator.counts_per_rev != counts_per_rev;
  const bool reversed = config_.actuator.encoder_reversed == protocol::Toggle::on;
  if (clears_scene || reversed != loop_config_.controller.motion.reversed) {
    config_.index_counts = kNoPlace;
  }
  // In their places: copies on the way there would be the deepest that the stack holds.
  new (&loop_config_) LoopConfig(
      make_loop_config(config_, board_.control_period_ns, trust_in(config_, board_.moves_parts)));
  guest_.configure(config_);
  // A lag of 0 takes the brake out of the sensor's model. Calibration does so to see its own
  // commands. The coil goes on with the earlier lag.
  const float lag_s = config_.actuator.brake_time_constant_s;
  if (power_ != nullptr && lag_s > 0.0F) power_->set_brake_lag(lag_s);
  if (clears_scene) scene_.clear();
  Order order = order_of(Order::Kind::configure);
  order.config = &loop_config_;
  order.clears_scene = clears_scene;
  return order;
}

/// Keeps everybody from arming until allow_arming().
/// @returns false if somebody has armed already
bool Device::bar_arming() {
  loop_.mail.barred.store(1, std::memory_order_relaxed);
  if (!armed()) return true;
  allow_arming();
  return false;
}

void Device::allow_arming() {
  loop_.mail.barred.store(bootloader_ != Bootloader::no ? 1 : 0, std::memory_order_relaxed);
}

Order Device::save() {
  // While flash is written nobody serves the bus, and the watchdog is slow.
  if (!bar_arming()) return refusal({Status::not_disarmed});
  if (const Snapshot now = loop_.snapshot(); now.index.found()) {
    config_.index_counts = within_turn(now.index.at_counts,
                                       static_cast<std::int32_t>(config_.actuator.counts_per_rev));
  }
  store_.prepare(config_, slot_write_.emplace());
  return order_of(Order::Kind::settled);
}

Order Device::enter_bootloader() {
  if (!board_.has_bootloader) return refusal({Status::unsupported});
  if (!bar_arming()) return refusal({Status::not_disarmed});
  bootloader_ = Bootloader::asked;
  return order_of(Order::Kind::settled);
}

// Main loop ----------------------------------------------------------------------------------

void Device::service() {
  const Wish wish = guest_.service(loop_.now());
  if (wish != Wish::nothing_new) loop_.guest.want(wish == Wish::take);
  if (!inbox_.empty()) [[unlikely]]
    read_inbox();
}

/// One order at a time, and only when its answer and an event have room: see ControlLoop::give().
/// Out of line, for nearly all rounds find nothing.
[[gnu::noinline]] void Device::read_inbox() {
  if (!loop_.takes_order() || save_order_) return;
  scene_.taken();
  if (loop_.mail.answers.free() < 4) return;
  const Order order = read(*inbox_.front());
  inbox_.pop();
  if (slot_write_) {
    save_order_ = order;  // acknowledged when it is true
    return;
  }
  loop_.give(order);
}

void Device::set_buttons(std::uint8_t pressed) {
  buttons_ = pressed;
  guest_.set_buttons(pressed);
}

void Device::set_connected(bool connected) {
  if (connected != loop_.connected()) guest_.settle(connected);
  loop_.set_connected(connected);
}

std::optional<SlotWrite> Device::take_slot_write() {
  if (!slot_write_) return std::nullopt;  // nearly always, and without copying a slot
  return std::exchange(slot_write_, std::nullopt);
}

void Device::storage_written() {
  if (!save_order_) return;
  store_.written();
  finish_save();
}

void Device::storage_failed() {
  if (!save_order_) return;
  save_order_->verdict = {Status::busy};
  finish_save();
}

void Device::finish_save() {
  allow_arming();
  loop_.give(*save_order_);
  save_order_.reset();
}

bool Device::take_bootloader_request() {
  if (bootloader_ != Bootloader::asked) return false;
  bootloader_ = Bootloader::begun;
  return true;
}

}  // namespace torsio::device
