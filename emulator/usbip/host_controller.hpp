/// @file A USB host controller without a bus: takes transfers, cuts them into packets and lets the
/// device's stack answer. Interrupt endpoints move one packet per polling interval, as on a wire.
/// Control transfers take no time.
///
/// A driver asks for the next report when it has the last one. Over a network, or on a busy
/// machine, that takes longer than an interval. A real controller would have polled meanwhile. So
/// the polls that a waiting packet missed are made up for when the transfer comes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "emulator/usbip/bus.hpp"
#include "emulator/usbip/messages.hpp"
#include "usb/usb_device.hpp"

namespace torsio::emulator::usbip {

/// Result of a transfer.
struct Completion {
  Submit request;
  std::int32_t status = kOk;
  std::uint32_t actual_length = 0;  // bytes that went either way
  Bytes data;                       // IN only
};

class HostController {
 public:
  static constexpr std::size_t kLongestTransfer = 65'536;
  /// Frames after which a driver that asks for nothing is not late but has stopped listening.
  static constexpr unsigned kMostLate = 20;

  explicit HostController(usb::UsbDevice& device) : device_(device) {}

  void plug();
  /// Forgets every transfer.
  void unplug();
  /// The bus sleeps: no endpoint is asked, and transfers wait. A device that is allowed to wakes
  /// it.
  void suspend();
  /// The device's port is reset while its bus sleeps: it has to be configured anew.
  void reset();
  void resume();

  /// @param data what an OUT transfer carries, at most kLongestTransfer
  /// @param done gets what is over at once
  void submit(const Submit& request, Bytes data, std::vector<Completion>& done);

  /// Takes a transfer back.
  /// @returns false if it is over already, or never was
  bool unlink(std::uint32_t sequence);

  /// One frame of 1 ms.
  void frame(std::vector<Completion>& done);

  /// Transfers that wait.
  [[nodiscard]] std::size_t pending() const;

 private:
  struct Transfer {
    Submit request;
    Bytes data;            // OUT: all of it, IN: what has come
    std::size_t sent = 0;  // OUT
  };
  using Queue = std::deque<Transfer>;
  /// An IN endpoint without a waiting transfer.
  struct Absence {
    unsigned frames = kMostLate + 1;  // since the last transfer; nobody has asked yet
    unsigned missed_polls = 0;        // while the device had a packet
  };

  Completion control(const Submit& request, const Bytes& data);
  Completion control_in(const Submit& request, std::size_t length);
  Completion control_out(const Submit& request, const Bytes& data);
  void poll_endpoints(Direction direction, std::vector<Completion>& done);
  void send_packet(Queue& queue, std::vector<Completion>& done);
  bool fetch_packet(Queue& queue, std::vector<Completion>& done);
  void note_absence(std::size_t endpoint);
  void make_up(std::size_t endpoint, std::vector<Completion>& done);

  usb::UsbDevice& device_;
  std::array<std::array<Queue, bus::kEndpoints>, 2> queues_;  // by direction and number
  std::array<Absence, bus::kEndpoints> absences_;             // by number
  std::uint64_t frame_ = 0;
  bool asleep_ = false;
};

}  // namespace torsio::emulator::usbip
