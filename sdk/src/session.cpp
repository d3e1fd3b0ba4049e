#include "session.hpp"

#include <utility>

#include "protocol/codec.hpp"
#include "protocol/reports.hpp"
#include "torsio/error.hpp"

namespace torsio {

Session::Session(std::unique_ptr<Transport> transport, SessionOptions options)
    : link(std::move(transport), std::move(options.interrupted), *this),
      device(link),
      requests(link, device, options.command_timeout_ns),
      samples(link, device, requests, options.ring_samples) {}

Session::~Session() { close(false); }

bool Session::close(bool disarm_first) noexcept {
  if (closing_.exchange(true)) {
    // A closing thread waits for the callback, or has called it. So the callback must not wait for
    // the close.
    if (device.events.tells_here()) return true;
    link.wait_until_let_go();
    device.events.close();
    return true;
  }
  if (disarm_first) {
    device.arming.forbid();
    const bool others_arm = device.arming.is_under_way();
    disarm_quietly();
    if (others_arm) {
      device.arming.outlast();
      disarm_quietly();
    }
  }
  link.stop();
  device.events.close();
  link.let_go();
  return !untold_.exchange(false);
}

void Session::disarm_quietly() noexcept {
  if (!device.arming.may_drive()) return;
  const Link::Unasked unasked(link);
  const bool was_lost = link.is_lost();
  try {
    requests.order_blindly(protocol::Op::disarm);
    untold_ = false;
  } catch (const Disconnected&) {
    if (!was_lost) untold_ = true;  // else the program has been told that the device is gone
  } catch (...) {
    untold_ = true;
  }
}

void Session::set_identity(const protocol::Identity& identity) {
  const Link::Locked locked = link.lock();
  device.configure(locked, identity);
  samples.configure(locked, identity);
}

LinkStatistics Session::statistics() {
  LinkStatistics statistics = link.statistics(link.lock());
  statistics.events_lost = device.events.lost();
  return statistics;
}

bool Session::take(const Link::Locked& locked, const protocol::ReportBytes& report) {
  const auto understood = [&]<class Report>(Report content) {
    if (!protocol::decode(report, content).ok()) return false;
    hear(locked, content);
    return true;
  };
  switch (report[0]) {
    case protocol::Layout<protocol::Telemetry>::id:
      return understood(protocol::Telemetry{});
    case protocol::Layout<protocol::Acknowledgement>::id:
      return understood(protocol::Acknowledgement{});
    case protocol::Layout<protocol::Event>::id:
      return understood(protocol::Event{});
    default:
      return false;
  }
}

void Session::hear(const Link::Locked& locked, const protocol::Acknowledgement& answer) {
  link.note_tick(locked, answer.tick);
  device.take(locked, answer);
  samples.take(locked, answer);
  requests.take(locked, answer);
}

void Session::hear(const Link::Locked& locked, const protocol::Event& event) {
  link.note_tick(locked, event.tick);
  device.take(locked, event);
}

}  // namespace torsio
