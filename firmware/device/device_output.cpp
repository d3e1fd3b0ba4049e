// Device: what the host is told.
#include <type_traits>

#include "device/device.hpp"
#include "protocol/registry.hpp"

namespace torsio::device {
namespace {

using protocol::Layout;
using protocol::Status;

constexpr float kSpeedStepRadS = 0.01F;

[[gnu::noinline]] protocol::ReportBytes encode_answer(const Answer& answer) {
  return answer.is_event ? protocol::encode(answer.event)
                         : protocol::encode(answer.acknowledgement);
}

}  // namespace

Status Device::get_feature(std::uint8_t id, protocol::ReportBytes& report) {
  const Snapshot now = loop_.snapshot();
  switch (id) {
    case Layout<protocol::Identity>::id: {
      protocol::Identity identity;
      identity.fingerprint = protocol::fingerprint();
      identity.firmware_version = board_.firmware_version;
      identity.board = board_.board;
      identity.serial = board_.serial;
      identity.control_period_ns = board_.control_period_ns;
      identity.counts_per_rev = config_.actuator.counts_per_rev;
      identity.torque_step_nm = torque_step_nm(config_.actuator);
      identity.speed_step_rad_s = kSpeedStepRadS;
      report = protocol::encode(identity);
      return Status::ok;
    }
    case Layout<protocol::Clock>::id:
      report = protocol::encode(
          protocol::Clock{now.tick, now.tick * board_.control_period_ns, now.position_counts});
      return Status::ok;
    case Layout<protocol::Health>::id:
      report = protocol::encode(
          protocol::Health{now.state, now.faults, now.counters.reports_accepted,
                           now.counters.reports_refused + stalled_, now.counters.samples_dropped,
                           now.counters.tick_overruns, now.counters.tick_time_ns,
                           now.counters.tick_time_max_ns, store_.saves(), now.owner,
                           board_.reset_cause, now.counters.unexpected_swings, centre(now.index)});
      return Status::ok;
    case Layout<protocol::GameMonitor>::id:
      report = protocol::encode(game_.monitor(torque_step_nm(config_.actuator)));
      return Status::ok;
    case Layout<protocol::Ledger>::id:
      report = protocol::encode(loop_.ledger());
      return Status::ok;
    case Layout<protocol::MotorCurrent>::id:
      report = protocol::encode(power_ == nullptr ? protocol::MotorCurrent{} : power_->sums([&] {
        return loop_.now().position_counts;
      }));
      return Status::ok;
    default:
      return get_configuration(id, report);
  }
}

Status Device::get_configuration(std::uint8_t id, protocol::ReportBytes& report) const {
  Status status = Status::unknown_report;
  protocol::for_each_configuration(config_, [&]<class Part>(const Part& part) {
    if (id != Layout<Part>::id) return;
    if constexpr (std::is_same_v<Part, protocol::CalibrationConfig>) {
      report = protocol::encode(calibration_now(config_));
    } else {
      report = protocol::encode(part);
    }
    status = Status::ok;
  });
  return status;
}

protocol::Centre Device::centre(const IndexWatch& index) const {
  if (index.found()) return protocol::Centre::index;
  return config_.actuator.encoder_index_pin != 0 ? protocol::Centre::awaits_index
                                                 : protocol::Centre::power_up;
}

Status Device::get_input(std::uint8_t id, protocol::ReportBytes& report) const {
  const Snapshot now = loop_.snapshot();
  if (id == Layout<protocol::Telemetry>::id) {
    report = protocol::encode(batch_.last());
    return Status::ok;
  }
  Answer answer;
  answer.is_event = id == Layout<protocol::Event>::id;
  if (!answer.is_event && id != Layout<protocol::Acknowledgement>::id) {
    return Status::unknown_report;
  }
  answer.acknowledgement = {0, 0, 0, protocol::kNoField, now.state, now.tick, now.owner};
  answer.event = {protocol::EventKind::state_changed, now.state, now.faults, now.tick, now.owner};
  report = encode_answer(answer);
  return Status::ok;
}

bool Device::next_input(protocol::ReportBytes& report, bool early) {
  if (const Answer* answer = loop_.mail.answers.front()) {
    report = encode_answer(*answer);
    loop_.mail.answers.pop();
    return true;
  }
  if (early && batch_.prompt()) return false;
  gather_telemetry();
  // A sample that did not fit sends the batch off before it is due.
  if (!batch_.due(board_.control_period_ns) && (batch_.empty() || loop_.mail.samples.empty())) {
    return false;
  }
  report = protocol::encode(batch_.take());
  return true;
}

void Device::gather_telemetry() {
  const SampleSteps steps{torque_step_nm(config_.actuator), kSpeedStepRadS};
  if (batch_.prompt()) {
    // The gap shows in the ticks.
    while (loop_.mail.samples.count() > protocol::samples_per_report) loop_.mail.samples.pop();
  }
  while (const LoopSample* sample = loop_.mail.samples.front()) {
    const bool waits = !batch_.prompt() && batch_.due(board_.control_period_ns);
    if (waits || !batch_.add(*sample, steps)) return;
    loop_.mail.samples.pop();
  }
}

}  // namespace torsio::device
