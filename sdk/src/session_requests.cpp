// Session: requests to the device, and its answers.
#include <cstdlib>
#include <optional>
#include <utility>

#include "protocol_names.hpp"
#include "session_scopes.hpp"
#include "torsio/error.hpp"

namespace torsio {
// Out --------------------------------------------------------------------------------------------

std::uint16_t Session::stamp(protocol::ReportBytes& report) {
  // 0 is for reports that nobody waits for.
  std::uint16_t sequence = ++sequence_;
  if (sequence == 0) sequence = ++sequence_;
  // Every report that the host sends begins with its id and its sequence number.
  report[1] = static_cast<std::uint8_t>(sequence & 0xFFU);
  report[2] = static_cast<std::uint8_t>(sequence >> 8U);
  return sequence;
}

/// Has the transport do something. A thread that finds the device gone tells all.
template <class Act>
void Session::on_transport(Act&& act) {
  {
    const std::lock_guard lock(mutex_);
    throw_if_gone();
  }
  try {
    act(*transport_);
  } catch (const Disconnected& error) {
    const std::lock_guard lock(mutex_);
    lose(error.what());
    throw;
  }
}

void Session::write(const protocol::ReportBytes& report, std::int64_t timeout_ns) {
  on_transport([&](Transport& transport) {
    const std::int64_t begin_ns = transport.now_ns();
    // A full queue empties by one report a frame.
    while (!transport.write(report)) {
      if (transport.now_ns() - begin_ns >= timeout_ns)
        throw_late("the way to the device had no room");
      sleep(kFrameNs);
    }
    const std::lock_guard lock(mutex_);
    log(true, report);
  });
  ++reports_sent_;
}

void Session::send_while_armed(protocol::ReportBytes report) {
  // A lost device is no matter of arming: write() finds it.
  if (const State known = state(); known == State::disarmed || known == State::fault) {
    protocol::Acknowledgement answer;
    answer.report = report[0];
    answer.status = static_cast<std::uint8_t>(protocol::Status::not_armed);
    throw_if_refused(answer);
  }
  stamp(report);
  write(report, options_.command_timeout_ns);
}

class Session::Tap final : public ReportTap {
 public:
  Tap(bool with_telemetry, std::vector<LoggedReport> begin)
      : with_telemetry_(with_telemetry), reports_(std::move(begin)) {}

  void add(const LoggedReport& report) {
    const bool is_telemetry = report.bytes[0] == protocol::Layout<protocol::Telemetry>::id;
    if (is_telemetry && !with_telemetry_) return;
    const std::lock_guard lock(mutex_);
    reports_.push_back(report);
  }

  std::vector<LoggedReport> take() override {
    const std::lock_guard lock(mutex_);
    return std::exchange(reports_, {});
  }

 private:
  const bool with_telemetry_;
  std::mutex mutex_;
  std::vector<LoggedReport> reports_;
};

std::shared_ptr<ReportTap> Session::tap(bool with_telemetry, std::vector<LoggedReport> begin) {
  auto tap = std::make_shared<Tap>(with_telemetry, std::move(begin));
  const std::lock_guard lock(mutex_);
  taps_.push_back(tap);
  return tap;
}

void Session::log(bool sent, const protocol::ReportBytes& report) {
  std::erase_if(taps_, [](const auto& tap) { return tap.expired(); });
  for (const auto& weak : taps_) {
    if (const auto tap = weak.lock()) tap->add({newest_tick_, sent, report});
  }
}

protocol::ReportBytes Session::keep_alive_report() {
  return protocol::encode(protocol::Command{0, 0, protocol::Op::keep_alive});
}

bool Session::send_keep_alive() noexcept {
  try {
    const bool sent = transport_->write(keep_alive_report());
    if (sent) ++reports_sent_;
    return sent;
  } catch (...) {
    return false;  // the next read finds out that the device is gone
  }
}

std::vector<protocol::Acknowledgement> Session::exchange(std::span<protocol::ReportBytes> reports) {
  Expectation expectation(*this);
  for (protocol::ReportBytes& report : reports) {
    expectation.add(stamp(report));
    write(report, options_.command_timeout_ns);
  }
  await(expectation);
  const std::lock_guard lock(mutex_);
  return expectation.answers();
}

void Session::command(protocol::Op op) {
  const bool arms = op == protocol::Op::arm;
  const bool disarms = op == protocol::Op::disarm || op == protocol::Op::stop;
  if (arms) may_drive_ = true;
  if (disarms) ++disarming_;
  try {
    request(protocol::Command{0, 0, op});
    const std::lock_guard lock(mutex_);
    if ((arms || disarms) && lost_.empty()) may_drive_ = false;  // from here on the state says it
  } catch (const Refused&) {
    if (arms) may_drive_ = false;
    if (disarms) --disarming_;
    throw;
  } catch (...) {
    if (disarms) --disarming_;
    throw;
  }
  if (disarms) --disarming_;
}

void Session::await(Expectation& expectation) {
  if (!wait_until([&] { return expectation.met(); }, options_.command_timeout_ns)) {
    throw_late("the device did not answer");
  }
}

void Session::throw_late(const std::string& what) const {
  throw Timeout(what + " within " + std::to_string(options_.command_timeout_ns / 1'000'000) +
                " ms; unplug it and plug it in again if that goes on");
}

void Session::throw_if_refused(const protocol::Acknowledgement& answer) {
  if (answer.status == 0) return;
  const std::string status = status_name(answer.status);
  const std::string report = report_name(answer.report);
  const std::string field = report_field_name(answer.report, answer.field);
  std::string message = "the device refused the " + report + " report (" + status;
  if (!field.empty()) message += ", field " + field;
  message += "): " + std::string(status_advice(answer.status));
  std::string reason;
  if (answer.status == static_cast<std::uint8_t>(protocol::Status::not_armed)) {
    if (const std::optional<Disarm> disarm = last_disarm()) {
      reason = disarm_reason_name(disarm->reason);
      message += "; " + disarm_text(*disarm);
    }
  }
  throw Refused(message, status, report, field, reason);
}

// Feature reports --------------------------------------------------------------------------------

protocol::ReportBytes Session::get_feature(std::uint8_t id) {
  protocol::ReportBytes report{};
  bool given = false;
  on_transport([&](Transport& transport) { given = transport.get_feature(id, report); });
  if (given) return report;
  throw Error("the device does not give its " + report_name(id) + " report");
}

void Session::check_feature(protocol::Verdict verdict, std::uint8_t id) {
  if (verdict.ok()) return;
  throw Error("the device's " + report_name(id) + " report is damaged (" +
              status_name(static_cast<std::uint8_t>(verdict.status)) + "); try again");
}

void Session::set_feature(protocol::ReportBytes report) {
  Expectation expectation(*this);
  on_transport([&](Transport& transport) {
    expectation.add(stamp(report));
    if (!transport.set_feature(report)) throw_stalled(report[0]);
    ++reports_sent_;
    const std::lock_guard lock(mutex_);
    log(true, report);
  });
  await(expectation);
  protocol::Acknowledgement answer;
  {
    const std::lock_guard lock(mutex_);
    answer = expectation.answers().front();
  }
  throw_if_refused(answer);
}

/// A stalled request carries no reason; the device's state tells the likely one.
void Session::throw_stalled(std::uint8_t id) {
  const auto health = get<protocol::Health>();
  note(health);
  protocol::Acknowledgement answer;
  answer.report = id;
  answer.status = static_cast<std::uint8_t>(health.state == protocol::State::armed
                                                ? protocol::Status::not_disarmed
                                                : protocol::Status::busy);
  throw_if_refused(answer);
  std::abort();  // not reached: neither status is ok
}

}  // namespace torsio
