#include "requests.hpp"

#include <algorithm>
#include <cstdlib>
#include <string>

#include "protocol_names.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

constexpr std::int64_t kLastWordsNs = 1'000'000'000;
constexpr int kAttempts = 4;

}  // namespace

/// Acknowledgements that somebody waits for; gives up on them when it goes out of scope.
class Requests::Expectation {
 public:
  explicit Expectation(Requests& requests) : requests_(requests) {}
  Expectation(const Expectation&) = delete;
  Expectation& operator=(const Expectation&) = delete;
  ~Expectation() {
    const Link::Locked locked = requests_.link_.lock();
    std::erase_if(requests_.pending_, [&](const Pending& pending) {
      return std::ranges::find(sequences_, pending.sequence) != sequences_.end();
    });
  }

  void add(std::uint16_t sequence) {
    const Link::Locked locked = requests_.link_.lock();
    sequences_.push_back(sequence);
    requests_.pending_.push_back({sequence, {}});
  }

  /// @returns false if not all have come in time
  [[nodiscard]] bool wait(std::int64_t timeout_ns) const {
    return requests_.link_.wait_until(
        [&](const Link::Locked&) {
          return std::ranges::all_of(
              sequences_, [&](auto sequence) { return find(sequence).answer.has_value(); });
        },
        timeout_ns);
  }

  [[nodiscard]] std::vector<protocol::Acknowledgement> answers() const {
    const Link::Locked locked = requests_.link_.lock();
    std::vector<protocol::Acknowledgement> answers;
    for (const std::uint16_t sequence : sequences_) answers.push_back(*find(sequence).answer);
    return answers;
  }

 private:
  [[nodiscard]] const Pending& find(std::uint16_t sequence) const {
    return *std::ranges::find(requests_.pending_, sequence, &Pending::sequence);
  }

  Requests& requests_;
  std::vector<std::uint16_t> sequences_;
};

std::uint16_t Requests::stamp(protocol::ReportBytes& report) {
  // 0 is for reports that nobody waits for.
  std::uint16_t sequence = ++sequence_;
  if (sequence == 0) sequence = ++sequence_;
  // Every report that the host sends begins with its id and its sequence number.
  report[1] = static_cast<std::uint8_t>(sequence & 0xFFU);
  report[2] = static_cast<std::uint8_t>(sequence >> 8U);
  return sequence;
}

std::vector<protocol::Acknowledgement> Requests::answers_to(const Expectation& expectation) {
  if (!expectation.wait(timeout_ns_)) throw_late("the device did not answer", timeout_ns_);
  std::vector<protocol::Acknowledgement> answers = expectation.answers();
  for (const protocol::Acknowledgement& answer : answers) throw_if_refused(answer);
  return answers;
}

std::vector<protocol::Acknowledgement> Requests::exchange(
    std::span<protocol::ReportBytes> reports) {
  Expectation expectation(*this);
  for (protocol::ReportBytes& report : reports) {
    expectation.add(stamp(report));
    link_.write(report, timeout_ns_);
  }
  return answers_to(expectation);
}

void Requests::say(protocol::ReportBytes report) {
  Expectation expectation(*this);
  expectation.add(stamp(report));
  link_.write(report, kLastWordsNs);
  (void)expectation.wait(kLastWordsNs);
}

void Requests::order_blindly(protocol::Op op) {
  Arming::Order order(device_.arming, op);
  protocol::ReportBytes report = protocol::encode(protocol::Command{0, 0, op});
  blind_answered_ = false;
  blind_ = stamp(report);
  for (int attempts_left = kAttempts;; --attempts_left) {
    try {
      if (!link_.write_blindly(report)) link_.write(report, kLastWordsNs);
      break;
    } catch (const Timeout&) {
      throw;
    } catch (...) {
      if (attempts_left == 1) throw;
    }
  }
  try {
    if (link_.wait_until([&](const Link::Locked&) { return blind_answered_.load(); }, kLastWordsNs))
      note_taken(order);
  } catch (...) {  // NOLINT(bugprone-empty-catch): it has the order, or its watchdog ends it
  }
}

void Requests::send_while_armed(protocol::ReportBytes report) {
  // A lost device is no matter of arming: write() finds it.
  if (const State known = device_.state(); known == State::disarmed || known == State::fault) {
    protocol::Acknowledgement answer;
    answer.report = report[0];
    answer.status = static_cast<std::uint8_t>(protocol::Status::not_armed);
    throw_if_refused(answer);
  }
  stamp(report);
  link_.write(report, timeout_ns_);
}

void Requests::command(protocol::Op op) {
  Arming::Order order(device_.arming, op);
  try {
    request(protocol::Command{0, 0, op});
  } catch (const Refused&) {
    order.refused();
    throw;
  } catch (const Disconnected&) {
    // A way that gives nothing may still take.
    if (order.disarms()) order_blindly(op);
    throw;
  }
  note_taken(order);
}

/// What a lost device has answered is no matter any more.
void Requests::note_taken(Arming::Order& order) {
  const Link::Locked locked = link_.lock();
  if (!link_.is_lost()) order.taken();
}

void Requests::take(const Link::Locked& locked, const protocol::Acknowledgement& answer) {
  if (answer.report == protocol::Layout<protocol::LocalModel>::id) {
    return link_.count_refused_model(
        locked, status_name(answer.status) + ": " + std::string(status_advice(answer.status)));
  }
  if (answer.sequence == blind_) blind_answered_ = true;
  const auto pending = std::ranges::find(pending_, answer.sequence, &Pending::sequence);
  if (pending != pending_.end()) pending->answer = answer;
}

void Requests::throw_if_refused(const protocol::Acknowledgement& answer) {
  if (answer.status == 0) return;
  const std::string status = status_name(answer.status);
  const std::string report = report_name(answer.report);
  const std::string field = report_field_name(answer.report, answer.field);
  std::string message = "the device refused the " + report + " report (" + status;
  if (!field.empty()) message += ", field " + field;
  message += "): " + std::string(status_advice(answer.status));
  std::string reason;
  if (answer.status == static_cast<std::uint8_t>(protocol::Status::not_armed)) {
    if (const std::optional<Disarm> disarm = device_.last_disarm()) {
      reason = disarm_reason_name(disarm->reason);
      message += "; " + disarm_text(*disarm);
    }
  }
  throw Refused(message, status, report, field, reason);
}

// Feature reports --------------------------------------------------------------------------------

protocol::ReportBytes Requests::get_feature(std::uint8_t id) {
  protocol::ReportBytes report{};
  if (link_.get_feature(id, report)) return report;
  throw Error("the device does not give its " + report_name(id) + " report");
}

void Requests::check_feature(protocol::Verdict verdict, std::uint8_t id) {
  if (verdict.ok()) return;
  throw Error("the device's " + report_name(id) + " report is damaged (" +
              status_name(static_cast<std::uint8_t>(verdict.status)) + "); try again");
}

void Requests::set_feature(protocol::ReportBytes report) {
  Expectation expectation(*this);
  expectation.add(stamp(report));
  if (!link_.set_feature(report)) throw_stalled(report[0]);
  (void)answers_to(expectation);
}

/// A stalled request carries no reason; the device's state tells the likely one.
void Requests::throw_stalled(std::uint8_t id) {
  const auto health = get<protocol::Health>();
  device_.note(health);
  protocol::Acknowledgement answer;
  answer.report = id;
  answer.status = static_cast<std::uint8_t>(health.state == protocol::State::armed
                                                ? protocol::Status::not_disarmed
                                                : protocol::Status::busy);
  throw_if_refused(answer);
  std::abort();  // not reached: neither status is ok
}

}  // namespace torsio
