#include "emulator/usbip/host_controller.hpp"

#include <algorithm>
#include <span>
#include <utility>

namespace torsio::emulator::usbip {
namespace {

using bus::Handshake;
using bus::kPacketSize;
using Packet = std::array<std::uint8_t, kPacketSize>;

std::uint8_t address_of(std::size_t endpoint, Direction direction) {
  return static_cast<std::uint8_t>(endpoint | (direction == Direction::in ? 0x80U : 0U));
}

std::span<const std::uint8_t> packet_at(const Bytes& data, std::size_t at) {
  return std::span(data).subspan(at, std::min(data.size() - at, kPacketSize));
}

Completion over(const Submit& request, std::int32_t status, std::size_t length, Bytes data = {}) {
  return {request, status, static_cast<std::uint32_t>(length), std::move(data)};
}

}  // namespace

void HostController::plug() {
  asleep_ = false;
  bus::plug();
  device_.poll();
}

void HostController::unplug() {
  for (auto& direction : queues_) {
    for (Queue& queue : direction) queue.clear();
  }
  absences_ = {};
  asleep_ = false;
  bus::unplug();
  device_.poll();
}

void HostController::suspend() {
  asleep_ = true;
  bus::suspend();
  device_.poll();
}

void HostController::reset() {
  asleep_ = true;
  bus::plug();
  device_.poll();
}

void HostController::resume() {
  asleep_ = false;
  bus::resume();
  device_.poll();
}

void HostController::submit(const Submit& request, Bytes data, std::vector<Completion>& done) {
  if (request.endpoint == 0) {
    done.push_back(control(request, data));
    return;
  }
  if (request.endpoint >= bus::kEndpoints) {
    done.push_back(over(request, kStalled, 0));
    return;
  }
  Queue& queue = queues_[static_cast<std::size_t>(request.direction)][request.endpoint];
  queue.push_back({request, std::move(data)});
  if (request.direction == Direction::in) make_up(request.endpoint, done);
}

bool HostController::unlink(std::uint32_t sequence) {
  for (auto& direction : queues_) {
    for (Queue& queue : direction) {
      const auto found = std::ranges::find_if(queue, [sequence](const Transfer& transfer) {
        return transfer.request.sequence == sequence;
      });
      if (found == queue.end()) continue;
      queue.erase(found);
      return true;
    }
  }
  return false;
}

std::size_t HostController::pending() const {
  std::size_t count = 0;
  for (const auto& direction : queues_) {
    for (const Queue& queue : direction) count += queue.size();
  }
  return count;
}

// Control transfers (USB 2.0, section 8.5.3) -----------------------------------------------------

Completion HostController::control(const Submit& request, const Bytes& data) {
  const std::size_t length = request.setup[6] | (std::size_t{request.setup[7]} << 8);
  const bool in = length > 0 && (request.setup[0] & 0x80U) != 0;
  // No host puts these on a bus: data against the request's direction, or more than it announces.
  const bool contradicts = length > 0 && in != (request.direction == Direction::in);
  if (contradicts || data.size() > length) return over(request, kStalled, 0);

  bus::setup(request.setup);
  device_.poll();
  return in ? control_in(request, length) : control_out(request, data);
}

Completion HostController::control_in(const Submit& request, std::size_t length) {
  const std::size_t room = std::min<std::size_t>(request.length, length);
  Bytes data;
  while (data.size() < room) {
    Packet packet;
    const auto [handshake, size] = bus::in(0, packet);
    device_.poll();
    // The stack answers within poll() or never.
    if (handshake != Handshake::ack) return over(request, kStalled, 0);
    const std::size_t kept = std::min(size, room - data.size());
    data.insert(data.end(), packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(kept));
    if (size < kPacketSize) break;
  }
  // A host with less room than it asked for breaks off here, and the next request begins anew.
  const bool broken_off = data.size() == room && room < length;
  if (!broken_off) {
    const Handshake status = bus::out(0, {});
    device_.poll();
    if (status != Handshake::ack) return over(request, kStalled, 0);
  }
  const std::size_t size = data.size();
  return over(request, kOk, size, std::move(data));
}

Completion HostController::control_out(const Submit& request, const Bytes& data) {
  for (std::size_t at = 0; at < data.size(); at += kPacketSize) {
    const Handshake handshake = bus::out(0, packet_at(data, at));
    device_.poll();
    if (handshake != Handshake::ack) return over(request, kStalled, 0);
  }
  Packet packet;
  const auto [status, size] = bus::in(0, packet);
  device_.poll();
  if (status != Handshake::ack || size != 0) return over(request, kStalled, 0);
  return over(request, kOk, data.size());
}

// Interrupt transfers ----------------------------------------------------------------------------

void HostController::frame(std::vector<Completion>& done) {
  if (asleep_) {
    device_.poll();
    if (bus::take_wakeup()) resume();
    return;
  }
  poll_endpoints(Direction::out, done);
  poll_endpoints(Direction::in, done);
  ++frame_;
}

void HostController::poll_endpoints(Direction direction, std::vector<Completion>& done) {
  auto& queues = queues_[static_cast<std::size_t>(direction)];
  for (std::size_t endpoint = 1; endpoint < queues.size(); ++endpoint) {
    Queue& queue = queues[endpoint];
    const std::uint8_t interval = bus::interval_frames(address_of(endpoint, direction));
    // A closed endpoint refuses at once.
    const bool due = interval <= 1 || frame_ % interval == 0;
    if (queue.empty()) {
      if (due && direction == Direction::in) note_absence(endpoint);
      continue;
    }
    if (!due) continue;
    if (direction == Direction::out) {
      send_packet(queue, done);
    } else {
      (void)fetch_packet(queue, done);
    }
    device_.poll();
  }
}

void HostController::send_packet(Queue& queue, std::vector<Completion>& done) {
  Transfer& transfer = queue.front();
  const auto packet = packet_at(transfer.data, transfer.sent);
  const Handshake handshake =
      bus::out(static_cast<std::uint8_t>(transfer.request.endpoint), packet);
  if (handshake == Handshake::nak) return;
  if (handshake == Handshake::ack) transfer.sent += packet.size();
  if (handshake == Handshake::ack && transfer.sent < transfer.data.size()) return;
  done.push_back(
      over(transfer.request, handshake == Handshake::ack ? kOk : kStalled, transfer.sent));
  queue.pop_front();
}

/// @returns false if the device had none
bool HostController::fetch_packet(Queue& queue, std::vector<Completion>& done) {
  Transfer& transfer = queue.front();
  const std::size_t room =
      std::min<std::size_t>(transfer.request.length, kLongestTransfer) - transfer.data.size();
  Packet packet;
  const auto space = std::span(packet).first(std::min(room, kPacketSize));
  const auto [handshake, size] =
      bus::in(static_cast<std::uint8_t>(transfer.request.endpoint), space);
  if (handshake == Handshake::nak) return false;
  std::int32_t status = kOk;
  if (handshake == Handshake::stall) {
    status = kStalled;
  } else if (size > space.size()) {
    status = kOverflow;
  } else {
    const auto kept = space.first(size);
    transfer.data.insert(transfer.data.end(), kept.begin(), kept.end());
    if (size == kPacketSize && size < room) return true;  // a full packet does not end a transfer
  }
  const std::size_t length = transfer.data.size();
  done.push_back(over(transfer.request, status, length, std::move(transfer.data)));
  queue.pop_front();
  return true;
}

/// A frame in which the driver did not ask.
void HostController::note_absence(std::size_t endpoint) {
  Absence& absence = absences_[endpoint];
  if (absence.frames <= kMostLate) ++absence.frames;
  if (absence.frames > kMostLate) {
    absence.missed_polls = 0;
  } else if (bus::has_packet(static_cast<std::uint8_t>(endpoint))) {
    ++absence.missed_polls;
  }
}

/// The driver asks again. It gets at once the packets that it missed, and no more.
void HostController::make_up(std::size_t endpoint, std::vector<Completion>& done) {
  Queue& queue = queues_[static_cast<std::size_t>(Direction::in)][endpoint];
  Absence& absence = absences_[endpoint];
  absence.frames = 0;
  while (absence.missed_polls > 0 && !queue.empty()) {
    const bool fetched = fetch_packet(queue, done);
    device_.poll();
    absence.missed_polls = fetched ? absence.missed_polls - 1 : 0;
  }
}

}  // namespace torsio::emulator::usbip
