// ControlLoop: what the host asks, between two ticks.
#include "device/control_loop.hpp"

namespace torsio::device {

using protocol::EventKind;
using protocol::Owner;
using protocol::Status;

void ControlLoop::take_order() {
  const Order* order = orders_.front();
  if (order == nullptr) return;
  const bool ends = order->kind == Order::Kind::disarm || order->kind == Order::Kind::stop;
  if (ends && armed()) return let_go();
  carry_out(*order);
  orders_.pop();
}

/// A torque that is cut is felt as a snap. So the order waits while the torque goes to zero along a
/// line, and is answered when it is gone. Nobody else is served meanwhile.
void ControlLoop::let_go() {
  if (phase_ == Phase::letting_go) return;
  change(Phase::letting_go, owner_, config_.let_go_ticks);
  // The next update of a stopped game must not undo the stop.
  if (owner_ != Owner::sdk) guest.forget();
}

void ControlLoop::carry_out(const Order& order) {
  protocol::Verdict verdict = order.verdict;
  if (verdict.ok()) verdict.status = execute(order);
  if (verdict.ok()) silent_ticks_left_ = config_.watchdog_ticks;
  ++(verdict.ok() ? counters_.reports_accepted : counters_.reports_refused);
  if (!order.acknowledged && verdict.ok()) return;
  // The main loop gives an order only when there is room for its answers.
  Answer answer;
  answer.acknowledgement = {order.sequence, order.report, static_cast<std::uint8_t>(verdict.status),
                            verdict.field,  state(),      controller_.tick,
                            owner_};
  (void)mail.answers.push(answer);
}

Status ControlLoop::execute(const Order& order) {
  switch (order.kind) {
    case Order::Kind::settled:
    case Order::Kind::keep_alive:
      return Status::ok;
    case Order::Kind::arm:
      return arm();
    case Order::Kind::stop:
      scene_ = nullptr;
      [[fallthrough]];
    case Order::Kind::disarm:  // by let_go(), before it
      return Status::ok;
    case Order::Kind::clear_fault:
      return clear_fault();
    case Order::Kind::stream:
      decimation_ = order.decimation;
      ticks_to_sample_ = 0;
      return Status::ok;
    case Order::Kind::play:
      scene_ = order.commit.scene;
      controller_.bound.new_scene = true;
      core::restart_effects(controller_.scene, order.commit.fresh, controller_.tick);
      return Status::ok;
    case Order::Kind::local_model:
      return follow_local_model(order);
    case Order::Kind::excite:
      return excite(order);
    case Order::Kind::zero:
      return zero();
    case Order::Kind::relax:
      return relax();
    case Order::Kind::configure:
      return configure(order);
  }
  return Status::unsupported;
}

Status ControlLoop::zero() {
  if (armed()) return Status::not_disarmed;
  takes_centre_ = false;
  move_origin(-controller_.motion.position_counts);
  return Status::ok;
}

Status ControlLoop::relax() {
  if (armed()) return Status::not_disarmed;
  controller_.sensor = {};
  return Status::ok;
}

Status ControlLoop::configure(const Order& order) {
  if (order.config->turn_counts != config_.turn_counts ||
      order.config->controller.motion.reversed != config_.controller.motion.reversed) {
    index_ = {.told = index_.told, .level = index_.level};
  }
  config_ = *order.config;
  guest.configure();
  controller_.bound = {};
  controller_.scene.inertia_share = 1.0F;
  controller_.scene.damping_share = 1.0F;
  // Only a law that knows the brake keeps these up, and a bent shaft its piece.
  controller_.sensor.slipped_nm = 0.0F;
  controller_.sensor.piece = {};
  controller_.brake.coil_nm = controller_.brake.capacity_nm;
  controller_.ledger = {};
  controller_.motion.counting =
      core::Counting::first;  // the counter may have another width or sense now
  if (order.clears_scene) scene_ = nullptr;
  return Status::ok;
}

Status ControlLoop::arm() {
  if (phase_ == Phase::fault) return Status::fault_latched;
  if (!may_take()) return Status::busy;
  if (owner_ == Owner::sdk) return Status::ok;
  const std::uint32_t ticks = config_.passive_ramp_ticks;
  const Phase begins = ticks != 0 ? Phase::rising : Phase::playing;
  if (owner_ != Owner::none) {
    // The other's torque fades while the scene's comes up: both in the time of the soft start.
    guest.release();
    change(begins, Owner::sdk, ticks);
    controller_.bound.new_scene = true;
    report_event(EventKind::owner_changed);
  } else {
    enter(begins, Owner::sdk, ticks);
  }
  return Status::ok;
}

Status ControlLoop::clear_fault() {
  if (faults_.present != 0) return Status::fault_persists;
  faults_.latched = 0;
  if (phase_ == Phase::fault) {
    guest.forget();  // what was started meanwhile
    enter(Phase::disarmed);
  }
  return Status::ok;
}

Status ControlLoop::follow_local_model(const Order& order) {
  if (!plays()) return Status::not_armed;
  if (owner_ != Owner::sdk) return Status::not_owner;
  const auto ahead = static_cast<std::int16_t>(order.sequence - local_model_sequence_);
  if (streams() && ahead <= 0) return Status::stale;
  local_model_sequence_ = order.sequence;
  core::change_local_model(controller_, config_.controller, streams() ? &local_model_ : nullptr,
                           order.deadline_ticks != 0 ? &order.local_model : nullptr);
  local_model_ = order.local_model;
  local_model_ticks_left_ = order.deadline_ticks == 0 ? 0 : order.deadline_ticks + 1;
  return Status::ok;
}

Status ControlLoop::excite(const Order& order) {
  if (!plays()) return Status::not_armed;
  if (owner_ != Owner::sdk) return Status::not_owner;
  core::begin_excitation(excitation_, order.excitation, controller_.motion.position_counts);
  local_model_ticks_left_ = 0;
  return Status::ok;
}

}  // namespace torsio::device
