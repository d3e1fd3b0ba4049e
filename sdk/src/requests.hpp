/// @file
/// Requests to one device, and its answers.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "arming.hpp"
#include "device_state.hpp"
#include "link.hpp"
#include "protocol/codec.hpp"
#include "protocol/reports.hpp"

namespace torsio {

/// The link's lock guards the answers. Every member may be called from any thread.
class Requests {
 public:
  Requests(Link& link, DeviceState& device, std::int64_t timeout_ns)
      : link_(link), device_(device), timeout_ns_(timeout_ns) {}

  /// Sends reports in order and waits until each is acknowledged. Their sequence numbers are
  /// filled in.
  /// @returns the acknowledgements in the same order
  /// @throws Refused for the first refusal, Timeout, Disconnected, Closed, Interrupted
  std::vector<protocol::Acknowledgement> exchange(std::span<protocol::ReportBytes> reports);

  /// Sends one report and waits. @throws as exchange() does
  template <class Report>
  protocol::Acknowledgement request(const Report& report) {
    std::array<protocol::ReportBytes, 1> bytes{protocol::encode(report)};
    return exchange(bytes).front();
  }

  /// Sends a report and gives the device a moment to answer; whether it does is all the same.
  void say(protocol::ReportBytes report);
  /// The same, but nothing that may fail or wait comes before, and a lost device is told too. Tries
  /// again if it is interrupted. @throws what the transport does if it takes no order
  void order_blindly(protocol::Op op);

  /// Sends a report that only an armed device takes and does not wait for an acknowledgement.
  /// Waits while the queue to the device is full.
  /// @throws Refused, without asking the device, if it is known not to be armed
  void send_while_armed(protocol::ReportBytes report);

  /// Reads a feature report. @throws Error if the device stalls, Disconnected, Closed
  template <class Report>
  Report get() {
    Report report{};
    const protocol::ReportBytes bytes = get_feature(protocol::Layout<Report>::id);
    check_feature(protocol::decode(bytes, report), protocol::Layout<Report>::id);
    return report;
  }
  /// Reads a feature report as it is. @throws as get() does
  protocol::ReportBytes get_feature(std::uint8_t id);

  /// Sets a feature report and waits for its acknowledgement. @throws as exchange() does
  template <class Report>
  void set(const Report& report) {
    set_feature(protocol::encode(report));
  }

  /// Gives an order and waits. @throws as exchange() does
  void command(protocol::Op op);

  void take(const Link::Locked& locked, const protocol::Acknowledgement& answer);

 private:
  struct Pending {
    std::uint16_t sequence;
    std::optional<protocol::Acknowledgement> answer;
  };
  class Expectation;

  std::uint16_t stamp(protocol::ReportBytes& report);
  std::vector<protocol::Acknowledgement> answers_to(const Expectation& expectation);
  void throw_if_refused(const protocol::Acknowledgement& answer);
  void set_feature(protocol::ReportBytes report);
  void note_taken(Arming::Order& order);
  static void check_feature(protocol::Verdict verdict, std::uint8_t id);
  [[noreturn]] void throw_stalled(std::uint8_t id);

  Link& link_;
  DeviceState& device_;
  const std::int64_t timeout_ns_;
  std::atomic<std::uint16_t> sequence_{0};
  std::atomic<std::uint16_t> blind_{0};  // sequence number of the last blind order
  std::atomic<bool> blind_answered_{false};
  std::vector<Pending> pending_;
};

}  // namespace torsio
